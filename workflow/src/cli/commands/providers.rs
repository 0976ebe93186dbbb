//! Who is asked for a mesh and a condition: a file that was given, else whom `kinfold.toml` names.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use adapters::budget::FileBook;
use adapters::config::{Draft, VlmConfig, VlmProvider, may_carry_keys};
use adapters::generators::FolderLedger;
use adapters::net::calls::FolderCalls;
use adapters::net::http::Http;
use adapters::net::pace::RealPace;
use adapters::net::redact;
use adapters::net::redirect::Following;
use adapters::transport::Deny;
use adapters::{AdapterError, Config, Critic, ImageTo3d, Vlm, World};

use trace::SystemClock;

use super::given;
use crate::batch::audit::BOOK;
use crate::cli::args::MakeArgs;
use crate::cli::speech::Complaint;
use crate::cli::trust::Approvals;
use crate::cli::{program, progress};
use crate::stages::Shared;

/// The configuration that is read where no other is named.
pub(super) const DEFAULT: &str = "kinfold.toml";

/// The variable that holds the key of a server that the command line names.
const KEY: &str = "OPENAI_API_KEY";

/// Who is asked; none is nobody.
pub(super) struct Chosen {
    /// Who makes the mesh.
    pub image_to_3d: Option<Box<dyn ImageTo3d>>,
    /// Who says what its parts are.
    pub vlm: Option<Box<dyn Vlm>>,
    /// Who says what looks wrong.
    pub critic: Option<Box<dyn Critic>>,
}

/// A file that was given comes first, then whom the configuration names. Where the condition was
/// given, nobody is asked what looks wrong, either.
pub(super) fn chosen(args: &MakeArgs, state: &Path) -> Result<Chosen, Complaint> {
    let config = config(args)?;
    asked(args)?.permit(&args.policy).map_err(|e| complaint(&e))?;
    tell_of_key(args, &config);
    let onlooker = (!args.quiet).then(progress::onlooker);
    let world = World { onlooker, ..world(state) };
    let own = args.own.clone();
    let image_to_3d: Option<Box<dyn ImageTo3d>> = match (given::mesh(args), own.image_to_3d) {
        (Some(mesh), _) => Some(Box::new(mesh)),
        (None, Some(own)) => Some(Box::new(Shared(own))),
        (None, None) => config.image_to_3d(&world).map_err(|e| complaint(&e))?,
    };
    let vlm: Option<Box<dyn Vlm>> = match (given::condition(args), own.vlm) {
        (Some(condition), _) => Some(Box::new(condition)),
        (None, Some(own)) => Some(Box::new(Shared(own))),
        (None, None) => config.vlm(&world).map_err(|e| complaint(&e))?,
    };
    let critic = match args.has_condition() {
        true => None,
        false => config.critic(&world).map_err(|e| complaint(&e))?,
    };
    Ok(Chosen { image_to_3d, vlm, critic })
}

/// Whom the configuration names.
pub(super) fn hired(config: &Config, state: &Path) -> Result<Chosen, Complaint> {
    let world = world(state);
    let image_to_3d = config.image_to_3d(&world).map_err(|e| complaint(&e))?;
    let vlm = config.vlm(&world).map_err(|e| complaint(&e))?;
    let critic = config.critic(&world).map_err(|e| complaint(&e))?;
    Ok(Chosen { image_to_3d, vlm, critic })
}

/// Every call that was made from this state directory.
pub(super) fn calls(state: &Path) -> FolderCalls {
    FolderCalls { folder: state.join("calls") }
}

/// Who is asked as it may be kept, without the sections that a given file stands in for.
pub(super) fn asked(args: &MakeArgs) -> Result<Config, Complaint> {
    Ok(config(args)?.redacted().without(args.has_mesh(), args.has_condition()))
}

fn config(args: &MakeArgs) -> Result<Config, Complaint> {
    let vlm = flagged(args);
    let mut config = configured(&Wanted {
        named: args.config.as_deref(),
        trusted: args.trust_config,
        mesh: !args.has_mesh(),
        condition: !args.has_condition() && vlm.is_none(),
    })?;
    if vlm.is_some() {
        config.vlm = vlm;
        config.check_keys().map_err(|e| complaint(&e))?;
    }
    Ok(config)
}

