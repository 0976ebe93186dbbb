//! A triangle surface in the object frame, validated once and trusted afterwards.

use glamx::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Most vertices a mesh may hold (5 million); more is refused before memory is taken.
pub const MAX_VERTICES: usize = 5_000_000;
/// Most triangles a mesh may hold (10 million).
pub const MAX_FACES: usize = 10_000_000;

/// A triangle mesh: z up, right-handed, lengths in metres (as far as the file was honest about its
/// unit), counter-clockwise faces seen from outside.
///
/// Built only through [`Mesh::new`], so every instance holds: at least one face, every index in
/// range, every coordinate finite, colours either absent or one per vertex.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawMesh", into = "RawMesh")]
pub struct Mesh {
    vertices: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    colours: Option<Vec<[u8; 4]>>,
    frame: FileFrame,
}

#[derive(Serialize, Deserialize)]
struct RawMesh {
    vertices: Vec<[f64; 3]>,
    faces: Vec<[u32; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    colours: Option<Vec<[u8; 4]>>,
    frame: FileFrame,
}

impl TryFrom<RawMesh> for Mesh {
    type Error = MeshError;
    fn try_from(raw: RawMesh) -> Result<Self, MeshError> {
        let vertices = raw.vertices.into_iter().map(DVec3::from_array).collect();
        Self::new(vertices, raw.faces)?.with_frame(raw.frame).with_colours(raw.colours)
    }
}

impl From<Mesh> for RawMesh {
    fn from(mesh: Mesh) -> Self {
        let vertices = mesh.vertices.iter().map(|v| v.to_array()).collect();
        Self { vertices, faces: mesh.faces, colours: mesh.colours, frame: mesh.frame }
    }
}

/// Why a surface is not a mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// No triangle at all.
    #[error("a mesh needs at least one triangle, found none")]
    Empty,
    /// Above [`MAX_VERTICES`] or [`MAX_FACES`].
    #[error("a mesh may have at most {limit} {what}, found {found}")]
    TooLarge {
        /// `vertices` or `triangles`.
        what: &'static str,
        /// The limit.
        limit: usize,
        /// What the mesh has.
        found: usize,
    },
    /// A face names a vertex that is not there.
    #[error("face {face} uses vertex {vertex}, but the mesh has {vertices} vertices")]
    IndexOutOfRange {
        /// Index of the face.
        face: usize,
        /// The index it uses.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// NaN or infinity in a position.
    #[error("vertex {vertex} is not finite: ({x}, {y}, {z})")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// Its x.
        x: f64,
        /// Its y.
        y: f64,
        /// Its z.
        z: f64,
    },
    /// All vertices in one point, or so far apart that arithmetic overflows.
    #[error("the mesh's largest extent is {found} m, expected between 1e-9 and 1e6")]
    Extent {
        /// The largest side of its box.
        found: f64,
    },
    /// Per-vertex data of the wrong length.
    #[error("{what}: expected one per vertex ({expected}), found {found}")]
    Length {
        /// Which attribute.
        what: &'static str,
        /// Number of vertices.
        expected: usize,
        /// Number of values.
        found: usize,
    },
}

impl Mesh {
    /// Proves the invariants of [`Mesh`].
    ///
    /// # Errors
    /// [`MeshError`], the first broken rule in the order of its variants.
    pub fn new(vertices: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if faces.is_empty() {
            return Err(MeshError::Empty);
        }
        limit("vertices", MAX_VERTICES, vertices.len())?;
        limit("triangles", MAX_FACES, faces.len())?;
        let mesh = Self { vertices, faces, colours: None, frame: FileFrame::default() };
        mesh.check_indices()?;
        mesh.check_positions()?;
        Ok(mesh)
    }

