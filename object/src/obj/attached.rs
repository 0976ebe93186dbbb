//! Files that an OBJ names, taken into its text as comments: one file then says all.

use std::collections::BTreeMap;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::mtl;
use crate::beside::Beside;

/// How the comment begins that holds a file: its bytes in base64 follow, then its name.
const FILE: &str = "#kinfold:file ";
/// The same of one that could not be had: why, as the rest of a sentence, stands between the bars.
const MISSING: &str = "#kinfold:missing ";
/// Most files of materials and pictures: a guess with room.
const MAX_FILES: usize = 1024;

/// What is known of the files that a text names.
#[derive(Debug, Default)]
pub(super) struct Attached<'a> {
    /// Name and base64 of each, and why others could not be had.
    files: BTreeMap<&'a str, Result<&'a str, &'a str>>,
}

impl<'a> Attached<'a> {
    /// Notes the file that a comment holds.
    pub(super) fn comment(&mut self, line: &'a str) {
        if self.files.len() >= MAX_FILES {
            return;
        }
        if let Some((bytes, name)) = line.strip_prefix(FILE).and_then(|l| l.split_once(' ')) {
            self.files.insert(name, Ok(bytes));
        } else if let Some((why, name)) = line.strip_prefix(MISSING).and_then(|l| l.split_once('|'))
        {
            self.files.insert(name, Err(why));
        }
    }

    /// A file's bytes, or why there are none.
    pub(super) fn file(&self, name: &str) -> Result<Vec<u8>, String> {
        match self.files.get(name) {
            Some(Ok(bytes)) => STANDARD.decode(bytes).map_err(|e| e.to_string()),
            Some(Err(why)) => Err((*why).to_owned()),
            None => Err("is not there".into()),
        }
    }
}

/// An OBJ text with the files it names, and those that these name: materials and pictures. A text that names
/// none stays as it is, to the byte.
pub fn contained(text: &str, beside: Beside<'_>) -> String {
    let mut files: BTreeMap<String, Result<Vec<u8>, String>> = BTreeMap::new();
    let mut get = |name: &str, files: &mut BTreeMap<_, _>| {
        let is_new = !files.contains_key(name) && files.len() < MAX_FILES;
        if is_new && !name.is_empty() && !name.contains(['\n', '\r']) {
            files.insert(name.to_owned(), beside(name).map(|found| found.bytes));
        }
    };
    let libraries: Vec<&str> = text.lines().filter_map(library).collect();
    for name in libraries.iter().flat_map(|line| names(line)) {
        get(name, &mut files);
        let Some(Ok(bytes)) = files.get(name) else { continue };
        let text = String::from_utf8_lossy(bytes).into_owned();
        text.lines().filter_map(mtl::picture).for_each(|name| get(&name, &mut files));
    }
    let mut whole = String::new();
    for (name, file) in &files {
        match file {
            Ok(bytes) => {
                whole.push_str(FILE);
                STANDARD.encode_string(bytes, &mut whole);
                whole.push(' ');
            }
            Err(why) => {
                whole.push_str(MISSING);
                whole.extend(why.chars().map(|c| if c.is_control() || c == '|' { ' ' } else { c }));
                whole.push('|');
            }
        }
        whole.push_str(name);
        whole.push('\n');
    }
    whole + text
}

/// What a `mtllib` line names.
pub(super) fn library(line: &str) -> Option<&str> {
    let rest = line.trim_start().strip_prefix("mtllib")?;
    rest.starts_with(char::is_whitespace).then(|| rest.trim())
}

/// The files of a `mtllib` line: one whose name has spaces, as exporters write it, or several.
pub(super) fn names(line: &str) -> Vec<&str> {
    match line.to_ascii_lowercase().matches(".mtl").count() {
        0 | 1 => vec![line],
        _ => line.split_whitespace().collect(),
    }
}
