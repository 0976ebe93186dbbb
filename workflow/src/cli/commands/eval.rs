//! `kinfold eval`: what an articulator is worth on objects whose parts and joints are known.

use std::fs;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use model::features::{ClipText, NgramText, TextFeatures};
use model::net::Precision;
use model::{Neural, NeuralError, Predecessor, articulator};
use training::evaluate::case::name_of;
use training::evaluate::csv::{csv, heading, line};
use training::evaluate::sheet::{sheet, strip};
use training::evaluate::table::table;
use training::evaluate::{
    How, Mode, Prompts, Report, Row, Set, Solver, Without, case, evaluate_all,
};
use training::metrics::Rules;

use super::supply;
use crate::cli::args::{EvalArgs, Labels, Prompted, Who, Withheld};
use crate::cli::speech::{Answer, Complaint, Exit};

/// Evaluates an articulator; the table is the answer, files are written where they were asked for.
///
/// # Errors
/// [`Complaint`] when there are no cases, no such articulator or a file cannot be written. A case
/// without an answer is no error but a row, and exit 3.
pub fn eval(args: &EvalArgs) -> Result<Answer, Complaint> {
    let solver = solver(args)?;
    let folders = folders(args)?;
    let how = how(args);
    check_places(args)?;
    let solver = supplied(solver, args)?;
    let mut progress = Progress::new(args.quiet, folders.len());
    let mut diary = args.csv.as_deref().map(Diary::open).transpose()?;
    let told = |row: &Row, took: Duration| {
        progress.tell(row, took);
        diary.iter_mut().for_each(|d| d.note(row));
    };
    let rows = evaluate_all(&folders, &solver, &how, usize::from(args.jobs), told);
    progress.clear();
    let rows = rows.map_err(|e| Complaint::from_error(&e))?;
    let report = Report::new(&solver, how, rows);
    write_files(args, &report, &folders, &solver)?;
    let remarks: Vec<_> = report.failed().filter_map(complaint_of).collect();
    let exit = if remarks.is_empty() { Exit::Done } else { Exit::Losses };
    Ok(Answer { result: table(&report), remarks, exit })
}

fn complaint_of(row: &Row) -> Option<String> {
    Some(format!("{}: {}", row.case, row.error.as_ref()?))
}

fn how(args: &EvalArgs) -> How {
    let withheld = |what| args.without.contains(&what);
    How {
        rules: if args.ref_compat { Rules::RefCompat } else { Rules::Paper },
        without: Without { text: withheld(Withheld::Text), points: withheld(Withheld::Points) },
        prompts: match args.prompts {
            Prompted::AsGiven => Prompts::AsGiven,
            Prompted::Anywhere => Prompts::Anywhere,
        },
        points: args.points as usize,
        seed: args.seed,
    }
}

fn folders(args: &EvalArgs) -> Result<Vec<PathBuf>, Complaint> {
    let mut folders = case::folders(&args.cases).map_err(|e| Complaint::from_error(&e))?;
    let all = folders.len();
    folders.retain(|folder| {
        let name = name_of(folder);
        let set = Set::of(&name);
        let in_set = args.set.is_empty() || args.set.contains(&set);
        in_set && args.filter.as_ref().is_none_or(|text| name.contains(text.as_str()))
    });
    if folders.is_empty() {
        let none = format!("{}: none of {all} cases is asked for", args.cases.display());
        return Err(Complaint::misused(none).hint("ask for more with --set and --filter"));
    }
    Ok(folders)
}

fn solver(args: &EvalArgs) -> Result<Solver, Complaint> {
    check_words(args)?;
    match (args.articulator, &args.weights) {
        (Who::Net, None) => {
            let told =
                Complaint::misused("the network needs weights: expected --weights, found none");
            Err(told.hint("name them with --weights FILE.safetensors"))
        }
        (Who::Net, Some(weights)) => network(weights, args),
        (Who::Particulate, weights) => {
            predecessor([weights.as_deref(), args.point_features.as_deref()])
        }
        _ if args.labels == Some(Labels::Truth) => Ok(Solver::JointsOnTrueLabels),
        (Who::Ships(choice), _) => Ok(Solver::Whole(articulator(choice))),
    }
}

