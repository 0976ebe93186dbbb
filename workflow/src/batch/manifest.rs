//! What a batch is asked for: a line per item, as JSON Lines, CSV or a folder of photos.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read as _};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// Longest line that is read, bytes.
const MAX_LINE: u64 = 1 << 20;
/// Most bytes of a manifest: some twenty million items. A guess; what is longer is read for hours before
/// its first line is.
pub const MOST: u64 = 4 << 30;
/// Longest id, bytes: it becomes the name of a folder.
const MAX_ID: usize = 120;
/// Pictures a folder is looked through for.
const PICTURES: [&str; 4] = ["png", "jpg", "jpeg", "webp"];

/// One line: a photo, what is known of it, and the name of the folder its asset goes to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Item {
    /// Name, unique in the manifest; the photo's file name without its end if left out.
    #[serde(default)]
    pub id: String,
    /// The photo, relative to the manifest's folder; empty where mesh and condition are given without one.
    #[serde(default, skip_serializing_if = "is_empty")]
    pub photo: PathBuf,
    /// A mesh, instead of a generator's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<PathBuf>,
    /// A condition, instead of a vision-language model's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<PathBuf>,
    /// Seed of everything random; the batch's if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// What it is, such as `kettle`; for the report.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub category: Option<String>,
    /// Licence of the photo, best as SPDX says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub license: Option<String>,
    /// How likely all of its asset must be right to be accepted, 0 to 1; the batch's if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_confidence: Option<f64>,
}

/// A line and what is in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Counted from 1; of a folder, the ordinal of the photo by name.
    pub number: u64,
    /// The item, or why there is none.
    pub item: Result<Item, String>,
}

/// Why a manifest cannot be read on.
#[derive(Debug, thiserror::Error)]
#[error("{}: {found}", path.display())]
pub struct ManifestError {
    /// The file or folder.
    pub path: PathBuf,
    /// What happened.
    pub found: String,
}

/// The lines of a manifest, one at a time.
pub type Lines = Box<dyn Iterator<Item = Result<Line, ManifestError>>>;

/// Opens a manifest: a folder of photos, a `.csv` file, or JSON Lines.
///
/// # Errors
/// [`ManifestError`] when it cannot be opened. What is wrong with one line stands in that line.
pub fn open(path: &Path) -> Result<Lines, ManifestError> {
    if path.is_dir() {
        return folder(path);
    }
    let file = guard::files::open_file(path, MOST).map_err(|e| failed(path, &e))?;
    let is_csv = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    if is_csv { csv_lines(path, file) } else { Ok(json_lines(path, BufReader::new(file))) }
}

/// The folder paths of a manifest's lines are relative to.
pub fn base(path: &Path) -> &Path {
    if path.is_dir() { path } else { path.parent().unwrap_or(Path::new("")) }
}

/// The manifest by a path that is the same wherever the program was started and however it was named,
/// so that its items are the same, too. A manifest that is not there stays as it was named.
pub fn settled(path: &Path) -> PathBuf {
    let folder = match base(path) {
        folder if folder.as_os_str().is_empty() => Path::new("."),
        folder => folder,
    };
    let Ok(whole) = std::fs::canonicalize(folder) else { return path.to_path_buf() };
    if path.is_dir() { whole } else { whole.join(path.file_name().unwrap_or_default()) }
}

fn failed(path: &Path, error: &dyn std::fmt::Display) -> ManifestError {
    ManifestError { path: path.to_path_buf(), found: error.to_string() }
}

fn folder(path: &Path) -> Result<Lines, ManifestError> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(path).map_err(|e| failed(path, &e))? {
        let name = PathBuf::from(entry.map_err(|e| failed(path, &e))?.file_name());
        let end = name.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        if end.is_some_and(|e| PICTURES.contains(&e.as_str())) {
            names.push(name);
        }
    }
    names.sort();
    let line = |(photo, number)| {
        let item = Item { photo, ..Item::default() }.named();
        Ok(Line { number, item })
    };
    Ok(Box::new(names.into_iter().zip(1..).map(line)))
}

fn json_lines(path: &Path, mut reader: impl BufRead + 'static) -> Lines {
    let path = path.to_path_buf();
    let mut number = 0;
    Box::new(std::iter::from_fn(move || {
        loop {
            number += 1;
            let bytes = match next_line(&mut reader) {
                Ok(bytes) => bytes?,
                Err(e) => return Some(Err(failed(&path, &e))),
            };
            if !bytes.trim_ascii().is_empty() {
                return Some(Ok(Line { number, item: item_of(&bytes) }));
            }
        }
    }))
}

