//! A pack: what was learned, in one file that says what it is, what it asks about and where it came from.
//!
//! | Bytes | What |
//! |---|---|
//! | 8 | [`MAGIC`]; its line end is broken by whatever takes the file for text |
//! | 4 | [`VERSION`], `u32`, little-endian, as all numbers here |
//! | 4 | length of the head |
//! | that many | the head: a [`Head`] as JSON |
//! | as the head says | the sections, one after another |
//! | 32 | BLAKE3 of everything before |
//!
//! A pack names the features that its models ask about, in order. A program with other features, or the
//! same in another order, refuses it by the first name that differs.
//!
//! ```
//! use model::classic::learned::pack::{Form, Head, Origin, Pack, Section, Table, write};
//!
//! let table = Table { name: "lengths".into(), features: vec!["width".into(), "height".into()] };
//! let weights = [0.5_f64, -2.0].map(f64::to_le_bytes).concat();
//! let section = Section::new("weights", "lengths", Form::Double);
//! let head = Head::new("example", vec![table], Origin::default());
//! let bytes = write(head, vec![(section, weights)]).unwrap();
//!
//! let pack = Pack::open("example", &bytes).unwrap();
//! pack.asks("lengths", &["width", "height"]).unwrap();
//! assert_eq!(pack.numbers("weights", 2).unwrap(), [0.5, -2.0]);
//! let refused = pack.asks("lengths", &["width", "depth"]).unwrap_err();
//! assert!(refused.to_string().contains("asks for `height`, this program has `depth`"));
//! ```

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::forest::Forest;

/// How a pack begins.
pub const MAGIC: [u8; 8] = *b"KFPACK\r\n";
/// The version that is written and read here.
pub const VERSION: u32 = 1;
/// Most bytes of a head; a guess, two hundred times the largest that ships.
const LONGEST_HEAD: usize = 4 << 20;
/// Bytes before the head, and of the digest at the end.
const BEFORE: usize = MAGIC.len() + 8;
const DIGEST: usize = blake3::OUT_LEN;

/// What a pack says of itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Head {
    /// What its models are for, such as `segments`.
    pub kind: String,
    /// The tables of features that its models ask about.
    pub tables: Vec<Table>,
    /// The ensembles in it, in the order in which they are asked; none where a pack is no ensemble.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ensembles: Vec<Ensemble>,
    /// Numbers that say how its models are asked, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub settings: BTreeMap<String, f64>,
    /// What stands behind the head, in order.
    pub sections: Vec<Section>,
    /// Where it came from.
    pub origin: Origin,
}

impl Head {
    /// A head without ensembles, settings and sections.
    pub fn new(kind: &str, tables: Vec<Table>, origin: Origin) -> Self {
        let (ensembles, settings, sections) = (Vec::new(), BTreeMap::new(), Vec::new());
        Self { kind: kind.into(), tables, ensembles, settings, sections, origin }
    }
}

/// The features that a model asks about, by name, in order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Its name, such as `unary`.
    pub name: String,
    /// One name for each feature.
    pub features: Vec<String>,
}

impl Table {
    /// A table of these features.
    pub fn new(name: &str, features: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self { name: name.into(), features: features.into_iter().map(Into::into).collect() }
    }
}

/// Models that answer together, their answers averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ensemble {
    /// How many models there are, each fitted without another share of the objects.
    pub folds: usize,
    /// For how many rounds it was fitted.
    pub rounds: usize,
}

/// Something that stands behind the head.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Section {
    /// Its name; no other section has it.
    pub name: String,
    /// The table whose features it asks about.
    pub table: String,
    /// How its bytes are to be read.
    pub form: Form,
    /// How many bytes it has.
    pub bytes: u64,
}

impl Section {
    /// A section whose bytes [`write()`] counts.
    pub fn new(name: impl Into<String>, table: &str, form: Form) -> Self {
        Self { name: name.into(), table: table.into(), form, bytes: 0 }
    }
}

/// How the bytes of a section are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// A [`Forest`].
    Forest,
    /// Numbers in single precision.
    Single,
    /// Numbers in double precision.
    Double,
}

/// Where a pack came from. What is not known is left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// The recipe that it was fitted by: its text, whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recipe: Option<String>,
    /// The commit of the program that fitted it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commit: Option<String>,
    /// What it was fitted on: names and BLAKE3 digests.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub data: BTreeMap<String, String>,
    /// How well it did when it was fitted, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub metrics: BTreeMap<String, f64>,
    /// What else a reader should know.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remark: Option<String>,
}