/// What is asked for goes with who answers.
fn check_words(args: &EvalArgs) -> Result<(), Complaint> {
    use Who::{Net, Particulate};
    let (who, true_labels) = (args.articulator, args.labels == Some(Labels::Truth));
    let only_net = "add --articulator net, or leave";
    let rules = [
        (
            who == Net && true_labels,
            "the network finds labels and joints together",
            "--labels truth goes with --articulator geometric".to_owned(),
        ),
        (
            who == Particulate
                && (true_labels || !args.without.is_empty() || args.mode != Mode::Mesh),
            "Particulate is given a mesh, and nothing more",
            "--articulator particulate goes with --mode mesh alone".to_owned(),
        ),
        (
            who != Particulate && args.point_features.is_some(),
            "only Particulate reads point features",
            "add --articulator particulate, or leave --point-features out".to_owned(),
        ),
        (
            who != Net && args.precision.is_some(),
            "only the network has a precision",
            format!("{only_net} --precision out"),
        ),
        (
            who != Net && args.text_features.is_some(),
            "only the network is told how to read texts",
            format!("{only_net} --text-features out"),
        ),
        (
            !matches!(who, Net | Particulate) && args.weights.is_some(),
            "only networks have weights",
            format!("{only_net} --weights out"),
        ),
    ];
    match rules.into_iter().find(|(broken, ..)| *broken) {
        Some((_, told, hint)) => Err(Complaint::misused(told).hint(hint)),
        None => Ok(()),
    }
}

/// Particulate, known by the digests of both its files.
fn predecessor(files: [Option<&Path>; 2]) -> Result<Solver, Complaint> {
    let [Some(weights), Some(features)] = files else {
        let told = Complaint::misused("Particulate needs its own weights and PartField's");
        return Err(told.hint("name them with --weights FILE and --point-features FILE"));
    };
    let (networks, cursor) = ([read(weights)?, read(features)?], std::io::Cursor::new);
    let digests = networks.each_ref().map(|bytes| trace::Digest::of(bytes).short().to_owned());
    let [network, described] = networks.map(cursor);
    let predecessor = Predecessor::load(network, described, &digests.join(" "));
    let names = format!("{}, {}", weights.display(), features.display());
    let predecessor = predecessor.map_err(|e| Complaint::failed(format!("{names}: {e}")))?;
    Ok(Solver::Alone(Box::new(predecessor)))
}

/// The same, on what others supply, where the case does not give all.
fn supplied(solver: Solver, args: &EvalArgs) -> Result<Solver, Complaint> {
    if args.mode == Mode::MeshAndKinematic {
        return Ok(solver);
    }
    match solver {
        Solver::Whole(articulator) => {
            Ok(Solver::Supplied(articulator, Box::new(supply::hired(args)?)))
        }
        Solver::Alone(_) => Ok(solver),
        Solver::JointsOnTrueLabels | Solver::Supplied(..) => {
            let told = Complaint::misused("true labels are of the true parts");
            Err(told.hint("--labels truth goes with --mode mesh+kinematic"))
        }
    }
}

fn read(path: &Path) -> Result<Vec<u8>, Complaint> {
    fs::read(path).map_err(|e| Complaint::failed(format!("{}: {e}", path.display())))
}

/// The network of a weights file, known by the digest of what is in it; that names the encoder of
/// texts, too.
fn network(weights: &Path, args: &EvalArgs) -> Result<Solver, Complaint> {
    let name = weights.display();
    let bytes = read(weights)?;
    let digest = trace::Digest::of(&bytes);
    let text = text_features(args.text_features.as_deref())?;
    let precision = args.precision.unwrap_or_else(Precision::best);
    let network = Neural::load_with(std::io::Cursor::new(bytes), text, digest.short(), precision);
    let network = network.map_err(|e| {
        let told = Complaint::failed(format!("{name}: {e}"));
        match e {
            NeuralError::Encoder { what: "text", .. } => told.hint(ENCODER),
            _ => told,
        }
    })?;
    Ok(Solver::Whole(Box::new(network)))
}

const ENCODER: &str = "--text-features DIR names the folder of a CLIP checkpoint; without it, the \
                       embedded encoder reads the texts";

fn text_features(folder: Option<&Path>) -> Result<Box<dyn TextFeatures>, Complaint> {
    match folder {
        None => Ok(Box::new(NgramText)),
        Some(folder) => {
            let clip = ClipText::open(folder).map_err(|e| Complaint::from_error(&e))?;
            Ok(Box::new(clip))
        }
    }
}

