//! The JSON of a glTF file, as far as a surface needs it, and the checks that need no buffer.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use serde::Deserialize;
use serde::de::{Deserializer, Error as _, SeqAccess, Visitor};

use super::error::GlbError;
use super::materials::{Material, Sampler, Texture};

/// Most nodes a file may have.
pub const MAX_NODES: usize = 10_000;
/// Most meshes a file may have.
pub const MAX_MESHES: usize = 4096;
/// Deepest chain of nodes from a root.
pub const MAX_NODE_DEPTH: usize = 64;
/// Most entries of every other list.
const MAX_LIST: usize = 65_536;

/// Where a GLB that was made of other files says, in `asset.extras`, what did not come along.
pub(crate) const LEFT_OUT: &str = "kinfold_left_out";

/// Extensions a file may require: either we follow them or they do not touch the surface.
const KNOWN: [&str; 11] = [
    "KHR_mesh_quantization",
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
    "EXT_texture_webp",
    "EXT_texture_avif",
    "KHR_texture_basisu",
    "KHR_node_visibility",
    "KHR_lights_punctual",
    "KHR_xmp_json_ld",
];
/// Extensions that multiply geometry in a way we do not follow: reading on would lose surface.
const GEOMETRY_WE_WOULD_LOSE: [&str; 1] = ["EXT_mesh_gpu_instancing"];

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    pub asset: Asset,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub extensions_used: Vec<String>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub extensions_required: Vec<String>,
    pub scene: Option<usize>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub scenes: Vec<Scene>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_NODES>")]
    pub nodes: Vec<Node>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_MESHES>")]
    pub meshes: Vec<MeshEntry>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub accessors: Vec<Accessor>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub buffer_views: Vec<BufferView>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub buffers: Vec<Buffer>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub materials: Vec<Material>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub textures: Vec<Texture>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub samplers: Vec<Sampler>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub images: Vec<ImageEntry>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub animations: Vec<Ignored>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub skins: Vec<Skin>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub cameras: Vec<Ignored>,
}

/// An entry we count and otherwise leave alone.
#[derive(Debug, Deserialize)]
pub(super) struct Ignored {}

#[derive(Debug, Deserialize)]
pub(super) struct Asset {
    pub version: String,
    #[serde(default)]
    pub extras: serde_json::Value,
}

impl Asset {
    /// What was left out when the file was made of others, as this house writes it down.
    pub(super) fn left_out(&self) -> impl Iterator<Item = String> + '_ {
        let said = self.extras.get(LEFT_OUT).and_then(|list| list.as_array());
        let words = said.into_iter().flatten().filter_map(|note| note.as_str());
        words.map(|note| note.chars().take(300).collect())
    }
}

