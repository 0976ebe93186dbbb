//! Closes the surface of a part that was cut from a larger skin: its holes are capped where that
//! makes a body of it, and where it is a sheet the sheet gets a back.
//!
//! Nobody saw what lies behind a cut: a cap is the plainest guess, and every one is counted.

use std::collections::{BTreeMap, BTreeSet};

use glamx::DVec3;
use object::mesh::{Bounds, MeshError};
use object::weld::Weld;
use object::{KinematicTree, Mesh};

use crate::change::Change;
use crate::surface::borders::loops;
use crate::surface::orient::Scene;
use crate::surface::polygon::triangles;
use crate::surface::repair::{from_smallest, repair};
use crate::surface::repaired::{Patch, Report, Surface, is_flat};
use crate::surface::seal;

/// A sheet gets no thicker than this share of its part's diagonal.
const THICKEST: f64 = 0.02;
/// What a sheet with a back encloses at least, as a share of its area times its thickness.
const BODY: f64 = 0.25;
/// What caps enclose at least of a patch too folded for a back, as a share of its area to the power
/// of 1.5: a square pane's is about a third of its thickness over its width.
const FOLDED: f64 = 1e-3;
/// The least thickness of a collision piece, metres (G2), and so of a sheet.
const THINNEST: f64 = 0.001;
const WHY: &str = "a part that moves is a body with a back, not a sheet";

/// Which parts move relative to the root: their surfaces are to be closed.
pub(crate) fn moving(tree: &KinematicTree) -> Vec<bool> {
    let mut moves = vec![false; tree.len()];
    for &part in tree.root_first() {
        let above = tree.parent(part).is_some_and(|p| moves[p]);
        moves[part] = above || !tree.parts()[part].joints.is_empty();
    }
    moves
}

/// What closing a surface did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Done {
    caps: usize,
    sheets: usize,
    thickness: f64,
}

impl Done {
    fn change(&self, part: &str) -> Option<Change> {
        let Self { caps, sheets, thickness } = *self;
        let after = match (caps, sheets) {
            (0, 0) => return None,
            (_, 0) => format!("closed by {caps} caps"),
            _ => format!("{caps} caps, {sheets} sheets given {:.1} mm", thickness * 1000.0),
        };
        Some(Change::new(part, "surface", "open where it was cut".into(), after, WHY))
    }
}

/// The surface without the backs of sheets, and with every corner that stands on another's edge
/// joined to it. A back goes only where a sheet shows both its sides by faces of their own; a sheet
/// with thickness has a back anyway.
///
/// # Errors
/// [`MeshError`] if what is left breaks a rule of meshes, which it should not.
pub(crate) fn ready(surface: Surface, scene: Option<&Scene>) -> Result<Surface, MeshError> {
    if surface.patches.iter().all(|p| p.volume.is_some()) {
        return Ok(surface);
    }
    let backs = backs(&surface);
    let faces = 0..surface.mesh.faces().len() as u32;
    let kept = faces.filter(|f| !backs.contains(f)).map(|f| f as usize);
    let mesh = surface.mesh.submesh(kept)?;
    let mesh = seal::joined(&mesh).unwrap_or(mesh);
    let Surface { mesh, patches, report } = repair(&mesh, scene)?;
    let repeated = report.repeated + surface.report.repeated + backs.len();
    Ok(Surface { mesh, patches, report: Report { repeated, ..surface.report } })
}

/// Faces of open patches that are others turned over.
fn backs(surface: &Surface) -> BTreeSet<u32> {
    let weld = Weld::new(&surface.mesh);
    let (mut fronts, mut backs) = (BTreeSet::new(), BTreeSet::new());
    for &face in surface.patches.iter().filter(|p| p.volume.is_none()).flat_map(|p| &p.faces) {
        let [a, b, c] = weld.faces[face as usize];
        if fronts.contains(&from_smallest([a, c, b])) {
            backs.insert(face);
        } else {
            fronts.insert(from_smallest([a, b, c]));
        }
    }
    backs
}

