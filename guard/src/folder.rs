//! A folder that a stranger sent: nothing outside of it is read, and looking through it ends.

use std::ffi::OsString;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use cap_std::ambient_authority;
use cap_std::fs::{Dir, File, FileType};

use crate::files::{Refused, reading, regular};

/// How much of a folder is read at most.
#[derive(Clone, Copy, Debug)]
pub struct Caps {
    /// Most files and folders of one walk.
    pub entries: usize,
    /// Most folders one in the other.
    pub depth: usize,
    /// Most bytes of one file.
    pub file: u64,
    /// Most bytes of all files that are read.
    pub all: u64,
    /// The longest time from opening the folder to the last byte read; `None`: whoever asks has a
    /// deadline of its own.
    pub time: Option<Duration>,
}

impl Default for Caps {
    /// A hundred thousand entries, 32 deep, 1 GiB a file, 16 GiB in all. Guesses, far above the
    /// largest package measured: 4,000 files, 4 deep, 0.3 GiB.
    fn default() -> Self {
        Self { entries: 100_000, depth: 32, file: 1 << 30, all: 16 << 30, time: None }
    }
}

/// What stands under a name. A link is a link, wherever it leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A regular file.
    File,
    /// A folder.
    Folder,
    /// A symbolic link.
    Link,
    /// A pipe, a socket or a device.
    Other,
}

impl Kind {
    fn of(kind: FileType) -> Self {
        if kind.is_file() {
            Self::File
        } else if kind.is_dir() {
            Self::Folder
        } else if kind.is_symlink() {
            Self::Link
        } else {
            Self::Other
        }
    }
}

/// Something in a folder.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Entry {
    /// Its path in the folder.
    pub path: PathBuf,
    /// What it is.
    pub kind: Kind,
}

/// A folder of which files are read, and never one outside of it: neither through a link nor by an
/// absolute path nor by `..`. Folders that were allowed besides count as inside.
#[derive(Debug)]
pub struct Folder {
    root: PathBuf,
    /// The folder itself first, then those allowed besides, each with its real path.
    open: Vec<(PathBuf, Dir)>,
    caps: Caps,
    until: Option<Instant>,
    left: AtomicU64,
}

impl Folder {
    /// Opens a folder that a person named.
    ///
    /// # Errors
    /// [`Refused::Open`] when there is none or it may not be opened.
    pub fn open(root: &Path, caps: Caps) -> Result<Self, Refused> {
        let until = caps.time.and_then(|time| Instant::now().checked_add(time));
        let left = AtomicU64::new(caps.all);
        let open = vec![ambient(root)?];
        Ok(Self { root: root.to_path_buf(), open, caps, until, left })
    }

    /// The same, with another folder from which files may be read: where a link or a path leads
    /// there, it leads inside.
    ///
    /// # Errors
    /// [`Refused::Open`] when there is none or it may not be opened.
    pub fn allowing(mut self, other: &Path) -> Result<Self, Refused> {
        self.open.push(ambient(other)?);
        Ok(self)
    }

    /// A folder within, with caps of its own and the same deadline.
    ///
    /// # Errors
    /// [`Refused`] when there is none, or it lies outside.
    pub fn within(&self, name: &Path, caps: Caps) -> Result<Self, Refused> {
        let (at, dir, name) = self.find(name, |dir, name| dir.open_dir(name))?;
        let root = at.join(name);
        let left = AtomicU64::new(caps.all);
        let open = vec![(root.clone(), dir)];
        Ok(Self { root, open, caps, until: self.until, left })
    }

    /// Its path, as it was named.
    pub fn path(&self) -> &Path {
        &self.root
    }

    /// What stands under a name in it; `None` if nothing does.
    ///
    /// # Errors
    /// [`Refused`] when the way there leads outside, or the disk refuses.
    pub fn kind(&self, name: &Path) -> Result<Option<Kind>, Refused> {
        match self.find(name, |dir, name| dir.symlink_metadata(name)) {
            Ok((_, about, _)) => Ok(Some(Kind::of(about.file_type()))),
            Err(refused) if refused.is_absence() => Ok(None),
            Err(refused) => Err(refused),
        }
    }

