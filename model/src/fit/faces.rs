//! A part for every face from the parts of sampled points: by majority, spread to faces without a
//! point, and made whole inside each connected component.

use std::collections::{BTreeMap, BTreeSet};

use object::weld::{DisjointSets, Neighbour, Weld};
use object::{DVec3, Mesh};

/// A component one part holds this share of belongs to that part.
const WHOLE_SHARE: f64 = 0.8;

/// Labelled points on faces.
#[derive(Clone, Copy, Debug)]
pub struct FaceVotes<'a> {
    /// The face of each point.
    pub face: &'a [u32],
    /// The part of each point.
    pub part: &'a [u16],
    /// How many parts there are.
    pub parts: usize,
}

/// How labels are made whole inside a connected component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The component is one part: the one with the largest area there.
    Strict,
    /// Each part is one patch in the component: smaller patches go to the neighbour with the
    /// largest area there.
    Refined,
    /// Strict where one part holds four fifths of the component, refined elsewhere.
    Automatic,
}

/// Surface with its connectivity.
struct Surface {
    area: Vec<f64>,
    neighbours: Vec<Neighbour>,
    component: Vec<u32>,
    components: usize,
}

/// The part of every face. The same votes in another order give the same labels.
pub fn label_faces(mesh: &Mesh, weld: &Weld, votes: FaceVotes, mode: Mode) -> Vec<u16> {
    let (component, components) = weld.components();
    let area = (0..mesh.faces().len()).map(|f| mesh.area(f)).collect();
    let surface = Surface { area, neighbours: weld.neighbours(), component, components };
    let mut labels = spread(mesh, &surface, majority(mesh.faces().len(), votes));
    make_whole(&surface, &mut labels, votes.parts, mode);
    labels
}

/// The part most points of a face have, the lowest if several; none without points.
fn majority(faces: usize, votes: FaceVotes) -> Vec<Option<u16>> {
    let mut pairs: Vec<_> = votes.face.iter().zip(votes.part).collect();
    pairs.sort_unstable();
    let mut best: Vec<Option<u16>> = vec![None; faces];
    for of_face in pairs.chunk_by(|a, b| a.0 == b.0) {
        let runs = of_face.chunk_by(|a, b| a.1 == b.1);
        let most = runs.fold(&of_face[..0], |m, run| if run.len() > m.len() { run } else { m });
        best[*of_face[0].0 as usize] = most.first().map(|(_, part)| **part);
    }
    best
}

/// Gives faces without a point the part of the nearest labelled face: first along the surface,
/// then, for components without any, through space.
fn spread(mesh: &Mesh, surface: &Surface, mut labels: Vec<Option<u16>>) -> Vec<u16> {
    let around = adjacency(labels.len(), &surface.neighbours);
    let mut front: Vec<u32> =
        (0..labels.len() as u32).filter(|&f| labels[f as usize].is_some()).collect();
    while !front.is_empty() {
        let mut next = Vec::new();
        for &face in &front {
            for &other in &around[face as usize] {
                if labels[other as usize].is_none() {
                    labels[other as usize] = labels[face as usize];
                    next.push(other);
                }
            }
        }
        next.sort_unstable();
        front = next;
    }
    fill_islands(mesh, surface, &labels)
}

/// Components that no point fell on take the part of the labelled face with the nearest centroid.
fn fill_islands(mesh: &Mesh, surface: &Surface, labels: &[Option<u16>]) -> Vec<u16> {
    let known: Vec<(DVec3, u16)> =
        labels.iter().enumerate().filter_map(|(f, l)| l.map(|l| (mesh.centroid(f), l))).collect();
    let nearest = |p: DVec3| {
        let closer = |best: (f64, u16), &(c, l): &(DVec3, u16)| {
            let d = c.distance_squared(p);
            if d < best.0 { (d, l) } else { best }
        };
        known.iter().fold((f64::INFINITY, 0), closer).1
    };
    let mut of_component: BTreeMap<u32, u16> = BTreeMap::new();
    let fill = |(f, l): (usize, &Option<u16>)| match l {
        Some(l) => *l,
        None => {
            let component = surface.component[f];
            *of_component.entry(component).or_insert_with(|| nearest(mesh.centroid(f)))
        }
    };
    labels.iter().enumerate().map(fill).collect()
}

