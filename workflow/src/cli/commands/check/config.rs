//! `kinfold-check.toml`: how the models of a repository are judged, and what may fail in it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use globset::{Glob, GlobBuilder, GlobMatcher};
use serde::Deserialize;
use sim_check::profile::RULES;
use sim_check::report::answer::Allowance;
use sim_check::report::source::day;
use sim_check::{Base, Subject, Tier};

use crate::cli::speech::Complaint;

/// What it is called.
pub(super) const NAME: &str = "kinfold-check.toml";
/// More than any such file has, bytes; a guess with room.
const MOST: u64 = 1 << 20;

/// How a file is judged; what is none is not said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Manner {
    pub tier: Option<Tier>,
    pub subject: Option<Kind>,
    pub base: Option<Standing>,
}

impl Manner {
    /// What is said here, else there.
    pub(super) fn or(self, other: Self) -> Self {
        Self {
            tier: self.tier.or(other.tier),
            subject: self.subject.or(other.subject),
            base: self.base.or(other.base),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Kind {
    Object,
    Robot,
}

impl Kind {
    pub(super) fn subject(self) -> Subject {
        match self {
            Self::Object => Subject::Object,
            Self::Robot => Subject::Robot,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Standing {
    Fixed,
    Free,
}

impl Standing {
    pub(super) fn base(self) -> Base {
        match self {
            Self::Fixed => Base::Fixed,
            Self::Free => Base::Free,
        }
    }
}

/// The file as it is written.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Written {
    tier: Option<String>,
    #[serde(rename = "as")]
    subject: Option<Kind>,
    base: Option<Standing>,
    exclude: Vec<String>,
    packages: BTreeMap<String, PathBuf>,
    waive: Vec<WrittenWaiver>,
    #[serde(rename = "override")]
    overrides: Vec<WrittenOverride>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenWaiver {
    check: String,
    reason: String,
    files: Option<String>,
    at: Option<String>,
    until: Option<toml::Value>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenOverride {
    files: String,
    tier: Option<String>,
    #[serde(rename = "as")]
    subject: Option<Kind>,
    base: Option<Standing>,
}

/// What the file says.
#[derive(Debug, Default)]
pub(super) struct Settings {
    /// The file itself; none where there is none.
    pub path: Option<PathBuf>,
    manner: Manner,
    exclude: Vec<GlobMatcher>,
    /// Folders of packages.
    pub packages: BTreeMap<String, PathBuf>,
    /// Waivers, each with the files it is for; none for all.
    pub waivers: Vec<(Option<GlobMatcher>, Allowance)>,
    overrides: Vec<(GlobMatcher, Manner)>,
    /// The folder its patterns count from.
    folder: PathBuf,
}

impl Settings {
    /// The named file, or the nearest at or above the working folder, up to the root of a repository.
    ///
    /// # Errors
    /// Where it cannot be read, or says what is not understood.
    pub(super) fn find(named: Option<&Path>, is_wanted: bool) -> Result<Self, Complaint> {
        let here = std::env::current_dir()
            .map_err(|e| Complaint::failed(format!("the working folder cannot be found: {e}")))?;
        let path = match named {
            Some(path) => Some(here.join(path)),
            None if is_wanted => nearest(&here),
            None => None,
        };
        path.map_or_else(|| Ok(Self::default()), |path| Self::read(&path))
    }

    fn read(path: &Path) -> Result<Self, Complaint> {
        let shown = path.display();
        let bytes = guard::files::read(path, MOST)
            .map_err(|e| Complaint::failed(format!("{shown} {e}")))?;
        let text = String::from_utf8(bytes)
            .map_err(|_| Complaint::misused(format!("{shown}: expected UTF-8 text")))?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Self::parse(&text, &folder)
            .map(|settings| Self { path: Some(path.to_owned()), ..settings })
            .map_err(|why| {
                let hint = "the fields are tier, as, base, exclude, [packages], [[waive]] and [[override]]";
                Complaint::misused(format!("{shown}: {why}")).hint(hint)
            })
    }

    fn parse(text: &str, folder: &Path) -> Result<Self, String> {
        let written: Written = toml::from_str(text).map_err(|e| e.to_string().trim().to_owned())?;
        let manner = Manner {
            tier: written.tier.as_deref().map(tier).transpose()?,
            subject: written.subject,
            base: written.base,
        };
        let waivers = written.waive.into_iter().map(waiver).collect::<Result<_, _>>()?;
        let one = |o: WrittenOverride| {
            let tier = o.tier.as_deref().map(tier).transpose()?;
            Ok((matcher(&o.files)?, Manner { tier, subject: o.subject, base: o.base }))
        };
        let overrides = written.overrides.into_iter().map(one).collect::<Result<_, String>>()?;
        let mut packages = BTreeMap::new();
        for (name, place) in written.packages {
            let is_inside = place.components().all(|c| {
                matches!(c, std::path::Component::Normal(_) | std::path::Component::CurDir)
            });
            if !is_inside {
                let place = place.display();
                return Err(format!(
                    "[packages] {name}: expected a folder below this file, found `{place}`; \
                     --package names others"
                ));
            }
            packages.insert(name, folder.join(place));
        }
        let exclude = written.exclude.iter().map(|g| matcher(g)).collect::<Result<_, _>>()?;
        Ok(Self {
            path: None,
            manner,
            exclude,
            packages,
            waivers,
            overrides,
            folder: folder.into(),
        })
    }

    /// How a file is judged: the last override that fits it first.
    pub(super) fn manner(&self, file: &Path) -> Manner {
        let own = self.below(file);
        let fitting = self.overrides.iter().rev().filter(|(glob, _)| glob.is_match(&own));
        fitting.fold(Manner::default(), |manner, (_, other)| manner.or(*other)).or(self.manner)
    }

    /// Whether a file that was found, and not named, is left out.
    pub(super) fn is_left_out(&self, file: &Path) -> bool {
        let own = self.below(file);
        self.exclude.iter().any(|glob| glob.is_match(&own))
    }

    /// The waivers for a file, each with its number.
    pub(super) fn waivers(&self, file: &Path) -> impl Iterator<Item = (usize, &Allowance)> {
        let own = self.below(file);
        self.waivers.iter().enumerate().filter_map(move |(number, (files, waiver))| {
            files.as_ref().is_none_or(|glob| glob.is_match(&own)).then_some((number, waiver))
        })
    }

    /// A file's path as patterns see it: from this file's folder.
    fn below(&self, file: &Path) -> String {
        from(&self.folder, file)
    }
}

/// A file's path from a folder, with slashes; its whole path where it lies elsewhere.
pub(super) fn from(folder: &Path, file: &Path) -> String {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    let whole = real(file).unwrap_or_else(|| std::path::absolute(file).unwrap_or(file.into()));
    let base = real(folder).unwrap_or(folder.into());
    let own = whole.strip_prefix(&base).unwrap_or(&whole);
    own.to_string_lossy().replace('\\', "/")
}

fn nearest(here: &Path) -> Option<PathBuf> {
    for folder in here.ancestors() {
        let path = folder.join(NAME);
        if path.is_file() {
            return Some(path);
        }
        if folder.join(".git").exists() {
            return None;
        }
    }
    None
}

fn tier(name: &str) -> Result<Tier, String> {
    let found = Tier::ALL.into_iter().find(|t| t.name() == name);
    let names = Tier::ALL.map(Tier::name).join(", ");
    found.ok_or_else(|| format!("tier: expected one of {names}, found `{name}`"))
}

/// A pattern as in .gitignore: without a slash it fits at any depth.
fn matcher(pattern: &str) -> Result<GlobMatcher, String> {
    let deep = if pattern.contains('/') { pattern.to_owned() } else { format!("**/{pattern}") };
    let deep = deep.trim_start_matches("./").trim_start_matches('/').to_owned();
    let built: Result<Glob, _> = GlobBuilder::new(&deep).literal_separator(true).build();
    built.map(|g| g.compile_matcher()).map_err(|e| format!("a pattern of files: {e}"))
}

fn waiver(written: WrittenWaiver) -> Result<(Option<GlobMatcher>, Allowance), String> {
    let id = written.check.as_str();
    let wrong = |what: String| format!("[[waive]] {id}: {what}");
    if !RULES.iter().any(|r| r.id == id) {
        return Err(wrong("expected the id of a check; `kinfold explain` lists them".into()));
    }
    if written.reason.trim().is_empty() {
        return Err(wrong("expected a reason, found none".into()));
    }
    let until = match written.until {
        None => None,
        Some(toml::Value::String(text)) => Some(day(&text).map_err(wrong)?),
        Some(toml::Value::Datetime(time)) => Some(day(&time.to_string()).map_err(wrong)?),
        Some(other) => {
            return Err(wrong(format!("until: expected a day as 2027-06-30, found `{other}`")));
        }
    };
    let files = written.files.as_deref().map(matcher).transpose().map_err(wrong)?;
    Ok((files, Allowance::new(id, written.reason.trim()).about(written.at).until(until)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"
        tier = "static"
        as = "object"
        exclude = ["third_party/**"]
        [packages]
        arm = "models/arm"
        [[waive]]
        check = "C1"
        files = "*.urdf"
        at = "door"
        until = 2027-06-30
        reason = "the pin sits in its hole"
        [[waive]]
        check = "G2"
        reason = "bowls"
        [[override]]
        files = "legs/**"
        as = "robot"
        base = "free"
        [[override]]
        files = "legs/crawl.xml"
        tier = "dynamic"
    "#;

    #[test]
    fn what_fits_a_file_last_counts_and_else_what_is_said_of_all() {
        let settings = Settings::parse(TEXT, Path::new("/r")).unwrap();
        let manner = |file: &str| settings.manner(Path::new(file));
        assert_eq!(manner("/r/a.urdf").subject, Some(Kind::Object));
        let crawl = manner("/r/legs/crawl.xml");
        assert_eq!((crawl.tier, crawl.subject), (Some(Tier::Dynamic), Some(Kind::Robot)));
        assert_eq!(manner("/r/legs/walk.xml").tier, Some(Tier::Static));
        assert!(settings.is_left_out(Path::new("/r/third_party/x/y.urdf")));
        assert!(!settings.is_left_out(Path::new("/r/x/third_party.urdf")));
        assert_eq!(settings.packages["arm"], Path::new("/r/models/arm"));
        let of = |file: &str| settings.waivers(Path::new(file)).map(|(n, _)| n).collect::<Vec<_>>();
        assert_eq!((of("/r/deep/er/a.urdf"), of("/r/a.xml")), (vec![0, 1], vec![1]));
        assert_eq!(settings.waivers[0].1.until.as_deref(), Some("2027-06-30"));
    }

    #[test]
    fn what_is_not_understood_is_said() {
        let error = |text: &str| Settings::parse(text, Path::new("/r")).unwrap_err();
        assert!(error("teir = \"static\"").contains("unknown field `teir`"));
        assert!(error("tier = \"best\"").contains("found `best`"));
        assert!(error("[[waive]]\ncheck = \"C99\"\nreason = \"x\"").contains("C99"));
        assert!(error("[[waive]]\ncheck = \"C1\"\nreason = \" \"").contains("found none"));
        assert!(error("[[waive]]\ncheck = \"C1\"").contains("reason"));
        assert!(error("[[waive]]\ncheck=\"C1\"\nreason=\"x\"\nuntil=\"soon\"").contains("soon"));
        assert!(error("[[waive]]\ncheck=\"C1\"\nreason=\"x\"\nuntil=3").contains("found `3`"));
        assert!(error("[packages]\na = \"../a\"").contains("below this file"));
        assert!(error("exclude = [\"a[\"]").contains("pattern"));
    }
}
