//! `kinfold worker`: does stages for a batch on another machine.

use std::net::SocketAddr;

use crate::cli::args::{EngineName, WorkerArgs};
use crate::cli::speech::{Answer, Complaint};

/// Serves until Ctrl-C.
///
/// # Errors
/// [`Complaint`] when socket or store cannot be used.
pub fn worker(args: &WorkerArgs) -> Result<Answer, Complaint> {
    if !args.identity_key.iter().all(|key| key.starts_with("publickeyv1_")) {
        // Not quoted: somebody may have put the secret one there.
        let message = "expected --identity-key publickeyv1_…, found something else";
        return Err(Complaint::misused(message).hint("Restate says its public key when it starts"));
    }
    match args.engine {
        EngineName::Restate if args.identity_key.is_empty() && !only_here(args.listen) => {
            let message = format!(
                "expected --identity-key to listen on {}, where others reach it, found none: anybody could have work done",
                args.listen
            );
            Err(Complaint::misused(message).hint(
                "give Restate a key (RESTATE_REQUEST_IDENTITY_PRIVATE_KEY_PEM_FILE); it says the public one when it \
                 starts. Or listen on 127.0.0.1",
            ))
        }
        EngineName::Restate => served(args),
        EngineName::Embedded => Err(Complaint::misused(
            "expected --engine restate, found embedded: that one works in the batch's own process",
        )),
    }
}

/// Whether nobody but this machine reaches an address.
fn only_here(address: SocketAddr) -> bool {
    address.ip().to_canonical().is_loopback()
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

    use runner::Cancel;
    use runner::restate::worker::{Bench, known, serve};

    use super::{engines, make};
    use crate::image_to_urdf::any_image_to_urdf;
    use crate::stages::Tools;

    known(&args.identity_key).map_err(Complaint::misused)?;
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
    let folder = scratch.path().to_path_buf();
    let tools = move |seed: Option<u64>| Tools::computing(seed.unwrap_or_default(), folder.clone());
    let bench = Bench::new(any_image_to_urdf(), tools, depot, jobs);
    let served = serve(&bench, listener, &args.identity_key, &cancel);
    signals.close();
    served.map_err(failed("the worker cannot go on".into()))?;
    Ok(Answer::done(""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_this_machine_reaches_the_loopback() {
        let here = |text: &str| only_here(text.parse().unwrap());
        assert!(
            ["127.0.0.1:1", "127.9.9.9:1", "[::1]:1", "[::ffff:127.0.0.1]:1"].map(here)
                == [true; 4]
        );
        assert!(
            ["0.0.0.0:1", "[::]:1", "10.0.0.1:1", "[::ffff:10.0.0.1]:1"].map(here) == [false; 4]
        );
    }
}