    /// The real path of a regular file in it, for libraries that open files by their names.
    ///
    /// # Errors
    /// [`Refused`] when there is none, it lies outside, or is no regular file.
    pub fn real(&self, name: &Path) -> Result<PathBuf, Refused> {
        let (at, about, name) = self.find(name, |dir, name| dir.metadata(name))?;
        if !about.is_file() {
            return Err(Refused::NotRegular);
        }
        if about.len() > self.caps.file {
            return Err(Refused::TooLarge { most: self.caps.file });
        }
        Ok(at.join(name))
    }

    /// Opens a regular file of it.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn file(&self, name: &Path) -> Result<Opened<'_>, Refused> {
        let (at, about, name) = self.find(name, |dir, name| dir.metadata(name))?;
        // To open a device may be to do something with it.
        if !about.is_file() {
            return Err(Refused::NotRegular);
        }
        let dir = self.open.iter().find(|(place, _)| *place == at).map(|(_, dir)| dir);
        let dir = dir.ok_or(Refused::Outside)?;
        let file = dir.open_with(&name, &reading()).map_err(refused)?;
        let length = regular(&file, self.caps.file)?;
        if length > self.left.load(Ordering::Relaxed) {
            return Err(Refused::TooMuch { most: self.caps.all });
        }
        Ok(Opened { file, folder: self, read: 0, length })
    }

    /// Reads a regular file of it.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn read(&self, name: &Path) -> Result<Vec<u8>, Refused> {
        let mut opened = self.file(name)?;
        let mut bytes = Vec::with_capacity(usize::try_from(opened.length).unwrap_or_default());
        opened.read_to_end(&mut bytes).map_err(Refused::of)?;
        Ok(bytes)
    }

    /// What stands directly in a folder of it, by name; nothing if there is no such folder. The
    /// paths begin with the folder's.
    ///
    /// # Errors
    /// [`Refused`] when it holds too much or lies outside.
    pub fn list(&self, name: &Path) -> Result<Vec<Entry>, Refused> {
        match self.kind(name)? {
            Some(Kind::Folder) => {}
            None => return Ok(Vec::new()),
            Some(_) => return Err(Refused::NotRegular),
        }
        let (_, dir, _) = self.find(name, |dir, name| dir.open_dir(name))?;
        let mut seen = 0;
        let names = self.names(&dir, &mut seen)?;
        let entry = |(own, kind): (OsString, Kind)| Entry { path: joined(name, &own), kind };
        Ok(names.into_iter().map(entry).collect())
    }

    /// Everything at or below a path that is no folder, by name. Links stand in the list and are not
    /// followed.
    ///
    /// # Errors
    /// [`Refused`] when there is too much of it, it is too deep, or takes too long.
    pub fn walk(&self, below: &Path) -> Result<Vec<Entry>, Refused> {
        let mut found = Vec::new();
        match self.kind(below)? {
            None => return Ok(found),
            Some(Kind::Folder) => {}
            Some(kind) => return Ok(vec![Entry { path: below.to_path_buf(), kind }]),
        }
        let (_, dir, _) = self.find(below, |dir, name| dir.open_dir(name))?;
        let mut seen = 0;
        self.descend(&dir, below, (0, &mut seen), &mut found)?;
        Ok(found)
    }

    fn descend(
        &self,
        dir: &Dir,
        at: &Path,
        (depth, seen): (usize, &mut usize),
        found: &mut Vec<Entry>,
    ) -> Result<(), Refused> {
        if depth >= self.caps.depth {
            return Err(Refused::TooDeep { most: self.caps.depth });
        }
        for (name, kind) in self.names(dir, seen)? {
            let path = joined(at, &name);
            if kind == Kind::Folder {
                let below = dir.open_dir(&name).map_err(refused)?;
                self.descend(&below, &path, (depth + 1, &mut *seen), found)?;
            } else {
                found.push(Entry { path, kind });
            }
        }
        Ok(())
    }

    /// The names directly in a folder, in order.
    fn names(&self, dir: &Dir, seen: &mut usize) -> Result<Vec<(OsString, Kind)>, Refused> {
        let mut names = Vec::new();
        for entry in dir.entries().map_err(Refused::Read)? {
            let entry = entry.map_err(Refused::Read)?;
            *seen += 1;
            if *seen > self.caps.entries {
                return Err(Refused::TooMany { most: self.caps.entries });
            }
            self.in_time()?;
            let kind = Kind::of(entry.file_type().map_err(Refused::Read)?);
            names.push((entry.file_name(), kind));
        }
        names.sort();
        Ok(names)
    }

    fn in_time(&self) -> Result<(), Refused> {
        match self.until.is_some_and(|until| Instant::now() > until) {
            true => Err(Refused::TooLong { most: self.caps.time.unwrap_or_default() }),
            false => Ok(()),
        }
    }

    /// Does something with a path in the folder, or, where it leads to one that was allowed, in
    /// that one; says in which, and the path there. It can lead nowhere else.
    fn find<'a, A>(
        &self,
        name: &'a Path,
        act: impl Fn(&Dir, &Path) -> io::Result<A>,
    ) -> Result<(PathBuf, A, std::borrow::Cow<'a, Path>), Refused> {
        self.in_time()?;
        let Some((root, dir)) = self.open.first() else { return Err(Refused::Outside) };
        match act(dir, name) {
            Ok(done) => return Ok((root.clone(), done, name.into())),
            Err(e) if is_escape(&e) => {}
            Err(e) => return Err(Refused::Open(e)),
        }
        // An absolute link may lead back inside.
        let real = root.join(name).canonicalize().map_err(Refused::Open)?;
        for (place, dir) in &self.open {
            if let Ok(rest) = real.strip_prefix(place) {
                let rest = if rest.as_os_str().is_empty() { Path::new(".") } else { rest };
                let done = act(dir, rest).map_err(refused)?;
                return Ok((place.clone(), done, rest.to_path_buf().into()));
            }
        }
        Err(Refused::Outside)
    }
}