/// Why a pack is refused, and which.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("pack {pack}: {fault}")]
pub struct PackError {
    /// Its name.
    pub pack: String,
    /// What is wrong with it.
    pub fault: Fault,
}

/// What is wrong with a pack.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// It does not begin as a pack does.
    #[error("no pack: it begins with {0:02x?}")]
    Foreign(Vec<u8>),
    /// It is of another version.
    #[error("version {0}, this program reads version {VERSION}")]
    Version(u32),
    /// It is shorter or longer than it says.
    #[error("{found} bytes, its head says {said}")]
    Length {
        /// How long it is.
        found: u64,
        /// How long it should be.
        said: u64,
    },
    /// Its bytes are not those that were written.
    #[error("damaged: its digest does not match its bytes")]
    Digest,
    /// Its head is none.
    #[error("its head cannot be read: {0}")]
    Head(String),
    /// It is a pack of something else.
    #[error("a pack of `{found}`, not of `{asked}`")]
    Kind {
        /// What was asked for.
        asked: String,
        /// What it is.
        found: String,
    },
    /// It asks about another feature than there is.
    #[error(
        "its table `{table}` asks for `{asked}`, this program has `{here}`, as feature {place}"
    )]
    Feature {
        /// The table.
        table: String,
        /// Where in the table, from 0.
        place: usize,
        /// The feature that the pack asks for.
        asked: String,
        /// The one that the program has there.
        here: String,
    },
    /// Something in it is missing or not as it should be.
    #[error("`{name}`: {why}")]
    Section {
        /// What.
        name: String,
        /// What is wrong.
        why: String,
    },
}

/// Where a feature stands among those of a table, at compile time; past the end where there is none.
pub const fn place(names: &[&str], name: &str) -> usize {
    let name = name.as_bytes();
    let mut at = 0;
    while at < names.len() {
        let other = names[at].as_bytes();
        let mut same = 0;
        while same < name.len() && same < other.len() && name[same] == other[same] {
            same += 1;
        }
        if same == name.len() && same == other.len() {
            break;
        }
        at += 1;
    }
    at
}

/// What the program has, or the pack, where one of the two has no more features.
const NOTHING_MORE: &str = "(nothing more)";

/// A pack that was opened: whole, and as its head says.
#[derive(Clone, Debug, PartialEq)]
pub struct Pack<'a> {
    name: String,
    /// What it says of itself.
    pub head: Head,
    sections: BTreeMap<String, (Section, &'a [u8])>,
    content: &'a [u8],
}

impl<'a> Pack<'a> {
    /// Opens a pack; `name` stands in errors.
    ///
    /// # Errors
    /// [`PackError`] when it is no pack, of another version, torn, damaged, or says two things at once.
    pub fn open(name: &str, bytes: &'a [u8]) -> Result<Self, PackError> {
        let refused = |fault| PackError { pack: name.into(), fault };
        let (head, content) = taken_apart(bytes).map_err(refused)?;
        let mut sections = BTreeMap::new();
        let mut rest = content;
        for section in &head.sections {
            let (own, after) = rest.split_at(section.bytes as usize);
            rest = after;
            sections.insert(section.name.clone(), (section.clone(), own));
        }
        Ok(Self { name: name.into(), head, sections, content })
    }

    fn refused(&self, fault: Fault) -> PackError {
        PackError { pack: self.name.clone(), fault }
    }

    fn wrong(&self, name: &str, why: impl Into<String>) -> PackError {
        self.refused(Fault::Section { name: name.into(), why: why.into() })
    }

    /// Refuses a pack of another kind.
    ///
    /// # Errors
    /// [`Fault::Kind`].
    pub fn is(&self, kind: &str) -> Result<(), PackError> {
        if self.head.kind == kind {
            return Ok(());
        }
        let (asked, found) = (kind.to_owned(), self.head.kind.clone());
        Err(self.refused(Fault::Kind { asked, found }))
    }

