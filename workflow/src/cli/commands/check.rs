//! `kinfold check`: how far do URDFs get?

mod causes;
mod forecasts;
mod kind;
mod told;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Duration;

use guard::files::Refused;
use guard::folder::{Caps, Entry, Folder, Kind};
use indicatif::ProgressBar;
use serde_json::json;
use sim_check::{
    Asked, Base, CheckOptions, Outside, Places, Status, Subject, Tier, Verdict, junit,
};

use crate::cli::args::{self as asked, CheckArgs};
use crate::cli::isolated::{Checker, Isolation, NAMES, serve};
use crate::cli::program;
use crate::cli::speech::{Answer, Complaint, Exit};

/// The longest time to look for URDFs in a folder.
const LONGEST_WALK: Duration = Duration::from_secs(600);

/// A file and what was found about it.
type Checked = (String, Verdict);

/// Checks URDFs; the exit code compares the tiers they reach with the tier asked for.
///
/// # Errors
/// [`Complaint`] when there is no such file, or a report cannot be written.
pub fn check(args: &CheckArgs) -> Result<Answer, Complaint> {
    let options = options(args);
    if args.here && args.paths == [Path::new(NAMES)] {
        serve(&options).map_err(|e| Complaint::failed(format!("names on standard input: {e}")))?;
        return Ok(Answer::done(String::new()));
    }
    let files = urdfs(&args.paths)?;
    if args.here {
        let [file] = &files[..] else { return Err(Complaint::misused("--here takes one file")) };
        return Ok(Answer::done(sim_check::check(file, &options).to_json()));
    }
    let checked = check_all(&files, &options, args)?;
    if let Some(path) = &args.junit {
        let report = junit::report(&checked, args.tier);
        let failed = |e| Complaint::failed(format!("{}: {e}", path.display()));
        std::fs::write(path, report).map_err(failed)?;
    }
    let is_one = matches!(&args.paths[..], [path] if !path.is_dir());
    let foreseen = foreseen(&files, args);
    if let ([(name, verdict)], [file], false) = (&checked[..], &files[..], args.json)
        && let Some(kind) = kind::not_xml(file, verdict)
    {
        let answer = no_model(name, kind, exit(verdict, args.tier));
        // What is no model for a check may be USD, which rules read.
        return Ok(Answer { result: told_of_all(&files, &foreseen, args), ..answer });
    }
    let mut result: String = match (is_one, args.json) {
        (true, true) if foreseen.is_empty() => checked.iter().map(|(_, v)| v.to_json()).collect(),
        (true, true) => {
            checked.iter().zip(&foreseen).map(|((_, v), f)| with_forecast(v, f)).collect()
        }
        (true, false) => {
            checked.iter().map(|(_, v)| told::told(v, args.tier, args.verbose)).collect()
        }
        (false, true) => lines_of_json(&checked, &foreseen),
        (false, false) => overview(&checked, args.tier),
    };
    if !args.json {
        result += &told_of_all(&files, &foreseen, args);
    }
    let exit = checked.iter().map(|(_, v)| exit(v, args.tier)).max_by_key(badness);
    let mut remarks = remarks(&checked, args);
    remarks.extend(
        foreseen.iter().filter_map(|f| f.as_ref().err()).map(|e| format!("no forecast: {e}")),
    );
    Ok(Answer { result, remarks, exit: exit.unwrap_or(Exit::Done) })
}

/// What is forecast of each file; nothing where nobody asked.
fn foreseen(files: &[PathBuf], args: &CheckArgs) -> Vec<forecasts::Of> {
    let Some(clients) = &args.clients else { return Vec::new() };
    files.iter().map(|file| forecasts::of(file, &clients.0, args.allow_outside)).collect()
}

/// The forecasts of all files, each under its name where there are several.
fn told_of_all(files: &[PathBuf], foreseen: &[forecasts::Of], args: &CheckArgs) -> String {
    let mut out = String::new();
    for (file, of) in files.iter().zip(foreseen) {
        let Ok(of) = of else { continue };
        if files.len() > 1 {
            let _ = writeln!(out, "\n{}", guard::text::shown(&file.display().to_string()));
        }
        out += &forecasts::told(of, args.verbose);
    }
    out
}

