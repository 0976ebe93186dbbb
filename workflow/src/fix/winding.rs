//! Faces that look inward, or against each other: G1, G2. A copy of the mesh's file has them turned
//! round; everything else of it stays, materials and texture coordinates too.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use object::Mesh;
use object::weld::Weld;
use sim_check::robot::{Geometry, Shape};

use super::collisions::{Place, meshes};
use super::offer::{Change, Job, Offer, State, quoted};
use super::remedies::Way;

/// Bytes of a binary STL before its first face, and of each face.
const STL: (usize, usize) = (84, 50);
/// Bytes of a face's normal, and of each of its corners.
const VECTOR: usize = 12;

/// One offer for each mesh that is named in the findings.
pub(super) fn offers((state, job): (&State, &Job), findings: &[(&str, &str)]) -> Vec<Offer> {
    let links = &state.robot.links;
    let shapes = || links.iter().flat_map(|l| l.visuals.iter().chain(&l.collisions));
    let mut named: BTreeMap<&str, &Shape> = BTreeMap::new();
    for (_, finding) in findings {
        // The link's name is quoted first, the mesh's after it.
        let Some(link) = quoted(finding, "link") else { continue };
        let after = finding.split_once(&format!("`{link}`")).map_or("", |(_, after)| after);
        let Some(label) = quoted(after, ",").or_else(|| quoted(after, ":")) else { continue };
        if let Some(shape) = shapes().find(|s| s.source == label) {
            named.entry(shape.source.as_str()).or_insert(shape);
        }
    }
    let offer = |(source, shape): (&str, &Shape)| Offer {
        way: Way::Turn,
        subject: format!("mesh `{source}`"),
        line: shape.line,
        changes: turned((state, job), shape).map(|change| vec![change]),
    };
    named.into_iter().map(offer).collect()
}

fn turned((state, job): (&State, &Job), shape: &Shape) -> Result<Change, String> {
    let Geometry::Mesh(mesh) = &shape.geometry else { return Err("it is no mesh".into()) };
    let name = shape.source.as_str();
    let ending = name.rsplit_once('.').map_or("", |(_, e)| e).to_ascii_lowercase();
    let turn = inward(mesh);
    let count = turn.iter().filter(|t| **t).count();
    if count == 0 {
        return Err("no face of it can be told to look the wrong way".into());
    }
    let (_, bytes) = state.mesh_file(job, name)?;
    let bytes = match ending.as_str() {
        "obj" => turned_obj(&bytes, &turn)?,
        "stl" => turned_stl(&bytes, &turn)?,
        _ => {
            return Err(
                "faces are turned in OBJ and STL files alone: turn them where it was made".into()
            );
        }
    };
    let place = Place::beside(state, job, name)?;
    let (file, written) = place.file((state, &[]), ("outward", &ending), bytes);
    let source = &state.source;
    let all = every(state, source.root());
    let (tag, attribute) = if state.is_urdf() { ("mesh", "filename") } else { ("mesh", "file") };
    let folder = meshes(state);
    let is_it = |at: &sim_check::read::source::At| {
        let told = source.get(*at, attribute).unwrap_or_default();
        source.tag(*at) == tag && format!("{folder}{told}") == name
    };
    let edits: Vec<_> =
        all.into_iter().filter(is_it).map(|at| source.set(at, attribute, &written)).collect();
    if edits.is_empty() || source.is_put_together() && state.is_urdf() {
        return Err(state.elsewhere("mesh", shape.line));
    }
    let words = format!("a copy with {count} of {} faces turned round", turn.len());
    Ok(Change { words, edits, files: vec![file] })
}

/// All elements in one, itself included.
fn every(state: &State, root: sim_check::read::source::At) -> Vec<sim_check::read::source::At> {
    let mut all = vec![root];
    let mut done = 0;
    while done < all.len() {
        all.extend(state.source.all_children(all[done]));
        done += 1;
    }
    all
}