    /// Refuses a pack whose table of that name has other features than these, or in another order.
    ///
    /// # Errors
    /// [`Fault::Feature`] with the first that differs, [`Fault::Section`] where there is no such table.
    pub fn asks(&self, table: &str, features: &[impl AsRef<str>]) -> Result<(), PackError> {
        let own = self.head.tables.iter().find(|t| t.name == table);
        let own = &own.ok_or_else(|| self.wrong(table, "there is no such table"))?.features;
        let here = |place: usize| features.get(place).map_or(NOTHING_MORE, AsRef::as_ref);
        let asked = |place: usize| own.get(place).map_or(NOTHING_MORE, String::as_str);
        let differs = |&place: &usize| asked(place) != here(place);
        match (0..own.len().max(features.len())).find(differs) {
            None => Ok(()),
            Some(place) => {
                let (asked, here) = (asked(place).to_owned(), here(place).to_owned());
                Err(self.refused(Fault::Feature { table: table.into(), place, asked, here }))
            }
        }
    }

    /// A setting that must be there.
    ///
    /// # Errors
    /// [`Fault::Section`] where it is not.
    pub fn setting(&self, name: &str) -> Result<f64, PackError> {
        let found = self.head.settings.get(name).copied();
        found.ok_or_else(|| self.wrong(name, "there is no such setting"))
    }

    /// An ensemble that must be there.
    ///
    /// # Errors
    /// [`Fault::Section`] where it is not.
    pub fn ensemble(&self, place: usize) -> Result<Ensemble, PackError> {
        let found = self.head.ensembles.get(place).copied();
        found.ok_or_else(|| self.wrong(&format!("ensemble {place}"), "there is no such ensemble"))
    }

    fn section(&self, name: &str) -> Result<&(Section, &'a [u8]), PackError> {
        self.sections.get(name).ok_or_else(|| self.wrong(name, "there is no such section"))
    }

    /// The forest of a section, which must ask about `N` features.
    ///
    /// # Errors
    /// [`Fault::Section`] where there is none.
    pub fn forest<const N: usize>(&self, name: &str) -> Result<Forest<N>, PackError> {
        let (section, bytes) = self.section(name)?;
        let mut bytes = *bytes;
        let features = self.head.tables.iter().find(|t| t.name == section.table);
        let count = features.map_or(0, |t| t.features.len());
        if section.form != Form::Forest || count != N {
            let why = format!("no forest over {N} features");
            return Err(self.wrong(name, why));
        }
        let forest = Forest::read(&mut bytes);
        let whole = forest.filter(|_| bytes.is_empty());
        whole.ok_or_else(|| self.wrong(name, "its bytes are no forest over these features"))
    }

    /// The numbers of a section, of which there must be `count`, all finite.
    ///
    /// # Errors
    /// [`Fault::Section`] where they are not there.
    pub fn numbers(&self, name: &str, count: usize) -> Result<Vec<f64>, PackError> {
        let (section, bytes) = self.section(name)?;
        let numbers: Vec<f64> = match section.form {
            Form::Forest => return Err(self.wrong(name, "a forest, not numbers")),
            Form::Single => {
                bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b).into()).collect()
            }
            Form::Double => bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
        };
        let width = if section.form == Form::Single { 4 } else { 8 };
        if numbers.len() != count || bytes.len() != width * count {
            let why = format!("{} bytes are not {count} numbers", bytes.len());
            return Err(self.wrong(name, why));
        }
        match numbers.iter().all(|n| n.is_finite()) {
            true => Ok(numbers),
            false => Err(self.wrong(name, "not every number is finite")),
        }
    }

    /// All sections, one after another: what was learned, without what is said of it.
    pub fn content(&self) -> &'a [u8] {
        self.content
    }
}

/// Head and content of a whole pack.
fn taken_apart(bytes: &[u8]) -> Result<(Head, &[u8]), Fault> {
    if !bytes.starts_with(&MAGIC) {
        return Err(Fault::Foreign(bytes[..bytes.len().min(MAGIC.len())].to_vec()));
    }
    let number = |at: usize| -> Option<u32> {
        Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
    };
    let found = bytes.len() as u64;
    let short = |said: usize| Fault::Length { found, said: said as u64 };
    let version = number(MAGIC.len()).ok_or_else(|| short(BEFORE))?;
    if version != VERSION {
        return Err(Fault::Version(version));
    }
    let length = number(MAGIC.len() + 4).ok_or_else(|| short(BEFORE))? as usize;
    if length > LONGEST_HEAD {
        return Err(Fault::Head(format!("{length} bytes, at most {LONGEST_HEAD} are read")));
    }
    let head = bytes.get(BEFORE..BEFORE + length).ok_or_else(|| short(BEFORE + length))?;
    let head: Head = serde_json::from_slice(head).map_err(|e| Fault::Head(e.to_string()))?;
    let content = head.sections.iter().try_fold(0_u64, |sum, s| sum.checked_add(s.bytes));
    let said = content.and_then(|content| content.checked_add((BEFORE + length + DIGEST) as u64));
    let said = said.ok_or_else(|| Fault::Head("its sections have no end".into()))?;
    if said != found {
        return Err(Fault::Length { found, said });
    }
    let (own, digest) = bytes.split_at(bytes.len() - DIGEST);
    if blake3::hash(own).as_bytes() != digest {
        return Err(Fault::Digest);
    }
    sound(&head)?;
    Ok((head, &own[BEFORE + length..]))
}