fn ambient(path: &Path) -> Result<(PathBuf, Dir), Refused> {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    let dir = Dir::open_ambient_dir(path, ambient_authority()).map_err(Refused::Open)?;
    Ok((path.canonicalize().map_err(Refused::Open)?, dir))
}

/// A path in a folder; one in `.` stands without it.
fn joined(folder: &Path, name: &OsString) -> PathBuf {
    if folder == Path::new(".") { PathBuf::from(name) } else { folder.join(name) }
}

/// Whether cap-std says that a path leads outside: its own error, none of the operating system's.
fn is_escape(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::PermissionDenied && error.raw_os_error().is_none()
}

fn refused(error: io::Error) -> Refused {
    if is_escape(&error) { Refused::Outside } else { Refused::Open(error) }
}

/// An open file of a folder. What is read counts against the folder's caps; an error of theirs comes
/// out of [`Refused::of`].
#[derive(Debug)]
pub struct Opened<'a> {
    file: File,
    folder: &'a Folder,
    read: u64,
    length: u64,
}

impl Opened<'_> {
    /// Its length when it was opened, bytes.
    pub fn length(&self) -> u64 {
        self.length
    }
}

impl Read for Opened<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let Caps { file, all, .. } = self.folder.caps;
        self.folder.in_time().map_err(io::Error::other)?;
        let count = self.file.read(bytes)?;
        self.read += count as u64;
        if self.read > file {
            return Err(io::Error::other(Refused::TooLarge { most: file }));
        }
        let take = |left: u64| left.checked_sub(count as u64);
        let taken = self.folder.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take);
        if taken.is_err() {
            return Err(io::Error::other(Refused::TooMuch { most: all }));
        }
        Ok(count)
    }
}

