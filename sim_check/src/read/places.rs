//! Where addresses in a file lead: `package://`, `model://`, `file://` and `$(find …)`.
//!
//! A package is looked for where the caller says, then beside the file: a folder at or above it
//! whose `package.xml` has that name or that is called so, or one of that name beside those. The
//! environment is never asked here.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use roxmltree::Document;

/// Most folders above a file that are looked at for a package.
const MOST_ABOVE: usize = 16;
/// Most bytes of a `package.xml`.
const MOST_BYTES: u64 = 1 << 20;
/// Folders this near the top of the file system are nobody's package.
const SHALLOW: usize = 2;

/// Where the addresses of a file lead, as far as the caller says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Places {
    /// Folders of packages by name.
    pub packages: BTreeMap<String, PathBuf>,
    /// Folders in which packages lie, each under its name or in `share`.
    pub shelves: Vec<PathBuf>,
    /// Values of `$(env NAME)` and `$(optenv NAME …)`; other names have none.
    pub env: BTreeMap<String, String>,
    /// Values of xacro's arguments, as a launch file would give them.
    pub args: BTreeMap<String, String>,
    /// The SRDF that goes with a URDF; else the one of its name beside it.
    pub srdf: Option<PathBuf>,
}

/// What an address names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Address<'n> {
    /// A path, relative to the file's folder or absolute.
    Path(&'n str),
    /// A path in a package.
    Package {
        /// Name of the package.
        name: &'n str,
        /// The path in it.
        path: &'n str,
    },
    /// An address of another kind, such as `http://`.
    Foreign,
}

/// Takes an address apart.
pub(crate) fn address(text: &str) -> Address<'_> {
    let text = text.trim();
    let inner = text.strip_prefix("file://").filter(|rest| rest.contains("://")).unwrap_or(text);
    for scheme in ["package://", "model://"] {
        if let Some(rest) = inner.strip_prefix(scheme) {
            let rest = rest.trim_start_matches('/');
            let (name, path) = rest.split_once('/').unwrap_or((rest, ""));
            return Address::Package { name, path };
        }
    }
    if let Some((name, path)) = inner.strip_prefix("$(find ").and_then(|rest| rest.split_once(')'))
    {
        return Address::Package { name: name.trim(), path: path.trim_start_matches('/') };
    }
    match inner.strip_prefix("file://") {
        Some(path) => Address::Path(path),
        None if inner.contains("://") => Address::Foreign,
        None => Address::Path(inner),
    }
}

impl Places {
    /// The folder of a package that a file in `home` names.
    pub(crate) fn package(&self, name: &str, home: &Path) -> Option<PathBuf> {
        let plain = Path::new(name).components().all(|c| matches!(c, Component::Normal(_)));
        if name.is_empty() || !plain {
            return None;
        }
        let told = self.packages.get(name).cloned();
        told.or_else(|| beside(name, home)).or_else(|| self.on_a_shelf(name))
    }

    fn on_a_shelf(&self, name: &str) -> Option<PathBuf> {
        let places = self.shelves.iter().flat_map(|s| [s.join(name), s.join("share").join(name)]);
        places.into_iter().find(|place| place.is_dir())
    }
}

/// The folder of a package at, above or beside a folder.
fn beside(name: &str, home: &Path) -> Option<PathBuf> {
    let home = std::fs::canonicalize(home).ok()?;
    let above = || {
        let deep = |p: &&Path| p.components().count() > SHALLOW;
        home.ancestors().take(MOST_ABOVE).filter(deep)
    };
    let called = |p: &Path| p.file_name().is_some_and(|n| n == name);
    let is_it = |p: &Path| package_name(p).as_deref() == Some(name);
    let own = above().find(|p| is_it(p)).or_else(|| above().find(|p| called(p)));
    let neighbour = || {
        let beside = above().map(|p| p.join(name)).filter(|p| p.is_dir());
        let all: Vec<PathBuf> = beside.collect();
        let listed = all.iter().find(|p| is_it(p)).cloned();
        listed.or_else(|| all.into_iter().next())
    };
    own.map(Path::to_path_buf).or_else(neighbour)
}

/// The folder at or above `home` that is a package by its `package.xml`.
pub(crate) fn package_above(home: &Path) -> Option<PathBuf> {
    let home = std::fs::canonicalize(home).ok()?;
    let found = home.ancestors().take(MOST_ABOVE).find(|p| package_name(p).is_some());
    found.map(Path::to_path_buf)
}

/// The name in a folder's `package.xml`.
fn package_name(folder: &Path) -> Option<String> {
    let file = folder.join("package.xml");
    let bytes = file.is_file().then(|| guard::files::read(&file, MOST_BYTES).ok())??;
    let text = String::from_utf8(bytes).ok()?;
    let text = text.trim_start_matches('\u{feff}').trim_start();
    if crate::read::caps::broken(text).is_some() {
        return None;
    }
    let document = Document::parse(text).ok()?;
    let name = document.root_element().children().find(|n| n.has_tag_name("name"))?;
    name.text().map(|t| t.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_paths_or_name_a_package() {
        let package = |name, path| Address::Package { name, path };
        assert_eq!(address("package://p/m/a.obj"), package("p", "m/a.obj"));
        assert_eq!(address("model://mug/a.obj"), package("mug", "a.obj"));
        assert_eq!(address("file://package://p/a.obj"), package("p", "a.obj"));
        assert_eq!(address("$(find p)/a.obj"), package("p", "a.obj"));
        assert_eq!(address("file:///a/b.obj"), Address::Path("/a/b.obj"));
        assert_eq!(address("m/a.obj"), Address::Path("m/a.obj"));
        assert_eq!(address("https://x.org/a.obj"), Address::Foreign);
    }

    #[test]
    fn a_package_is_found_by_its_name_above_and_beside_the_file() {
        let place = std::env::temp_dir().join(format!("kinfold-places-{}", std::process::id()));
        let (home, other) = (place.join("src/one/urdf"), place.join("src/two"));
        for made in [&home, &other] {
            std::fs::create_dir_all(made).unwrap();
        }
        let named = |folder: PathBuf, name: &str| {
            let text = format!("<package><name>{name}</name></package>");
            std::fs::write(folder.join("package.xml"), text).unwrap();
        };
        named(place.join("src/one"), "first");
        named(other.clone(), "two");
        let places = Places::default();
        let real = |p: PathBuf| Some(std::fs::canonicalize(p).unwrap());
        assert_eq!(places.package("first", &home), real(place.join("src/one")));
        assert_eq!(places.package("two", &home), real(other.clone()));
        assert_eq!(places.package("one", &home), real(place.join("src/one")), "by its folder");
        assert_eq!(places.package("three", &home), None);
        for odd in ["..", "", "a/../..", "/etc"] {
            assert_eq!(places.package(odd, &home), None, "{odd}");
        }
        let told = Places { packages: BTreeMap::from([("three".into(), other.clone())]), ..places };
        assert_eq!(told.package("three", &home), Some(other));
        assert_eq!(package_above(&home), real(place.join("src/one")));
        std::fs::remove_dir_all(&place).unwrap();
    }
}
