//! Which side of a surface is its outer one. Many files draw every triangle twice, once each way round, so
//! that it is seen from anywhere; in others some faces, or all, are drawn as seen from within. What asks how
//! a surface turns, or where its outside is, wants every triangle once and from without.

use glamx::DVec3;
use rustc_hash::FxHashMap;

use crate::mesh::{Bounds, Mesh, MeshError};
use crate::sheets::{Join, Sheets};
use crate::weld::Weld;

/// A component is drawn on both sides if this share of its surface is; where two things touch, a few faces
/// may lie on each other as well. A mesh is drawn from within if sheets that enclose this share of its space
/// are.
const MOSTLY: f64 = 0.9;

/// A sheet that encloses no more than this share of its area^1.5 lies flat.
const FLAT: f64 = 1e-7;

/// The outer side of a mesh that has more to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OuterSide {
    /// The faces of that side, ascending, and whether each has to be turned round to look outward.
    pub faces: Vec<(usize, bool)>,
    /// For each face of the mesh, the place among [`Self::faces`] of the one that lies where it does.
    pub of_face: Vec<usize>,
}

impl OuterSide {
    /// The outer side of a mesh; `None` where that is the mesh as it is.
    ///
    /// What is turned are sheets: faces that go on into each other over edges where no third face
    /// meets them. Which way a sheet looks depends on how it is drawn:
    ///
    /// - drawn the same way all over: it stays so, unless the whole mesh is drawn from inside;
    /// - closed, or part of a component that is drawn on both sides: away from what it encloses, or
    ///   as its first face does where it lies flat;
    /// - any other: as most of its surface is drawn.
    pub fn of(mesh: &Mesh, weld: &Weld) -> Option<Self> {
        let (component, count) = weld.components();
        let spots = Spots::of(weld);
        let is_doubled = doubled(mesh, (&component, count), &spots);
        let (joins, is_border) = spots.joins();
        let sheets = Sheets::of(&joins);
        let outward =
            outward(&looks(mesh, &spots, (&sheets, &is_border), (&component, &is_doubled)));
        let stands = |face: usize| {
            let (spot, own) = (spots.of_face[face], is_doubled[component[face] as usize]);
            let there = &spots.all[spot];
            let outward = outward[sheets.of_face[spot] as usize];
            let outward = outward.map(|even| even != sheets.is_turned[spot]);
            match (outward, own) {
                (None, true) => (there.first(), false),
                (Some(even), false) if !there.is_doubled() => {
                    (face, is_even(weld.faces[face]) != even)
                }
                (_, false) => (face, false),
                (Some(even), true) => {
                    there.drawn(even).map_or((there.first(), true), |face| (face, false))
                }
            }
        };
        let stands: Vec<(usize, bool)> = (0..component.len()).map(stands).collect();
        let mut faces = stands.clone();
        faces.sort_unstable();
        faces.dedup();
        if faces.len() == component.len() && faces.iter().all(|(_, is_turned)| !is_turned) {
            return None;
        }
        let place = |face: &(usize, bool)| faces.binary_search(face).unwrap_or(0);
        let of_face = stands.iter().map(place).collect();
        Some(Self { faces, of_face })
    }

    /// That side as a mesh of its own, its faces in the order of [`Self::faces`].
    ///
    /// # Errors
    /// [`MeshError`] where the faces are not of this mesh.
    pub fn mesh(&self, mesh: &Mesh) -> Result<Mesh, MeshError> {
        let all = mesh.faces();
        let drawn = |&(face, is_turned): &(usize, bool)| {
            let [a, b, c] = all[face];
            if is_turned { [b, a, c] } else { [a, b, c] }
        };
        let faces: Vec<[u32; 3]> = self.faces.iter().map(drawn).collect();
        let count = faces.len();
        let side = Mesh::new(mesh.vertices().to_vec(), faces)?.with_frame(mesh.frame());
        side.with_colours(mesh.colours().map(<[_]>::to_vec))?.submesh(0..count)
    }
}