/// A verdict with its forecast beside it, as JSON.
fn with_forecast(verdict: &Verdict, forecast: &forecasts::Of) -> String {
    #[derive(serde::Serialize)]
    struct Both<'a> {
        #[serde(flatten)]
        verdict: &'a Verdict,
        forecast: Option<&'a Vec<forecast::Forecast>>,
    }
    let both = Both { verdict, forecast: forecast.as_ref().ok() };
    let text = serde_json::to_string_pretty(&both).unwrap_or_default();
    guard::text::json(&text).into_owned() + "\n"
}

/// A file that is no model at all: one line, whatever could not be judged of it.
fn no_model(name: &str, kind: &str, exit: Exit) -> Answer {
    let told = format!("error: {name}: {kind} is not read: expected URDF or MJCF, which are XML");
    Answer { result: String::new(), remarks: vec![told], exit }
}

fn options(args: &CheckArgs) -> CheckOptions {
    CheckOptions {
        seed: args.seed,
        up_to: args.tier.max(Tier::Dynamic),
        waivers: args.waive.iter().cloned().collect(),
        outside: if args.allow_outside { Outside::Allowed } else { Outside::Refused },
        subject: args.subject.map_or(Asked::Found, |kind| {
            Asked::As(match kind {
                asked::Kind::Object => Subject::Object,
                asked::Kind::Robot => Subject::Robot,
            })
        }),
        base: args.base.map(|base| match base {
            asked::Standing::Fixed => Base::Fixed,
            asked::Standing::Free => Base::Free,
        }),
        places: Places {
            packages: args.packages.iter().cloned().collect(),
            shelves: if args.ros { shelves() } else { Vec::new() },
            env: args.env.iter().cloned().collect(),
            args: args.args.iter().cloned().collect(),
        },
        ..CheckOptions::default()
    }
}

/// Folders in which this environment's ROS looks for packages.
fn shelves() -> Vec<PathBuf> {
    let named = ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"].into_iter();
    let all = named.filter_map(std::env::var_os);
    all.flat_map(|all| std::env::split_paths(&all).collect::<Vec<_>>()).collect()
}

/// The files named, and those in the folders named, sorted within each folder. None is opened here:
/// that is for a process with a deadline.
fn urdfs(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Complaint> {
    let mut all = Vec::new();
    for path in paths {
        let failed = |e: std::io::Error| Complaint::failed(format!("{}: {e}", path.display()));
        if std::fs::metadata(path).map_err(failed)?.is_dir() {
            let found = below(path)?;
            if found.is_empty() {
                let complaint = Complaint::failed(format!("{}: no model in it", path.display()));
                let hint = "files that end in .urdf, and .xml files that hold URDF or MJCF, are \
                            looked for, at any depth";
                return Err(complaint.hint(hint));
            }
            all.extend(found);
        } else {
            all.push(path.clone());
        }
    }
    Ok(all)
}

/// Every `.urdf` below a folder, and every `.xml` that holds a model; links to folders are not
/// followed, and to files only those that lead to one below it.
fn below(folder: &Path) -> Result<Vec<PathBuf>, Complaint> {
    let failed = |e: Refused| Complaint::failed(format!("{} {e}", folder.display()));
    // A library of models has as many files as it has; the time is what is bounded.
    let caps = Caps { entries: 100_000_000, time: Some(LONGEST_WALK), ..Caps::default() };
    let opened = Folder::open(folder, caps).map_err(failed)?;
    let mut found = Vec::new();
    for Entry { path, kind } in opened.walk(Path::new(".")).map_err(failed)? {
        let is_urdf = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("urdf"))
            || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("xml"))
                && kind::is_model(&opened, &path);
        let is_file = match kind {
            Kind::Link => is_urdf && opened.real(&path).is_ok(),
            // What is no file gets a verdict that says so.
            _ => is_urdf,
        };
        if is_file {
            found.push(folder.join(path));
        }
    }
    found.sort();
    Ok(found)
}

