//! One primitive of a glTF mesh, plain or Draco-packed, as positions, colours and triangles.

use draco_gltf::{
    ComponentType, DecodeLimits, DracoPrimitiveContract, DracoPrimitiveExtension, JsonValue,
    PackedAttribute, PackedGeometry, PrimitiveMode,
};
use glamx::DVec3;

use super::accessor::{Accessors, Component};
use super::decoding::{most_unpacked, timed};
use super::document::{Draco, Primitive};
use super::error::GlbError;
use crate::mesh::{MAX_FACES, MAX_VERTICES};

/// Most primitives that nodes lay in place. Exports of whole buildings have some ten thousand; a
/// guess with room.
const MAX_PLACES: usize = 1_000_000;
/// How many times the bytes of a file compressed primitives may be decoded: a stream is used once,
/// or by a few primitives that differ in material; a guess with room.
const PACKED_TWICE: usize = 16;

/// A primitive's data in the file's own frame, before any node moves it.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub positions: Vec<DVec3>,
    pub colours: Option<Vec<[u8; 4]>>,
    pub faces: Vec<[u32; 3]>,
    /// Material, and texture coordinates of each vertex; empty without a texture.
    pub look: (Option<u32>, Vec<[f32; 2]>),
}

/// How much more the file may bring: of its surface, and of work that leaves no trace in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    pub vertices: usize,
    pub faces: usize,
    /// Of vertices and triangles, as they are held.
    bytes: usize,
    /// Primitives laid in place, empty ones included.
    places: usize,
    /// Bytes of compressed primitives handed to the decoder, each time they are.
    packed: usize,
}

impl Budget {
    /// For a file of so many bytes.
    pub(super) fn of(file: usize) -> Self {
        Self {
            vertices: MAX_VERTICES,
            faces: MAX_FACES,
            bytes: most_unpacked(file),
            places: MAX_PLACES,
            packed: file.saturating_mul(PACKED_TWICE),
        }
    }

    /// Takes the given counts off, or says that the file has too many.
    pub(super) fn spend(&mut self, vertices: usize, faces: usize) -> Result<(), GlbError> {
        self.vertices = left(self.vertices, vertices, "a mesh may have 5,000,000 vertices")?;
        self.faces = left(self.faces, faces, "a mesh may have 10,000,000 triangles")?;
        let bytes = vertices * size_of::<DVec3>() + faces * size_of::<[u32; 3]>();
        self.bytes =
            left(self.bytes, bytes, "a mesh may unpack to 16 MiB and 2000 times its file")?;
        Ok(())
    }

    /// What was read once may be placed often: only the work of reading is spent.
    pub(super) fn keep_work_of(&mut self, read: Self) {
        self.packed = read.packed;
    }

    /// Takes one primitive off that is laid in place.
    pub(super) fn place(&mut self) -> Result<(), GlbError> {
        self.places = left(self.places, 1, "nodes may place 1,000,000 primitives")?;
        Ok(())
    }

    /// Takes a compressed primitive off that is to be decoded.
    fn unpack(&mut self, bytes: usize) -> Result<(), GlbError> {
        let rule = "compressed primitives may add up to 16 times the file";
        self.packed = left(self.packed, bytes, rule)?;
        Ok(())
    }
}

fn left(have: usize, want: usize, rule: &'static str) -> Result<usize, GlbError> {
    have.checked_sub(want).ok_or_else(|| {
        let found = format!("{want} where {have} are left");
        GlbError::rule("the file", rule, found)
    })
}

/// Where a primitive's attributes come from: its Draco stream first, its accessors else.
#[derive(Debug)]
pub(super) struct Source<'a> {
    pub accessors: Accessors<'a>,
    pub primitive: &'a Primitive,
    pub place: String,
    unpacked: Option<PackedGeometry>,
}

impl<'a> Source<'a> {
    /// Opens a primitive; a Draco stream is unpacked here, under the ceilings of `budget`.
    pub(super) fn open(
        accessors: Accessors<'a>,
        primitive: &'a Primitive,
        place: String,
        budget: &mut Budget,
    ) -> Result<Self, GlbError> {
        let Some(&position) = primitive.attributes.get("POSITION") else {
            return Err(GlbError::rule(place, "a surface needs POSITION", "none"));
        };
        let vertices = accessors.get(position, &place)?.count;
        let corners = match primitive.indices {
            Some(indices) => accessors.get(indices, &place)?.count,
            None => vertices,
        };
        let left = *budget;
        budget.clone().spend(vertices, face_count(primitive.mode, corners))?;
        let mut source = Self { accessors, primitive, place, unpacked: None };
        if let Some(draco) = &primitive.extensions.draco {
            let payload = accessors.buffers.view(draco.buffer_view, &source.place)?;
            budget.unpack(payload.len())?;
            source.unpacked = Some(source.unpack(draco, payload, left)?);
        }
        Ok(source)
    }

