//! Mesh files of a package: which paths a URDF may name, and how each format is read.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use glamx::DVec3;
use guard::files::Refused;
use guard::folder::{Caps, Folder};
use object::Mesh;
use object::mesh::UpAxis;

use crate::read::places::{Address, Places, address, package_above};
use crate::robot::Geometry;

/// Most bytes all mesh files of one URDF may have (1 GiB).
pub const MAX_MESH_BYTES: u64 = 1 << 30;

/// Whether a URDF may name meshes outside its own folder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outside {
    /// It may not: such a mesh is not even opened.
    #[default]
    Refused,
    /// It may, by absolute paths, `..` and links; check F2 flags each.
    Allowed,
}

/// The mesh files of one package, each read once.
pub(crate) struct Shelf {
    /// None if there is no such folder.
    folder: Option<Folder>,
    home: PathBuf,
    outside: Outside,
    places: Places,
    /// Packages that were named, by name; none where there is no such package.
    packages: BTreeMap<String, Option<Folder>>,
    /// The package the file itself lies in, once it was asked for.
    own: Option<Option<(PathBuf, Folder)>>,
    found_outside: Vec<String>,
    /// Bytes that may still be read outside of the folder.
    elsewhere: u64,
    files: BTreeMap<String, Result<Arc<Mesh>, Trouble>>,
    /// Files that stand nowhere yet, by the names they are to have.
    added: Added,
    /// Meshes that were decoded before.
    decoded: Decoded,
    scaled: BTreeMap<(String, [u64; 3]), Result<Arc<Mesh>, Trouble>>,
}

/// Files that stand nowhere yet, by the names that a model gives them.
pub type Added = BTreeMap<String, Arc<[u8]>>;

/// Meshes by the digest and the format of their bytes: of a model that is read again and again each
/// is decoded once.
#[derive(Clone, Debug, Default)]
pub struct Decoded(Arc<Mutex<Known>>);

type Known = BTreeMap<([u8; 32], String), Arc<Mesh>>;

impl Decoded {
    fn or_decode(&self, format: &str, bytes: &[u8]) -> Result<Arc<Mesh>, String> {
        let key = (*blake3::hash(bytes).as_bytes(), format.to_owned());
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(mesh) = known().get(&key) {
            return Ok(mesh.clone());
        }
        let mesh = Arc::new(decode(format, bytes)?);
        known().insert(key, mesh.clone());
        Ok(mesh)
    }
}

/// Why a mesh cannot be had.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Trouble {
    /// The path breaks a rule, or nothing readable is there: check F2 fails.
    Broken(String),
    /// The file is there, but its format is not read here: what depends on it is unknown.
    Foreign(String),
}

impl Shelf {
    /// The package whose URDF lies in `folder`.
    #[cfg(test)]
    pub(crate) fn new(folder: &Path, outside: Outside) -> Self {
        Self::with(folder, outside, &Places::default())
    }

    /// The same, with where its addresses lead.
    pub(crate) fn with(home: &Path, outside: Outside, places: &Places) -> Self {
        Self {
            folder: Folder::open(home, caps()).ok(),
            home: home.to_owned(),
            outside,
            places: places.clone(),
            packages: BTreeMap::new(),
            own: None,
            found_outside: Vec::new(),
            elsewhere: MAX_MESH_BYTES,
            files: BTreeMap::new(),
            added: Added::new(),
            decoded: Decoded::default(),
            scaled: BTreeMap::new(),
        }
    }

    /// The same with files that stand nowhere yet, and with meshes that were decoded before.
    pub(crate) fn and(mut self, added: &Added, decoded: &Decoded) -> Self {
        (self.added, self.decoded) = (added.clone(), decoded.clone());
        self
    }

    /// Where addresses lead.
    pub(crate) fn places(&self) -> &Places {
        &self.places
    }

    /// The packages that were found, in the order of their names.
    pub(crate) fn found_packages(&self) -> Vec<String> {
        let found = self.packages.iter().filter(|(_, folder)| folder.is_some());
        found.map(|(name, _)| name.clone()).collect()
    }

    /// Names that two meshes in different folders have.
    pub(crate) fn shared_names(&self) -> Vec<String> {
        let mut by_name: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for path in self.files.keys() {
            let name = path.rsplit('/').next().unwrap_or(path);
            by_name.entry(name).or_default().insert(path);
        }
        let shared = by_name.into_iter().filter(|(_, paths)| paths.len() > 1);
        shared.map(|(_, paths)| paths.into_iter().collect::<Vec<_>>().join("` and `")).collect()
    }