/// Which faces look the wrong way: those of a connected piece are made to agree, and then to enclose a
/// volume above 0 where the piece is closed; of an open one the smaller part is turned.
fn inward(mesh: &Mesh) -> Vec<bool> {
    let weld = Weld::new(mesh);
    let mut uses: BTreeMap<[u32; 2], Vec<(u32, bool)>> = BTreeMap::new();
    for (face, &[a, b, c]) in weld.faces.iter().enumerate() {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            if p != q {
                uses.entry([p.min(q), p.max(q)]).or_default().push((face as u32, p < q));
            }
        }
    }
    let mut beside: Vec<Vec<(u32, bool)>> = vec![Vec::new(); weld.faces.len()];
    let mut open: BTreeSet<u32> = BTreeSet::new();
    for fan in uses.values() {
        match fan[..] {
            [(f, one), (g, other)] => {
                beside[f as usize].push((g, one == other));
                beside[g as usize].push((f, one == other));
            }
            // More than two faces at an edge say nothing of each other; one is a border.
            _ => open.extend(fan.iter().filter(|_| fan.len() % 2 == 1).map(|(f, _)| *f)),
        }
    }
    let (mut turn, mut seen) = (vec![false; weld.faces.len()], vec![false; weld.faces.len()]);
    for first in 0..weld.faces.len() {
        if seen[first] {
            continue;
        }
        seen[first] = true;
        let (mut piece, mut queue) = (vec![first], VecDeque::from([first]));
        while let Some(face) = queue.pop_front() {
            for &(other, clashes) in &beside[face] {
                let other = other as usize;
                if !std::mem::replace(&mut seen[other], true) {
                    turn[other] = turn[face] != clashes;
                    piece.push(other);
                    queue.push_back(other);
                }
            }
        }
        let anchor = mesh.corners(first)[0];
        let volume: f64 = piece
            .iter()
            .map(|&f| {
                let [a, b, c] = mesh.corners(f).map(|p| p - anchor);
                a.dot(b.cross(c)) / 6.0 * if turn[f] { -1.0 } else { 1.0 }
            })
            .sum();
        let is_open = piece.iter().any(|f| open.contains(&(*f as u32)));
        let turned = piece.iter().filter(|f| turn[**f]).count();
        let wrong = if is_open { 2 * turned > piece.len() } else { volume < 0.0 };
        if wrong {
            piece.iter().for_each(|&f| turn[f] = !turn[f]);
        }
    }
    turn
}

/// An OBJ text with some of its faces turned round. Normals that only such faces use are turned, too,
/// where they looked as the faces did.
pub(crate) fn turned_obj(bytes: &[u8], turn: &[bool]) -> Result<Vec<u8>, String> {
    let text =
        std::str::from_utf8(bytes).map_err(|_| "it is not UTF-8, so it is not written anew")?;
    if text.lines().any(|l| l.trim_end().ends_with('\\') && !l.trim_start().starts_with('#')) {
        return Err("it has lines that go on in the next one".into());
    }
    let (mut out, mut face) = (String::with_capacity(text.len()), 0);
    for line in text.split_inclusive('\n') {
        let body = line.trim_end_matches(['\r', '\n']);
        let end = &line[body.len()..];
        let told = body.split('#').next().unwrap_or_default();
        let words: Vec<&str> = told.split_whitespace().collect();
        if words.first() != Some(&"f") || words.len() < 4 {
            out.push_str(line);
            continue;
        }
        let count = words.len() - 3;
        let mine = turn.get(face..face + count).ok_or("its faces are not those that were read")?;
        face += count;
        if 2 * mine.iter().filter(|t| **t).count() > count {
            let corners: Vec<&str> = words[2..].iter().rev().copied().collect();
            out.push_str(&format!("f {} {}{end}", words[1], corners.join(" ")));
        } else {
            out.push_str(line);
        }
    }
    if face != turn.len() {
        return Err("its faces are not those that were read".into());
    }
    Ok(if turn.iter().all(|t| *t) { with_normals_turned(&out) } else { out }.into_bytes())
}

/// The text with all its normals turned, where they look against its faces.
fn with_normals_turned(text: &str) -> String {
    let (mut points, mut normals, mut votes) = (Vec::new(), Vec::new(), 0_i64);
    let vector = |line: &str| -> Option<glamx::DVec3> {
        let all: Vec<f64> = line.split_whitespace().skip(1).map_while(|w| w.parse().ok()).collect();
        (all.len() >= 3).then(|| glamx::DVec3::new(all[0], all[1], all[2]))
    };
    for line in text.lines() {
        match line.split_whitespace().next() {
            Some("v") => points.extend(vector(line)),
            Some("vn") => normals.extend(vector(line)),
            Some("f") => {
                let corner = |word: &str| -> Option<(glamx::DVec3, glamx::DVec3)> {
                    let mut parts = word.split('/');
                    let at = |text: Option<&str>, count: usize| {
                        let n: i64 = text?.parse().ok()?;
                        usize::try_from(if n < 0 { count as i64 + n } else { n - 1 }).ok()
                    };
                    let p = at(parts.next(), points.len())?;
                    let n = at(parts.nth(1), normals.len())?;
                    Some((*points.get(p)?, *normals.get(n)?))
                };
                let all: Vec<_> = line.split_whitespace().skip(1).map_while(corner).collect();
                if let [(a, n), (b, _), (c, _), ..] = all[..] {
                    votes += if (b - a).cross(c - a).dot(n) < 0.0 { 1 } else { -1 };
                }
            }
            _ => {}
        }
    }
    if votes <= 0 {
        return text.to_owned();
    }
    let turned = |line: &str| {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("vn") => {
                let end = if line.ends_with("\r\n") { "\r\n" } else { "\n" };
                let all: Vec<String> = words.map(super::numbers::negated).collect();
                format!("vn {}{end}", all.join(" "))
            }
            _ => line.to_owned(),
        }
    };
    text.split_inclusive('\n').map(turned).collect()
}