    /// Rows of an attribute; none if the primitive has no such attribute.
    pub(super) fn rows<const N: usize>(
        &self,
        name: &str,
    ) -> Result<Option<Vec<[f64; N]>>, GlbError> {
        if let Some(attribute) = self.unpacked_attribute(name) {
            let component =
                component_of(attribute).filter(|_| attribute.components() as usize == N);
            let Some(component) = component else {
                let (kind, width) = (attribute.component_type(), attribute.components());
                let found = format!("{name} of {width} {kind:?}");
                return Err(GlbError::rule(&self.place, "an attribute must fit its use", found));
            };
            return Ok(Some(component.rows(attribute.bytes(), attribute.normalized())));
        }
        let Some(&index) = self.primitive.attributes.get(name) else { return Ok(None) };
        let count = self.accessors.get(index, &self.place)?.count;
        let position = self.primitive.attributes.get("POSITION").copied().unwrap_or(index);
        let vertices = self.accessors.get(position, &self.place)?.count;
        if self.unpacked.is_none() && count != vertices {
            return Err(self.uneven(name, count, vertices));
        }
        self.accessors.rows(index, &self.place).map(Some)
    }

    fn uneven(&self, name: &str, found: usize, vertices: usize) -> GlbError {
        let found = format!("{found} of {name} for {vertices} vertices");
        GlbError::rule(&self.place, "attributes have one entry per vertex", found)
    }

    /// How many numbers an attribute has per vertex; none if the primitive has no such attribute.
    pub(super) fn width(&self, name: &str) -> Result<Option<usize>, GlbError> {
        if let Some(attribute) = self.unpacked_attribute(name) {
            return Ok(Some(attribute.components().into()));
        }
        let Some(&index) = self.primitive.attributes.get(name) else { return Ok(None) };
        let wide = self.accessors.get(index, &self.place)?.shape == "VEC4";
        Ok(Some(if wide { 4 } else { 3 }))
    }

    /// One row per vertex, or an error: attributes of a primitive are equally long.
    pub(super) fn checked<T>(
        &self,
        name: &str,
        rows: Vec<T>,
        vertices: usize,
    ) -> Result<Vec<T>, GlbError> {
        if rows.len() == vertices {
            return Ok(rows);
        }
        Err(self.uneven(name, rows.len(), vertices))
    }

