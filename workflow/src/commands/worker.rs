//! `kinfold worker`: does stages for a batch on another machine.

use crate::cli::{EngineName, WorkerArgs};
use crate::speech::{Answer, Complaint};

/// Serves until Ctrl-C.
///
/// # Errors
/// [`Complaint`] when socket or store cannot be used.
pub fn worker(args: &WorkerArgs) -> Result<Answer, Complaint> {
    match args.engine {
        EngineName::Restate => served(args),
        EngineName::Embedded => Err(Complaint::misused(
            "expected --engine restate, found embedded: that one works in the batch's own process",
        )),
    }
}

#[cfg(not(feature = "restate"))]
fn served(_args: &WorkerArgs) -> Result<Answer, Complaint> {
    Err(Complaint::misused(
        "expected a kinfold built with its feature `restate`, found one without",
    ))
}

#[cfg(feature = "restate")]
fn served(args: &WorkerArgs) -> Result<Answer, Complaint> {
    use std::io::Write as _;
    use std::net::TcpListener;

    use super::{engines, make};
    use crate::batch::restate::worker::{Bench, serve};
    use crate::dag::Cancel;

    let cancel = Cancel::default();
    let signals = make::listen(&cancel, true)?;
    let failed = |what: String| move |e: std::io::Error| Complaint::failed(format!("{what}: {e}"));
    let listener = TcpListener::bind(args.listen)
        .map_err(failed(format!("{}: cannot listen there", args.listen)))?;
    let name = format!("worker-{}", std::process::id());
    let depot = args.store.open(&name).map_err(|e| engines::depot_complaint(&e))?;
    let scratch = tempfile::tempdir()
        .map_err(failed("a folder for passing files cannot be created".into()))?;
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = args.jobs.unwrap_or_else(cores);
    if !args.quiet
        && let Ok(address) = listener.local_addr()
    {
        // Nobody may be reading.
        let _ = writeln!(std::io::stderr(), "listening on {address}, {jobs} stages at a time");
    }
    let bench = Bench::new(depot, scratch.path().to_path_buf(), jobs);
    let served = serve(&bench, listener, &cancel);
    signals.close();
    served.map_err(failed("the worker cannot go on".into()))?;
    Ok(Answer::done(""))
}
