//! Where in a model's text its links and joints stand, and what the text itself lets pass.
//!
//! A comment lets checks pass for the element behind it, or, before the root element, for the file:
//! `<!-- kinfold: allow C1, C4 until 2027-06-30: the pin sits in its hole -->`.
//!
//! ```
//! use sim_check::report::source::{Place, Source};
//! let text = "<robot name=\"r\">\n  <!-- kinfold: allow G2: a bowl -->\n  <link name=\"bowl\"/>\n</robot>";
//! let source = Source::read(text);
//! assert_eq!(source.place_of("link `bowl`: not convex"), Place { line: 3, column: 3 });
//! assert_eq!(source.allowances[0].about.as_deref(), Some("bowl"));
//! ```

use std::collections::BTreeMap;

use super::answer::{Allowance, quoted};
use crate::profile::RULES;

/// Where an element begins; both count from 1, columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
}

/// What was found in a model's text.
#[derive(Clone, Debug, Default)]
pub struct Source {
    names: BTreeMap<String, Place>,
    root: Option<Place>,
    /// What its comments let pass.
    pub allowances: Vec<Allowance>,
    /// Comments that say `kinfold:` and are not understood, each with its line.
    pub misread: Vec<String>,
}

/// What begins such a comment.
const SIGN: &str = "kinfold:";
/// Elements whose names findings quote; of others only the place is of use.
const NAMED: [&str; 5] = ["link", "joint", "body", "geom", "mesh"];

impl Source {
    /// Looks through a text, whether it is sound XML or not.
    pub fn read(text: &str) -> Self {
        let mut reader = Reader::default();
        let mut at = 0;
        while let Some(start) = text.get(at..).and_then(|rest| rest.find('<')).map(|n| at + n) {
            let rest = text.get(start..).unwrap_or_default();
            let (end, is_tag) = match rest {
                _ if rest.starts_with("<!--") => (past(rest, "-->"), false),
                _ if rest.starts_with("<![CDATA[") => (past(rest, "]]>"), false),
                _ if rest.starts_with("<?") => (past(rest, "?>"), false),
                _ if rest.starts_with("<!") => (past(rest, ">"), false),
                _ => (tag_end(rest), true),
            };
            let whole = rest.get(..end).unwrap_or(rest);
            reader.pass(text.get(at..start).unwrap_or_default());
            if is_tag {
                reader.tag(whole);
            } else if let Some(words) = whole.strip_prefix("<!--") {
                reader.comment(words.strip_suffix("-->").unwrap_or(words).trim());
            }
            reader.pass(whole);
            at = start + end.max(1);
        }
        reader.source
    }

    /// Where what a finding is about stands: its line where it says one, the first link, joint, body, geom or
    /// mesh that it quotes, else the root element.
    pub fn place_of(&self, finding: &str) -> Place {
        let line = finding.strip_prefix("line ").and_then(|rest| {
            rest.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok().filter(|l| *l > 0)
        });
        if let Some(line) = line {
            return Place { line, column: 1 };
        }
        let quoted = quoted(finding).find_map(|name| self.names.get(name)).copied();
        quoted.or(self.root).unwrap_or(Place { line: 1, column: 1 })
    }
}

/// Bytes up to and with `end`, or all.
fn past(rest: &str, end: &str) -> usize {
    rest.find(end).map_or(rest.len(), |n| n + end.len())
}

/// Bytes of a tag: its `>` is the first outside of quotes.
fn tag_end(rest: &str) -> usize {
    let mut quote = None;
    for (at, c) in rest.char_indices() {
        match (quote, c) {
            (None, '"' | '\'') => quote = Some(c),
            (None, '>') => return at + 1,
            (Some(q), c) if q == c => quote = None,
            _ => {}
        }
    }
    rest.len()
}