    /// Colours the vertices have of themselves, linear light, and opacity; none without any.
    pub(super) fn colours(&self, vertices: usize) -> Result<Option<Vec<[f64; 4]>>, GlbError> {
        let rows = match self.width("COLOR_0")? {
            None => return Ok(None),
            Some(4) => self.rows::<4>("COLOR_0")?,
            Some(_) => {
                let rows = self.rows::<3>("COLOR_0")?;
                rows.map(|r| r.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
            }
        };
        rows.map(|rows| self.checked("COLOR_0", rows, vertices)).transpose()
    }

    /// Whether vertices have colours of themselves that are not all white.
    pub(super) fn is_tinted(&self, vertices: usize) -> Result<bool, GlbError> {
        let colours = self.colours(vertices)?;
        Ok(colours.is_some_and(|c| c.iter().any(|c| c != &[1.0; 4])))
    }

    /// Positions, all finite.
    pub(super) fn positions(&self) -> Result<Vec<DVec3>, GlbError> {
        let rows = self.rows::<3>("POSITION")?.unwrap_or_default();
        let positions: Vec<_> = rows.into_iter().map(DVec3::from_array).collect();
        match positions.iter().position(|p| !p.is_finite()) {
            Some(v) => {
                let found = format!("vertex {v} at {}", positions[v]);
                Err(GlbError::rule(&self.place, "positions must be finite", found))
            }
            None => Ok(positions),
        }
    }

    /// Triangles in file order, degenerate ones kept.
    pub(super) fn faces(&self, vertices: usize) -> Result<Vec<[u32; 3]>, GlbError> {
        let (corners, mode) = match (&self.unpacked, self.primitive.indices) {
            (Some(geometry), _) => (unpacked_indices(geometry), 4),
            (None, Some(i)) => (self.accessors.indices(i, &self.place)?, self.primitive.mode),
            (None, None) => ((0..vertices as u32).collect(), self.primitive.mode),
        };
        if let Some(at) = corners.iter().position(|&v| v as usize >= vertices) {
            let found = format!("index {} at {at} for {vertices} vertices", corners[at]);
            return Err(GlbError::rule(&self.place, "an index must name a vertex", found));
        }
        if mode == 4 && corners.len() % 3 != 0 {
            let found = format!("{} corners", corners.len());
            return Err(GlbError::rule(&self.place, "triangles take three corners each", found));
        }
        Ok(assemble(mode, &corners))
    }

    fn unpacked_attribute(&self, name: &str) -> Option<&PackedAttribute> {
        let attributes = self.unpacked.as_ref()?.attributes();
        attributes.iter().find(|a| a.semantic() == name)
    }

    fn unpack(
        &self,
        draco: &Draco,
        payload: &[u8],
        left: Budget,
    ) -> Result<PackedGeometry, GlbError> {
        let extension = extension_json(draco);
        let bytes = self.accessors.buffers.most_unpacked() as u64;
        let limits = DecodeLimits::default()
            .with_max_points(left.vertices as u64)
            .with_max_faces(left.faces as u64)
            .with_max_decoded_bytes(bytes);
        let contract = self.contract()?.with_limits(limits);
        let payload = payload.to_vec();
        let geometry = timed(&self.place, "Draco", payload.len(), move || {
            DracoPrimitiveExtension::from_json(&extension)?.decode(&payload, &contract)
        })?;
        let faces = geometry.indices().map_or(0, |i| i.count()) / 3;
        left.clone().spend(geometry.vertex_count(), faces)?;
        Ok(geometry)
    }

    fn contract(&self) -> Result<DracoPrimitiveContract, GlbError> {
        let mode = PrimitiveMode::from_gltf(self.primitive.mode).unwrap_or_default();
        let mut contract = DracoPrimitiveContract::new().with_mode(mode);
        for (name, &index) in &self.primitive.attributes {
            let accessor = self.accessors.get(index, &self.place)?;
            contract = contract.with_attribute(name, accessor.count as u64, accessor.normalized);
        }
        if let Some(index) = self.primitive.indices {
            let count = self.accessors.get(index, &self.place)?.count;
            contract = contract.with_indices(count as u64);
        }
        Ok(contract)
    }
}

fn extension_json(draco: &Draco) -> JsonValue {
    let ids = draco.attributes.iter();
    let ids = ids.map(|(name, &id)| (name.clone(), JsonValue::from(u64::from(id)))).collect();
    JsonValue::object([
        ("bufferView", JsonValue::from(draco.buffer_view)),
        ("attributes", JsonValue::Object(ids)),
    ])
}

fn component_of(attribute: &PackedAttribute) -> Option<Component> {
    Component::from_code(attribute.component_type() as u32)
}

fn unpacked_indices(geometry: &PackedGeometry) -> Vec<u32> {
    let Some(indices) = geometry.indices() else { return Vec::new() };
    let component = match indices.component_type() {
        ComponentType::U8 => Component::U8,
        ComponentType::U16 => Component::U16,
        _ => Component::U32,
    };
    let words = indices.bytes().chunks_exact(component.size());
    words.map(|word| component.number(word, false) as u32).collect()
}

fn face_count(mode: u32, corners: usize) -> usize {
    if mode == 4 { corners / 3 } else { corners.saturating_sub(2) }
}

/// Triangles of a list (4), a strip (5) or a fan (6), by the specification's formulas.
fn assemble(mode: u32, corners: &[u32]) -> Vec<[u32; 3]> {
    let of_strip = |(i, w): (usize, &[u32])| {
        if i % 2 == 1 { [w[0], w[2], w[1]] } else { [w[0], w[1], w[2]] }
    };
    match (mode, corners) {
        (4, _) => corners.chunks_exact(3).map(|w| [w[0], w[1], w[2]]).collect(),
        (6, [hub, rim @ ..]) => rim.windows(2).map(|w| [w[0], w[1], *hub]).collect(),
        _ => corners.windows(3).enumerate().map(of_strip).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_wind_like_the_specification_says() {
        assert_eq!(assemble(5, &[0, 1, 2, 3, 4]), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        let fan = assemble(6, &[0, 1, 2, 3]);
        assert_eq!(fan, [[1, 2, 0], [2, 3, 0]]);
        assert!(assemble(5, &[0, 1]).is_empty());
    }
}
