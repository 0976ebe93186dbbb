//! From names to arrows between files, and the circles among them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::module::{Crate, Named};

/// Most re-exports a name is followed through.
const FARTHEST: usize = 16;

/// What a path leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Target {
    Module(usize),
    /// Something that this module defines.
    Item(usize),
}

/// Which file names which, with the first place that does: line and path.
pub type Arrows = BTreeMap<(PathBuf, PathBuf), (usize, String)>;

impl Crate {
    /// Arrows from every file to the files that define what it names.
    ///
    /// A name is followed to where it is defined: who names `a::Y`, which `a` has by `pub use x::Y`,
    /// names a thing of `x`. So the re-export itself is a sign at a door and no arrow.
    pub fn arrows(&self) -> Arrows {
        let mut arrows = Arrows::new();
        for (number, module) in self.modules.iter().enumerate() {
            let own = |(name, import): &(&String, &super::module::Import)| {
                !import.shown || module.words.contains(*name)
            };
            let imports = module.imports.iter().filter(own).map(|(_, import)| &import.named);
            for named in imports.chain(&module.paths) {
                if let Some(Target::Item(to)) = self.lead(number, named, FARTHEST) {
                    self.draw(&mut arrows, number, to, named);
                }
            }
            for named in &module.globs {
                if let Some(Target::Item(to) | Target::Module(to)) =
                    self.lead(number, named, FARTHEST)
                {
                    self.draw(&mut arrows, number, to, named);
                }
            }
        }
        arrows
    }

    fn draw(&self, arrows: &mut Arrows, from: usize, to: usize, named: &Named) {
        let (from, to) = (&self.modules[from].file, &self.modules[to].file);
        if from != to {
            let said = (named.line, named.path.join("::"));
            arrows.entry((from.clone(), to.clone())).or_insert(said);
        }
    }

    /// Where a path leads that is written in this module; `None` for another crate or a local name.
    fn lead(&self, from: usize, named: &Named, left: usize) -> Option<Target> {
        let (first, rest) = named.path.split_first()?;
        let mut target = match first.as_str() {
            "crate" => Target::Module(self.root_of(from)),
            "self" => Target::Module(from),
            "super" => Target::Module(self.modules[from].parent?),
            name => self.look(from, name, rest.is_empty(), left)?,
        };
        for (at, name) in rest.iter().enumerate() {
            let Target::Module(module) = target else { break };
            target = match name.as_str() {
                "super" => Target::Module(self.modules[module].parent?),
                "self" => target,
                _ => {
                    let last = at + 1 == rest.len();
                    self.look(module, name, last, left).unwrap_or(Target::Item(module))
                }
            };
        }
        Some(target)
    }

    fn root_of(&self, mut module: usize) -> usize {
        while let Some(parent) = self.modules[module].parent {
            module = parent;
        }
        module
    }

    /// What a name means in a module. A module and something else may share one name: the module is
    /// meant where more follows.
    fn look(&self, module: usize, name: &str, last: bool, left: usize) -> Option<Target> {
        let left = left.checked_sub(1)?;
        let of = &self.modules[module];
        let child = of.children.get(name).map(|&c| Target::Module(c));
        if child.is_some() && !last {
            return child;
        }
        if of.items.contains(name) {
            return Some(Target::Item(module));
        }
        let import = of.imports.get(name);
        if let Some(target) = import.and_then(|i| self.lead(module, &i.named, left)) {
            return Some(target);
        }
        child.or_else(|| {
            let within = |glob: &Named| match self.lead(module, glob, left)? {
                Target::Module(m) if m != module => self.look(m, name, last, left),
                _ => None,
            };
            of.globs.iter().find_map(within)
        })
    }
}

/// Sets of files that all lead to each other, the largest first.
pub fn circles(arrows: &Arrows) -> Vec<BTreeSet<PathBuf>> {
    let mut next: BTreeMap<&Path, BTreeSet<&Path>> = BTreeMap::new();
    for (from, to) in arrows.keys() {
        next.entry(from).or_default().insert(to);
    }
    let reached: BTreeMap<&Path, BTreeSet<&Path>> =
        next.keys().map(|&from| (from, reach(&next, from))).collect();
    let mut circles = BTreeSet::new();
    for (&file, ahead) in &reached {
        let both = |other: &&&Path| reached.get(**other).is_some_and(|back| back.contains(file));
        let circle: BTreeSet<PathBuf> =
            ahead.iter().filter(both).map(|f| f.to_path_buf()).collect();
        circles.extend((!circle.is_empty()).then_some(circle));
    }
    let mut circles: Vec<_> = circles.into_iter().collect();
    circles.sort_by_key(|c| std::cmp::Reverse(c.len()));
    circles
}