fn adjacency(faces: usize, neighbours: &[Neighbour]) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); faces];
    for n in neighbours {
        around[n.first as usize].push(n.second);
        around[n.second as usize].push(n.first);
    }
    around
}

fn make_whole(surface: &Surface, labels: &mut [u16], parts: usize, mode: Mode) {
    let mut area = vec![vec![0.0; parts]; surface.components];
    for ((&component, &label), a) in surface.component.iter().zip(&*labels).zip(&surface.area) {
        if let Some(slot) = area[component as usize].get_mut(usize::from(label)) {
            *slot += a;
        }
    }
    let verdict = |of_part: &Vec<f64>| {
        let better = |best: usize, p: usize| if of_part[p] > of_part[best] { p } else { best };
        let best = (0..parts).fold(0, better);
        let whole = of_part[best] >= WHOLE_SHARE * of_part.iter().sum::<f64>();
        let strict = mode == Mode::Strict || (mode == Mode::Automatic && whole);
        strict.then_some(best as u16)
    };
    let whole: Vec<Option<u16>> = area.iter().map(verdict).collect();
    for (label, &component) in labels.iter_mut().zip(&surface.component) {
        *label = whole[component as usize].unwrap_or(*label);
    }
    if whole.iter().any(Option::is_none) {
        Patches::new(surface, labels).refine(&area, labels);
    }
}

/// Same-label patches of the surface and which of them touch.
struct Patches {
    of_face: Vec<u32>,
    label: Vec<u16>,
    component: Vec<u32>,
    area: Vec<f64>,
    touch: Vec<BTreeSet<u32>>,
    /// How many patches a part has in a component.
    count: BTreeMap<(u32, u16), usize>,
}

impl Patches {
    fn new(surface: &Surface, labels: &[u16]) -> Self {
        let mut sets = DisjointSets::new(labels.len());
        let same = |n: &&Neighbour| labels[n.first as usize] == labels[n.second as usize];
        surface.neighbours.iter().filter(same).for_each(|n| sets.join(n.first, n.second));
        let mut number = BTreeMap::new();
        let mut patches = Self {
            of_face: vec![],
            label: vec![],
            component: vec![],
            area: vec![],
            touch: vec![],
            count: BTreeMap::new(),
        };
        for (face, &label) in labels.iter().enumerate() {
            let next = number.len() as u32;
            let patch = *number.entry(sets.root(face as u32)).or_insert(next);
            if patch == next {
                patches.open(label, surface.component[face]);
            }
            patches.of_face.push(patch);
            patches.area[patch as usize] += surface.area[face];
        }
        for n in &surface.neighbours {
            let [a, b] = [n.first, n.second].map(|f| patches.of_face[f as usize]);
            if a != b {
                patches.touch[a as usize].insert(b);
                patches.touch[b as usize].insert(a);
            }
        }
        patches
    }

    fn open(&mut self, label: u16, component: u32) {
        self.label.push(label);
        self.component.push(component);
        self.area.push(0.0);
        self.touch.push(BTreeSet::new());
        *self.count.entry((component, label)).or_default() += 1;
    }

    /// Gives the smallest patch of a part that has several to the touching part with the largest
    /// area in the component, until no part has several (or none of its patches touches another).
    fn refine(mut self, area: &[Vec<f64>], labels: &mut [u16]) {
        let mut area = area.to_vec();
        let mut queue: BTreeSet<(u64, u32)> =
            self.area.iter().zip(0u32..).map(|(a, p)| (a.to_bits(), p)).collect();
        let mut owner: Vec<u32> = (0..self.label.len() as u32).collect();
        while let Some((size, patch)) = queue.pop_first() {
            let p = patch as usize;
            if owner[p] != patch || self.area[p].to_bits() != size {
                continue;
            }
            let key = (self.component[p], self.label[p]);
            if self.count[&key] < 2 {
                continue;
            }
            let of_part = &mut area[self.component[p] as usize];
            let best = self.touch[p].iter().map(|&t| self.label[t as usize]).max_by(|&a, &b| {
                let by_area = of_part[usize::from(a)].total_cmp(&of_part[usize::from(b)]);
                by_area.then(b.cmp(&a))
            });
            let Some(best) = best else { continue };
            of_part[usize::from(self.label[p])] -= self.area[p];
            of_part[usize::from(best)] += self.area[p];
            *self.count.entry(key).or_default() -= 1;
            let merged = self.merge(patch, best, &mut owner);
            queue.insert((self.area[merged as usize].to_bits(), merged));
        }
        for (label, &patch) in labels.iter_mut().zip(&self.of_face) {
            let mut p = patch;
            while owner[p as usize] != p {
                p = owner[p as usize];
            }
            *label = self.label[p as usize];
        }
    }