    /// Triangles by their corners, of which none share a vertex.
    ///
    /// # Errors
    /// As [`Mesh::new`].
    pub fn of_triangles(triangles: &[[DVec3; 3]]) -> Result<Self, MeshError> {
        let faces = (0..triangles.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        Self::new(triangles.concat(), faces)
    }

    fn check_indices(&self) -> Result<(), MeshError> {
        let vertices = self.vertices.len();
        for (face, corners) in self.faces.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
                return Err(MeshError::IndexOutOfRange { face, vertex, vertices });
            }
        }
        Ok(())
    }

    fn check_positions(&self) -> Result<(), MeshError> {
        if let Some((vertex, v)) = self.vertices.iter().enumerate().find(|(_, v)| !v.is_finite()) {
            return Err(MeshError::NotFinite { vertex, x: v.x, y: v.y, z: v.z });
        }
        let found = self.bounds().size().max_element();
        if (1e-9..=1e6).contains(&found) { Ok(()) } else { Err(MeshError::Extent { found }) }
    }

    /// The same surface with one RGBA colour (sRGB, 0–255) per vertex, or none.
    ///
    /// # Errors
    /// [`MeshError::Length`] unless there is one colour per vertex.
    pub fn with_colours(mut self, colours: Option<Vec<[u8; 4]>>) -> Result<Self, MeshError> {
        if let Some(c) = &colours
            && c.len() != self.vertices.len()
        {
            let (expected, found) = (self.vertices.len(), c.len());
            return Err(MeshError::Length { what: "colours", expected, found });
        }
        self.colours = colours;
        Ok(self)
    }

    /// The same surface, remembering how its file was turned into the object frame.
    #[must_use]
    pub fn with_frame(mut self, frame: FileFrame) -> Self {
        self.frame = frame;
        self
    }

    /// Vertex positions, object frame, metres.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Vertex indices of each triangle, counter-clockwise seen from outside.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// RGBA colour of each vertex (sRGB, 0–255), where the file had any.
    pub fn colours(&self) -> Option<&[[u8; 4]]> {
        self.colours.as_deref()
    }

    /// How the file's frame relates to the object frame.
    pub fn frame(&self) -> FileFrame {
        self.frame
    }

    /// The three corners of a face.
    pub fn corners(&self, face: usize) -> [DVec3; 3] {
        self.faces[face].map(|v| self.vertices[v as usize])
    }

    /// Twice-area-weighted normal of a face: direction outward, length twice the area.
    pub fn area_vector(&self, face: usize) -> DVec3 {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a)
    }

    /// Unit normal of a face; zero for a degenerate one.
    pub fn normal(&self, face: usize) -> DVec3 {
        self.area_vector(face).normalize_or_zero()
    }

    /// Area of a face, m².
    pub fn area(&self, face: usize) -> f64 {
        self.area_vector(face).length() / 2.0
    }

    /// Centroid of a face.
    pub fn centroid(&self, face: usize) -> DVec3 {
        let [a, b, c] = self.corners(face);
        (a + b + c) / 3.0
    }

    /// Axis-aligned box of the vertices that faces use.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.faces.iter().flatten().map(|&v| self.vertices[v as usize]))
    }

    /// Signed volume enclosed, m³ (positive when faces point outward); exact for closed surfaces.
    pub fn signed_volume(&self) -> f64 {
        let origin = self.vertices[self.faces[0][0] as usize];
        let cone = |f: usize| {
            let [a, b, c] = self.corners(f).map(|p| p - origin);
            a.dot(b.cross(c)) / 6.0
        };
        (0..self.faces.len()).map(cone).sum()
    }

    /// The surface made of the given faces only; vertices no face uses are dropped, order is kept.
    ///
    /// # Errors
    /// [`MeshError::Empty`] if no face is given.
    pub fn submesh(&self, faces: impl IntoIterator<Item = usize>) -> Result<Self, MeshError> {
        let mut new_index = vec![u32::MAX; self.vertices.len()];
        let (mut vertices, mut colours, mut kept) = (Vec::new(), Vec::new(), Vec::new());
        for face in faces {
            kept.push(self.faces[face].map(|v| {
                let slot = &mut new_index[v as usize];
                if *slot == u32::MAX {
                    *slot = vertices.len() as u32;
                    vertices.push(self.vertices[v as usize]);
                    colours.extend(self.colours.as_ref().map(|c| c[v as usize]));
                }
                *slot
            }));
        }
        let colours = self.colours.is_some().then_some(colours);
        Self::new(vertices, kept)?.with_frame(self.frame).with_colours(colours)
    }

    /// Digest of the surface: BLAKE3 over its vertices, object frame, and its faces, as 64 hexadecimal
    /// digits. Colours do not count.
    pub fn digest(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for vertex in &self.vertices {
            vertex.to_array().iter().for_each(|c| {
                hasher.update(&c.to_le_bytes());
            });
        }
        for corner in self.faces.iter().flatten() {
            hasher.update(&corner.to_le_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }

    /// The same surface with every vertex moved; faces and colours stay.
    ///
    /// # Errors
    /// [`MeshError`] if a moved vertex is not finite or the result has no extent.
    pub fn map_vertices(&self, f: impl Fn(DVec3) -> DVec3) -> Result<Self, MeshError> {
        let vertices = self.vertices.iter().map(|&v| f(v)).collect();
        let mesh = Self { vertices, ..self.clone() };
        mesh.check_positions()?;
        Ok(mesh)
    }
}

pub(crate) fn limit(what: &'static str, limit: usize, found: usize) -> Result<(), MeshError> {
    if found > limit { Err(MeshError::TooLarge { what, limit, found }) } else { Ok(()) }
}

/// An axis-aligned box, object frame, metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Smallest corner.
    pub min: DVec3,
    /// Largest corner.
    pub max: DVec3,
}

