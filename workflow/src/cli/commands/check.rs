//! `kinfold check`: how far do URDFs get?

mod answers;
mod baseline;
mod causes;
mod changed;
mod checked;
mod config;
mod forecasts;
mod kind;
mod scan;
mod told;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Duration;

use guard::files::Refused;
use guard::folder::{Caps, Entry, Folder, Kind};
use indicatif::ProgressBar;
use serde_json::json;
use sim_check::report::{Item, html, junit, markdown, sarif};
use sim_check::{Asked, Base, CheckOptions, Outside, Places, Status, Subject, Tier, Verdict};

pub use scan::scan;

use baseline::Baseline;
use checked::Checked;
use config::{Manner, Settings};

use crate::cli::args::{self as asked, CheckArgs};
use crate::cli::isolated::{Checker, Isolation, NAMES, serve};
use crate::cli::program;
use crate::cli::speech::{Answer, Complaint, Exit};

/// The longest time to look for URDFs in a folder.
const LONGEST_WALK: Duration = Duration::from_secs(600);

/// Checks URDFs; the exit code compares the tiers they reach with the tier asked for.
///
/// # Errors
/// [`Complaint`] when there is no such file, or a report cannot be written.
pub fn check(args: &CheckArgs) -> Result<Answer, Complaint> {
    if args.here {
        return here(args);
    }
    let (checked, remarks) = gathered(args)?;
    let is_one = matches!(&args.paths[..], [path] if !path.is_dir());
    let foreseen = foreseen(&checked, args);
    if let ([of], false) = (&checked[..], args.json)
        && let Some(kind) = kind::not_xml(&of.path, &of.verdict)
    {
        let answer = no_model(&of.name, kind, exit(of));
        // What is no model for a check may be USD, which rules read.
        return Ok(Answer { result: told_of_all(&checked, &foreseen, args), ..answer });
    }
    let mut result: String = match (is_one, args.json) {
        (true, true) if foreseen.is_empty() => {
            checked.iter().map(|c| c.verdict.to_json()).collect()
        }
        (true, true) => {
            checked.iter().zip(&foreseen).map(|(c, f)| with_forecast(&c.verdict, f)).collect()
        }
        (true, false) => {
            checked.iter().map(|c| told::told(&c.verdict, c.asked, args.verbose)).collect()
        }
        (false, true) => lines_of_json(&checked, &foreseen),
        (false, false) => overview(&checked),
    };
    if !args.json {
        result += &told_of_all(&checked, &foreseen, args);
    }
    let mut exits: Vec<Exit> = checked.iter().map(exit).collect();
    let mut remarks = [remarks, self::remarks(&checked)].concat();
    if args.portable {
        for (of, foreseen) in checked.iter().zip(&foreseen) {
            if let Some(why) = forecasts::obstacles(foreseen) {
                exits.push(Exit::Losses);
                remarks.push(format!("{}: not portable: {why}", of.name));
            }
        }
    }
    let exit = exits.into_iter().max_by_key(badness);
    remarks.extend(
        foreseen.iter().filter_map(|f| f.as_ref().err()).map(|e| format!("no forecast: {e}")),
    );
    Ok(Answer { result, remarks, exit: exit.unwrap_or(Exit::Done) })
}

/// One file, or those named on standard input, in this process.
///
/// # Errors
/// [`Complaint`] when it is not one file, or names cannot be read.
pub(in crate::cli) fn here(args: &CheckArgs) -> Result<Answer, Complaint> {
    let options = options(args, Manner::default(), &Settings::default());
    if args.paths == [Path::new(NAMES)] {
        serve(&options).map_err(|e| Complaint::failed(format!("names on standard input: {e}")))?;
        return Ok(Answer::done(String::new()));
    }
    let [file] = &args.paths[..] else {
        return Err(Complaint::misused("--here takes one file"));
    };
    Ok(Answer::done(sim_check::check(file, &options).to_json()))
}

/// Every file with its verdict, answered for by whoever may; reports are written. With what is to be said.
fn gathered(args: &CheckArgs) -> Result<(Vec<Checked>, Vec<String>), Complaint> {
    let settings = Settings::find(args.config.as_deref(), !args.no_config)?;
    let baseline = args.baseline.as_deref().map(Baseline::read).transpose()?;
    let mut files = urdfs(&args.paths, &settings)?;
    let mut remarks = Vec::new();
    if let Some(path) = &settings.path {
        remarks.push(format!("settings from {}", path.display()));
    }
    if let Some(reference) = &args.changed_since {
        let all = files.len();
        files = changed::changed(files, reference)?;
        remarks.push(format!("{} of {all} models are touched since {reference}", files.len()));
    }
    let mut checked = check_all(&files, args, &settings)?;
    let again = |file: &Path, reason: &str| {
        let mut options = options(args, settings.manner(file), &settings);
        options.waivers.insert("C1".into(), reason.to_owned());
        match isolation(args, 1) {
            Ok(isolation) => Checker::new(&isolation, &options).check(file),
            Err(why) => sim_check::undecided(&why.message, &options),
        }
    };
    remarks.extend(answers::given(&mut checked, args, (&settings, baseline.as_ref()), &again));
    reports(&checked, args)?;
    if let Some(path) = &args.write_baseline {
        let all = checked.iter().map(|c| (c.path.as_path(), &c.verdict));
        let count = baseline::write(path, all)?;
        remarks.push(format!("{} knows {count} findings", path.display()));
    }
    Ok((checked, remarks))
}