/// Checks the files, several at a time, in processes of their own; results in order.
fn check_all(
    files: &[PathBuf],
    options: &CheckOptions,
    args: &CheckArgs,
) -> Result<Vec<Checked>, Complaint> {
    let program = program::apart()
        .map_err(|e| Complaint::failed(format!("this program cannot find itself: {e}")))?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = args.jobs.unwrap_or(cores);
    let jobs = threads.clamp(1, files.len());
    let isolation = Isolation { program, deadline: args.deadline, threads: threads.div_ceil(jobs) };
    let bar =
        if files.len() > 1 { ProgressBar::new(files.len() as u64) } else { ProgressBar::hidden() };
    let (next, (sender, receiver)) = (AtomicUsize::new(0), mpsc::channel());
    std::thread::scope(|scope| {
        for sender in std::iter::repeat_n(sender, jobs) {
            let (next, isolation, bar) = (&next, &isolation, &bar);
            scope.spawn(move || {
                let mut checker = Checker::new(isolation, options);
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(file) = files.get(index) else { return };
                    let verdict = checker.check(file);
                    bar.inc(1);
                    // The receiver outlives this scope.
                    let _ = sender.send((index, (file.display().to_string(), verdict)));
                }
            });
        }
    });
    bar.finish_and_clear();
    let mut checked: Vec<(usize, Checked)> = receiver.iter().collect();
    checked.sort_by_key(|(index, _)| *index);
    Ok(checked.into_iter().map(|(_, checked)| checked).collect())
}

/// One line of JSON per file: its name, its verdict, and its forecast where one was asked for.
fn lines_of_json(checked: &[Checked], foreseen: &[forecasts::Of]) -> String {
    let line = |(i, (file, verdict)): (usize, &Checked)| match foreseen.get(i) {
        None => format!("{}\n", json!({"file": file, "verdict": verdict})),
        Some(of) => {
            let of = of.as_ref().ok();
            format!("{}\n", json!({"file": file, "verdict": verdict, "forecast": of}))
        }
    };
    checked.iter().enumerate().map(line).collect()
}

/// One line per file: the tier it reaches and the checks that keep it there.
fn overview(checked: &[Checked], asked: Tier) -> String {
    let mut out = String::new();
    let width =
        checked.iter().map(|(f, _)| guard::text::shown(f).chars().count()).max().unwrap_or(0);
    for (file, verdict) in checked {
        let file = guard::text::shown(file);
        let failed = verdict.failures().filter(|c| c.status == Status::Fail);
        let mut told: Vec<_> = failed.map(|c| c.id.clone()).collect();
        match verdict.counts.unknown {
            0 => {}
            open => told.push(format!("({open} not judged)")),
        }
        let line = format!("{:<9}  {file:<width$}  {}", verdict.tier.name(), told.join(" "));
        let _ = writeln!(out, "{}", line.trim_end());
    }
    let reached = checked.iter().filter(|(_, v)| v.tier >= asked).count();
    let _ = writeln!(out, "{reached} of {} reach {}", checked.len(), asked.name());
    out
}

fn exit(verdict: &Verdict, asked: Tier) -> Exit {
    match verdict.tier {
        tier if tier >= asked => Exit::Done,
        Tier::None => Exit::Failed,
        _ => Exit::Losses,
    }
}

/// Of several files the worst decides: nothing reached is worse than less than asked.
fn badness(exit: &Exit) -> u8 {
    match exit {
        Exit::Done => 0,
        Exit::Losses => 1,
        _ => 2,
    }
}

fn remarks(checked: &[Checked], args: &CheckArgs) -> Vec<String> {
    // Of several files the overview says it already.
    let below = checked.iter().filter(|(_, v)| checked.len() == 1 && v.tier < args.tier);
    let asked = args.tier.name();
    let below = below.map(|(file, v)| format!("{file}: tier {}, asked for {asked}", v.tier.name()));
    let is_used =
        |id: &str| checked.iter().any(|(_, v)| v.check(id).is_some_and(|c| c.waived.is_some()));
    let unused = args.waive.iter().filter(|(id, _)| !is_used(id));
    let unused =
        unused.map(|(id, _)| format!("--waive {id}: nothing failed it, so nothing was waived"));
    below.chain(unused).collect()
}