/// The surface with its open patches closed, and what was done; `wall` is the usual thickness of
/// what the part is made of, metres. A patch that encloses nothing either way stays open.
///
/// # Errors
/// [`MeshError`] if the closed surface breaks a rule of meshes, which none should.
pub(crate) fn close(
    surface: Surface,
    part: &str,
    wall: f64,
) -> Result<(Surface, Option<Change>), MeshError> {
    if surface.patches.iter().all(|p| p.volume.is_some()) {
        return Ok((surface, None));
    }
    let diagonal = surface.mesh.bounds().diagonal();
    let wall = wall.min(THICKEST * diagonal).max(THINNEST);
    let mut work = Work::new(&surface, wall);
    let mut patches = surface.patches.clone();
    patches.iter_mut().filter(|p| p.volume.is_none()).for_each(|p| work.close(p));
    let change = work.done.change(part);
    let mesh = work.mesh(&surface.mesh)?;
    Ok((Surface { mesh, patches, report: surface.report }, change))
}

/// A mesh that grows.
struct Work {
    weld: Weld,
    vertices: Vec<DVec3>,
    /// For each vertex added, the vertex it was made from.
    made_of: Vec<u32>,
    faces: Vec<[u32; 3]>,
    wall: f64,
    done: Done,
}

/// A patch with the vertex that stands for each of its places, and its borders.
struct Open {
    faces: Vec<[u32; 3]>,
    vertex_at: BTreeMap<u32, u32>,
    borders: Vec<Vec<u32>>,
}

impl Work {
    fn new(surface: &Surface, wall: f64) -> Self {
        let (mesh, done) = (&surface.mesh, Done { thickness: wall, ..Done::default() });
        let (vertices, faces) = (mesh.vertices().to_vec(), mesh.faces().to_vec());
        Self { weld: Weld::new(mesh), vertices, made_of: vec![], faces, wall, done }
    }

    /// Caps the patch where that encloses at least what a sheet would; else gives it a back, or if it
    /// is too folded for one, caps it where that encloses anything.
    fn close(&mut self, patch: &mut Patch) {
        let open = self.open(patch);
        let caps = self.caps(&open);
        let area: f64 = open.faces.iter().map(|f| self.area(*f)).sum();
        let volume = self.volume(open.faces.iter().chain(&caps), &self.vertices);
        if volume >= self.wall * area {
            self.cap(patch, (&open, caps), volume);
            return;
        }
        let capped = (caps, volume);
        let (back, points) = self.back(&open);
        let vertices = [&self.vertices[..], &points.iter().map(|p| p.1).collect::<Vec<_>>()];
        let volume = self.volume(open.faces.iter().chain(&back), &vertices.concat());
        // A sheet that shows both its sides already folds over into a body of next to nothing.
        if volume >= BODY * self.wall * area {
            self.done.sheets += 1;
            self.made_of.extend(points.iter().map(|p| p.0));
            self.vertices.extend(points.iter().map(|p| p.1));
            self.add(patch, back, volume);
        } else if capped.1 >= FOLDED * area.powf(1.5) {
            self.cap(patch, (&open, capped.0), capped.1);
        }
    }

    fn cap(&mut self, patch: &mut Patch, (open, caps): (&Open, Vec<[u32; 3]>), volume: f64) {
        self.done.caps += open.borders.len();
        self.add(patch, caps, volume);
    }

    fn add(&mut self, patch: &mut Patch, faces: Vec<[u32; 3]>, volume: f64) {
        let first = self.faces.len() as u32;
        patch.faces.extend(first..first + faces.len() as u32);
        patch.volume = Some(volume);
        self.faces.extend(faces);
    }

    fn place(&self, vertex: u32) -> u32 {
        self.weld.place_of_vertex[vertex as usize]
    }

    fn open(&self, patch: &Patch) -> Open {
        let faces: Vec<_> = patch.faces.iter().map(|&f| self.faces[f as usize]).collect();
        let vertex_at = faces.iter().flatten().map(|&v| (self.place(v), v)).collect();
        let borders = loops(faces.iter().map(|f| f.map(|v| self.place(v))));
        Open { faces, vertex_at, borders }
    }

