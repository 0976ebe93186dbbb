//! `kinfold init`: a condition and a configuration to begin with, every field explained.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use serde_json::json;

use crate::cli::speech::{Answer, Complaint};

/// What is written, by name.
const FILES: [(&str, &str); 2] = [
    ("condition.json", include_str!("init/condition.json")),
    ("kinfold.toml", include_str!("init/kinfold.toml")),
];

/// Writes a commented condition and a commented `kinfold.toml`; a file that is there already stays.
///
/// # Errors
/// [`Complaint`] when a folder or a file cannot be written, or when both files are there already.
pub fn init(folder: &Path, as_json: bool) -> Result<Answer, Complaint> {
    let failed =
        |path: &Path, e: std::io::Error| Complaint::failed(format!("{}: {e}", path.display()));
    std::fs::create_dir_all(folder).map_err(|e| failed(folder, e))?;
    let (mut written, mut left): (Vec<PathBuf>, Vec<PathBuf>) = (vec![], vec![]);
    for (name, text) in FILES {
        let path = folder.join(name);
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(mut file) => {
                file.write_all(text.as_bytes()).map_err(|e| failed(&path, e))?;
                written.push(path);
            }
            Err(e) if e.kind() == ErrorKind::AlreadyExists => left.push(path),
            Err(e) => return Err(failed(&path, e)),
        }
    }
    let told = |path: &PathBuf| guard::text::shown(&path.to_string_lossy()).into_owned();
    if written.is_empty() {
        let names: Vec<String> = left.iter().map(told).collect();
        let complaint = Complaint::failed(format!("{} are there already", names.join(" and ")));
        return Err(complaint.hint("name another folder: kinfold init DIR"));
    }
    let result = if as_json {
        let names = |paths: &[PathBuf]| paths.iter().map(told).collect::<Vec<_>>();
        format!("{:#}\n", json!({ "written": names(&written), "left": names(&left) }))
    } else {
        written.iter().map(|path| told(path) + "\n").collect()
    };
    let mut answer = Answer::done(result);
    answer.remarks =
        left.iter().map(|path| format!("{} was there, and stays", told(path))).collect();
    Ok(answer)
}

#[cfg(test)]
mod tests {
    use object::Condition;

    use super::*;

    #[test]
    fn what_is_written_to_begin_with_can_be_read() {
        let [(_, condition), (_, config)] = FILES;
        let condition = Condition::from_json(condition).unwrap();
        assert_eq!((condition.tree.len(), condition.size.unwrap().metres), (3, 0.72));
        let corrected: String = include_str!("init/condition.json")
            .lines()
            .map(|line| match line.trim_start().strip_prefix("// \"") {
                Some(rest) if line.starts_with("      ") => format!(", \"{}", rest.split("   ").next().unwrap().trim_end_matches(',')),
                _ => line.to_owned(),
            } + "\n")
            .collect();
        let corrected = Condition::from_json(&corrected).unwrap();
        assert!(corrected.prompts[2].given(0).axis.is_some(), "each example is one");
        let lines = config.lines().map(|line| match line.strip_prefix("# ") {
            Some(setting) if setting.starts_with('[') || setting.contains(" = ") => setting,
            _ => line,
        });
        let config = lines.collect::<Vec<_>>().join("\n");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("kinfold.toml");
        std::fs::write(&path, config).unwrap();
        adapters::Config::open(&path).unwrap();
    }

    #[test]
    fn a_file_that_is_there_stays() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("kinfold.toml"), "# mine").unwrap();
        let answer = init(folder.path(), false).unwrap();
        assert!(answer.result.ends_with("condition.json\n") && answer.remarks.len() == 1);
        assert_eq!(std::fs::read_to_string(folder.path().join("kinfold.toml")).unwrap(), "# mine");
        assert!(init(folder.path(), false).unwrap_err().message.contains("are there already"));
    }
}
