//! Which engine a batch runs on, and the store it shares.

use std::sync::Arc;

use adapters::net::http::Http;
use adapters::transport::Transport;
use runner::{Address, Depot, DepotError};

use crate::batch::gate::AtOnce;
use crate::batch::plan::Share;
use crate::batch::restate::{Admin, AdminError, Ingress, Restate};
use crate::batch::{Embedded, Engine, Shard};
use crate::cli::args::{BatchArgs, EngineName};
use crate::cli::speech::{Complaint, Exit};

/// Stages that Restate is asked for at a time, unless --jobs says otherwise.
const ON_RESTATE: usize = 32;

/// Stages that compute at a time, and items that ask nobody.
pub(super) fn jobs(args: &BatchArgs) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    args.jobs.unwrap_or_else(|| match args.engines.engine {
        EngineName::Embedded => cores(),
        EngineName::Restate => ON_RESTATE,
    })
}

/// The engine that is asked for.
pub(super) fn chosen(
    args: &BatchArgs,
    at_once: AtOnce,
    depot: Option<&Arc<dyn Depot>>,
) -> Result<Box<dyn Engine>, Complaint> {
    let AtOnce { cpu, mesh, condition } = at_once;
    let hands = cpu.saturating_add(mesh).saturating_add(condition);
    match (args.engines.engine, args.shard, depot) {
        (EngineName::Embedded, None, _) => Ok(Box::new(Embedded { hands })),
        (EngineName::Embedded, Some(share), _) => Ok(Box::new(Shard { share, hands })),
        (EngineName::Restate, Some(_), _) => Err(Complaint::misused(
            "expected either --shard or --engine restate, found both: Restate shares the work out by itself",
        )),
        (EngineName::Restate, None, None) => {
            Err(Complaint::misused("expected a --store that the workers share, found none")
                .hint("a folder that all machines see, or a bucket: --store s3://BUCKET/PREFIX"))
        }
        (EngineName::Restate, None, Some(depot)) => Ok(Box::new(on_restate(args, hands, depot)?)),
    }
}

/// Makes the workers known, and looks whether every stage has one.
fn on_restate(
    args: &BatchArgs,
    hands: usize,
    depot: &Arc<dyn Depot>,
) -> Result<Restate, Complaint> {
    let transport: Arc<dyn Transport> = Arc::new(Http::default());
    let engines = &args.engines;
    let admin = Admin::new(&engines.admin, Arc::clone(&transport));
    let introduced = engines.workers.as_deref().map_or(Ok(()), |workers| admin.introduce(workers));
    introduced.and_then(|()| admin.everybody_there()).map_err(|e| admin_complaint(&e))?;
    let workers = Arc::new(Ingress::new(&engines.ingress, transport, Arc::clone(depot)));
    Ok(Restate { hands, workers })
}

fn admin_complaint(error: &AdminError) -> Complaint {
    let complaint = Complaint::from_error(error);
    match error {
        AdminError::Silent { .. } => complaint.hint("--admin URL names Restate's administration"),
        AdminError::Refused { .. } => {
            complaint.hint("start `kinfold worker` first; --workers names it as Restate sees it")
        }
        AdminError::Nobody { .. } => {
            complaint.hint("start `kinfold worker` and name its address with --workers URL")
        }
    }
}

/// The shared store, with a name of its own for this process's unfinished files.
pub(super) fn shared(address: &Address, share: Option<Share>) -> Result<Arc<dyn Depot>, Complaint> {
    let Share { k, of } = share.unwrap_or(Share::ALL);
    let name = format!("{k}-{of}-{}", std::process::id());
    address.open(&name).map_err(|e| depot_complaint(&e))
}

/// A shared store that cannot be used.
pub(super) fn depot_complaint(error: &DepotError) -> Complaint {
    let complaint = Complaint::from_error(error);
    match error {
        DepotError::NotBuilt(_) => Complaint { exit: Exit::Misused, ..complaint },
        DepotError::NotOurs { .. } => {
            complaint.hint("choose a new or an empty folder with --store DIR")
        }
        DepotError::Bucket { .. } => complaint.hint(
            "bucket and keys come from the environment: AWS_ACCESS_KEY_ID, AWS_REGION, AWS_ENDPOINT; \
             GOOGLE_APPLICATION_CREDENTIALS; AZURE_STORAGE_ACCOUNT_NAME, AZURE_STORAGE_ACCOUNT_KEY",
        ),
        _ => complaint,
    }
}
