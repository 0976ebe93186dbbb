//! `kinfold studio`: a page on which a person sees, steers and corrects one object.

mod ask;
mod bench;
mod opened;
mod remedies;

use std::io::{ErrorKind, Write as _};
use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::sync::Arc;

use serde_json::json;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use studio::{Desk, Paper, Setup, Stop, Token};

use self::bench::Bench;
use self::opened::{Opened, opened};
use super::{given, make, view};
use crate::cli::args::{PORT, StudioArgs};
use crate::cli::speech::{Answer, Complaint};
use crate::output::OutFolder;
use crate::recording::VERSION;

/// Serves the page until Ctrl-C.
///
/// # Errors
/// [`Complaint`] when a file cannot be read, or the port is taken.
pub fn studio(args: &StudioArgs) -> Result<Answer, Complaint> {
    let (listener, taken) = listener(args.port)?;
    let Opened { title, make, photo, mesh_name, mesh, condition, out, remarks } = opened(args)?;
    OutFolder::look(&out).map_err(|e| make::out_complaint(&e))?;
    let folder = condition.parent().filter(|p| !p.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        let message = format!("{}: there is no such folder for the condition", folder.display());
        return Err(Complaint::misused(message).hint("make it, or name another --condition FILE"));
    }
    let up = given::mesh(&make).map(|file| file.up).unwrap_or_default();
    let paper = Paper::open(&condition, up).map_err(|e| Complaint::from_error(&e))?;
    let token = Token::new().map_err(|e| Complaint::failed(format!("no random token: {e}")))?;
    let port = listener.local_addr().map_err(|e| Complaint::failed(e.to_string()))?.port();
    let address = format!("http://127.0.0.1:{port}/?token={}", token.as_str());
    let bench = Bench::new(make, args, &out, photo.is_some());
    let shown = |path: &Path| guard::text::shown(&path.to_string_lossy()).into_owned();
    let setup = Setup {
        page: page::studio(&title),
        version: VERSION.to_owned(),
        mesh_name,
        desk: Desk::new(mesh),
        photo,
        paper,
        out: shown(&out),
        house: Arc::new(bench),
        title,
    };
    if !args.quiet {
        let remarks = remarks.into_iter().chain(taken);
        remarks.for_each(|remark| say(&remark));
        say(&format!("editing {}", shown(&condition)));
        say("Ctrl-C ends it; what was done stands in the condition file");
    }
    print(&address, args, &[&condition, &out])?;
    if args.open
        && let Some(why) = view::open_address(&address)
    {
        say(&why);
    }
    let stop = Stop::default();
    let signals = listen(stop.clone())?;
    let served = studio::serve(listener, token, setup, &stop);
    signals.close();
    served.map_err(|e| Complaint::failed(format!("the page cannot be served: {e}")))?;
    Ok(Answer::done(String::new()))
}

/// Listens on this machine alone; where nobody named a port and the usual one is taken, on another.
fn listener(port: Option<u16>) -> Result<(TcpListener, Option<String>), Complaint> {
    let bind = |port| TcpListener::bind((Ipv4Addr::LOCALHOST, port));
    match bind(port.unwrap_or(PORT)) {
        Ok(listener) => Ok((listener, None)),
        Err(e) if e.kind() == ErrorKind::AddrInUse && port.is_none() => {
            let other = bind(0).map_err(|e| Complaint::failed(format!("no free port: {e}")))?;
            Ok((other, Some(format!("port {PORT} is taken, so another is used"))))
        }
        Err(e) => {
            let port = port.unwrap_or(PORT);
            let complaint = Complaint::failed(format!("port {port} of this machine: {e}"));
            Err(complaint.hint("name another with --port N; without it a free one is found"))
        }
    }
}

/// The address at once, since the command does not end by itself.
fn print(address: &str, args: &StudioArgs, [condition, out]: &[&Path; 2]) -> Result<(), Complaint> {
    let text = if args.json {
        let [condition, out] = [condition, out].map(|p| p.to_string_lossy().into_owned());
        let value = json!({ "url": address, "condition": condition, "out": out });
        guard::text::json(&format!("{value}\n")).into_owned()
    } else {
        format!("{address}\n")
    };
    let mut stdout = std::io::stdout().lock();
    let written = stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush());
    written.map_err(|e| Complaint::failed(format!("the address cannot be printed: {e}")))
}

fn say(line: &str) {
    // Nobody may be listening.
    let _ = writeln!(std::io::stderr(), "{}", guard::text::shown(line));
}

/// Ctrl-C ends the server.
fn listen(stop: Stop) -> Result<signal_hook::iterator::Handle, Complaint> {
    let signals = Signals::new([SIGINT, SIGTERM]);
    let mut signals = signals.map_err(|e| Complaint::failed(format!("cannot hear Ctrl-C: {e}")))?;
    let handle = signals.handle();
    std::thread::spawn(move || signals.forever().for_each(|_| stop.stop()));
    Ok(handle)
}