/// Writes the reports that are asked for.
fn reports(checked: &[Checked], args: &CheckArgs) -> Result<(), Complaint> {
    type Report = fn(&[Item<'_>]) -> String;
    let wanted: [(&Option<PathBuf>, Report); 4] = [
        (&args.junit, junit::report),
        (&args.sarif, sarif::report),
        (&args.markdown, markdown::report),
        (&args.html, html::report),
    ];
    let items: Vec<Item<'_>> = checked.iter().map(Checked::item).collect();
    for (path, report) in wanted {
        if let Some(path) = path {
            let failed = |e| Complaint::failed(format!("{}: {e}", path.display()));
            std::fs::write(path, report(&items)).map_err(failed)?;
        }
    }
    Ok(())
}

/// What is forecast of each file; nothing where nobody asked.
fn foreseen(files: &[Checked], args: &CheckArgs) -> Vec<forecasts::Of> {
    let clients = match &args.clients {
        Some(clients) => &clients.0[..],
        None if args.portable => &forecast::Client::ALL,
        None => return Vec::new(),
    };
    files.iter().map(|of| forecasts::of(&of.path, clients, args.allow_outside)).collect()
}

/// The forecasts of all files, each under its name where there are several.
fn told_of_all(files: &[Checked], foreseen: &[forecasts::Of], args: &CheckArgs) -> String {
    let mut out = String::new();
    for (file, of) in files.iter().zip(foreseen) {
        let Ok(of) = of else { continue };
        if files.len() > 1 {
            let _ = writeln!(out, "\n{}", guard::text::shown(&file.name));
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
    let told = format!("error: {name}: {kind} is not read: expected URDF, MJCF, SDFormat or USD");
    Answer { result: String::new(), remarks: vec![told], exit }
}

/// What a file is judged by: what the command says, then the settings of the repository.
fn options(args: &CheckArgs, manner: Manner, settings: &Settings) -> CheckOptions {
    let asked = args.subject.map(|kind| match kind {
        asked::Kind::Object => Subject::Object,
        asked::Kind::Robot => Subject::Robot,
    });
    let standing = args.base.map(|base| match base {
        asked::Standing::Fixed => Base::Fixed,
        asked::Standing::Free => Base::Free,
    });
    let mut packages = settings.packages.clone();
    packages.extend(args.packages.iter().cloned());
    CheckOptions {
        seed: args.seed,
        up_to: args.tier.or(manner.tier).unwrap_or(Tier::Dynamic),
        waivers: args.waive.iter().cloned().collect(),
        outside: if args.allow_outside { Outside::Allowed } else { Outside::Refused },
        subject: asked
            .or(manner.subject.map(config::Kind::subject))
            .map_or(Asked::Found, Asked::As),
        base: standing.or(manner.base.map(config::Standing::base)),
        places: Places {
            packages,
            shelves: if args.ros { shelves() } else { Vec::new() },
            env: args.env.iter().cloned().collect(),
            args: args.args.iter().cloned().collect(),
            srdf: args.srdf.clone(),
        },
        ..CheckOptions::default()
    }
}

/// Folders in which this environment's ROS looks for packages.
pub(in crate::cli) fn shelves() -> Vec<PathBuf> {
    let named = ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"].into_iter();
    let all = named.filter_map(std::env::var_os);
    all.flat_map(|all| std::env::split_paths(&all).collect::<Vec<_>>()).collect()
}

/// The files named, and those in the folders named, sorted within each folder. None is opened here:
/// that is for a process with a deadline.
fn urdfs(paths: &[PathBuf], settings: &Settings) -> Result<Vec<PathBuf>, Complaint> {
    let mut all = Vec::new();
    for path in paths {
        let failed = |e: std::io::Error| Complaint::failed(format!("{}: {e}", path.display()));
        if std::fs::metadata(path).map_err(failed)?.is_dir() {
            let found = below(path)?;
            if found.is_empty() {
                let complaint = Complaint::failed(format!("{}: no model in it", path.display()));
                let hint = "files that end in .urdf, and .xml, .sdf and .world files that hold a \
                            model, are looked for, at any depth; name a USD file itself";
                return Err(complaint.hint(hint));
            }
            all.extend(found.into_iter().filter(|file| !settings.is_left_out(file)));
        } else {
            all.push(path.clone());
        }
    }
    Ok(all)
}

/// Every `.urdf` below a folder, and every `.xml`, `.sdf` and `.world` that holds a model; links to folders are not
/// followed, and to files only those that lead to one below it.
fn below(folder: &Path) -> Result<Vec<PathBuf>, Complaint> {
    let failed = |e: Refused| Complaint::failed(format!("{} {e}", folder.display()));
    // A library of models has as many files as it has; the time is what is bounded.
    let caps = Caps { entries: 100_000_000, time: Some(LONGEST_WALK), ..Caps::default() };
    let opened = Folder::open(folder, caps).map_err(failed)?;
    let mut found = Vec::new();
    for Entry { path, kind } in opened.walk(Path::new(".")).map_err(failed)? {
        let ends = |with: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(with));
        let is_xml = ["xml", "sdf", "world"].into_iter().any(ends);
        let is_urdf = ends("urdf") || is_xml && kind::is_model(&opened, &path);
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

/// How processes check, with so many threads each.
fn isolation(args: &CheckArgs, threads: usize) -> Result<Isolation, Complaint> {
    let program = program::apart()
        .map_err(|e| Complaint::failed(format!("this program cannot find itself: {e}")))?;
    Ok(Isolation { program, deadline: args.deadline, threads })
}

/// Checks the files, several at a time, in processes of their own; results in order.
fn check_all(
    files: &[PathBuf],
    args: &CheckArgs,
    settings: &Settings,
) -> Result<Vec<Checked>, Complaint> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = args.jobs.unwrap_or(cores);
    let jobs = threads.clamp(1, files.len().max(1));
    let isolation = isolation(args, threads.div_ceil(jobs))?;
    let manners: Vec<Manner> = files.iter().map(|file| settings.manner(file)).collect();
    let mut ways = manners.clone();
    ways.sort_unstable();
    ways.dedup();
    let ways: Vec<(Manner, CheckOptions)> =
        ways.into_iter().map(|manner| (manner, options(args, manner, settings))).collect();
    let bar =
        if files.len() > 1 { ProgressBar::new(files.len() as u64) } else { ProgressBar::hidden() };
    let (next, (sender, receiver)) = (AtomicUsize::new(0), mpsc::channel());
    std::thread::scope(|scope| {
        for sender in std::iter::repeat_n(sender, jobs) {
            let (next, isolation, bar, ways, manners) = (&next, &isolation, &bar, &ways, &manners);
            scope.spawn(move || {
                // A process for each way of judging; none is started before it is asked.
                let mut checkers: Vec<_> =
                    ways.iter().map(|(of, how)| (of, Checker::new(isolation, how))).collect();
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let (Some(file), Some(manner)) = (files.get(index), manners.get(index)) else {
                        return;
                    };
                    let Some((_, checker)) = checkers.iter_mut().find(|(of, _)| *of == manner)
                    else {
                        return;
                    };
                    let verdict = checker.check(file);
                    bar.inc(1);
                    let checked = Checked {
                        path: file.clone(),
                        name: file.display().to_string(),
                        verdict,
                        // A file that can be posed is of use.
                        asked: args.tier.or(manner.tier).unwrap_or(Tier::Kinematic),
                        source: None,
                    };
                    // The receiver outlives this scope.
                    let _ = sender.send((index, checked));
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
    let line = |(i, Checked { name, verdict, .. }): (usize, &Checked)| match foreseen.get(i) {
        None => format!("{}\n", json!({"file": name, "verdict": verdict})),
        Some(of) => {
            let of = of.as_ref().ok();
            format!("{}\n", json!({"file": name, "verdict": verdict, "forecast": of}))
        }
    };
    checked.iter().enumerate().map(line).collect()
}

/// One line per file: the tier it reaches and the checks that keep it there.
fn overview(checked: &[Checked]) -> String {
    let mut out = String::new();
    let width =
        checked.iter().map(|c| guard::text::shown(&c.name).chars().count()).max().unwrap_or(0);
    for Checked { name, verdict, .. } in checked {
        let file = guard::text::shown(name);
        let failed = verdict.failures().filter(|c| c.status == Status::Fail);
        let mut told: Vec<_> = failed.map(|c| c.id.clone()).collect();
        match verdict.counts.unknown {
            0 => {}
            open => told.push(format!("({open} not judged)")),
        }
        let line = format!("{:<9}  {file:<width$}  {}", verdict.tier.name(), told.join(" "));
        let _ = writeln!(out, "{}", line.trim_end());
    }
    let reached = checked.iter().filter(|c| c.item().is_enough()).count();
    let asked: BTreeSet<Tier> = checked.iter().map(|c| c.asked).collect();
    let what = match asked.first() {
        Some(tier) if asked.len() == 1 => tier.name(),
        _ => "what is asked of them",
    };
    let _ = writeln!(out, "{reached} of {} reach {what}", checked.len());
    out
}

fn exit(of: &Checked) -> Exit {
    match of.verdict.tier {
        tier if tier >= of.asked => Exit::Done,
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

/// Of several files the overview says it already.
fn remarks(checked: &[Checked]) -> Vec<String> {
    let below = checked.iter().filter(|c| checked.len() == 1 && !c.item().is_enough());
    let told = |c: &Checked| {
        let (tier, asked) = (c.verdict.tier.name(), c.asked.name());
        format!("{}: tier {tier}, asked for {asked}", c.name)
    };
    below.map(told).collect()
}
