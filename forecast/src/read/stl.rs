//! As much of an STL as the rules need: its triangles, from binary or text.

use crate::read::mesh::{Mesh, Point};

/// Most triangles that are looked at; a guess with room.
const MAX_FACES: usize = 4_000_000;

/// Notes what an STL says.
pub(crate) fn look(bytes: &[u8], mesh: &mut Mesh) {
    mesh.is_text = is_text(bytes);
    let corners = if mesh.is_text { of_text(bytes) } else { of_binary(bytes) };
    let faces: Vec<_> = (0..corners.len() / 3).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    mesh.measure(&corners, &faces);
}

/// Text begins with `solid`; many binary headers say so, too, but then the length fits.
fn is_text(bytes: &[u8]) -> bool {
    let count = bytes.get(80..84).and_then(|b| <[u8; 4]>::try_from(b).ok()).map(u32::from_le_bytes);
    let fits = count.is_some_and(|n| u64::from(n) * 50 + 84 == bytes.len() as u64);
    bytes.trim_ascii_start().starts_with(b"solid") && !fits
}

fn of_text(bytes: &[u8]) -> Vec<Point> {
    let lines = bytes.split(|b| *b == b'\n').filter_map(|l| std::str::from_utf8(l).ok());
    let vertices = lines.filter_map(|line| line.trim().strip_prefix("vertex "));
    let points = vertices.filter_map(|text| {
        let numbers: Vec<f64> = text.split_whitespace().map_while(|w| w.parse().ok()).collect();
        <Point>::try_from(numbers).ok()
    });
    points.take(3 * MAX_FACES).collect()
}

fn of_binary(bytes: &[u8]) -> Vec<Point> {
    let float =
        |b: &[u8]| <[u8; 4]>::try_from(b).map_or(f64::NAN, |b| f64::from(f32::from_le_bytes(b)));
    let records = bytes.get(84..).unwrap_or_default().chunks_exact(50).take(MAX_FACES);
    let corners = records.flat_map(|r| r[12..48].chunks_exact(12));
    corners.map(|c| [float(&c[..4]), float(&c[4..8]), float(&c[8..])]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_binary_are_measured_alike() {
        let mut text = Mesh::named("a.stl");
        look(b"solid a\nfacet\nvertex 0 0 0\n vertex 2 0 0\nvertex 0 3 0\nendfacet\n", &mut text);
        assert_eq!((text.faces, text.bounds), (1, Some([[0.0; 3], [2.0, 3.0, 0.0]])));
        let mut bytes = vec![0; 80];
        bytes.extend(1_u32.to_le_bytes());
        let numbers = [0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0, 0.0];
        bytes.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend([0, 0]);
        let mut binary = Mesh::named("a.stl");
        look(&bytes, &mut binary);
        assert!(text.is_text && !binary.is_text);
        assert_eq!((binary.faces, binary.bounds), (text.faces, text.bounds));
        for broken in [&b""[..], b"solid", &bytes[..100]] {
            look(broken, &mut Mesh::named("a.stl"));
        }
    }
}