fn reach<'a>(next: &BTreeMap<&'a Path, BTreeSet<&'a Path>>, from: &Path) -> BTreeSet<&'a Path> {
    let (mut reached, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(file) = open.pop() {
        for &to in next.get(file).into_iter().flatten() {
            if reached.insert(to) {
                open.push(to);
            }
        }
    }
    reached
}

/// A circle in words: its files, and every arrow inside it with its place.
pub fn told(circle: &BTreeSet<PathBuf>, arrows: &Arrows) -> String {
    let files: Vec<String> = circle.iter().map(|f| f.display().to_string()).collect();
    let inside = |(from, to): &(PathBuf, PathBuf)| circle.contains(from) && circle.contains(to);
    let arrows =
        arrows.iter().filter(|(ends, _)| inside(ends)).map(|((from, to), (line, name))| {
            format!("\n    {}:{line} names {name} of {}", from.display(), to.display())
        });
    format!("{} files: {}{}", files.len(), files.join(" "), arrows.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The arrows of a crate of these files, as `from names to`.
    fn arrows(files: &[(&str, &str)]) -> Vec<String> {
        let source = |file: &Path| {
            files.iter().find(|(f, _)| Path::new(f) == file).map(|(_, text)| (*text).to_string())
        };
        let arrows = Crate::of(&source).arrows();
        arrows.keys().map(|(from, to)| format!("{} {}", from.display(), to.display())).collect()
    }

    #[test]
    fn a_name_is_followed_to_the_file_that_defines_it() {
        let found = arrows(&[
            ("lib.rs", "mod a; mod b; pub use a::A;"),
            ("a.rs", "pub mod deep; pub use deep::A; pub fn f() {}"),
            ("a/deep.rs", "pub struct A; pub(crate) const N: usize = 1;"),
            ("b.rs", "use crate::{A, a}; fn g() -> usize { a::deep::N }"),
        ]);
        assert_eq!(found, ["b.rs a/deep.rs"], "re-exports and modules alone are no arrows");
    }

    #[test]
    fn what_a_file_uses_of_its_children_and_they_of_it_is_a_circle() {
        let files = [
            ("lib.rs", "mod a;"),
            ("a.rs", "mod deep; pub(crate) enum Fault { Bad } fn f() { deep::g() }"),
            ("a/deep.rs", "use super::Fault; pub(crate) fn g() { let _ = Fault::Bad; }"),
        ];
        assert_eq!(arrows(&files), ["a/deep.rs a.rs", "a.rs a/deep.rs"]);
        let source = |f: &Path| files.iter().find(|g| Path::new(g.0) == f).map(|g| g.1.into());
        let drawn = Crate::of(&source).arrows();
        let found = circles(&drawn);
        assert_eq!(found.len(), 1);
        let said = told(&found[0], &drawn);
        assert!(
            said.starts_with("2 files: a/deep.rs a.rs\n    a/deep.rs:1 names super::Fault"),
            "{said}"
        );
    }

    #[test]
    fn paths_in_code_globs_blocks_and_lists_count_and_tests_do_not() {
        let found = arrows(&[
            ("lib.rs", "mod a; mod b; mod c; mod d; mod e;"),
            ("a.rs", "fn f() -> crate::b::B { todo() }"),
            ("b.rs", "pub struct B; mod inner { use super::super::c::*; }"),
            ("c.rs", "pub fn c() {} #[cfg(test)] mod tests { use crate::a::f; }"),
            ("d.rs", "use crate::{b::{self, B as Bee}, c as other}; fn d() { other::c() }"),
            ("e.rs", "use std::fmt; use serde::a; /// crate::a::f\nfn e() { ::b::B; a::x() }"),
        ]);
        assert_eq!(found, ["a.rs b.rs", "b.rs c.rs", "d.rs b.rs", "d.rs c.rs"]);
    }
}