#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_NODES>")]
    pub nodes: Vec<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Node {
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_NODES>")]
    pub children: Vec<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    #[serde(default)]
    pub extensions: NodeExtensions,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_NODES>")]
    pub joints: Vec<usize>,
    pub inverse_bind_matrices: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct NodeExtensions {
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Option<Visibility>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Visibility {
    #[serde(default = "yes")]
    pub visible: bool,
}

fn yes() -> bool {
    true
}

#[derive(Debug, Deserialize)]
pub(super) struct MeshEntry {
    #[serde(deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub attributes: BTreeMap<String, usize>,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    #[serde(default = "triangles")]
    pub mode: u32,
    #[serde(default, deserialize_with = "at_most::<_, _, MAX_LIST>")]
    pub targets: Vec<Ignored>,
    #[serde(default)]
    pub extensions: PrimitiveExtensions,
}

fn triangles() -> u32 {
    4
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<Draco>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Draco {
    pub buffer_view: usize,
    pub attributes: BTreeMap<String, u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub shape: String,
    pub sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Sparse {
    pub count: usize,
    pub indices: SparsePart,
    pub values: SparsePart,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparsePart {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
    #[serde(default)]
    pub extensions: BufferViewExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct BufferViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub meshopt: Option<Meshopt>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Meshopt {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: usize,
    pub count: usize,
    pub mode: String,
    pub filter: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub uri: Option<String>,
    pub byte_length: usize,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ImageEntry {
    pub uri: Option<String>,
    pub buffer_view: Option<usize>,
}

/// A list that stops parsing as soon as it is too long, before memory is taken.
fn at_most<'de, D, T, const N: usize>(deserializer: D) -> Result<Vec<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    struct Bounded<T, const N: usize>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for Bounded<T, N> {
        type Value = Vec<T>;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "a list of at most {N} entries")
        }
        fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Vec<T>, A::Error> {
            let mut list = Vec::new();
            while let Some(entry) = entries.next_element()? {
                if list.len() == N {
                    return Err(A::Error::custom(format!("expected {self}, found more")));
                }
                list.push(entry);
            }
            Ok(list)
        }
    }
    impl<T, const N: usize> fmt::Display for Bounded<T, N> {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "a list of at most {N} entries")
        }
    }
    deserializer.deserialize_seq(Bounded::<T, N>(PhantomData))
}

impl Document {
    /// Parses the JSON chunk and checks version, extensions, URIs and the node forest.
    pub(super) fn parse(json: &[u8]) -> Result<Self, GlbError> {
        let document: Self =
            serde_json::from_slice(json).map_err(|e| GlbError::Json(e.to_string()))?;
        document.check_version()?;
        document.check_extensions()?;
        document.check_uris()?;
        document.check_nodes()?;
        Ok(document)
    }

    fn check_version(&self) -> Result<(), GlbError> {
        if self.asset.version.split('.').next() == Some("2") {
            return Ok(());
        }
        let found = format!("`{}`", self.asset.version);
        Err(GlbError::rule("asset", "the glTF version must be 2.x", found))
    }

    fn check_extensions(&self) -> Result<(), GlbError> {
        let known = |e: &&String| KNOWN.contains(&e.as_str()) || e.starts_with("KHR_materials_");
        if let Some(name) = self.extensions_required.iter().find(|e| !known(e)) {
            return Err(GlbError::Extension(name.clone()));
        }
        let loses = |e: &&String| GEOMETRY_WE_WOULD_LOSE.contains(&e.as_str());
        match self.extensions_used.iter().find(loses) {
            Some(name) => Err(GlbError::Extension(name.clone())),
            None => Ok(()),
        }
    }

    fn check_uris(&self) -> Result<(), GlbError> {
        let buffers = self.buffers.iter().filter_map(|b| b.uri.as_ref());
        let images = self.images.iter().filter_map(|i| i.uri.as_ref());
        match buffers.chain(images).find(|uri| !uri.starts_with("data:")) {
            Some(uri) => Err(GlbError::External(uri.chars().take(200).collect())),
            None => Ok(()),
        }
    }

    /// Every node has at most one parent, and every chain to a root is at most 64 long.
    fn check_nodes(&self) -> Result<(), GlbError> {
        let mut parent = vec![None; self.nodes.len()];
        for (n, node) in self.nodes.iter().enumerate() {
            for &child in &node.children {
                let place = || format!("node {n}");
                let slot = parent
                    .get_mut(child)
                    .ok_or_else(|| GlbError::reference(place(), "node", child, self.nodes.len()))?;
                if let Some(other) = slot.replace(n) {
                    let found = format!("node {child} below node {other} and node {n}");
                    return Err(GlbError::rule(place(), "a node has one parent at most", found));
                }
            }
        }
        (0..self.nodes.len()).try_for_each(|n| check_depth(&parent, n))
    }

    /// The parent of each node; none of a root.
    pub(super) fn parents(&self) -> Vec<Option<usize>> {
        let mut parents = vec![None; self.nodes.len()];
        for (n, node) in self.nodes.iter().enumerate() {
            for &child in &node.children {
                if let Some(parent) = parents.get_mut(child) {
                    *parent = Some(n);
                }
            }
        }
        parents
    }

    /// The roots to read: the default scene's nodes; without any scene, all nodes without parent.
    pub(super) fn roots(&self) -> Result<Vec<usize>, GlbError> {
        let children: std::collections::BTreeSet<usize> =
            self.nodes.iter().flat_map(|n| n.children.iter().copied()).collect();
        let is_root = |n: &usize| !children.contains(n);
        if self.scenes.is_empty() && self.scene.is_none() {
            return Ok((0..self.nodes.len()).filter(is_root).collect());
        }
        let index = self.scene.unwrap_or(0);
        let (place, count) = ("scene", self.scenes.len());
        let scene = self.scenes.get(index);
        let roots = &scene.ok_or_else(|| GlbError::reference(place, "scene", index, count))?.nodes;
        let mut seen = std::collections::BTreeSet::new();
        for &n in roots {
            if n >= self.nodes.len() {
                return Err(GlbError::reference(place, "node", n, self.nodes.len()));
            }
            if !is_root(&n) || !seen.insert(n) {
                let found = format!("node {n}");
                return Err(GlbError::rule(place, "a scene lists root nodes, each once", found));
            }
        }
        Ok(roots.clone())
    }
}

fn check_depth(parent: &[Option<usize>], node: usize) -> Result<(), GlbError> {
    let chain = std::iter::successors(Some(node), |&n| parent.get(n).copied().flatten());
    let length = chain.take(parent.len() + 1).count();
    let cyclic = length > parent.len();
    if length <= MAX_NODE_DEPTH && !cyclic {
        return Ok(());
    }
    let found = if cyclic { "a cycle".into() } else { format!("{length}") };
    Err(GlbError::rule(format!("node {node}"), "nodes form trees at most 64 deep", found))
}