/// The next line, of which no more than [`MAX_LINE`] bytes are kept; none at the end.
fn next_line(reader: &mut impl BufRead) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    if reader.by_ref().take(MAX_LINE + 1).read_until(b'\n', &mut bytes)? == 0 {
        return Ok(None);
    }
    if bytes.len() as u64 > MAX_LINE && bytes.last() != Some(&b'\n') {
        reader.skip_until(b'\n')?;
    }
    Ok(Some(bytes))
}

fn item_of(bytes: &[u8]) -> Result<Item, String> {
    if bytes.len() as u64 > MAX_LINE {
        return Err(format!("a line has at most {MAX_LINE} bytes, found more"));
    }
    let item: Result<Item, _> = serde_json::from_slice(bytes);
    item.map_err(|e| format!("expected an item as JSON, found {}", words(&e)))?.named()
}

/// The error without its place in the line: the line is known, and it is short.
fn words(error: &serde_json::Error) -> String {
    let text = error.to_string();
    text.split(" at line 1 column").next().unwrap_or(&text).to_owned()
}

fn csv_lines(path: &Path, file: File) -> Result<Lines, ManifestError> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
    let headers = reader.headers().map_err(|e| failed(path, &e))?.clone();
    let has = |name: &str| headers.iter().any(|h| h == name);
    if !(has("photo") || has("mesh") && has("condition")) {
        let found: Vec<_> = headers.iter().collect();
        let found = format!("expected a column `photo`, found {}", found.join(", "));
        return Err(ManifestError { path: path.to_path_buf(), found });
    }
    let line = |read: Result<csv::StringRecord, csv::Error>, headers: &csv::StringRecord| {
        let place = read.as_ref().map_or_else(csv::Error::position, csv::StringRecord::position);
        let number = place.map_or(0, csv::Position::line);
        let item = read.and_then(|r| r.deserialize::<Item>(Some(headers)));
        Line { number, item: item.map_err(|e| csv_words(&e)).and_then(Item::named) }
    };
    let path = path.to_path_buf();
    let lines = reader.into_records().map(move |read| match read {
        Err(e) if e.is_io_error() => Err(failed(&path, &e)),
        read => Ok(line(read, &headers)),
    });
    Ok(Box::new(lines))
}

/// The error without the place, which is told anyway.
fn csv_words(error: &csv::Error) -> String {
    let text = error.to_string();
    text.rsplit_once("): ").map_or(text.as_str(), |(_, words)| words).to_owned()
}

fn is_empty(path: &Path) -> bool {
    path.as_os_str().is_empty()
}

impl Item {
    /// The photo, if there is one.
    pub fn given_photo(&self) -> Option<&Path> {
        Some(self.photo.as_path()).filter(|path| !is_empty(path))
    }

    /// The item with an id that can be a folder's name.
    fn named(mut self) -> Result<Self, String> {
        let is_given = self.mesh.is_some() && self.condition.is_some();
        if self.photo.as_os_str().is_empty() && !is_given {
            return Err("an item needs a `photo`, or a `mesh` and a `condition`".into());
        }
        if let Some(least) = self.min_confidence.filter(|p| !(0.0..=1.0).contains(p)) {
            return Err(format!("`min_confidence` is a probability from 0 to 1, found {least}"));
        }
        if self.id.is_empty() {
            let named = self.given_photo().or(self.mesh.as_deref()).unwrap_or(Path::new(""));
            self.id = named.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        }
        let fits = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
        let good = self.id.chars().all(fits) && !self.id.starts_with('.');
        if good && (1..=MAX_ID).contains(&self.id.len()) {
            return Ok(self);
        }
        Err(format!(
            "an id has 1 to {MAX_ID} letters, digits, `.`, `_` or `-` and does not begin with a dot, found `{}`",
            self.id
        ))
    }

    /// The same with paths that count from the program's folder.
    #[must_use]
    pub fn found_from(mut self, base: &Path) -> Self {
        let join = |path: PathBuf| base.join(path);
        if !is_empty(&self.photo) {
            self.photo = join(self.photo);
        }
        self.mesh = self.mesh.map(join);
        self.condition = self.condition.map(join);
        self
    }