/// Refuses a head that says two things at once.
fn sound(head: &Head) -> Result<(), Fault> {
    let mut seen = BTreeSet::new();
    let tables = head.tables.iter().map(|t| ("table", &t.name));
    for (what, name) in tables.chain(head.sections.iter().map(|s| ("section", &s.name))) {
        if !seen.insert((what, name)) {
            return Err(Fault::Head(format!("two things are called {what} `{name}`")));
        }
    }
    let stray = head.sections.iter().find(|s| !seen.contains(&("table", &s.table)));
    match stray {
        Some(s) => Err(Fault::Head(format!("`{}` asks about no table: `{}`", s.name, s.table))),
        None => Ok(()),
    }
}

/// A pack of these sections. The same head and bytes give the same pack.
///
/// # Errors
/// [`Fault::Head`] when two sections or tables have one name, a section names no table, or the head is
/// too long.
pub fn write(mut head: Head, sections: Vec<(Section, Vec<u8>)>) -> Result<Vec<u8>, Fault> {
    let count = |(section, bytes): &(Section, Vec<u8>)| Section {
        bytes: bytes.len() as u64,
        ..section.clone()
    };
    head.sections = sections.iter().map(count).collect();
    sound(&head)?;
    let text = serde_json::to_vec(&head).map_err(|e| Fault::Head(e.to_string()))?;
    let length = u32::try_from(text.len()).ok().filter(|&l| l as usize <= LONGEST_HEAD);
    let length = length.ok_or_else(|| Fault::Head(format!("{} bytes are too many", text.len())))?;
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(length.to_le_bytes());
    bytes.extend(text);
    sections.iter().for_each(|(_, own)| bytes.extend(own));
    let digest = blake3::hash(&bytes);
    bytes.extend(digest.as_bytes());
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::super::forest::{Step, Tree, Way};
    use super::*;

    fn forest() -> Forest<2> {
        let steps = vec![Step { feature: 1, most: 0.5, ways: [Way::End(0), Way::End(1)] }];
        Forest { trees: vec![Tree::new(steps, vec![1.0, -1.0]).unwrap()] }
    }

    fn head() -> Head {
        let origin = Origin { commit: Some("0".repeat(40)), ..Origin::default() };
        let table = Table::new("unary", ["way", "gap"]);
        let mut head = Head::new("segments", vec![table], origin);
        head.ensembles.push(Ensemble { folds: 1, rounds: 1 });
        head.settings.insert("rounds".into(), 3.0);
        head
    }

    fn sections() -> Vec<(Section, Vec<u8>)> {
        let mut trees = Vec::new();
        forest().write(&mut trees);
        let weights = [0.25_f32, 3.0].map(f32::to_le_bytes).concat();
        vec![
            (Section::new("trees", "unary", Form::Forest), trees),
            (Section::new("weights", "unary", Form::Single), weights),
        ]
    }

    fn pack() -> Vec<u8> {
        write(head(), sections()).unwrap()
    }

    fn fault(bytes: &[u8]) -> Fault {
        Pack::open("p", bytes).unwrap_err().fault
    }

    /// The pack of other bytes, with a digest that holds.
    fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
        bytes.truncate(bytes.len() - DIGEST);
        let digest = blake3::hash(&bytes);
        bytes.extend(digest.as_bytes());
        bytes
    }

    #[test]
    fn what_was_written_is_read() {
        let bytes = pack();
        let pack = Pack::open("p", &bytes).unwrap();
        assert_eq!(pack.forest::<2>("trees").unwrap(), forest());
        assert_eq!(pack.numbers("weights", 2).unwrap(), [0.25, 3.0]);
        assert_eq!(pack.setting("rounds").unwrap(), 3.0);
        assert_eq!(pack.head.ensembles, [Ensemble { folds: 1, rounds: 1 }]);
        assert_eq!(pack.content(), sections().into_iter().flat_map(|s| s.1).collect::<Vec<_>>());
        assert_eq!(pack.is("segments"), Ok(()));
        assert_eq!(write(head(), sections()).unwrap(), bytes, "same input, same bytes");
    }

    #[test]
    fn a_pack_is_refused_by_the_first_feature_that_differs() {
        let bytes = pack();
        let pack = Pack::open("segments.pack", &bytes).unwrap();
        assert_eq!(pack.asks("unary", &["way", "gap"]), Ok(()));
        let told = |here: &[&str]| pack.asks("unary", here).unwrap_err().to_string();
        assert_eq!(
            told(&["gap", "way"]),
            "pack segments.pack: its table `unary` asks for `way`, this program has `gap`, as feature 0"
        );
        assert!(told(&["way"]).contains("asks for `gap`, this program has `(nothing more)`"));
        assert!(told(&["way", "gap", "x"]).contains("`(nothing more)`, this program has `x`"));
        assert!(pack.asks("pairwise", &["way"]).unwrap_err().to_string().contains("no such table"));
    }

    #[test]
    fn every_damaged_bit_and_every_cut_is_noticed() {
        let whole = pack();
        for at in 0..whole.len() {
            assert!(Pack::open("p", &whole[..at]).is_err(), "cut at {at}");
            for bit in 0..8 {
                let mut damaged = whole.clone();
                damaged[at] ^= 1 << bit;
                assert!(Pack::open("p", &damaged).is_err(), "bit {bit} of byte {at}");
            }
        }
        let longer = [&whole[..], b"x"].concat();
        assert!(matches!(fault(&longer), Fault::Length { .. }));
    }

    #[test]
    fn what_is_no_pack_of_this_program_says_what_it_is() {
        assert_eq!(fault(b"PK\x03\x04"), Fault::Foreign(b"PK\x03\x04".to_vec()));
        let mut newer = pack();
        newer[MAGIC.len()] = 2;
        assert_eq!(fault(&sealed(newer)), Fault::Version(2));
        let bytes = pack();
        let pack = Pack::open("p", &bytes).unwrap();
        let told = pack.is("axes").unwrap_err().to_string();
        assert_eq!(told, "pack p: a pack of `segments`, not of `axes`");
    }

    #[test]
    fn a_section_is_what_it_says_or_refused_by_name() {
        let bytes = pack();
        let pack = Pack::open("p", &bytes).unwrap();
        assert!(pack.forest::<3>("trees").is_err(), "three features");
        assert!(pack.forest::<2>("weights").is_err(), "numbers are no forest");
        assert!(pack.numbers("trees", 2).is_err(), "a forest is no numbers");
        assert!(pack.numbers("weights", 1).is_err() && pack.numbers("weights", 3).is_err());
        assert!(pack.numbers("none", 1).unwrap_err().to_string().contains("`none`"));
        assert!(pack.setting("none").is_err());
        let mut own = sections();
        own[0].1.push(0);
        let longer = write(head(), own).unwrap();
        assert!(Pack::open("p", &longer).unwrap().forest::<2>("trees").is_err());
        let mut own = sections();
        own[1].1[..4].copy_from_slice(&f32::NAN.to_le_bytes());
        let endless = write(head(), own).unwrap();
        assert!(Pack::open("p", &endless).unwrap().numbers("weights", 2).is_err());
    }

    #[test]
    fn a_feature_is_found_by_its_whole_name() {
        let names = ["way", "way_over", "gap"];
        assert_eq!(
            ["way", "way_over", "gap", "wa", "gaps"].map(|n| place(&names, n)),
            [0, 1, 2, 3, 3]
        );
    }

    #[test]
    fn one_name_means_one_thing() {
        let mut twice = sections();
        twice[1].0.name = "trees".into();
        assert!(matches!(write(head(), twice), Err(Fault::Head(_))));
        let mut stray = sections();
        stray[1].0.table = "pairwise".into();
        assert!(matches!(write(head(), stray), Err(Fault::Head(_))));
        let mut unknown = pack();
        let text = String::from_utf8_lossy(&unknown).into_owned();
        let at = text.find("\"kind\"").unwrap_or(BEFORE + 1);
        unknown[at + 1] = b'K';
        assert!(matches!(fault(&sealed(unknown)), Fault::Head(_)), "unknown fields are refused");
    }
}
