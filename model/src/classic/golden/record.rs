//! What was computed of one object, by name: how it is written, read and compared.

use std::fmt::Write;

/// Numbers agree if they differ by no more than this, or by this share of what is expected where that is
/// more than 1.
const TOLERANCE: f64 = 1e-6;
/// How many differences are told.
const TOLD: usize = 25;

/// What was computed, in order.
#[derive(Default)]
pub(crate) struct Record {
    sections: Vec<Section>,
}

/// Values that belong together.
pub(crate) struct Section {
    /// What they are; up to the first comma, of which kind.
    pub title: String,
    /// By name, in order.
    pub lines: Vec<(String, Value)>,
}

/// What stands under one name.
pub(crate) enum Value {
    /// Compared to [`TOLERANCE`]; one number alone stands for a row of it.
    Numbers(Vec<f64>),
    /// Compared letter by letter.
    Exact(String),
}

impl Record {
    /// Begins a section.
    pub(crate) fn section(&mut self, title: impl Into<String>) {
        self.sections.push(Section { title: title.into(), lines: Vec::new() });
    }

    /// Numbers of the last section.
    pub(crate) fn numbers(&mut self, name: impl Into<String>, values: &[f64]) {
        self.line(name.into(), Value::Numbers(values.to_vec()));
    }

    /// A text of the last section.
    pub(crate) fn exact(&mut self, name: impl Into<String>, text: impl Into<String>) {
        self.line(name.into(), Value::Exact(text.into()));
    }

    /// A section of columns by name; `rows` says what each row is of, and each of them has as many values
    /// as there are names.
    pub(crate) fn table<S: AsRef<str>>(
        &mut self,
        title: impl Into<String>,
        names: &[S],
        rows: &[(String, Vec<f64>)],
    ) {
        self.section(title);
        let keys: Vec<&str> = rows.iter().map(|r| r.0.as_str()).collect();
        self.exact("rows", keys.join(", "));
        assert!(rows.iter().all(|r| r.1.len() == names.len()), "as many values as names");
        for (i, name) in names.iter().enumerate() {
            let column: Vec<f64> = rows.iter().map(|r| r.1[i]).collect();
            self.numbers(name.as_ref(), &column);
        }
    }

    /// Appends what another holds.
    pub(super) fn take(&mut self, other: Self) {
        self.sections.extend(other.sections);
    }

    /// All sections.
    pub(crate) fn sections(&self) -> &[Section] {
        &self.sections
    }

    fn line(&mut self, name: String, value: Value) {
        let section = self.sections.last_mut().unwrap();
        section.lines.push((name, value));
    }

    /// As text, which [`Record::read`] reads.
    pub(super) fn written(&self, head: &str) -> String {
        let mut out = head.to_string();
        for Section { title, lines } in &self.sections {
            let _ = writeln!(out, "\n[{title}]");
            for (name, value) in lines {
                let _ = match value {
                    Value::Exact(text) => writeln!(out, "{name} | {text}"),
                    Value::Numbers(all)
                        if all.len() > 1 && all.iter().all(|x| same(*x, all[0])) =>
                    {
                        writeln!(out, "{name} = {}", short(all[0]))
                    }
                    Value::Numbers(all) => {
                        let all: Vec<String> = all.iter().map(|x| short(*x)).collect();
                        writeln!(out, "{name} = {}", all.join(" "))
                    }
                };
            }
        }
        out
    }

