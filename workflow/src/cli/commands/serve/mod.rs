//! `kinfold serve`: assets for programs that ask over the network.

mod inputs;
mod tokens;
mod told;
mod works;

use std::collections::BTreeSet;
use std::io::{ErrorKind, Write as _};
use std::net::{Ipv4Addr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use runner::ours::Turns;
use runner::{Cancel, Wish};
use serde_json::json;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use studio::service::{self, Bell, Limits};
use studio::{About, Budget, Stop};
use trace::{Clock, SystemClock};

use self::inputs::Inputs;
use self::tokens::Tokens;
use self::works::{Desk, Waiting};
use super::batch::{Made, complaint, settings};
use super::providers::{self, Wanted};
use crate::batch::BatchError;
use crate::batch::allowance::{Allowance, Prices};
use crate::batch::gate::AtOnce;
use crate::batch::run::{Opened, Order};
use crate::batch::service::Service;
use crate::cli::args::ServeArgs;
use crate::cli::speech::{Answer, Complaint};
use crate::image_to_urdf::of_any_photo;
use crate::recording::VERSION;
use crate::stages::Export;

/// Serves until Ctrl-C.
///
/// # Errors
/// [`Complaint`] when folder, tokens or port cannot be used, or the work cannot go on.
pub fn serve(args: &ServeArgs) -> Result<Answer, Complaint> {
    let order = order(args)?;
    let most_waiting = args.max_waiting as u64;
    let chosen = tokens::chosen(args.tokens.as_deref(), most_waiting)?;
    order.look().map_err(|e| refused(&e))?;
    let listener = listener(args.port)?;
    let turns = Turns { wait: !args.no_wait, tell: !args.quiet };
    let opened = Opened::of(&order, turns).map_err(|e| refused(&e))?;
    let root = std::fs::canonicalize(&args.folder).map_err(|e| unused(&args.folder, &e))?;
    let inputs = Inputs::open(&root, (args.max_stored as u64).saturating_mul(1 << 30))
        .map_err(|e| unused(&root, &e))?;
    let who = chosen.map_or_else(|| tokens::own(&root, most_waiting), Ok)?;
    let clock: Arc<dyn Clock> = Arc::new(SystemClock::default());
    let service = Service::begin((&order, &opened), who.shares.clone(), &root, &clock);
    let service = service.map_err(|e| complaint(&e))?;
    let desk = Arc::new(desk(args, (&order, service), (root, inputs), &who)?);
    announce(args, &listener, &who, &desk)?;
    let limits = Limits {
        most_bytes: desk.about.most_bytes,
        most_requests: args.max_rate,
        connections: args.connections,
        patience: args.patience,
    };
    let shown = service::Service {
        tokens: who.tokens,
        limits,
        bell: desk.bell.clone(),
        works: Arc::clone(&desk) as _,
    };
    let (cancel, stop) = (Cancel::default(), Stop::default());
    let signals = listen((&cancel, &stop), args.quiet)?;
    let (worked, served) = std::thread::scope(|scope| {
        let work = scope.spawn(|| {
            let worked = desk.service.work((&order, &opened), &*desk, &cancel, clock);
            stop.stop();
            worked
        });
        let served = service::serve(listener, shown, &stop);
        if cancel.wish() == Wish::Go {
            // Nobody could ask any more.
            cancel.press();
        }
        (work.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), served)
    });
    signals.close();
    worked.map_err(|e| complaint(&e))?;
    served.map_err(|e| Complaint::failed(format!("nobody can be answered: {e}")))?;
    Ok(Answer::done(String::new()))
}

/// What a batch would say of its folder, which is named in another way here.
fn refused(error: &BatchError) -> Complaint {
    let mut complaint = complaint(error);
    if let BatchError::Io { .. } = error {
        complaint.hints = vec!["name a folder that may be written to".into()];
    }
    for hint in &mut complaint.hints {
        *hint = hint.replace(" with --out DIR", "").replace(" with --state DIR", "");
    }
    complaint
}

fn unused(folder: &Path, error: &std::io::Error) -> Complaint {
    Complaint::failed(format!("{}: {error}", runner::ours::name(folder)))
        .hint("name a folder that may be written to")
}

