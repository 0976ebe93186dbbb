//! `kinfold mutate`: defects of known kinds, planted in copies of a sound model.
//!
//! Strangers' files are read in a process apart; this one writes the folders.

mod asked;
mod here;
mod list;
mod written;

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::Path;

use sim_check::{CheckOptions, Places, Subject, Verdict};
use similar::TextDiff;

use self::asked::options;
use self::here::{Line, Made};
use self::written::{Content, Making};
use crate::cli::args::{Kind as AskedKind, MutateArgs};
use crate::cli::isolated::{Checker, Isolation};
use crate::cli::program;
use crate::cli::speech::{Answer, Complaint, Exit};
use crate::mutate::kinds;
use crate::mutate::manifest::{FILE, Manifest, Mutant, ORIGINAL, Original, SCHEMA};

/// What a hunk of a diff shows around a change, lines: as diff and git do.
const AROUND: usize = 3;

/// Plants defects, or lists their kinds.
///
/// # Errors
/// [`Complaint`] when there is no such file, it is no sound model, or the folder cannot be written.
pub fn mutate(args: &MutateArgs) -> Result<Answer, Complaint> {
    if args.list {
        return Ok(Answer::done(list::list(args.json)));
    }
    let (Some(file), Some(out)) = (&args.model, &args.out) else {
        return Err(Complaint::misused("names no model or no folder"));
    };
    if args.here {
        return here::answer(file, args);
    }
    let failed = |e: std::io::Error| Complaint::failed(format!("{}: {e}", file.display()));
    if std::fs::metadata(file).map_err(failed)?.is_dir() {
        let message = format!("{} is a folder: one model is taken at a time", file.display());
        return Err(Complaint::misused(message));
    }
    written::look(out)?;
    let made = made(file, args)?;
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let making = Making::begin(out)?;
    let manifest = filled(&making, made, (&name, args))?;
    let mut names: BTreeSet<String> = BTreeSet::new();
    names.insert(FILE.into());
    files_below(making.root(), making.root(), &mut names)
        .map_err(|e| Complaint::failed(format!("{}: {e}", out.display())))?;
    making.publish(names)?;
    Ok(told(&manifest, (file, out), args))
}

fn isolation(args: &MutateArgs) -> Result<Isolation, Complaint> {
    let program = program::apart()
        .map_err(|e| Complaint::failed(format!("this program cannot find itself: {e}")))?;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    Ok(Isolation { program, deadline: args.deadline, threads })
}

/// The words that ask this program to plant defects, apart.
fn words(file: &Path, args: &MutateArgs) -> Vec<OsString> {
    let mut all: Vec<OsString> =
        ["mutate", "--here", "--out", ".", "--seed"].map(Into::into).into();
    all.push(args.seed.to_string().into());
    all.extend(args.kinds.iter().flat_map(|k| ["--kind".into(), k.into()]));
    all.extend(args.allow_outside.then(|| "--allow-outside".into()));
    let subject = args.subject.map(|kind| match kind {
        AskedKind::Object => "object",
        AskedKind::Robot => "robot",
    });
    all.extend(subject.into_iter().flat_map(|word| ["--as".into(), word.into()]));
    for (name, folder) in &args.packages {
        let mut told = OsString::from(format!("{name}="));
        told.push(folder);
        all.extend(["--package".into(), told]);
    }
    all.extend(["--".into(), file.as_os_str().to_owned()]);
    all
}

fn made(file: &Path, args: &MutateArgs) -> Result<Made, Complaint> {
    let line = isolation(args)?.line(words(file, args)).map_err(|reason| {
        let complaint = Complaint::failed(format!("{}: {reason}", file.display()));
        complaint.hint("give it more time with --deadline")
    })?;
    let line: Line = serde_json::from_str(&line)
        .map_err(|e| Complaint::failed(format!("the answer of the other process is odd: {e}")))?;
    match line {
        Line::Made(made) => Ok(*made),
        Line::Complaint(message) => {
            let hint = "defects are planted in models that `kinfold check` reads to the end";
            Err(Complaint::failed(message).hint(hint))
        }
    }
}