/// Whether a face goes round its places upward, from whichever it begins.
fn is_even([a, b, c]: [u32; 3]) -> bool {
    let mut places = [a, b, c];
    places.sort_unstable();
    [[a, b, c], [b, c, a], [c, a, b]].contains(&places)
}

/// Where a triangle lies, whichever way round.
#[derive(Clone, Copy, Debug)]
struct Spot {
    /// Its places, ascending.
    places: [u32; 3],
    /// The first face that lies there each way round, the even way first.
    ways: [Option<usize>; 2],
}

impl Spot {
    /// The first face that lies there.
    fn first(&self) -> usize {
        self.ways.iter().flatten().copied().min().unwrap_or(0)
    }

    /// Whether faces lie there both ways round.
    fn is_doubled(&self) -> bool {
        self.ways.iter().all(Option::is_some)
    }

    /// The first face that lies there the even way, or the other.
    fn drawn(&self, is_even: bool) -> Option<usize> {
        self.ways[usize::from(!is_even)]
    }
}

/// All spots of a mesh, in the order of their first faces.
struct Spots {
    all: Vec<Spot>,
    of_face: Vec<usize>,
}

impl Spots {
    fn of(weld: &Weld) -> Self {
        let (mut number, mut all) = (FxHashMap::default(), Vec::<Spot>::new());
        let mut of_face = Vec::with_capacity(weld.faces.len());
        for (face, &round) in weld.faces.iter().enumerate() {
            let mut places = round;
            places.sort_unstable();
            // A sliver has no sides.
            let sliver = (places[0] == places[1] || places[1] == places[2]).then_some(face);
            let spot = *number.entry((places, sliver)).or_insert(all.len());
            if spot == all.len() {
                all.push(Spot { places, ways: [None; 2] });
            }
            all[spot].ways[usize::from(!is_even(round))].get_or_insert(face);
            of_face.push(spot);
        }
        Self { all, of_face }
    }

    /// For each spot, those it goes on into over edges where no third one meets them, and whether it has
    /// any other edge.
    fn joins(&self) -> (Vec<Vec<Join>>, Vec<bool>) {
        let mut edges: Vec<([u32; 2], usize, bool)> = Vec::with_capacity(3 * self.all.len());
        for (spot, &Spot { places: [a, b, c], .. }) in self.all.iter().enumerate() {
            if a != b && b != c {
                edges.extend([([a, b], spot, true), ([b, c], spot, true), ([a, c], spot, false)]);
            }
        }
        edges.sort_unstable();
        let (mut joins, mut is_border) =
            (vec![Vec::new(); self.all.len()], vec![false; self.all.len()]);
        for around in edges.chunk_by(|a, b| a.0 == b.0) {
            if let &[(_, first, ahead), (_, second, other)] = around {
                let is_opposed = ahead == other;
                joins[first].push(Join { other: second as u32, is_opposed });
                joins[second].push(Join { other: first as u32, is_opposed });
            } else {
                around.iter().for_each(|&(_, spot, _)| is_border[spot] = true);
            }
        }
        (joins, is_border)
    }
}

/// Whether each component is drawn on both sides.
fn doubled(mesh: &Mesh, (component, count): (&[u32], usize), spots: &Spots) -> Vec<bool> {
    let (mut both, mut all) = (vec![0.0; count], vec![0.0; count]);
    for (face, &c) in component.iter().enumerate() {
        let area = mesh.area(face);
        all[c as usize] += area;
        let is_doubled = spots.all[spots.of_face[face]].is_doubled();
        both[c as usize] += if is_doubled { area } else { 0.0 };
    }
    both.iter().zip(&all).map(|(both, all)| *both > MOSTLY * all).collect()
}