/// The attribute `name` of a tag.
fn name_of(tag: &str) -> Option<String> {
    let mut rest = tag;
    while let Some(at) = rest.find("name") {
        let is_whole = rest.get(..at).is_some_and(|before| before.ends_with(char::is_whitespace));
        let behind = rest.get(at + 4..)?.trim_start();
        if let (true, Some(value)) = (is_whole, behind.strip_prefix('=')) {
            let value = value.trim_start();
            let quote = value.chars().next().filter(|c| ['"', '\''].contains(c))?;
            let value = value.get(1..)?.split(quote).next()?;
            let plain =
                [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
            return Some(plain.iter().fold(value.to_owned(), |v, (from, to)| v.replace(from, to)));
        }
        rest = behind;
    }
    None
}

struct Reader {
    source: Source,
    at: Place,
    /// Names of the elements that are open.
    open: Vec<Option<String>>,
    /// Allowances that wait for the next element.
    waiting: Vec<Allowance>,
}

impl Default for Reader {
    fn default() -> Self {
        let at = Place { line: 1, column: 1 };
        Self { source: Source::default(), at, open: Vec::new(), waiting: Vec::new() }
    }
}

impl Reader {
    fn pass(&mut self, text: &str) {
        for c in text.chars() {
            self.at = match c {
                '\n' => Place { line: self.at.line + 1, column: 1 },
                _ => Place { column: self.at.column + 1, ..self.at },
            };
        }
    }

    fn tag(&mut self, tag: &str) {
        if tag.starts_with("</") {
            self.open.pop();
            return;
        }
        let name = name_of(tag);
        let is_root = self.source.root.is_none();
        self.source.root.get_or_insert(self.at);
        let kind =
            tag.trim_start_matches('<').split(|c: char| c.is_whitespace() || c == '/' || c == '>');
        let is_named = kind.into_iter().next().is_some_and(|kind| NAMED.contains(&kind));
        if let Some(name) = name.clone().filter(|_| is_named) {
            self.source.names.entry(name).or_insert(self.at);
        }
        let enclosing = || self.open.iter().rev().find_map(Clone::clone);
        let about = name.clone().filter(|_| is_named).or_else(enclosing);
        for mut allowance in self.waiting.drain(..) {
            allowance.about = about.clone().filter(|_| !is_root);
            self.source.allowances.push(allowance);
        }
        if !tag.ends_with("/>") {
            self.open.push(name.filter(|_| is_named));
        }
    }

    fn comment(&mut self, words: &str) {
        let Some(said) = words.strip_prefix(SIGN) else { return };
        let line = self.at.line;
        match allowances(said.trim()) {
            Ok(all) => {
                self.waiting.extend(all.into_iter().map(|a| Allowance { line: Some(line), ..a }))
            }
            Err(why) => self.source.misread.push(format!("line {line}: {why}")),
        }
    }
}

/// `allow IDS [until DATE]: REASON`, one allowance for each id.
fn allowances(said: &str) -> Result<Vec<Allowance>, String> {
    let form = "expected `kinfold: allow IDS [until YYYY-MM-DD]: REASON`";
    let rest = said.strip_prefix("allow ").ok_or_else(|| format!("{form}, found `{said}`"))?;
    let (what, reason) = rest.split_once(':').ok_or_else(|| format!("{form}, found no reason"))?;
    let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
    if reason.is_empty() {
        return Err(format!("{form}, found no reason"));
    }
    let (ids, until) = match what.split_once(" until ") {
        Some((ids, date)) => (ids, Some(day(date.trim())?)),
        None => (what, None),
    };
    let ids = ids.split(',').map(str::trim).filter(|id| !id.is_empty());
    let one = |id: &str| {
        let is_known = RULES.iter().any(|r| r.id == id);
        let unknown =
            || format!("{form}, found the unknown id `{id}`: `kinfold explain` lists them");
        is_known.then(|| Allowance::new(id, &reason).until(until.clone())).ok_or_else(unknown)
    };
    ids.map(one).collect()
}

/// A day as it is compared: `YYYY-MM-DD`.
///
/// # Errors
/// What else was found.
pub fn day(text: &str) -> Result<String, String> {
    let digits: Vec<&str> = text.split('-').collect();
    let is_day = matches!(digits[..], [y, m, d]
        if [(y, 4), (m, 2), (d, 2)].iter().all(|(t, n)| t.len() == *n && t.bytes().all(|b| b.is_ascii_digit()))
            && ("01"..="12").contains(&m) && ("01"..="31").contains(&d));
    is_day
        .then(|| text.to_owned())
        .ok_or_else(|| format!("expected a day as YYYY-MM-DD, found `{text}`"))
}

#[cfg(test)]
mod tests;
