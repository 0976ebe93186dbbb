//! `kinfold view`: a page that shows a model, whoever made it.
//!
//! Strangers' files are read and checked in a process apart; this one only writes the page.

mod here;
mod model;
mod shown;

use std::ffi::OsString;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::json;
use sim_check::{CheckOptions, undecided};

use self::shown::{Shown, Told};
use crate::cli::args::ViewArgs;
use crate::cli::isolated::Isolation;
use crate::cli::program;
use crate::cli::speech::{Answer, Complaint, Exit};
use crate::stages::page::{Subject, scene};

/// What every page of ours has in its head.
const OURS: &str = "<meta name=\"generator\" content=\"kinfold page\">";
/// Where in a page that stands, at most, bytes.
const HEAD: usize = 4096;

/// Makes a page of a model and says where it is.
///
/// # Errors
/// [`Complaint`] when there is no such file, or the page cannot be written.
pub fn view(args: &ViewArgs) -> Result<Answer, Complaint> {
    if args.here {
        return here::answer(args);
    }
    let failed = |e: std::io::Error| Complaint::failed(format!("{}: {e}", args.path.display()));
    std::fs::metadata(&args.path).map_err(failed)?;
    let out = match &args.out {
        Some(out) => out.clone(),
        None => default_out(&args.path)?,
    };
    ours_or_new(&out)?;
    let shown = shown(args)?;
    write(&out, &shown.html)?;
    let opened = if args.open { open(&out) } else { None };
    Ok(told(&out, &shown, opened, args.json))
}

/// `./<name>.html`; an asset's folder is called `<name>.kinfold`.
fn default_out(path: &Path) -> Result<PathBuf, Complaint> {
    let whole = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let stem = whole.file_stem().ok_or_else(|| {
        Complaint::misused(format!("{} has no name", path.display()))
            .hint("name the page with --out FILE")
    })?;
    let mut name = stem.to_owned();
    name.push(".html");
    Ok(PathBuf::from(name))
}

/// Refuses a place where something stands that no kinfold made.
fn ours_or_new(out: &Path) -> Result<(), Complaint> {
    use std::io::Read as _;
    let about = match std::fs::symlink_metadata(out) {
        Ok(about) => about,
        Err(_) => return Ok(()),
    };
    let mut head = Vec::new();
    let file = about.is_file().then(|| std::fs::File::open(out).ok()).flatten();
    let read = file.and_then(|f| f.take(HEAD as u64).read_to_end(&mut head).ok());
    if read.is_some() && String::from_utf8_lossy(&head).contains(OURS) {
        return Ok(());
    }
    let message = format!("{} is there already, and is no page of kinfold's", out.display());
    Err(Complaint::misused(message).hint("name another file with --out FILE"))
}

/// The page, made apart. Where the check does not end, the model is shown without it; where even
/// reading does not, the page says so.
fn shown(args: &ViewArgs) -> Result<Shown, Complaint> {
    let program = program::apart()
        .map_err(|e| Complaint::failed(format!("this program cannot find itself: {e}")))?;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let isolation = Isolation { program, deadline: args.deadline, threads };
    let told = isolation.line(words(args, None)).or_else(|reason| {
        isolation.line(words(args, Some(&reason))).map_err(|again| (reason, again))
    });
    let told = match told {
        Ok(line) => serde_json::from_str(&line).map_err(|e| {
            Complaint::failed(format!("the page that was made cannot be read: {e}"))
        })?,
        Err((reason, _)) => Told::Page(without_model(args, &reason)),
    };
    match told {
        Told::Page(shown) => Ok(shown),
        Told::Complaint { message, hints } => {
            Err(hints.into_iter().fold(Complaint::failed(message), Complaint::hint))
        }
    }
}