/// How a sheet of spots looks, its first spot taken the even way.
#[derive(Clone, Copy, Debug)]
struct Look {
    /// Whether no edge of it is a border.
    is_closed: bool,
    /// Whether it has but one side.
    is_twisted: bool,
    /// Whether it is of a component that is drawn on both sides.
    is_doubled: bool,
    /// What it encloses, cubes of the mesh's unit, as seen from the middle of its component.
    encloses: f64,
    /// Its area, squares of the mesh's unit.
    area: f64,
    /// The areas that are drawn this way alone, and the other way alone.
    drawn: [f64; 2],
    /// Whether this is the way its first face is drawn.
    is_first: bool,
}

/// How each sheet of spots looks; `is_border` says of each spot whether an edge of it is one.
fn looks(
    mesh: &Mesh,
    spots: &Spots,
    (sheets, is_border): (&Sheets, &[bool]),
    (component, is_doubled): (&[u32], &[bool]),
) -> Vec<Look> {
    let middles = middles(mesh, component, is_doubled.len());
    let one = |(members, conflicts): (&Vec<u32>, &usize)| {
        let first = members.first().map_or(0, |&spot| spots.all[spot as usize].first());
        let own = component[first] as usize;
        let mut look = Look {
            is_closed: true,
            is_twisted: *conflicts > 0,
            is_doubled: is_doubled[own],
            encloses: 0.0,
            area: 0.0,
            drawn: [0.0; 2],
            is_first: members
                .first()
                .is_none_or(|&s| spots.all[s as usize].drawn(true) == Some(first)),
        };
        for spot in members.iter().map(|&spot| spot as usize) {
            let (there, along) = (&spots.all[spot], !sheets.is_turned[spot]);
            let at = there.first();
            look.is_closed &= !is_border[spot];
            look.area += mesh.area(at);
            let sign = if (there.drawn(true) == Some(at)) == along { 1.0 } else { -1.0 };
            let out = mesh.centroid(at) - middles[own];
            look.encloses += sign * out.dot(mesh.area_vector(at)) / 3.0;
            let drawn = [along, !along].map(|way| there.drawn(way).is_some());
            if drawn[0] != drawn[1] {
                look.drawn[usize::from(drawn[1])] += mesh.area(at);
            }
        }
        look
    };
    sheets.faces.iter().zip(&sheets.conflicts).map(one).collect()
}

/// For each sheet, whether it looks outward where its first spot is taken the even way; nothing where
/// nobody knows.
fn outward(sheets: &[Look]) -> Vec<Option<bool>> {
    let [mut without, mut within] = [0.0; 2];
    for sheet in sheets.iter().filter(|s| s.is_closed && !s.is_twisted) {
        let [along, against] = sheet.drawn;
        let drawn = (along - against) * sheet.encloses;
        let space = if along == against { 0.0 } else { sheet.encloses.abs() };
        *(if drawn < 0.0 { &mut within } else { &mut without }) += space;
    }
    let is_inside_out = within > MOSTLY * (within + without);
    let one = |sheet: &Look| {
        let [along, against] = sheet.drawn;
        let is_mixed = along > 0.0 && against > 0.0;
        if sheet.is_twisted {
            None
        } else if sheet.is_doubled || (sheet.is_closed && is_mixed) {
            let is_flat = sheet.encloses.abs() <= FLAT * sheet.area.powf(1.5);
            Some(if is_flat { sheet.is_first } else { sheet.encloses > 0.0 })
        } else {
            (along != against).then_some((along > against) != is_inside_out)
        }
    };
    sheets.iter().map(one).collect()
}

/// The middle of each component's box.
fn middles(mesh: &Mesh, component: &[u32], count: usize) -> Vec<DVec3> {
    let mut bounds = vec![Bounds::of([]); count];
    for (face, &c) in component.iter().enumerate() {
        let (own, all) = (Bounds::of(mesh.corners(face)), &mut bounds[c as usize]);
        *all = Bounds { min: all.min.min(own.min), max: all.max.max(own.max) };
    }
    bounds.iter().map(Bounds::centre).collect()
}

