//! `kinfold bench-check`: what a checker finds of planted defects.

mod answers;
mod ours;
mod program;
mod told;

use std::path::Path;

use self::answers::{Asker, Bench, One, Original};
use self::ours::Ours;
use self::program::Program;
use crate::cli::args::BenchArgs;
use crate::cli::isolated::Isolation;
use crate::cli::program as own;
use crate::cli::speech::{Answer, Complaint, Exit};
use crate::mutate::manifest::{FILE, MOST, Manifest, Mutant, SCHEMA};

/// Asks a checker of every mutant.
///
/// # Errors
/// [`Complaint`] when a folder is none of `kinfold mutate`, or there is no such program.
pub fn bench(args: &BenchArgs) -> Result<Answer, Complaint> {
    let mut manifests = Vec::new();
    for folder in &args.mutants {
        manifests.push((folder, read(folder)?));
    }
    if let Some(name) = args.program.first()
        && !program::stands(name)
    {
        let message = format!("there is no program `{name}`");
        return Err(
            Complaint::misused(message).hint("name it by its path, and its arguments after --")
        );
    }
    let program = match args.program.is_empty() {
        true => "kinfold check".to_owned(),
        false => args.program.join(" "),
    };
    let mut bench = Bench { program, originals: vec![], mutants: vec![], not_applicable: vec![] };
    for (folder, manifest) in &manifests {
        if args.program.is_empty() {
            let isolation = isolation(args)?;
            let options = ours::options(manifest);
            ask(&mut bench, &mut Ours::new(&isolation, &options), (folder, manifest), args);
        } else {
            let asked = Program::new(args);
            let mut asked =
                asked.map_err(|e| Complaint::failed(format!("no room for a lock: {e}")))?;
            ask(&mut bench, &mut asked, (folder, manifest), args);
        }
    }
    let missing = manifests.iter().flat_map(|(_, m)| &m.not_applicable);
    let mut counts = std::collections::BTreeMap::<&str, usize>::new();
    missing.for_each(|n| *counts.entry(n.kind.as_str()).or_default() += 1);
    bench.not_applicable = counts.into_iter().map(|(k, n)| (k.to_owned(), n)).collect();
    if let Some(path) = &args.markdown {
        let failed = |e| Complaint::failed(format!("{}: {e}", path.display()));
        std::fs::write(path, told::markdown(&bench)).map_err(failed)?;
    }
    let result = if args.json { told::json(&bench) } else { told::table(&bench) };
    let is_whole =
        bench.mutants.iter().all(|m| m.found) && bench.originals.iter().all(|o| o.alarm.is_none());
    let exit = if is_whole { Exit::Done } else { Exit::Losses };
    Ok(Answer { result, remarks: vec![told::summary(&bench)], exit })
}

/// Asks of one model and its mutants.
fn ask(
    bench: &mut Bench,
    asker: &mut dyn Asker,
    (folder, manifest): (&Path, &Manifest),
    args: &BenchArgs,
) {
    let model = folder.display().to_string();
    let whole = std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
    let seen = asker.original(&whole.join(&manifest.original.folder).join(&manifest.model));
    bench.originals.push(Original {
        model: model.clone(),
        format: manifest.format.clone(),
        alarm: seen.alarm,
        seconds: seen.seconds,
    });
    let wanted = |m: &&Mutant| args.kinds.is_empty() || args.kinds.contains(&m.kind);
    for mutant in manifest.mutants.iter().filter(wanted) {
        let found = asker.mutant(&whole.join(&mutant.folder).join(&manifest.model), mutant);
        bench.mutants.push(One {
            model: model.clone(),
            kind: mutant.kind.clone(),
            found: found.is_found,
            by: found.by,
            seconds: found.seconds,
        });
    }
}

fn isolation(args: &BenchArgs) -> Result<Isolation, Complaint> {
    let program = own::apart()
        .map_err(|e| Complaint::failed(format!("this program cannot find itself: {e}")))?;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    Ok(Isolation { program, deadline: args.deadline, threads })
}

fn read(folder: &Path) -> Result<Manifest, Complaint> {
    let path = folder.join(FILE);
    let hint = "`kinfold mutate MODEL --out DIR` writes such a folder";
    let failed = |why: String| Complaint::failed(format!("{}: {why}", path.display())).hint(hint);
    let bytes = guard::files::read(&path, MOST).map_err(|e| failed(e.to_string()))?;
    let manifest: Manifest = serde_json::from_slice(&bytes).map_err(|e| failed(e.to_string()))?;
    if manifest.schema != SCHEMA {
        let found = guard::text::shown(&manifest.schema).into_owned();
        return Err(failed(format!("expected schema `{SCHEMA}`, found `{found}`")));
    }
    let names = manifest.mutants.iter().map(|m| &m.folder);
    let plain = |name: &&String| !name.is_empty() && !name.contains(['/', '\\']) && *name != "..";
    let all = names.chain([&manifest.original.folder, &manifest.model]);
    if let Some(name) = all.into_iter().find(|n| !plain(n)) {
        let name = guard::text::shown(name).into_owned();
        return Err(failed(format!("`{name}` is no name of a file or folder in it")));
    }
    Ok(manifest)
}