/// The words that ask this program for a page, apart.
fn words(args: &ViewArgs, unchecked: Option<&str>) -> Vec<OsString> {
    let mut words: Vec<OsString> = ["view", "--here", "--seed"].map(OsString::from).into();
    words.push(args.seed.to_string().into());
    if args.allow_outside {
        words.push("--allow-outside".into());
    }
    if let Some(reason) = unchecked {
        words.push(format!("--unchecked={reason}").into());
    }
    words.push("--".into());
    words.push(args.path.clone().into_os_string());
    words
}

/// A page that says why there is nothing to see.
fn without_model(args: &ViewArgs, reason: &str) -> Shown {
    let verdict = undecided(reason, &CheckOptions::default());
    let name = args.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let notes = vec![reason.to_owned()];
    let subject =
        Subject { name: &name, robot: None, verdict: Some(&verdict), sidecar: None, notes };
    let html = page::write(&scene(&subject));
    let (tier, notes) = (Some(verdict.tier.name().to_owned()), subject.notes);
    Shown { html, name, links: 0, moving_joints: 0, tier, failures: vec![], notes }
}

/// Puts the page in its place by one step; a link that stands there is replaced, not followed.
fn write(out: &Path, html: &str) -> Result<(), Complaint> {
    let failed = |e: std::io::Error| Complaint::failed(format!("{}: {e}", out.display()));
    let folder = out.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".kinfold-page-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    let mut file = builder.tempfile_in(folder).map_err(failed)?;
    file.write_all(html.as_bytes()).map_err(failed)?;
    file.persist(out).map(drop).map_err(|e| failed(e.error))
}

/// Asks the desktop to show the page; why it does not, otherwise.
fn open(page: &Path) -> Option<String> {
    let whole = std::fs::canonicalize(page).unwrap_or_else(|_| page.to_path_buf());
    open_address(whole.as_os_str())
}

/// Asks the desktop to show what an address leads to; why it does not, otherwise.
pub(super) fn open_address(address: impl AsRef<std::ffi::OsStr>) -> Option<String> {
    let program = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    let mut command = Command::new(program);
    command.arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    match command.status() {
        Ok(status) if status.success() || cfg!(windows) => None,
        Ok(status) => Some(format!("{program} did not open the page ({status})")),
        Err(e) => Some(format!("no browser was opened: {program}: {e}")),
    }
}

fn told(out: &Path, shown: &Shown, opened: Option<String>, json: bool) -> Answer {
    let exit = if shown.links == 0 { Exit::Losses } else { Exit::Done };
    let result = if json {
        let value = json!({
            "page": out.display().to_string(),
            "name": shown.name,
            "links": shown.links,
            "moving_joints": shown.moving_joints,
            "tier": shown.tier,
            "failures": shown.failures,
            "notes": shown.notes,
        });
        format!("{value:#}\n")
    } else {
        format!("{}\n", guard::text::shown(&out.display().to_string()))
    };
    let mut remarks = shown.notes.clone();
    if let Some(tier) = shown.tier.as_ref().filter(|_| !shown.failures.is_empty()) {
        remarks
            .push(format!("tier {tier}: the page shows what {} found", shown.failures.join(", ")));
    }
    remarks.extend(opened);
    Answer { result, remarks, exit }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use super::*;

    #[test]
    fn only_a_page_of_ours_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("a.html");
        ours_or_new(&out).unwrap();
        write(&out, &page::write(&page::Scene::default())).unwrap();
        ours_or_new(&out).unwrap();
        std::fs::write(&out, "<!doctype html><p>mine").unwrap();
        let message = ours_or_new(&out).unwrap_err().message;
        assert!(message.ends_with("is there already, and is no page of kinfold's"), "{message}");
        assert!(ours_or_new(folder.path()).is_err());
    }

    #[test]
    fn a_file_that_breaks_its_reader_still_gets_a_page() {
        let cli =
            <crate::cli::args::Cli as clap::Parser>::parse_from(["kinfold", "view", "a.urdf"]);
        let crate::cli::args::Command::View(args) = cli.command else { unreachable!() };
        let shown = without_model(&args, "it took too long");
        assert!(shown.html.contains(OURS) && shown.html.contains("it took too long"));
    }
}