#[cfg(test)]
mod tests {
    use glamx::DVec3;

    use super::*;

    /// The twelve faces of a box, outward.
    fn cube(min: DVec3, max: DVec3) -> Vec<[DVec3; 3]> {
        let corner = |i: usize| {
            let pick = |k: usize| if i >> k & 1 == 1 { max[k] } else { min[k] };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
        quads.into_iter().flat_map(halves).map(|f| f.map(corner)).collect()
    }

    fn mesh(faces: &[[DVec3; 3]]) -> Mesh {
        Mesh::of_triangles(faces).unwrap()
    }

    fn turned(face: &[DVec3; 3]) -> [DVec3; 3] {
        [face[1], face[0], face[2]]
    }

    fn outer(mesh: &Mesh) -> Option<OuterSide> {
        OuterSide::of(mesh, &Weld::new(mesh))
    }

    fn as_drawn(faces: impl IntoIterator<Item = usize>) -> Vec<(usize, bool)> {
        faces.into_iter().map(|face| (face, false)).collect()
    }

    #[test]
    fn of_a_box_drawn_on_both_sides_the_outer_one_is_kept() {
        let once = cube(DVec3::splat(5.0), DVec3::splat(6.0));
        // Every third face stands there first as seen from within, and two are there three times.
        let first = |(i, f): (usize, &[DVec3; 3])| if i.is_multiple_of(3) { turned(f) } else { *f };
        let mut both: Vec<_> = once.iter().enumerate().map(first).collect();
        both.extend(once.iter().enumerate().map(|(i, f)| turned(&first((i, f)))));
        both.extend([once[4], turned(&once[7])]);
        let both = mesh(&both);
        let side = outer(&both).unwrap();
        assert_eq!(side.faces.len(), 12);
        let kept = side.mesh(&both).unwrap();
        assert!((kept.signed_volume() - 1.0).abs() < 1e-12, "{}", kept.signed_volume());
        for (face, &place) in side.of_face.iter().enumerate() {
            let there = kept.centroid(place);
            assert!(there.distance(both.centroid(face)) < 1e-12);
        }
    }

    #[test]
    fn what_is_drawn_once_is_left_alone_where_two_things_touch() {
        let low = cube(DVec3::ZERO, DVec3::ONE);
        let high = cube(DVec3::Z, DVec3::new(1.0, 1.0, 2.0));
        let stack = mesh(&[low, high].concat());
        assert_eq!(Weld::new(&stack).components().1, 1, "they share the edges of a face");
        assert_eq!(outer(&stack), None);
    }

    #[test]
    fn beside_what_is_drawn_on_both_sides_the_rest_stays() {
        let (once, far) =
            (cube(DVec3::ZERO, DVec3::ONE), cube(DVec3::splat(3.0), DVec3::splat(4.0)));
        let both: Vec<_> = far.iter().flat_map(|f| [turned(f), *f]).collect();
        let side = outer(&mesh(&[once, both].concat())).unwrap();
        let outward = (0..12).map(|i| 12 + 2 * i + 1);
        assert_eq!(side.faces, as_drawn((0..12).chain(outward)));
    }

    #[test]
    fn an_open_sheet_looks_away_from_the_middle() {
        // Three walls of a box, and slivers on both of their sides.
        let walls = &cube(DVec3::ZERO, DVec3::ONE)[..6];
        let mut both: Vec<_> = walls.iter().flat_map(|f| [turned(f), *f]).collect();
        both.push([DVec3::ZERO, DVec3::X, DVec3::X]);
        let side = outer(&mesh(&both)).unwrap();
        assert_eq!(side.faces, as_drawn([1, 3, 5, 7, 9, 11, 12]));
        assert_eq!(side.of_face, [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6]);
    }

    #[test]
    fn a_flat_sheet_looks_as_its_first_face_does() {
        let tilt = |p: DVec3| DVec3::new(p.x, p.y, 0.37 * p.x - 0.61 * p.y + 0.1);
        let wall = cube(DVec3::ZERO, DVec3::ONE)[2..4].to_vec();
        let once: Vec<_> = wall.iter().map(|face| face.map(tilt)).collect();
        for first in [turned as fn(&[DVec3; 3]) -> [DVec3; 3], |f| *f] {
            let second = |f: &[DVec3; 3]| turned(&first(f));
            let [a, b] = [&once[0], &once[1]];
            let drawn = mesh(&[first(a), second(b), second(a), first(b)]);
            assert_eq!(outer(&drawn).unwrap().faces, as_drawn([0, 3]));
        }
    }

    #[test]
    fn a_band_with_one_side_keeps_one_face_of_each_two() {
        let count = 12;
        let rail = |i: usize, side: f64| {
            let turn = i as f64 / count as f64 * std::f64::consts::TAU;
            let out = DVec3::new(turn.cos(), turn.sin(), 0.0);
            out * 2.0 + (out * (turn / 2.0).cos() + DVec3::Z * (turn / 2.0).sin()) * side
        };
        let piece = |i: usize| {
            // The last piece meets the first one upside down.
            let (a, b) = (rail(i, -0.5), rail(i, 0.5));
            let (c, d) = (rail(i + 1, -0.5), rail(i + 1, 0.5));
            [[a, b, c], [b, d, c]]
        };
        let once: Vec<_> = (0..count).flat_map(piece).collect();
        let both: Vec<_> = once.iter().flat_map(|f| [*f, turned(f)]).collect();
        let side = outer(&mesh(&both)).unwrap();
        assert_eq!(side.faces.len(), once.len());
    }

    /// Faces of a box, those of some numbers as seen from within.
    fn some_turned(is_turned: impl Fn(usize) -> bool, min: f64, max: f64) -> Vec<[DVec3; 3]> {
        let turn = |(i, f): (usize, [DVec3; 3])| if is_turned(i) { turned(&f) } else { f };
        cube(DVec3::splat(min), DVec3::splat(max)).into_iter().enumerate().map(turn).collect()
    }

    #[test]
    fn what_is_drawn_from_within_is_turned() {
        let some = |i: usize| i.is_multiple_of(3);
        for inside in [&some as &dyn Fn(usize) -> bool, &|_| true, &|i| !some(i)] {
            let drawn = mesh(&some_turned(inside, 2.0, 3.0));
            let side = outer(&drawn).unwrap();
            let expected: Vec<_> = (0..12).map(|i| (i, inside(i))).collect();
            assert_eq!((&side.faces, &side.of_face), (&expected, &(0..12).collect()));
            assert!((side.mesh(&drawn).unwrap().signed_volume() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_wall_of_a_hollow_looks_into_it() {
        let (once, hollow) = (some_turned(|_| false, 0.0, 3.0), some_turned(|_| true, 1.0, 2.0));
        assert_eq!(outer(&mesh(&[once, hollow].concat())), None);
        let (within, hollow) = (some_turned(|_| true, 0.0, 3.0), some_turned(|_| false, 1.0, 2.0));
        let side = outer(&mesh(&[within, hollow].concat())).unwrap();
        assert!(side.faces.iter().all(|(_, is_turned)| *is_turned), "{:?}", side.faces);
    }

    #[test]
    fn an_open_sheet_is_drawn_as_most_of_it_is() {
        let open = |is_turned: fn(usize) -> bool| mesh(&some_turned(is_turned, 0.0, 1.0)[..10]);
        assert_eq!(outer(&open(|_| true)), None, "nothing says which side is outside");
        let side = outer(&open(|i| i == 4)).unwrap();
        assert_eq!(side.faces, (0..10).map(|i| (i, i == 4)).collect::<Vec<_>>());
    }
}