#[cfg(all(test, unix))]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    fn folder() -> (tempfile::TempDir, Folder) {
        let place = tempfile::tempdir().unwrap();
        let root = place.path().join("package");
        std::fs::create_dir_all(root.join("in/deep")).unwrap();
        std::fs::write(root.join("in/deep/a"), "inside").unwrap();
        std::fs::write(place.path().join("secret"), "outside").unwrap();
        let folder = Folder::open(&root, Caps::default()).unwrap();
        (place, folder)
    }

    fn told(refused: Result<Vec<u8>, Refused>) -> String {
        refused.unwrap_err().to_string()
    }

    #[test]
    fn no_way_leads_out_and_every_way_inside_is_followed() {
        let (place, folder) = folder();
        let root = place.path().join("package");
        symlink("../secret", root.join("relative")).unwrap();
        symlink(place.path().join("secret"), root.join("absolute")).unwrap();
        symlink(place.path(), root.join("up")).unwrap();
        symlink(root.join("in"), root.join("own")).unwrap();
        symlink("deep/a", root.join("in/near")).unwrap();
        let secret = place.path().join("secret").display().to_string();
        for out in ["relative", "absolute", "up/secret", "../secret", "in/../../secret", &secret] {
            let error = folder.read(Path::new(out)).unwrap_err();
            assert!(matches!(error, Refused::Outside), "{out}: {error}");
        }
        for inside in ["in/deep/a", "own/deep/a", "in/near", "in/../in/deep/a", "./in/deep/a"] {
            assert_eq!(folder.read(Path::new(inside)).unwrap(), b"inside", "{inside}");
        }
        let allowed = Folder::open(&root, Caps::default()).unwrap().allowing(place.path()).unwrap();
        assert_eq!(allowed.read(Path::new("relative")).unwrap(), b"outside");
        assert!(allowed.read(Path::new("/etc/hostname")).is_err());
    }

    #[test]
    fn links_in_circles_and_pipes_are_told_and_not_followed() {
        let (place, folder) = folder();
        let root = place.path().join("package");
        for name in ["x", "y"] {
            symlink(".", root.join("in").join(name)).unwrap();
        }
        symlink("self", root.join("self")).unwrap();
        assert!(
            std::process::Command::new("mkfifo").arg(root.join("p")).status().unwrap().success()
        );
        let found = folder.walk(Path::new(".")).unwrap();
        let told: Vec<_> =
            found.iter().map(|e| (e.path.to_str().unwrap().to_owned(), e.kind)).collect();
        let expected = [
            ("in/deep/a", Kind::File),
            ("in/x", Kind::Link),
            ("in/y", Kind::Link),
            ("p", Kind::Other),
            ("self", Kind::Link),
        ];
        assert_eq!(told, expected.map(|(name, kind)| (name.to_owned(), kind)));
        assert!(matches!(folder.read(Path::new("p")), Err(Refused::NotRegular)));
        assert!(matches!(folder.read(Path::new("self")), Err(Refused::Open(_))));
        assert_eq!(folder.walk(Path::new("nothing")).unwrap(), []);
    }

    #[test]
    fn every_cap_is_named_by_the_error() {
        let (place, _) = folder();
        let root = place.path().join("package");
        let with = |caps| Folder::open(&root, caps).unwrap();
        let few = with(Caps { entries: 2, ..Caps::default() }).walk(Path::new("."));
        assert!(few.unwrap_err().to_string().contains("more than 2 files and folders"));
        let flat = with(Caps { depth: 2, ..Caps::default() }).walk(Path::new("."));
        assert!(flat.unwrap_err().to_string().contains("more than 2 deep"));
        let short = with(Caps { file: 5, ..Caps::default() });
        assert!(told(short.read(Path::new("in/deep/a"))).contains("more than 5 bytes"));
        let little = with(Caps { all: 8, ..Caps::default() });
        assert!(little.read(Path::new("in/deep/a")).is_ok());
        assert!(told(little.read(Path::new("in/deep/a"))).contains("more than 8 bytes in all"));
        let late = with(Caps { time: Some(Duration::ZERO), ..Caps::default() });
        std::thread::sleep(Duration::from_millis(2));
        assert!(told(late.read(Path::new("in/deep/a"))).contains("after 0 s"));
    }

    #[test]
    fn a_folder_within_is_no_way_out_either() {
        let (place, folder) = folder();
        symlink(place.path(), place.path().join("package/in/up")).unwrap();
        assert!(matches!(
            folder.within(Path::new("in/up"), Caps::default()),
            Err(Refused::Outside)
        ));
        assert!(matches!(folder.within(Path::new(".."), Caps::default()), Err(Refused::Outside)));
        let within = folder.within(Path::new("in"), Caps::default()).unwrap();
        assert_eq!(within.read(Path::new("deep/a")).unwrap(), b"inside");
        assert!(matches!(within.read(Path::new("../../secret")), Err(Refused::Outside)));
        assert_eq!(within.read(Path::new("../in/deep/a")).unwrap(), b"inside", "it leads back");
        let real = within.real(Path::new("deep/a")).unwrap();
        assert_eq!(real, place.path().canonicalize().unwrap().join("package/in/deep/a"));
    }
}
