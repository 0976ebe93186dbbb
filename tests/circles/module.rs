//! The modules of one crate: what each declares, imports and names.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::words::{Word, closed, of_code};

/// A path as it is written, and its line.
#[derive(Clone, Debug)]
pub struct Named {
    pub path: Vec<String>,
    pub line: usize,
}

/// An import: the name it gives, and whether others see it.
#[derive(Clone, Debug)]
pub struct Import {
    pub named: Named,
    pub shown: bool,
}

/// A module: a file, or a block `mod x { … }` inside one.
#[derive(Debug, Default)]
pub struct Module {
    /// Relative to the crate's source folder.
    pub file: PathBuf,
    pub parent: Option<usize>,
    pub children: BTreeMap<String, usize>,
    pub imports: BTreeMap<String, Import>,
    /// Modules and enums whose every name is imported.
    pub globs: Vec<Named>,
    /// What is defined here.
    pub items: BTreeSet<String>,
    /// Paths of two and more names outside imports.
    pub paths: Vec<Named>,
    /// Single names outside imports.
    pub words: BTreeSet<String>,
}

/// All modules of a crate that the library or program itself is made of.
#[derive(Debug, Default)]
pub struct Crate {
    pub modules: Vec<Module>,
}

/// What stands in a file of the source folder; `None` where there is none.
pub type Source<'a> = &'a dyn Fn(&Path) -> Option<String>;

impl Crate {
    /// Reads the crate with this source folder, from `lib.rs` and `main.rs` on.
    pub fn read(folder: &Path) -> Self {
        Self::of(&|file| std::fs::read_to_string(folder.join(file)).ok())
    }

    /// The same from any source.
    pub fn of(source: Source) -> Self {
        let mut read = Self::default();
        for root in ["lib.rs", "main.rs"] {
            if let Some(text) = source(Path::new(root)) {
                let place = Place { source, file: root.into(), inside: Vec::new() };
                read.module(&of_code(&text), &place, None);
            }
        }
        read
    }

    /// A module of these words.
    fn module(&mut self, words: &[Word], place: &Place, parent: Option<usize>) -> usize {
        let number = self.modules.len();
        self.modules.push(Module { file: place.file.clone(), parent, ..Module::default() });
        let (mut at, mut depth) = (0, 0);
        while at < words.len() {
            let word = words[at].text.as_str();
            let next = words.get(at + 1).map_or("", |w| w.text.as_str());
            let behind = words.get(at + 2).map_or("", |w| w.text.as_str());
            match (word, behind) {
                ("mod", ";") => {
                    let child = self.child_file(next, place, number);
                    self.modules[number].children.insert(next.into(), child);
                    at += 3;
                }
                ("mod", "{") => {
                    let end = closed(words, at + 2);
                    let inner = place.deeper(next);
                    let child = self.module(&words[at + 3..end - 1], &inner, Some(number));
                    self.modules[number].children.insert(next.into(), child);
                    at = end;
                }
                ("use", _) => {
                    let shown = at > 0 && ["pub", ")"].contains(&words[at - 1].text.as_str());
                    at = self.modules[number].import(words, at + 1, shown);
                }
                _ => {
                    depth += i32::from(word == "{") - i32::from(word == "}");
                    at = self.modules[number].read_word(words, at, depth == 0);
                }
            }
        }
        number
    }

    fn child_file(&mut self, name: &str, place: &Place, parent: usize) -> usize {
        let inner = place.deeper(name);
        let folder: PathBuf = inner.inside.iter().collect();
        let candidates = [folder.with_extension("rs"), folder.join("mod.rs")];
        let found = candidates.into_iter().find_map(|f| Some(((place.source)(&f)?, f)));
        let (text, file) = found.unwrap_or_else(|| panic!("no file for `mod {name}`"));
        self.module(&of_code(&text), &Place { file, ..inner }, Some(parent))
    }
}

/// Where a module stands: its file, and the folder that its own modules lie in.
struct Place<'a> {
    source: Source<'a>,
    file: PathBuf,
    inside: Vec<String>,
}

impl<'a> Place<'a> {
    fn deeper(&self, name: &str) -> Place<'a> {
        let mut inside = self.inside.clone();
        inside.push(name.to_string());
        Place { source: self.source, file: self.file.clone(), inside }
    }
}

fn is_name(word: &str) -> bool {
    word.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

impl Module {
    /// Reads one import, from behind `use`; returns where it ends.
    fn import(&mut self, words: &[Word], from: usize, shown: bool) -> usize {
        let length = words[from..].iter().take_while(|w| w.text != ";").count();
        self.tree(&words[from..from + length], &[], shown);
        from + length + 1
    }

    /// One branch of an import behind this path.
    fn tree(&mut self, words: &[Word], before: &[String], shown: bool) {
        let (mut path, mut at) = (before.to_vec(), 0);
        while at < words.len() {
            let (word, line) = (words[at].text.as_str(), words[at].line);
            match word {
                "{" => {
                    for branch in branches(&words[at + 1..closed(words, at) - 1]) {
                        self.tree(branch, &path, shown);
                    }
                    return;
                }
                "*" => {
                    self.globs.push(Named { path, line });
                    return;
                }
                "as" => break,
                "self" if !path.is_empty() => {}
                "::" => {}
                _ => path.push(word.to_string()),
            }
            at += 1;
        }
        let Some(last) = path.last() else { return };
        let renamed = words.iter().position(|w| w.text == "as").and_then(|at| words.get(at + 1));
        let name = renamed.map_or(last.clone(), |w| w.text.clone());
        let line = words[0].line;
        self.imports.insert(name, Import { named: Named { path, line }, shown });
    }

    /// Takes note of a definition or a path; returns where to read on.
    fn read_word(&mut self, words: &[Word], at: usize, outermost: bool) -> usize {
        const KINDS: [&str; 9] =
            ["fn", "struct", "enum", "union", "trait", "const", "static", "type", "macro_rules"];
        let (word, line) = (words[at].text.as_str(), words[at].line);
        if KINDS.contains(&word) && outermost {
            let names = words[at + 1..].iter().find(|w| is_name(&w.text) && w.text != "mut");
            self.items.extend(names.map(|w| w.text.clone()));
        }
        if !is_name(word) || (at > 0 && words[at - 1].text == "::") {
            return at + 1;
        }
        let (mut path, mut end) = (vec![word.to_string()], at + 1);
        while words.get(end).is_some_and(|w| w.text == "::")
            && words.get(end + 1).is_some_and(|w| is_name(&w.text))
        {
            path.push(words[end + 1].text.clone());
            end += 2;
        }
        self.words.insert(word.to_string());
        if path.len() > 1 {
            self.paths.push(Named { path, line });
        }
        end
    }
}

/// The parts of a list between its outermost commas.
fn branches(words: &[Word]) -> Vec<&[Word]> {
    let (mut parts, mut from, mut at) = (Vec::new(), 0, 0);
    while at < words.len() {
        match words[at].text.as_str() {
            "," => {
                parts.push(&words[from..at]);
                (from, at) = (at + 1, at + 1);
            }
            "{" => at = closed(words, at),
            _ => at += 1,
        }
    }
    parts.push(&words[from..]);
    parts.retain(|p| !p.is_empty());
    parts
}
