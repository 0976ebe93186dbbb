//! STL file → mesh, binary or text.
//!
//! ```
//! let text = "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 3 0\n\
//!             endloop\nendfacet\nendsolid";
//! let mesh = object::stl::read(text.as_bytes())?;
//! assert_eq!(mesh.area(0), 3.0);
//! # Ok::<(), object::stl::StlError>(())
//! ```

use glamx::DVec3;
use rustc_hash::FxHashMap;

use crate::mesh::{FileFrame, MAX_VERTICES, Mesh, MeshError, UpAxis};

/// Why bytes are not an STL surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StlError {
    /// A binary file whose length is not 84 + 50 per triangle.
    #[error("a binary STL of {triangles} triangles has {expected} bytes, found {found}")]
    Length {
        /// Triangles the header promises.
        triangles: usize,
        /// Bytes they need.
        expected: usize,
        /// Bytes there are.
        found: usize,
    },
    /// A text file with a broken vertex line.
    #[error("line {line}: expected `vertex x y z` with finite numbers, found `{found}`")]
    Vertex {
        /// Line, from 1.
        line: usize,
        /// What stands there.
        found: String,
    },
    /// A text file whose vertices do not come in threes.
    #[error("vertices come in threes, found {0}")]
    Threes(usize),
    /// Triangles that are not a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// Reads an STL; coordinates are taken as metres, z up, as URDF has them.
///
/// # Errors
/// [`StlError`], the first broken rule.
pub fn read(bytes: &[u8]) -> Result<Mesh, StlError> {
    let corners = corners(bytes)?;
    let faces = (0..corners.len() as u32 / 3).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    Ok(Mesh::new(corners, faces)?)
}

/// Reads an STL whose `up` axis is known. Corners at the same place share a vertex; faces keep their
/// order.
///
/// # Errors
/// [`StlError`], the first broken rule.
pub fn read_shared(bytes: &[u8], up: UpAxis) -> Result<Mesh, StlError> {
    let frame = FileFrame { up };
    let mut known: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    let mut vertices = Vec::new();
    let corners = corners(bytes)?.into_iter().map(|p| {
        // Both zeros are one place.
        let place = (p + DVec3::ZERO).to_array().map(f64::to_bits);
        *known.entry(place).or_insert_with(|| {
            vertices.push(frame.point_to_object(p));
            vertices.len() as u32 - 1
        })
    });
    let corners: Vec<u32> = corners.collect();
    let faces = corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
    Ok(Mesh::new(vertices, faces)?.with_frame(frame))
}

/// Three corners a triangle, in the file's frame.
fn corners(bytes: &[u8]) -> Result<Vec<DVec3>, StlError> {
    let corners = if is_binary(bytes) { binary_corners(bytes)? } else { text_corners(bytes)? };
    if corners.len() % 3 != 0 {
        return Err(StlError::Threes(corners.len()));
    }
    Ok(corners)
}

/// Text begins with `solid` and holds a `facet` or ends at once; many binary headers say `solid` too.
fn is_binary(bytes: &[u8]) -> bool {
    if !bytes.trim_ascii_start().starts_with(b"solid") {
        return true;
    }
    let promised = triangle_count(bytes).and_then(|n| n.checked_mul(50)?.checked_add(84));
    promised == Some(bytes.len())
}

fn triangle_count(bytes: &[u8]) -> Option<usize> {
    let count: [u8; 4] = bytes.get(80..84)?.try_into().ok()?;
    usize::try_from(u32::from_le_bytes(count)).ok()
}

fn binary_corners(bytes: &[u8]) -> Result<Vec<DVec3>, StlError> {
    let found = bytes.len();
    let triangles = triangle_count(bytes).unwrap_or(0);
    let expected = triangles.saturating_mul(50).saturating_add(84);
    if found < expected {
        return Err(StlError::Length { triangles, expected, found });
    }
    check_count(triangles.saturating_mul(3))?;
    let number = |b: &[u8]| match *b {
        [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => f64::NAN,
    };
    let corner = |b: &[u8]| DVec3::new(number(&b[..4]), number(&b[4..8]), number(&b[8..12]));
    let records = bytes[84..expected].chunks_exact(50);
    Ok(records.flat_map(|r| r[12..48].chunks_exact(12).map(corner)).collect())
}

/// Each corner becomes a vertex: too many are refused before they take memory.
fn check_count(corners: usize) -> Result<(), StlError> {
    if corners <= MAX_VERTICES {
        return Ok(());
    }
    Err(MeshError::TooLarge { what: "vertices", limit: MAX_VERTICES, found: corners }.into())
}

fn text_corners(bytes: &[u8]) -> Result<Vec<DVec3>, StlError> {
    let text = String::from_utf8_lossy(bytes);
    let mut corners = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        if !words.next().is_some_and(|word| word.eq_ignore_ascii_case("vertex")) {
            continue;
        }
        let numbers: Vec<f64> = words.map_while(|w| w.parse().ok()).take(4).collect();
        match numbers[..] {
            [x, y, z] if (x + y + z).is_finite() => {
                corners.push(DVec3::new(x, y, z));
                check_count(corners.len())?;
            }
            _ => {
                return Err(StlError::Vertex {
                    line: i + 1,
                    found: line.trim().chars().take(80).collect(),
                });
            }
        }
    }
    Ok(corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary(header: &[u8], triangles: u32) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(triangles.to_le_bytes());
        let numbers = [0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0, 0.0];
        bytes.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend([0, 0]);
        bytes
    }

    const TEXT: &str = "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\n\
                        vertex 0 3 0\nendloop\nendfacet\nendsolid";

    #[test]
    fn text_and_binary_give_the_same_triangle() {
        let text = read(TEXT.as_bytes()).unwrap();
        assert_eq!(text.area(0), 3.0);
        assert_eq!(read(&binary(b"made by hand", 1)).unwrap(), text);
        assert_eq!(read(&binary(b"solid but binary", 1)).unwrap(), text);
    }

    #[test]
    fn corners_at_one_place_share_a_vertex_and_z_up_is_turned() {
        let text = "solid\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 0 0 2\n\
                    VERTEX 1 0 0\nVERTEX -0 0 0\nVERTEX 0 3 0\n";
        let mesh = read_shared(text.as_bytes(), UpAxis::Z).unwrap();
        assert_eq!(mesh.faces(), [[0, 1, 2], [1, 0, 3]]);
        assert_eq!(mesh.vertices()[2], DVec3::new(0.0, 0.0, 2.0));
        let turned = read_shared(text.as_bytes(), UpAxis::Y).unwrap();
        assert_eq!(turned.vertices()[3], DVec3::new(0.0, 0.0, 3.0));
        assert_eq!(turned.frame().up, UpAxis::Y);
    }

    #[test]
    fn broken_files_are_refused_with_the_rule() {
        let e = read(&binary(b"x", 2)).unwrap_err().to_string();
        assert_eq!(e, "a binary STL of 2 triangles has 184 bytes, found 134");
        let e = read(TEXT.replace("0 3 0", "0 nan 0").as_bytes()).unwrap_err().to_string();
        assert!(e.starts_with("line 6: expected `vertex x y z`"), "{e}");
        assert_eq!(read(b"solid"), Err(StlError::Mesh(MeshError::Empty)));
        assert!(matches!(read(b""), Err(StlError::Length { found: 0, .. })));
        assert_eq!(read(b"solid a\nvertex 0 0 0"), Err(StlError::Threes(1)));
    }
}