/// Writes all folders, and says what stands in them.
fn filled(
    making: &Making,
    made: Made,
    (name, args): (&str, &MutateArgs),
) -> Result<Manifest, Complaint> {
    let odd = || Complaint::failed("the answer of the other process is odd: a file is no base64");
    let bytes_of = |files: &BTreeMap<String, here::Bytes>| {
        let all = files.iter().map(|(to, b)| Some((to.clone(), b.bytes()?)));
        all.collect::<Option<BTreeMap<String, Vec<u8>>>>().ok_or_else(odd)
    };
    let needed = bytes_of(&made.files)?;
    let mut files: BTreeMap<String, Content> = BTreeMap::new();
    files.insert(format!("{ORIGINAL}/{name}"), Content::Bytes(made.text.as_bytes()));
    let original = needed.iter().map(|(to, b)| (format!("{ORIGINAL}/{to}"), Content::Bytes(b)));
    files.extend(original);
    making.fill(&files)?;
    let mut mutants = Vec::new();
    for defect in &made.mutants {
        let Some(kind) = kinds::known(&defect.kind) else { continue };
        let (folder, changed) = (&defect.kind, bytes_of(&defect.files)?);
        let mut files: BTreeMap<String, Content> = BTreeMap::new();
        files.insert(format!("{folder}/{name}"), Content::Bytes(defect.text.as_bytes()));
        for to in needed.keys() {
            let content = match changed.get(to) {
                Some(bytes) => Content::Bytes(bytes),
                None => Content::Same(format!("{ORIGINAL}/{to}")),
            };
            files.insert(format!("{folder}/{to}"), content);
        }
        making.fill(&files)?;
        let diff = TextDiff::from_lines(made.text.as_str(), defect.text.as_str());
        let (from, to) = (format!("{ORIGINAL}/{name}"), format!("{folder}/{name}"));
        let diff = diff.unified_diff().context_radius(AROUND).header(&from, &to).to_string();
        mutants.push(Mutant {
            kind: kind.id.into(),
            folder: folder.clone(),
            subject: defect.subject.clone(),
            line: defect.line,
            change: defect.change.clone(),
            wrong: kind.wrong.into(),
            rules: kind.rules.iter().map(|r| (*r).to_owned()).collect(),
            files: changed.into_keys().collect(),
            diff,
        });
    }
    let manifest = Manifest {
        schema: SCHEMA.into(),
        model: name.to_owned(),
        format: made.format,
        seed: args.seed,
        renamed: made.renamed,
        original: judged(&making.root().join(ORIGINAL).join(name), args)?,
        mutants,
        not_applicable: made.not_applicable,
    };
    let text = json(&manifest);
    making.fill(&BTreeMap::from([(FILE.to_owned(), Content::Bytes(text.as_bytes()))]))?;
    Ok(manifest)
}

fn json(manifest: &Manifest) -> String {
    let text = serde_json::to_string_pretty(manifest).unwrap_or_default();
    guard::text::json(&text).into_owned() + "\n"
}

/// What `kinfold check` says of the copy without a defect.
fn judged(file: &Path, args: &MutateArgs) -> Result<Original, Complaint> {
    let options = CheckOptions { places: Places::default(), ..options(args) };
    let verdict: Verdict = Checker::new(&isolation(args)?, &options).check(file);
    let subject = verdict.judged.as_ref().map_or(Subject::Object, |j| j.subject);
    Ok(Original {
        folder: ORIGINAL.into(),
        judged: subject.name().into(),
        tier: verdict.tier.name().into(),
        failing: verdict.failures().map(|c| c.id.clone()).collect(),
    })
}

/// The files below a folder, by path in it with `/` between.
fn files_below(root: &Path, folder: &Path, names: &mut BTreeSet<String>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            files_below(root, &path, names)?;
        } else if let Ok(name) = path.strip_prefix(root) {
            let parts: Vec<_> =
                name.components().map(|c| c.as_os_str().to_string_lossy()).collect();
            names.insert(parts.join("/"));
        }
    }
    Ok(())
}

fn told(manifest: &Manifest, (file, out): (&Path, &Path), args: &MutateArgs) -> Answer {
    let (mutants, original) = (&manifest.mutants, &manifest.original);
    let result = if args.json {
        json(manifest)
    } else {
        let wide = mutants.iter().map(|m| m.kind.len()).max().unwrap_or(0);
        let line = |m: &Mutant| {
            format!("{:wide$}  {} (line {}): {}\n", m.kind, m.subject, m.line, m.change)
        };
        mutants.iter().map(line).collect()
    };
    let mut remarks = Vec::new();
    if !args.json {
        remarks.extend(
            manifest
                .not_applicable
                .iter()
                .map(|n| format!("does not apply: {}: {}", n.kind, n.why)),
        );
    }
    if !original.failing.is_empty() {
        let (name, failing) = (file.display(), original.failing.join(", "));
        remarks.push(format!(
            "warning: {name} has findings of its own, judged as {}: {failing}",
            original.judged
        ));
    }
    remarks.push(format!(
        "{} defects of {} kinds in {}, and the model without one in {ORIGINAL}",
        mutants.len(),
        mutants.len() + manifest.not_applicable.len(),
        out.display()
    ));
    let is_whole = !mutants.is_empty() && original.failing.is_empty();
    Answer { result, remarks, exit: if is_whole { Exit::Done } else { Exit::Losses } }
}