fn order(args: &ServeArgs) -> Result<Order, Complaint> {
    let wanted = Wanted {
        named: args.config.as_deref(),
        trusted: args.trust_config,
        mesh: true,
        condition: true,
    };
    let config = providers::configured(&wanted)?;
    let to_look_at = Export::ALL.into_iter().filter(|e| args.pages && e.is_for_looking());
    let exports: BTreeSet<_> =
        args.export.iter().copied().chain([Export::Urdf]).chain(to_look_at).collect();
    let made = Made {
        exports: exports.into_iter().collect(),
        tier: args.tier,
        seed: args.seed,
        min_confidence: args.min_confidence,
    };
    let state = args.folder.join("state");
    let settings = settings(config, &state, made)?;
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let prices = Prices { mesh: args.mesh_price, condition: args.condition_price };
    Ok(Order {
        manifest: PathBuf::new(),
        out: args.folder.clone(),
        state,
        depot: None,
        settings,
        at_once: AtOnce {
            cpu: args.jobs.unwrap_or_else(cores),
            mesh: args.mesh_calls,
            condition: args.condition_calls,
        },
        allowance: Allowance::new(args.max_calls, args.max_cost, prices),
        retry: vec![],
        onlooker: None,
        quiet: args.quiet,
    })
}

fn desk(
    args: &ServeArgs,
    (order, service): (&Order, Service),
    (root, inputs): (PathBuf, Inputs),
    who: &Tokens,
) -> Result<Desk, Complaint> {
    let mut waiting = std::collections::BTreeMap::new();
    for (name, &most) in &who.waiting {
        let now = service.unsettled(name).map_err(|e| complaint(&e.into()))?;
        waiting.insert(name.clone(), Waiting { most, now });
    }
    let settings = &order.settings;
    let formats = settings.exports.iter().map(|e| e.name().to_owned());
    let about = About {
        version: VERSION.to_owned(),
        token: String::new(),
        formats: formats.collect(),
        tier: settings.tier.name().to_owned(),
        makes_meshes: settings.image_to_3d.is_some(),
        makes_conditions: settings.vlm.is_some(),
        most_bytes: (args.max_upload as u64).saturating_mul(1 << 20),
        most_requests: args.max_rate,
        most_waiting: 0,
        waiting: 0,
        budget: Budget::default(),
    };
    let stages = of_any_photo(&settings.exports).stages();
    let (bell, running) = (Bell::default(), Default::default());
    Ok(Desk { root, service, inputs, bell, about, stages, waiting: waiting.into(), running })
}

/// Listens on this machine alone.
fn listener(port: u16) -> Result<TcpListener, Complaint> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|e| {
        let complaint = Complaint::failed(format!("port {port} of this machine: {e}"));
        match e.kind() {
            ErrorKind::AddrInUse => {
                complaint.hint("name another with --port N; 0 finds a free one")
            }
            _ => complaint,
        }
    })
}

/// The address at once, since the command does not end by itself; and the token where nobody chose it.
fn announce(
    args: &ServeArgs,
    listener: &TcpListener,
    who: &Tokens,
    desk: &Desk,
) -> Result<(), Complaint> {
    let port = listener.local_addr().map_err(|e| Complaint::failed(e.to_string()))?.port();
    let url = format!("http://127.0.0.1:{port}");
    let made = who.made.as_ref().map(|token| token.as_str());
    let waiting: u64 =
        desk.waiting.lock().map_or(0, |waiting| waiting.values().map(|of| of.now).sum());
    if !args.quiet {
        say(&format!("{waiting} jobs wait; Ctrl-C ends it, and nothing is lost"));
    }
    let text = if args.json {
        let names: Vec<_> = who.tokens.iter().map(|(name, _)| name).collect();
        format!("{}\n", json!({ "url": url, "token": made, "tokens": names, "waiting": waiting }))
    } else {
        let token = made.map(|made| format!("token  {made}\n"));
        format!("url    {url}\n{}", token.unwrap_or_default())
    };
    let mut stdout = std::io::stdout().lock();
    let written = stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush());
    written.map_err(|e| Complaint::failed(format!("the address cannot be printed: {e}")))
}

fn say(line: &str) {
    // Nobody may be listening.
    let _ = writeln!(std::io::stderr(), "{}", guard::text::shown(line));
}

/// The first Ctrl-C answers nobody any more and lets running stages finish, the second ends all at once.
fn listen(
    (cancel, stop): (&Cancel, &Stop),
    quiet: bool,
) -> Result<signal_hook::iterator::Handle, Complaint> {
    let signals = Signals::new([SIGINT, SIGTERM]);
    let mut signals = signals.map_err(|e| Complaint::failed(format!("cannot hear Ctrl-C: {e}")))?;
    let handle = signals.handle();
    let (cancel, stop) = (cancel.clone(), stop.clone());
    std::thread::spawn(move || {
        for _ in signals.forever() {
            if cancel.press() == Wish::Drain && !quiet {
                say("stopping after the running stages, press Ctrl-C again to stop at once");
            }
            stop.stop();
        }
    });
    Ok(handle)
}