    /// The text of a file that another names: a part of the model in a file of its own.
    ///
    /// # Errors
    /// The rule that the path or the file breaks.
    pub(crate) fn text(&mut self, name: &str) -> Result<String, String> {
        let bytes = self.reach(name).map_err(|trouble| match trouble {
            Trouble::Broken(why) | Trouble::Foreign(why) => why,
        })?;
        String::from_utf8(bytes).map_err(|_| format!("`{name}` is not UTF-8"))
    }

    /// The bytes of a file that another names: a layer of a stage.
    ///
    /// # Errors
    /// The rule that the path or the file breaks.
    pub(crate) fn layer(&mut self, name: &str) -> Result<Vec<u8>, String> {
        self.reach(name).map_err(|trouble| match trouble {
            Trouble::Broken(why) | Trouble::Foreign(why) => why,
        })
    }

    /// Where a file that an address names lies, and its bytes.
    ///
    /// # Errors
    /// The rule that the path or the file breaks.
    pub(crate) fn file(&mut self, name: &str) -> Result<(PathBuf, Vec<u8>), String> {
        let bytes = self.reach(name).map_err(|trouble| match trouble {
            Trouble::Broken(why) | Trouble::Foreign(why) => why,
        })?;
        let path = match address(name) {
            Address::Package { name: package, path } => {
                let folder = self.packages.get(package).and_then(Option::as_ref);
                folder.map(|folder| folder.path().join(path))
            }
            Address::Path(path) => Some(self.home.join(path)),
            Address::Foreign => None,
        };
        Ok((path.unwrap_or_else(|| self.home.join(name)), bytes))
    }

    /// Meshes that were read although they lie outside the folder, in order of first use.
    pub(crate) fn found_outside(self) -> Vec<String> {
        self.found_outside
    }

    /// The mesh a URDF names, scaled; a broken path or file is reported in `faults`.
    pub(crate) fn geometry(
        &mut self,
        name: &str,
        scale: DVec3,
        faults: &mut Vec<String>,
    ) -> Geometry {
        match self.scaled_mesh(name, scale) {
            Ok(mesh) => Geometry::Mesh(mesh),
            Err(Trouble::Foreign(reason)) => Geometry::Unread { reason },
            Err(Trouble::Broken(reason)) => {
                faults.push(reason.clone());
                Geometry::Unread { reason }
            }
        }
    }

    fn scaled_mesh(&mut self, name: &str, scale: DVec3) -> Result<Arc<Mesh>, Trouble> {
        let mesh = self.mesh(name)?;
        if scale == DVec3::ONE {
            return Ok(mesh);
        }
        let key = (name.to_owned(), scale.to_array().map(f64::to_bits));
        let made = self.scaled.entry(key).or_insert_with(|| {
            let trouble = |e| Trouble::Broken(format!("mesh `{name}` scaled by {scale}: {e}"));
            scaled(&mesh, scale).map(Arc::new).map_err(trouble)
        });
        made.clone()
    }

    fn mesh(&mut self, name: &str) -> Result<Arc<Mesh>, Trouble> {
        if let Some(known) = self.files.get(name) {
            return known.clone();
        }
        let read = self.read(name);
        self.files.insert(name.to_owned(), read.clone());
        read
    }

    fn read(&mut self, name: &str) -> Result<Arc<Mesh>, Trouble> {
        let extension = name.rsplit_once('.').map(|(_, e)| e.trim().to_ascii_lowercase());
        let format = extension.as_deref().unwrap_or("");
        let bytes = self.reach(name)?;
        if !matches!(format, "obj" | "stl" | "glb" | "dae" | "msh") {
            return Err(Trouble::Foreign(format!("mesh `{name}`: this format is not read here")));
        }
        match self.decoded.or_decode(format, &bytes) {
            Err(e) if format == "dae" => {
                Err(Trouble::Foreign(format!("mesh `{name}` is not read here: {e}")))
            }
            made => made.map_err(|e| Trouble::Broken(format!("mesh `{name}` is unreadable: {e}"))),
        }
    }

    /// The bytes of what an address names.
    fn reach(&mut self, name: &str) -> Result<Vec<u8>, Trouble> {
        if let Some(bytes) = self.added.get(name) {
            return Ok(bytes.to_vec());
        }
        let broken = |rule: &str| Trouble::Broken(format!("mesh path `{name}` {rule}"));
        match address(name) {
            Address::Foreign => Err(broken("is an address that nothing is fetched from")),
            Address::Package { name: package, path } => self.in_package(name, package, path),
            Address::Path(path) => {
                let rule = broken_path_rule(path, self.outside);
                if rule.is_some() && path.contains("..") && self.outside == Outside::Refused {
                    return self.in_own_package(name, path);
                }
                match rule {
                    Some(rule) => Err(broken(rule)),
                    None => self.bytes(path),
                }
            }
        }
    }