    /// What [`Record::written`] wrote; what stands before the first section is passed over.
    pub(super) fn read(text: &str) -> Self {
        let mut record = Self::default();
        for line in text.lines() {
            if let Some(title) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
                record.section(title);
            } else if record.sections.is_empty() || line.is_empty() {
            } else if let Some((name, text)) = line.split_once(" | ") {
                record.exact(name, text);
            } else {
                let (name, numbers) = line.split_once(" =").unwrap_or((line, ""));
                let numbers = numbers.split_whitespace().map(|n| n.parse().unwrap());
                record.numbers(name, &numbers.collect::<Vec<f64>>());
            }
        }
        record
    }

    /// What differs from what is expected, by name, at most some of it, and how much there is in all.
    pub(super) fn differences(&self, expected: &Self) -> (Vec<String>, usize) {
        let mut found = Vec::new();
        let (own, other) = (&self.sections, &expected.sections);
        for (i, section) in own.iter().enumerate() {
            match other.get(i) {
                Some(wanted) if wanted.title == section.title => {
                    section.against(wanted, &mut found)
                }
                Some(wanted) => {
                    found.push(format!("[{}] expected, found [{}]", wanted.title, section.title));
                    break;
                }
                None => found.push(format!("[{}] is not expected", section.title)),
            }
        }
        let missing = other.iter().skip(own.len());
        found.extend(missing.map(|s| format!("[{}] is missing", s.title)));
        let all = found.len();
        found.truncate(TOLD);
        (found, all)
    }
}

impl Section {
    fn against(&self, expected: &Self, found: &mut Vec<String>) {
        let title = &self.title;
        let names = |s: &Self| s.lines.iter().map(|l| l.0.clone()).collect::<Vec<_>>();
        if names(self) != names(expected) {
            found.push(format!(
                "[{title}] {:?} expected, found {:?}",
                names(expected),
                names(self)
            ));
            return;
        }
        for ((name, value), (_, expected)) in self.lines.iter().zip(&expected.lines) {
            match (value, expected) {
                (Value::Exact(own), Value::Exact(wanted)) if own.trim() == wanted.trim() => {}
                (Value::Numbers(own), Value::Numbers(wanted)) => {
                    let count = own.len().max(wanted.len());
                    let at = |all: &[f64], i: usize| all.get(i.min(all.len().max(1) - 1)).copied();
                    let fits = |v: &Vec<f64>| v.len() == count || v.len() == 1;
                    if !fits(own) || !fits(wanted) {
                        let (a, b) = (wanted.len(), own.len());
                        found.push(format!("[{title}] {name}: {a} numbers expected, found {b}"));
                    }
                    let is_off = |i: &usize| match (at(own, *i), at(wanted, *i)) {
                        (Some(a), Some(b)) => !same(a, b),
                        (a, b) => a.is_some() != b.is_some(),
                    };
                    found.extend((0..count).find(is_off).map(|i| {
                        let (a, b) =
                            (at(wanted, i).unwrap_or(f64::NAN), at(own, i).unwrap_or(f64::NAN));
                        format!("[{title}] {name} (row {i}): {a} expected, found {b}")
                    }));
                }
                (own, wanted) => {
                    let text = |v: &Value| match v {
                        Value::Exact(text) => text.chars().take(200).collect(),
                        Value::Numbers(all) => format!("{} numbers", all.len()),
                    };
                    let (a, b): (String, String) = (text(wanted), text(own));
                    found.push(format!("[{title}] {name}: expected\n    {a}\n  found\n    {b}"));
                }
            }
        }
    }
}

/// Whether two numbers agree.
pub(crate) fn same(found: f64, expected: f64) -> bool {
    found == expected
        || (found.is_nan() && expected.is_nan())
        || (found - expected).abs() <= TOLERANCE * expected.abs().max(1.0)
}

/// Eight digits, as few as say the same.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.7e}").parse().unwrap();
    if rounded == 0.0 { "0".into() } else { rounded.to_string() }
}

/// At most so many of some things, spread evenly, with their places.
pub(crate) fn few(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|i| i * (count - 1) / (most - 1).max(1)).collect()
}

/// Numbers in a row as "number × how often".
pub(crate) fn runs<T: PartialEq + std::fmt::Display>(all: &[T]) -> String {
    let mut runs: Vec<(usize, &T)> = Vec::new();
    for one in all {
        match runs.last_mut() {
            Some((count, last)) if *last == one => *count += 1,
            _ => runs.push((1, one)),
        }
    }
    runs.iter().map(|(n, one)| format!("{one}*{n}")).collect::<Vec<_>>().join(" ")
}