    /// Relabels a patch and joins it with all touching patches of that label; gives the joined one.
    fn merge(&mut self, patch: u32, label: u16, owner: &mut [u32]) -> u32 {
        let component = self.component[patch as usize];
        self.label[patch as usize] = label;
        let same = |t: &&u32| self.label[**t as usize] == label;
        let joined: Vec<u32> = self.touch[patch as usize].iter().filter(same).copied().collect();
        *self.count.entry((component, label)).or_default() -= joined.len().saturating_sub(1);
        for other in joined {
            owner[other as usize] = patch;
            self.area[patch as usize] += self.area[other as usize];
            for next in std::mem::take(&mut self.touch[other as usize]) {
                self.touch[next as usize].remove(&other);
                if next != patch {
                    self.touch[next as usize].insert(patch);
                    self.touch[patch as usize].insert(next);
                }
            }
        }
        patch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of unit squares side by side, two faces each; `gaps` start a new component.
    fn strip(squares: usize, gaps: &[usize]) -> Mesh {
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        let mut x = 0.0;
        for i in 0..squares {
            x += if gaps.contains(&i) { 5.0 } else { 1.0 };
            let start = vertices.len() as u32;
            for (dx, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                vertices.push(DVec3::new(x + dx, y, 0.0));
            }
            faces.extend([[start, start + 1, start + 2], [start, start + 2, start + 3]]);
        }
        Mesh::new(vertices, faces).unwrap()
    }

    fn labels(mesh: &Mesh, votes: &[(u32, u16)], mode: Mode) -> Vec<u16> {
        let face: Vec<u32> = votes.iter().map(|v| v.0).collect();
        let part: Vec<u16> = votes.iter().map(|v| v.1).collect();
        let votes = FaceVotes { face: &face, part: &part, parts: 3 };
        label_faces(mesh, &Weld::new(mesh), votes, mode)
    }

    #[test]
    fn a_face_takes_the_part_of_most_of_its_points_and_the_lowest_of_equals() {
        let mesh = strip(2, &[1]);
        let votes = [(0, 2), (0, 1), (0, 2), (1, 2), (2, 2), (2, 1), (3, 1)];
        assert_eq!(labels(&mesh, &votes, Mode::Refined), [2, 2, 1, 1]);
    }

    #[test]
    fn faces_without_points_take_their_neighbours_part() {
        let mesh = strip(6, &[5]);
        let found = labels(&mesh, &[(0, 1), (9, 2)], Mode::Refined);
        assert_eq!(found[..2], [1, 1]);
        assert_eq!(found[8..10], [2, 2]);
        assert_eq!(found[10..], [2, 2], "the island takes the nearest through space");
    }

    #[test]
    fn strict_makes_a_component_one_part_and_refined_keeps_one_patch_of_each() {
        let mesh = strip(9, &[]);
        let votes: Vec<(u32, u16)> = [0, 0, 1, 0, 0, 1, 1, 2, 1]
            .iter()
            .zip(0u32..)
            .flat_map(|(&l, i)| [(2 * i, l), (2 * i + 1, l)])
            .collect();
        let strict = labels(&mesh, &votes, Mode::Strict);
        assert!(strict.iter().all(|&l| l == 0), "equal areas: the lowest; {strict:?}");
        let refined = labels(&mesh, &votes, Mode::Refined);
        let squares: Vec<u16> = refined.iter().step_by(2).copied().collect();
        assert_eq!(squares, [0, 0, 0, 0, 0, 1, 1, 2, 2], "{refined:?}");
        assert_eq!(labels(&mesh, &votes, Mode::Automatic), refined);
    }

    #[test]
    fn nearly_whole_components_are_made_whole() {
        let mesh = strip(11, &[10]);
        let mut votes: Vec<(u32, u16)> = (0..20).map(|f| (f, 1)).collect();
        votes[3].1 = 2;
        votes.extend([(20, 2), (21, 2)]);
        let found = labels(&mesh, &votes, Mode::Automatic);
        assert!(found[..20].iter().all(|&l| l == 1));
        assert_eq!(found[20..], [2, 2]);
    }
}