    fn in_package(&mut self, name: &str, package: &str, path: &str) -> Result<Vec<u8>, Trouble> {
        if !self.packages.contains_key(package) {
            let found = self.places.package(package, &self.home);
            let opened = found.and_then(|folder| Folder::open(&folder, caps()).ok());
            self.packages.insert(package.to_owned(), opened);
        }
        let Some(Some(folder)) = self.packages.get(package) else {
            let what = format!("package `{package}` is not at, above or beside the file");
            return Err(Trouble::Broken(format!("mesh path `{name}`: {what}")));
        };
        let read = folder.read(Path::new(path));
        read.map_err(|refused| Trouble::Broken(format!("mesh `{name}` {}", in_words(&refused))))
    }

    /// What lies above the file's folder, and within the package that both lie in.
    fn in_own_package(&mut self, name: &str, path: &str) -> Result<Vec<u8>, Trouble> {
        let home = std::fs::canonicalize(&self.home).unwrap_or_default();
        let own = self.own.get_or_insert_with(|| {
            let root = package_above(&self.home)?;
            let folder = Folder::open(&root, caps()).ok()?;
            Some((root, folder))
        });
        let leaves = || Trouble::Broken(format!("mesh path `{name}` leaves the package with `..`"));
        let (root, folder) = own.as_ref().ok_or_else(leaves)?;
        let inside = home.strip_prefix(root).ok().map(|from| from.join(path)).ok_or_else(leaves)?;
        let plain = inside.to_string_lossy().into_owned();
        if broken_path_rule(&plain, Outside::Refused).is_some() {
            return Err(leaves());
        }
        let read = folder.read(&inside);
        read.map_err(|refused| Trouble::Broken(format!("mesh `{name}` {}", in_words(&refused))))
    }

    fn bytes(&mut self, name: &str) -> Result<Vec<u8>, Trouble> {
        let broken = |what: &str| Trouble::Broken(format!("mesh `{name}` {what}"));
        let Some(folder) = &self.folder else { return Err(broken("does not exist")) };
        let read = match folder.read(Path::new(name)) {
            Err(Refused::Outside) if self.outside == Outside::Allowed => {
                let read = guard::files::read(&folder.path().join(name), self.elsewhere);
                if let Ok(bytes) = &read {
                    self.elsewhere = self.elsewhere.saturating_sub(bytes.len() as u64);
                    self.found_outside.push(name.to_owned());
                }
                read
            }
            read => read,
        };
        read.map_err(|refused| broken(&in_words(&refused)))
    }
}

/// A mesh scaled along its axes. A scale that mirrors turns the corners of each face round, so that
/// what faced outward still does.
pub(crate) fn scaled(mesh: &Mesh, scale: DVec3) -> Result<Mesh, object::mesh::MeshError> {
    let moved = mesh.map_vertices(|v| v * scale)?;
    if scale.x * scale.y * scale.z >= 0.0 {
        return Ok(moved);
    }
    let turned = moved.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
    Mesh::new(moved.vertices().to_vec(), turned)
}

/// The caps of a package: one for all that its URDF names. The check has a deadline of its own.
pub(crate) fn caps() -> Caps {
    Caps { file: MAX_MESH_BYTES, all: MAX_MESH_BYTES, ..Caps::default() }
}

/// The rule a file of a package breaks.
pub(crate) fn in_words(refused: &Refused) -> String {
    match refused {
        Refused::NotRegular => "is not a file".into(),
        Refused::Outside => "leads out of the package through a link".into(),
        Refused::TooLarge { .. } | Refused::TooMuch { .. } => {
            "exceeds the 1 GiB all files of a package together may have".into()
        }
        refused if refused.is_absence() => "does not exist".into(),
        refused => refused.to_string(),
    }
}

/// The rule a mesh path breaks, if any: relative, forward slashes, inside the URDF's folder.
/// Leaving the folder is no fault where it is allowed.
pub(crate) fn broken_path_rule(name: &str, outside: Outside) -> Option<&'static str> {
    if name.trim().is_empty() {
        return Some("is empty");
    }
    if name.contains("://") || name.starts_with("package:") || name.starts_with("file:") {
        return Some("is an address; it must be relative to the URDF");
    }
    if name.contains('\\') {
        return Some("has a backslash; it must use forward slashes");
    }
    if outside == Outside::Allowed {
        return None;
    }
    let drive = name.as_bytes().get(1) == Some(&b':');
    if drive || Path::new(name).is_absolute() {
        return Some("is absolute; it must be relative to the URDF");
    }
    let depth = Path::new(name).components().try_fold(0_usize, |depth, part| match part {
        Component::ParentDir => depth.checked_sub(1),
        Component::Normal(_) => Some(depth + 1),
        _ => Some(depth),
    });
    depth.is_none().then_some("leaves the package with `..`")
}

