//! Who is asked for a mesh and a condition: a file that was given, else whom `kinfold.toml` names.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use adapters::generators::FolderLedger;
use adapters::net::http::Http;
use adapters::net::pace::{Pace, RealPace};
use adapters::net::redirect::Following;
use adapters::net::retry::Retrying;
use adapters::{AdapterError, ConditionFile, Config, ImageTo3d, MeshFile, Vlm, World};

use crate::cli::MakeArgs;
use crate::speech::Complaint;

/// Most times a request is sent.
const ATTEMPTS: u32 = 4;
/// The configuration that is read where no other is named.
const DEFAULT: &str = "kinfold.toml";

/// Who makes the mesh, and who says what its parts are.
pub(super) type Chosen = (Option<Box<dyn ImageTo3d>>, Option<Box<dyn Vlm>>);

/// A file that was given comes first, then whom the configuration names; none is nobody.
pub(super) fn chosen(args: &MakeArgs, state: &Path) -> Result<Chosen, Complaint> {
    let config = config(args.config.as_deref())?;
    let world = world(state);
    let image_to_3d: Option<Box<dyn ImageTo3d>> = match &args.mesh {
        Some(path) => Some(Box::new(MeshFile { path: path.clone() })),
        None => config.image_to_3d(&world).map_err(|e| complaint(&e))?,
    };
    let vlm: Option<Box<dyn Vlm>> = match &args.condition {
        Some(path) => Some(Box::new(ConditionFile { path: path.clone() })),
        None => config.vlm(&world).map_err(|e| complaint(&e))?,
    };
    Ok((image_to_3d, vlm))
}

/// Whom the configuration names.
pub(super) fn configured(file: Option<&Path>, state: &Path) -> Result<Chosen, Complaint> {
    let (config, world) = (config(file)?, world(state));
    let image_to_3d = config.image_to_3d(&world).map_err(|e| complaint(&e))?;
    Ok((image_to_3d, config.vlm(&world).map_err(|e| complaint(&e))?))
}

fn config(file: Option<&Path>) -> Result<Config, Complaint> {
    let beside = || Some(PathBuf::from(DEFAULT)).filter(|path| path.is_file());
    match file.map(PathBuf::from).or_else(beside) {
        Some(path) => Config::open(&path).map_err(|e| complaint(&e)),
        None => Ok(Config::default()),
    }
}

fn world(state: &Path) -> World {
    let pace: Arc<dyn Pace> = Arc::new(RealPace::default());
    let inner = Following(Http::default());
    let transport = Retrying { inner, pace: Arc::clone(&pace), attempts: ATTEMPTS };
    World {
        transport: Arc::new(transport),
        pace,
        ledger: Arc::new(FolderLedger { folder: state.join("jobs") }),
        scratch: state.join("tmp"),
        variable: |name| std::env::var(name).ok(),
    }
}

fn complaint(error: &AdapterError) -> Complaint {
    let complaint = Complaint::from_error(error);
    match error.hint() {
        Some(hint) => complaint.hint(hint),
        None => complaint,
    }
}