/// A binary STL with some of its faces turned round.
pub(crate) fn turned_stl(bytes: &[u8], turn: &[bool]) -> Result<Vec<u8>, String> {
    if bytes.len() != STL.0 + STL.1 * turn.len() {
        return Err("it is no binary STL: turn its faces where it was made".into());
    }
    let mut out = bytes.to_vec();
    for (face, _) in turn.iter().enumerate().filter(|(_, t)| **t) {
        let from = STL.0 + STL.1 * face;
        for k in 0..3 {
            // The sign of a number of four bytes, least byte first.
            out[from + 4 * k + 3] ^= 0x80;
        }
        let (second, third) = (from + 2 * VECTOR, from + 3 * VECTOR);
        for k in 0..VECTOR {
            out.swap(second + k, third + k);
        }
    }
    Ok(out)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use super::*;
    use object::mesh::UpAxis;

    const TETRAHEDRON: &str = "# kept\r\nmtllib a.mtl\r\nv 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nv 0 0 1\r\nvn 0 0 1\r\nusemtl red\r\nf 1//1 2//1 3//1\r\nf 1 4 2\r\nf 1 3 4\r\nf 2 4 3\r\n";

    fn volume(text: &[u8]) -> f64 {
        object::obj::read(std::str::from_utf8(text).unwrap(), UpAxis::Z).unwrap().signed_volume()
    }

    #[test]
    fn a_solid_inside_out_is_turned_and_the_rest_of_its_file_kept() {
        let mesh = object::obj::read(TETRAHEDRON, UpAxis::Z).unwrap();
        assert!(mesh.signed_volume() < 0.0);
        let turn = inward(&mesh);
        assert_eq!(turn, [true; 4]);
        let made = turned_obj(TETRAHEDRON.as_bytes(), &turn).unwrap();
        assert!(volume(&made) > 0.0);
        let text = String::from_utf8(made).unwrap();
        assert!(
            text.starts_with("# kept\r\nmtllib a.mtl\r\n")
                && text.contains("usemtl red\r\nf 1//1 3//1 2//1\r\n"),
            "{text}"
        );
        assert!(text.contains("vn -0 0 -1") || text.contains("vn 0 0 -1"), "{text}");
    }

    #[test]
    fn one_face_against_the_others_is_turned_alone() {
        let text = TETRAHEDRON.replace("f 1 4 2", "f 1 2 4");
        let mesh = object::obj::read(&text, UpAxis::Z).unwrap();
        let made = turned_obj(text.as_bytes(), &inward(&mesh)).unwrap();
        assert!((volume(&made) - 1.0 / 6.0).abs() < 1e-12);
        assert!(
            inward(&object::obj::read(std::str::from_utf8(&made).unwrap(), UpAxis::Z).unwrap())
                .iter()
                .all(|t| !t)
        );
    }

    #[test]
    fn a_binary_stl_keeps_its_head_and_turns_its_faces() {
        let mesh = object::obj::read(TETRAHEDRON, UpAxis::Z).unwrap();
        let mut bytes = vec![b'x'; 80];
        bytes.extend(4_u32.to_le_bytes());
        for face in 0..4 {
            let normal = mesh.normal(face);
            for v in std::iter::once(normal).chain(mesh.corners(face)) {
                v.to_array().iter().for_each(|c| bytes.extend((*c as f32).to_le_bytes()));
            }
            bytes.extend([0, 0]);
        }
        let made = turned_stl(&bytes, &[true; 4]).unwrap();
        assert_eq!((made.len(), &made[..84]), (bytes.len(), &bytes[..84]));
        assert!(object::stl::read(&made).unwrap().signed_volume() > 0.0);
        assert!(turned_stl(b"solid a\nendsolid", &[true]).is_err());
    }
}