    fn caps(&self, open: &Open) -> Vec<[u32; 3]> {
        let flat = seal::FLAT * Bounds::of(self.weld.places.iter().copied()).diagonal();
        let cap = |border: &Vec<u32>| {
            let points: Vec<_> = border.iter().map(|&p| self.weld.places[p as usize]).collect();
            let at: Vec<_> = border.iter().filter_map(|p| open.vertex_at.get(p).copied()).collect();
            let has_area = |t: &[usize; 3]| !is_flat(t.map(|i| points[i]), flat);
            let cap = triangles(&points).into_iter().filter(has_area);
            cap.map(move |t| t.map(|i| at[i])).collect::<Vec<_>>()
        };
        open.borders.iter().flat_map(cap).collect()
    }

    /// The patch again, turned over and moved inward by the wall, and sides along its borders;
    /// with the points it needs and the vertices they come from.
    fn back(&self, open: &Open) -> (Vec<[u32; 3]>, Vec<(u32, DVec3)>) {
        let inward = self.inward(open);
        let (mut number, mut points) = (BTreeMap::new(), Vec::new());
        for &vertex in open.faces.iter().flatten() {
            number.entry(vertex).or_insert_with(|| {
                let moved = inward.get(&self.place(vertex)).copied().unwrap_or_default();
                points.push((vertex, self.vertices[vertex as usize] + moved));
                (self.vertices.len() + points.len() - 1) as u32
            });
        }
        let behind = |v: u32| number.get(&v).copied().unwrap_or(v);
        let mut faces: Vec<_> = open.faces.iter().map(|&[a, b, c]| [a, c, b].map(behind)).collect();
        for border in &open.borders {
            let at: Vec<_> = border.iter().filter_map(|p| open.vertex_at.get(p).copied()).collect();
            for (a, b) in at.iter().zip(at.iter().cycle().skip(1)) {
                faces.extend([[*a, *b, behind(*b)], [*a, behind(*b), behind(*a)]]);
            }
        }
        (faces, points)
    }

    /// For each place of a patch, the way through the wall.
    fn inward(&self, open: &Open) -> BTreeMap<u32, DVec3> {
        let mut sums: BTreeMap<u32, DVec3> = BTreeMap::new();
        for face in &open.faces {
            let [a, b, c] = face.map(|v| self.vertices[v as usize]);
            let vector = (b - a).cross(c - a);
            face.iter().for_each(|&v| *sums.entry(self.place(v)).or_default() += vector);
        }
        sums.values_mut().for_each(|sum| *sum = sum.normalize_or_zero() * -self.wall);
        sums
    }

    fn area(&self, face: [u32; 3]) -> f64 {
        let [a, b, c] = face.map(|v| self.vertices[v as usize]);
        (b - a).cross(c - a).length() / 2.0
    }