/// The server that the command line names; whoever names it approves it. Its key is that of OpenAI, where
/// one is set and may be sent there.
fn flagged(args: &MakeArgs) -> Option<VlmConfig> {
    let (base, model) = (args.vlm.clone()?, args.model.clone()?);
    let is_set = std::env::var(KEY).is_ok_and(|key| !key.trim().is_empty());
    let key_env = (is_set && may_carry_keys(&base)).then(|| KEY.to_owned());
    let (provider, points, critic) = (VlmProvider::Openai, None, false);
    Some(VlmConfig { provider, model, base: Some(base), key_env, points, critic })
}

/// Says, before anybody is asked, that a key goes to the server that the command line names, for no file of
/// the person's says so: the variable and the host, never the key.
fn tell_of_key(args: &MakeArgs, config: &Config) {
    let told = config.vlm.as_ref().filter(|_| args.vlm.is_some());
    let Some((base, key)) = told.and_then(|vlm| vlm.base.as_deref().zip(vlm.key_env.as_deref()))
    else {
        return;
    };
    if !(args.quiet || args.dry_run || args.graph) {
        let host = guard::text::shown(&redact::host(base)).into_owned();
        let line = format!("--vlm: sends what {key} holds to {host}\n");
        // Nobody may be listening.
        let _ = std::io::stderr().write_all(line.as_bytes());
    }
}

/// Which configuration is wanted, and what of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted<'a> {
    /// The file that was named; a person who names a file approves it.
    pub named: Option<&'a Path>,
    /// Whether the one beside is approved for this once.
    pub trusted: bool,
    /// Whether somebody is asked for meshes.
    pub mesh: bool,
    /// Whether somebody is asked for conditions.
    pub condition: bool,
}

/// The configuration that is named, or the one beside once it was approved, or an empty one.
pub(super) fn configured(wanted: &Wanted<'_>) -> Result<Config, Complaint> {
    let Some(draft) = draft(wanted.named)? else { return Ok(Config::default()) };
    let draft = draft.without(!wanted.mesh, !wanted.condition);
    if wanted.named.is_none() && !wanted.trusted {
        check_approved(&draft)?;
    }
    draft.config().check_keys().map_err(|e| complaint(&e))?;
    draft.approved().map_err(|e| complaint(&e))
}

/// The configuration that is named, or the one beside, as it stands in its file.
pub(super) fn draft(named: Option<&Path>) -> Result<Option<Draft>, Complaint> {
    let beside = || Some(PathBuf::from(DEFAULT)).filter(|path| path.is_file());
    let path = named.map(Path::to_path_buf).or_else(beside);
    path.map(|path| Draft::read(&path).map_err(|e| complaint(&e))).transpose()
}

/// Refuses a configuration that was found in the working folder and would do what nobody approved.
pub(super) fn check_approved(draft: &Draft) -> Result<(), Complaint> {
    let acts = draft.acts();
    if acts.is_empty() {
        return Ok(());
    }
    let known = Approvals::of_user().and_then(|approvals| approvals.know(draft));
    if let Ok(true) = known {
        return Ok(());
    }
    let found = format!(
        "{}: a configuration found in the working folder acts only once you approved it",
        draft.path.display()
    );
    let mut complaint = Complaint::misused(found);
    complaint.causes = acts;
    complaint.causes.extend(known.err().map(|e| e.to_string()));
    let hint = "read the file, then `kinfold trust`; for this once --trust-config or --config FILE";
    Err(complaint.hint(hint))
}

/// What adapters reach the real world through.
pub(super) fn world(state: &Path) -> World {
    World {
        transport: Arc::new(Following(Http::default())),
        on_record: Arc::new(Deny),
        calls: Arc::new(calls(state)),
        pace: Arc::new(RealPace::default()),
        clock: Arc::new(SystemClock::default()),
        ledger: Arc::new(FolderLedger { folder: state.join("jobs") }),
        book: Arc::new(FileBook::new(state.join(BOOK))),
        gates: Arc::default(),
        scratch: state.join("tmp"),
        keeper: program::apart().ok(),
        onlooker: None,
        variable: |name| std::env::var(name).ok(),
    }
}

/// An adapter's error with its advice.
pub(super) fn complaint(error: &AdapterError) -> Complaint {
    let complaint = Complaint::from_error(error);
    match error.hint() {
        Some(hint) => complaint.hint(hint),
        None => complaint,
    }
}