impl Bounds {
    /// The smallest box around some points; inverted (min > max) when there are none.
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        let empty = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        points.into_iter().fold(empty, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// Side lengths.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// Centre.
    pub fn centre(&self) -> DVec3 {
        (self.min + self.max) / 2.0
    }

    /// Length of the space diagonal.
    pub fn diagonal(&self) -> f64 {
        self.size().length()
    }

    /// The box grown by `margin` metres on every side.
    #[must_use]
    pub fn grown(&self, margin: f64) -> Self {
        Self { min: self.min - DVec3::splat(margin), max: self.max + DVec3::splat(margin) }
    }

    /// Whether a point lies inside or on the box.
    pub fn holds(&self, p: DVec3) -> bool {
        self.min.cmple(p).all() && self.max.cmpge(p).all()
    }

    /// Whether two boxes share a point.
    pub fn intersects(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }
}

/// Which direction is up in a file.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// +Y up, as glTF demands.
    #[default]
    Y,
    /// +Z up, as URDF and most CAD files have it.
    Z,
}

/// How a file's frame relates to the object frame: a right-handed turn that makes z up.
///
/// glTF (x right, y up, z towards the viewer) becomes (x right, y away from the viewer, z up), so
/// the side that faces −y in the object frame is the front.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileFrame {
    /// The file's up axis.
    pub up: UpAxis,
}

impl FileFrame {
    /// Rotation that takes file coordinates to object coordinates.
    pub fn to_object(self) -> DQuat {
        match self.up {
            UpAxis::Z => DQuat::IDENTITY,
            UpAxis::Y => DQuat::from_mat3(&DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y)),
        }
    }

    /// File coordinates to object coordinates, exactly (no rounding from a quaternion).
    pub fn point_to_object(self, p: DVec3) -> DVec3 {
        match self.up {
            UpAxis::Z => p,
            UpAxis::Y => DVec3::new(p.x, -p.z, p.y),
        }
    }

    /// Object coordinates back to file coordinates, exactly.
    pub fn point_to_file(self, p: DVec3) -> DVec3 {
        match self.up {
            UpAxis::Z => p,
            UpAxis::Y => DVec3::new(p.x, p.z, -p.y),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Mesh {
        let v = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        Mesh::new(v.to_vec(), vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap()
    }

    #[test]
    fn a_unit_corner_encloses_a_sixth() {
        assert!((tetrahedron().signed_volume() - 1.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn broken_surfaces_are_refused_with_the_rule_and_the_finding() {
        assert_eq!(Mesh::new(vec![DVec3::ZERO], vec![]), Err(MeshError::Empty));
        let v = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let e = Mesh::new(v.clone(), vec![[0, 1, 7]]).unwrap_err();
        assert_eq!(e.to_string(), "face 0 uses vertex 7, but the mesh has 3 vertices");
        let mut nan = v;
        nan[1].y = f64::NAN;
        assert!(matches!(
            Mesh::new(nan, vec![[0, 1, 2]]),
            Err(MeshError::NotFinite { vertex: 1, .. })
        ));
        let point = vec![DVec3::ONE; 3];
        assert_eq!(Mesh::new(point, vec![[0, 1, 2]]), Err(MeshError::Extent { found: 0.0 }));
    }

    #[test]
    fn a_submesh_keeps_only_what_its_faces_use() {
        let colours = (0..4).map(|i| [i, 0, 0, 255]).collect();
        let mesh = tetrahedron().with_colours(Some(colours)).unwrap();
        let part = mesh.submesh([3]).unwrap();
        assert_eq!(part.vertices(), [DVec3::X, DVec3::Y, DVec3::Z]);
        assert_eq!(part.colours().unwrap(), [[1, 0, 0, 255], [2, 0, 0, 255], [3, 0, 0, 255]]);
    }

    #[test]
    fn triangles_by_their_corners_share_no_vertex() {
        let whole = tetrahedron();
        let triangles: Vec<_> = (0..4).map(|f| whole.corners(f)).collect();
        let apart = Mesh::of_triangles(&triangles).unwrap();
        assert_eq!((apart.vertices().len(), apart.faces().len()), (12, 4));
        assert!((0..4).all(|f| apart.corners(f) == whole.corners(f)));
        assert_eq!(Mesh::of_triangles(&[]), Err(MeshError::Empty));
    }

    #[test]
    fn the_turn_from_gltf_is_undone_exactly() {
        let frame = FileFrame { up: UpAxis::Y };
        let p = DVec3::new(0.1, 0.2, 0.3);
        assert_eq!(frame.point_to_object(DVec3::Y), DVec3::Z);
        assert_eq!(frame.point_to_file(frame.point_to_object(p)), p);
        assert!((frame.to_object() * p - frame.point_to_object(p)).length() < 1e-15);
    }

    #[test]
    fn a_mesh_survives_json_bit_for_bit() {
        let mesh = tetrahedron().map_vertices(|v| v * 0.1 + DVec3::splat(1.0 / 3.0)).unwrap();
        let text = serde_json::to_string(&mesh).unwrap();
        assert_eq!(serde_json::from_str::<Mesh>(&text).unwrap(), mesh);
    }
}