fn decode(format: &str, bytes: &[u8]) -> Result<Mesh, String> {
    match format {
        "obj" => {
            // Remarks and names of groups may be in any code page; numbers are ASCII.
            let text = String::from_utf8_lossy(bytes);
            object::obj::read(&text, UpAxis::Z).map_err(|e| e.to_string())
        }
        "stl" => object::stl::read(bytes).map_err(|e| e.to_string()),
        "dae" => crate::read::dae::read(bytes).map_err(|e| e.to_string()),
        "msh" => crate::read::msh::read(bytes),
        _ => {
            let mesh = object::glb::read(bytes).map_err(|e| e.to_string())?;
            // URDF readers take a GLB's coordinates as they stand, without the turn to z up.
            let frame = mesh.frame();
            mesh.map_vertices(|v| frame.point_to_file(v)).map_err(|e| e.to_string())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_relative_and_inside() {
        for good in ["a.obj", "meshes/a.obj", "./meshes/a.obj", "x/../meshes/a.obj"] {
            assert_eq!(broken_path_rule(good, Outside::Refused), None, "{good}");
        }
        for bad in [
            "",
            "/etc/passwd",
            "C:/a.obj",
            "meshes\\a.obj",
            "../a.obj",
            "m/../../a.obj",
            "package://p/a.obj",
            "file:///a.obj",
        ] {
            assert!(broken_path_rule(bad, Outside::Refused).is_some(), "{bad}");
        }
        for allowed in ["/meshes/a.obj", "../a.obj"] {
            assert_eq!(broken_path_rule(allowed, Outside::Allowed), None, "{allowed}");
        }
        assert!(broken_path_rule("package://p/a.obj", Outside::Allowed).is_some());
    }

    #[test]
    fn a_missing_mesh_is_reported_and_a_foreign_one_is_unknown() {
        let folder = std::env::temp_dir().join(format!("kinfold-shelf-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("a.dae"), "<COLLADA/>").unwrap();
        let (mut shelf, mut faults) = (Shelf::new(&folder, Outside::Refused), vec![]);
        let dae = shelf.geometry("a.dae", DVec3::ONE, &mut faults);
        assert!(matches!(dae, Geometry::Unread { .. }) && faults.is_empty());
        shelf.geometry("nope.obj", DVec3::ONE, &mut faults);
        assert_eq!(faults, ["mesh `nope.obj` does not exist"]);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn a_link_may_lead_about_the_package_and_not_out_of_it() {
        let place = std::env::temp_dir().join(format!("kinfold-links-{}", std::process::id()));
        let (folder, elsewhere) = (place.join("package"), place.join("elsewhere"));
        for made in [folder.join("meshes"), elsewhere.clone()] {
            std::fs::create_dir_all(&made).unwrap();
            std::fs::write(made.join("a.stl"), "solid a\nendsolid a\n").unwrap();
        }
        let link = |to: &Path, name: &str| std::os::unix::fs::symlink(to, folder.join(name));
        link(&folder.join("meshes/a.stl"), "own.stl").unwrap();
        link(&folder.join("meshes"), "also").unwrap();
        link(&elsewhere.join("a.stl"), "others.stl").unwrap();
        link(&elsewhere, "out").unwrap();
        let mut shelf = Shelf::new(&folder, Outside::Refused);
        let mut read = |name: &str| shelf.bytes(name).map(|bytes| bytes.len());
        for name in ["meshes/a.stl", "meshes/./a.stl", "meshes/../own.stl", "own.stl", "also/a.stl"]
        {
            assert_eq!(read(name), Ok(19), "{name}");
        }
        for name in ["others.stl", "out/a.stl", "meshes/../out/a.stl"] {
            let refused = format!("mesh `{name}` leads out of the package through a link");
            assert_eq!(read(name), Err(Trouble::Broken(refused)));
        }
        let mut shelf = Shelf::new(&folder, Outside::Allowed);
        assert!(shelf.bytes("out/a.stl").is_ok() && shelf.bytes("meshes/a.stl").is_ok());
        assert_eq!(shelf.found_outside(), ["out/a.stl"]);
        std::fs::remove_dir_all(&place).unwrap();
    }
}