fn write_files(
    args: &EvalArgs,
    report: &Report,
    folders: &[PathBuf],
    solver: &Solver,
) -> Result<(), Complaint> {
    if let Some(path) = &args.json {
        let json = report.to_json().map_err(|e| Complaint::from_error(&e))?;
        write(path, json.as_bytes())?;
    }
    if let Some(path) = &args.csv {
        write(path, csv(&report.cases).as_bytes())?;
    }
    if let Some(path) = &args.sheet {
        write(path, &worst(args, report, folders, solver)?)?;
    }
    Ok(())
}

/// Whoever waited for a long evaluation wants no surprise about a folder at its end.
fn check_places(args: &EvalArgs) -> Result<(), Complaint> {
    let files = [&args.json, &args.csv, &args.sheet];
    let parents = files.into_iter().flatten().filter_map(|path| path.parent());
    let mut missing = parents.filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir());
    match missing.next() {
        Some(folder) => Err(Complaint::misused(format!("{}: no such folder", folder.display()))),
        None => Ok(()),
    }
}

/// The CSV file while the evaluation goes on: rows as they come, so that a run that is killed leaves
/// what it had. The finished file, in order, takes its place at the end.
struct Diary(fs::File);

impl Diary {
    fn open(path: &Path) -> Result<Self, Complaint> {
        write(path, heading().as_bytes())?;
        let file = fs::OpenOptions::new().append(true).open(path);
        file.map(Self).map_err(|e| Complaint::failed(format!("{}: {e}", path.display())))
    }

    /// A row that cannot be noted is not lost: the finished file is written with an error of its own.
    fn note(&mut self, row: &Row) {
        let _ = self.0.write_all(line(row).as_bytes());
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Complaint> {
    fs::write(path, bytes).map_err(|e| Complaint::failed(format!("{}: {e}", path.display())))
}

/// The worst cases that can be read at all, drawn one after the other.
fn worst(
    args: &EvalArgs,
    report: &Report,
    folders: &[PathBuf],
    solver: &Solver,
) -> Result<Vec<u8>, Complaint> {
    let readable = report.worst_first().into_iter().filter(|row| row.parts > 0);
    let shown = readable.take(usize::from(args.worst)).filter_map(|row| {
        let folder = folders.iter().find(|folder| name_of(folder) == row.case)?;
        Some(strip(folder, row, solver, &report.how))
    });
    let strips = shown.collect::<Result<Vec<_>, _>>();
    strips.and_then(sheet).map_err(|e| Complaint::from_error(&e))
}

/// A line per case on stderr, and a bar on a terminal.
struct Progress {
    bar: Option<ProgressBar>,
    quiet: bool,
    all: usize,
    done: usize,
}

impl Progress {
    fn new(quiet: bool, all: usize) -> Self {
        let lively = !quiet && std::io::stderr().is_terminal();
        let bar = lively.then(|| {
            let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {eta} {msg}");
            let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
            ProgressBar::new(all as u64).with_style(style)
        });
        Self { bar, quiet, all, done: 0 }
    }

    fn tell(&mut self, row: &Row, took: Duration) {
        self.done += 1;
        let line = guard::text::shown(&self.line(row, took)).into_owned();
        match &self.bar {
            Some(bar) => {
                bar.println(line);
                bar.inc(1);
            }
            None if self.quiet => {}
            // Nobody may be listening; that is no reason to stop.
            None => drop(writeln!(std::io::stderr(), "{line}")),
        }
    }

    fn line(&self, row: &Row, took: Duration) -> String {
        let (scores, width) = (row.scores(), self.all.to_string().len());
        let found = row.joints.iter().filter(|j| j.joint.is_found()).count();
        let points = scores.point_iou.unwrap_or(scores.box_iou);
        let said = match &row.error {
            Some(_) => "no answer".to_owned(),
            None => format!("points {points:.3}  joints {found}/{}", row.joints.len()),
        };
        let (done, all, seconds) = (self.done, self.all, took.as_secs_f64());
        format!("{done:>width$}/{all}  {seconds:>5.1} s  {said:<28}  {}", row.case)
    }

    fn clear(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
