//! How an asset's links look: groups of faces of one material each, and the pictures these use.

use object::appearance::{Material, Picture};
use serde::{Deserialize, Serialize};

/// How every link of an asset looks; the default says nothing, and links have one colour each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AssetAppearance {
    /// For each link of the asset; empty where nothing is known.
    pub(crate) links: Vec<LinkAppearance>,
    /// The pictures of all links.
    pub(crate) textures: Vec<TextureFile>,
    /// What did not come along, in plain words.
    pub(crate) notes: Vec<String>,
}

impl AssetAppearance {
    /// What did not come along, in plain words.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Adds what was left out before, such as by the reader of a file.
    #[must_use]
    pub fn with_notes(mut self, notes: impl IntoIterator<Item = String>) -> Self {
        self.notes.splice(0..0, notes);
        self
    }

    /// The faces of a link by material; none where the link has one colour.
    pub(crate) fn groups(&self, link: usize) -> &[Group] {
        self.links.get(link).map_or(&[], |l| &l.groups)
    }

    /// The same, unless they only repeat what colours of vertices say.
    pub(crate) fn materials(&self, link: usize) -> &[Group] {
        let of = self.links.get(link).filter(|l| !l.of_vertices);
        of.map_or(&[], |l| &l.groups)
    }
}

/// How one link looks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct LinkAppearance {
    /// Every face of the link's surface is in one of them.
    pub(crate) groups: Vec<Group>,
    /// Whether all of it follows from the colours of the surface's vertices.
    pub(crate) of_vertices: bool,
}

/// Faces of one material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Group {
    /// Unique in the asset: letters, digits and underscores.
    pub(crate) name: String,
    /// The material; its textures are indices of [`AssetAppearance::textures`].
    pub(crate) material: Material,
    /// Mean colour of what is seen, sRGB and opacity, each 0 to 1.
    pub(crate) mean: [f64; 4],
    /// Faces of the link's surface, ascending.
    pub(crate) faces: Vec<u32>,
    /// For each face, where its corners lie on the textures, v downward; empty without textures.
    pub(crate) corners: Vec<[[f32; 2]; 3]>,
}

/// A picture of an asset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TextureFile {
    /// Its path below the package's folder, ending in `.png`.
    pub(crate) path: String,
    /// A PNG file.
    pub(crate) picture: Picture,
    /// The same as it came, where that was a JPEG, which is much smaller: for formats that read it.
    pub(crate) original: Option<Picture>,
}

impl TextureFile {
    /// The name it goes by: its path's, without folder and ending.
    pub(crate) fn name(&self) -> &str {
        let file = self.path.rsplit_once('/').map_or(self.path.as_str(), |(_, file)| file);
        file.rsplit_once('.').map_or(file, |(stem, _)| stem)
    }
}
