//! MuJoCo's own mesh files (`.msh`): counts of points, normals, texture coordinates and faces, then
//! these, as 32-bit numbers.

use glamx::DVec3;
use object::Mesh;
use object::mesh::{MAX_FACES, MAX_VERTICES};

/// Reads one; the first broken rule in words.
pub(crate) fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let count = |k: usize| {
        let word: Option<[u8; 4]> = bytes.get(4 * k..4 * k + 4).and_then(|w| w.try_into().ok());
        word.and_then(|w| usize::try_from(i32::from_le_bytes(w)).ok())
    };
    let [Some(points), Some(normals), Some(coordinates), Some(faces)] = [0, 1, 2, 3].map(count)
    else {
        return Err("a mesh of MuJoCo begins with four counts".into());
    };
    if points > MAX_VERTICES || faces > MAX_FACES {
        return Err(format!("at most {MAX_VERTICES} points and {MAX_FACES} faces"));
    }
    let numbers = normals.checked_mul(3).zip(coordinates.checked_mul(2));
    let skipped = numbers.and_then(|(n, c)| n.checked_add(c)).unwrap_or(usize::MAX);
    let words = |from: usize, many: usize| {
        let end = from.checked_add(many)?.checked_mul(4)?;
        bytes.get(from * 4..end)
    };
    let after = points.saturating_mul(3).saturating_add(4);
    let places = words(4, 3 * points).zip(
        after
            .checked_add(skipped)
            .filter(|from| *from < bytes.len())
            .and_then(|f| words(f, 3 * faces)),
    );
    let Some((places, corners)) = places else {
        let (found, due) = (bytes.len(), 4 * (after.saturating_add(skipped) + 3 * faces));
        return Err(format!("a mesh of these counts has {due} bytes, found {found}"));
    };
    let word = |w: &[u8]| <[u8; 4]>::try_from(w).unwrap_or_default();
    let places: Vec<f64> =
        places.chunks_exact(4).map(|w| f64::from(f32::from_le_bytes(word(w)))).collect();
    let corners: Vec<u32> = corners.chunks_exact(4).map(|w| u32::from_le_bytes(word(w))).collect();
    let points = places.chunks_exact(3).map(|p| DVec3::new(p[0], p[1], p[2])).collect();
    let faces = corners.chunks_exact(3).map(|f| [f[0], f[1], f[2]]).collect();
    Mesh::new(points, faces).map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Vec<u8> {
        let mut bytes: Vec<u8> = [3_i32, 1, 3, 1].iter().flat_map(|n| n.to_le_bytes()).collect();
        let numbers = [0.0_f32, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.0];
        bytes.extend(numbers.iter().chain(&[0.0; 6]).flat_map(|n| n.to_le_bytes()));
        bytes.extend([0_i32, 1, 2].iter().flat_map(|n| n.to_le_bytes()));
        bytes
    }

    #[test]
    fn a_mesh_of_mujoco_is_read_past_its_normals() {
        let mesh = read(&triangle()).unwrap();
        assert_eq!((mesh.area(0), mesh.normal(0)), (3.0, DVec3::Z));
    }

    #[test]
    fn a_mesh_of_mujoco_that_breaks_off_is_refused_wherever_it_does() {
        let whole = triangle();
        assert!((0..whole.len()).all(|end| read(&whole[..end]).is_err()));
        let mut wild = whole.clone();
        wild[0..4].copy_from_slice(&i32::MAX.to_le_bytes());
        assert!(read(&wild).is_err());
        wild[0..4].copy_from_slice(&(-1_i32).to_le_bytes());
        assert!(read(&wild).is_err());
    }
}
