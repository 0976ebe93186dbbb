//! Labels for what nothing linked to a prompt: the part of the nearest labelled face.

use std::collections::BTreeMap;

use object::{DVec3, Mesh};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;

use crate::classic::lexicon::sizes::SizePrior;
use crate::classic::segment::grow::merge::Group;

/// Points of an island that are asked for their nearest labelled face, at most.
const POINTS: usize = 64;

/// The label of each face: its group's, or for a group without one, that of the labelled face
/// nearest any of some points of the group. `root` if nothing at all is labelled, or if words say
/// that the nearest part is far smaller than the group.
pub(crate) fn settle(
    mesh: &Mesh,
    segment_of_face: &[u32],
    groups: &[Group],
    (priors, root): (&[SizePrior], u16),
) -> Vec<u16> {
    let group = |f: usize| groups[segment_of_face[f] as usize];
    let faces = 0..mesh.faces().len();
    let mut islands: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for f in faces.clone().filter(|&f| group(f).label.is_none()) {
        islands.entry(group(f).number).or_default().push(f);
    }
    let mut settled: BTreeMap<u32, u16> = BTreeMap::new();
    if !islands.is_empty() {
        let shore: Vec<usize> = faces.clone().filter(|&f| group(f).label.is_some()).collect();
        if let Some(land) = surface(mesh, &shore) {
            let label = |f: u32| group(shore[f as usize]).label.unwrap_or(root);
            let total = area_of(mesh, faces.clone());
            settled.extend(islands.iter().map(|(&n, island)| {
                let part = label(nearest(mesh, island, &land));
                let share = area_of(mesh, island.iter().copied()) / total;
                let may = priors.get(usize::from(part)).is_none_or(|p| p.allows(share));
                (n, if may { part } else { root })
            }));
        }
    }
    let of_group = |g: Group| g.label.or(settled.get(&g.number).copied()).unwrap_or(root);
    faces.map(|f| of_group(group(f))).collect()
}

fn area_of(mesh: &Mesh, faces: impl Iterator<Item = usize>) -> f64 {
    faces.map(|f| mesh.area(f)).sum()
}

fn surface(mesh: &Mesh, faces: &[usize]) -> Option<TriMesh> {
    let triangles = faces.iter().map(|&f| mesh.faces()[f]).collect();
    TriMesh::new(mesh.vertices().to_vec(), triangles).ok()
}

/// The land's own number of the face nearest any of the island's points.
fn nearest(mesh: &Mesh, faces: &[usize], land: &TriMesh) -> u32 {
    let stride = faces.len().div_ceil(POINTS);
    let points = faces.iter().step_by(stride).map(|&f| mesh.centroid(f));
    let found = points.map(|p: DVec3| {
        let near = land.project_local_point(p, false);
        (near.point.distance(p), near.subshape)
    });
    found.reduce(|a, b| if b.0 < a.0 { b } else { a }).map_or(0, |(_, face)| face)
}