    /// Its files that are not there, as the line names them; paths count from `base`.
    pub fn missing(&self, base: &Path) -> Option<String> {
        let files = [("photo", self.given_photo()), ("mesh", self.mesh.as_deref())];
        let files = files.into_iter().chain([("condition", self.condition.as_deref())]);
        let gone: Vec<_> = files
            .filter_map(|(what, path)| path.filter(|p| !base.join(p).is_file()).map(|p| (what, p)))
            .map(|(what, path)| format!("{what} {} is not there", path.display()))
            .collect();
        (!gone.is_empty()).then(|| gone.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(name: &str, text: &[u8]) -> Vec<Line> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(name);
        std::fs::write(&path, text).unwrap();
        open(&path).unwrap().map(Result::unwrap).collect()
    }

    fn wrong(line: &Line) -> &str {
        line.item.as_ref().unwrap_err()
    }

    /// It was hashed, byte by byte, for as long as the deadline let it.
    #[test]
    fn a_terabyte_of_nothing_is_no_manifest() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("items.jsonl");
        std::fs::File::create(&path).unwrap().set_len(1 << 40).unwrap();
        let refused = open(&path).map(drop).unwrap_err().to_string();
        assert!(
            refused.contains("items.jsonl") && refused.contains(&MOST.to_string()),
            "{refused}"
        );
    }

    #[test]
    fn a_manifest_is_the_same_however_it_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("a");
        std::fs::create_dir_all(folder.join("b")).unwrap();
        let file = folder.join("items.jsonl");
        std::fs::write(&file, "").unwrap();
        let whole = std::fs::canonicalize(&file).unwrap();
        assert_eq!(settled(&folder.join("b/../items.jsonl")), whole);
        assert_eq!(settled(&file), whole);
        assert_eq!(settled(&folder.join("b/..")), std::fs::canonicalize(&folder).unwrap());
        assert_eq!(settled(Path::new("no/such/file.jsonl")), Path::new("no/such/file.jsonl"));
    }

    #[test]
    fn json_lines_are_read_one_by_one_and_a_bad_one_stops_nothing() {
        let text = b"{\"photo\":\"a/lid.jpg\"}\n\nnot json\n{\"id\":\"k\",\"photo\":\"k.png\",\"seed\":7}\n\
            {\"photo\":\"x.png\",\"sede\":1}\n{\"id\":\"../up\",\"photo\":\"x.png\"}\n\xff\xfe\n{\"photo\":\"end.png\"}";
        let lines = lines("m.jsonl", text);
        let numbers: Vec<_> = lines.iter().map(|l| l.number).collect();
        assert_eq!(numbers, [1, 3, 4, 5, 6, 7, 8]);
        assert_eq!(lines[0].item.as_ref().unwrap().id, "lid");
        assert!(wrong(&lines[1]).starts_with("expected an item as JSON, found"));
        assert_eq!(lines[2].item.as_ref().unwrap().seed, Some(7));
        assert!(wrong(&lines[3]).contains("unknown field `sede`"), "{}", wrong(&lines[3]));
        assert!(wrong(&lines[4]).contains("found `../up`"));
        assert!(lines[5].item.is_err() && lines[6].item.is_ok());
    }

    #[test]
    fn a_line_without_end_is_refused_and_the_next_is_read() {
        let mut text = vec![b'{'; (MAX_LINE + 5) as usize];
        text.extend_from_slice(b"\n{\"photo\":\"end.png\"}\n");
        let lines = lines("m.jsonl", &text);
        assert!(wrong(&lines[0]).contains("at most"));
        assert_eq!(lines[1].item.as_ref().unwrap().id, "end");
        assert_eq!(lines[1].number, 2);
    }

    #[test]
    fn a_table_is_read_by_its_headers() {
        let text =
            b"id,photo,seed,category\nk1,a.png,5,kettle\nk2,b.png,,\nk3,c.png,many,\nshort\n";
        let lines = lines("m.csv", text);
        assert_eq!(lines[0].item.as_ref().unwrap().category.as_deref(), Some("kettle"));
        assert_eq!(lines[1].item.as_ref().unwrap().seed, None);
        assert_eq!((lines[2].number, lines[2].item.is_err()), (4, true));
        assert_eq!((lines[3].number, lines[3].item.is_err()), (5, true));
    }

    #[test]
    fn a_table_without_photos_is_no_manifest() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("m.csv");
        std::fs::write(&path, "id,picture\n").unwrap();
        let Err(error) = open(&path) else { panic!("it opened") };
        assert!(error.to_string().contains("expected a column `photo`, found id, picture"));
    }

    #[test]
    fn a_folder_gives_its_pictures_by_name() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["b.PNG", "a.jpg", "notes.txt"] {
            std::fs::write(dir.path().join(name), "x").unwrap();
        }
        let lines: Vec<_> = open(dir.path()).unwrap().map(Result::unwrap).collect();
        let ids: Vec<_> = lines.iter().map(|l| l.item.as_ref().unwrap().id.clone()).collect();
        assert_eq!(ids, ["a", "b"]);
        assert_eq!(base(dir.path()), dir.path());
    }
}