    fn volume<'a>(&self, faces: impl Iterator<Item = &'a [u32; 3]>, vertices: &[DVec3]) -> f64 {
        let origin = vertices.first().copied().unwrap_or_default();
        let cone = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|v| vertices[v as usize] - origin);
            a.dot(b.cross(c)) / 6.0
        };
        faces.map(cone).sum()
    }

    fn mesh(self, was: &Mesh) -> Result<Mesh, MeshError> {
        let colours = was.colours().map(|old| {
            let more = self.made_of.iter().map(|&v| old[v as usize]);
            old.iter().copied().chain(more).collect()
        });
        Mesh::new(self.vertices, self.faces)?.with_frame(was.frame()).with_colours(colours)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::seal::is_closed;
    use crate::tests::{block, joined, reversed};

    fn closed(mesh: &Mesh, wall: f64) -> (Surface, Option<Change>) {
        close(repair(mesh, Scene::new(mesh).as_ref()).unwrap(), "part", wall).unwrap()
    }

    #[test]
    fn a_box_without_a_lid_gets_one() {
        let cube = block(DVec3::ONE, DVec3::ZERO);
        let open = cube.submesh((0..12).filter(|&f| cube.normal(f).z < 0.5)).unwrap();
        let (surface, change) = closed(&open, 0.01);
        assert!(is_closed(&surface.mesh));
        assert!((surface.mesh.signed_volume() - 1.0).abs() < 1e-12);
        assert!((surface.patches[0].volume.unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(change.unwrap().after, "closed by 1 caps");
    }

    #[test]
    fn the_front_of_a_drawer_becomes_a_board_behind_itself() {
        let cube = block(DVec3::new(0.4, 0.5, 0.2), DVec3::ZERO);
        let front = cube.submesh((0..12).filter(|&f| cube.normal(f).y < -0.5)).unwrap();
        let (surface, change) = closed(&front, 0.018);
        assert!(is_closed(&surface.mesh));
        let wall = 0.02 * front.bounds().diagonal();
        assert!((surface.mesh.signed_volume() - 0.08 * wall.min(0.018)).abs() < 1e-12);
        assert_eq!(surface.mesh.bounds().min.y, -0.25);
        assert!(change.unwrap().after.starts_with("0 caps, 1 sheets given"));
    }

    #[test]
    fn a_sheet_that_shows_both_its_sides_is_no_body_and_gets_no_back() {
        let corners = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 0.0, 1.0), DVec3::Z];
        let faces = vec![[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]];
        let (surface, change) = closed(&Mesh::new(corners, faces).unwrap(), 0.018);
        assert_eq!((surface.mesh.faces().len(), change), (4, None));
        assert!(surface.patches.iter().all(|p| p.volume.is_none()));
    }

    #[test]
    fn a_sheet_of_two_sides_loses_one_and_becomes_a_board() {
        let cube = block(DVec3::new(0.4, 0.5, 0.2), DVec3::ZERO);
        let front = cube.submesh((0..12).filter(|&f| cube.normal(f).y < -0.5)).unwrap();
        let both = joined(&[front.clone(), reversed(&front).submesh([0]).unwrap()]);
        let surface = ready(repair(&both, None).unwrap(), None).unwrap();
        assert_eq!((surface.mesh.faces().len(), surface.report.repeated), (2, 1));
        let (surface, change) = close(surface, "part", 0.018).unwrap();
        assert!(is_closed(&surface.mesh) && change.is_some());
        let board = 0.08 * 0.02 * front.bounds().diagonal();
        assert!((surface.mesh.signed_volume() - board.min(0.08 * 0.018)).abs() < 1e-9);
    }

    #[test]
    fn a_knob_thinner_than_its_wall_is_capped() {
        let knob = block(DVec3::new(0.004, 0.004, 0.003), DVec3::ZERO);
        let open = knob.submesh((0..12).filter(|&f| knob.normal(f).y < 0.5)).unwrap();
        let (surface, _) = closed(&joined(&[open, block(DVec3::ONE, DVec3::X)]), 0.018);
        assert!(is_closed(&surface.mesh));
        assert!(surface.patches.iter().all(|p| p.volume.is_some()));
    }

    #[test]
    fn closed_parts_and_their_neighbours_stay_as_they_are() {
        let cube = block(DVec3::ONE, DVec3::ZERO);
        let (surface, change) = closed(&cube, 0.01);
        assert_eq!((surface.mesh.faces().len(), change), (12, None));
        let open = block(DVec3::ONE, DVec3::X * 3.0).submesh(2..12).unwrap();
        let (surface, _) = closed(&joined(&[cube, open]), 0.01);
        assert_eq!(surface.patches.iter().filter(|p| p.volume.is_some()).count(), 2);
        assert!(is_closed(&surface.mesh));
    }

    #[test]
    fn what_moves_is_what_hangs_below_a_joint() {
        use object::{JointKind, Part};
        let part = |name: &str, parent, joints| Part {
            name: name.into(),
            text: name.into(),
            parent,
            joints,
        };
        let parts = vec![
            part("body", None, vec![]),
            part("door", Some(0), vec![JointKind::Prismatic]),
            part("knob", Some(1), vec![]),
            part("foot", Some(0), vec![]),
        ];
        let tree = KinematicTree::new(parts).unwrap();
        assert_eq!(moving(&tree), [false, true, true, false]);
    }
}
