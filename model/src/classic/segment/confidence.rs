//! How likely each part is of each face, as the fitted models have it, and what that says of the parts that
//! were found.

use std::collections::BTreeMap;

use object::{DVec3, Mesh};

use crate::classic::segment::classify::Probabilities;

/// What is told of a part that was found, in order.
pub(crate) const NAMES: [&str; 13] = [
    "expected_iou",
    "own_chance",
    "own_doubtful",
    "own_margin",
    "missed",
    "others_least",
    "others_mean",
    "share",
    "share_to_alike",
    "faces",
    "pieces",
    "largest_piece",
    "fused",
];
/// How many numbers that are.
pub(crate) const COUNT: usize = NAMES.len();
/// The number of [`NAMES`] that says what is worth most alone.
pub(crate) const EXPECTED: usize = 0;
/// Another part is worth a word from this chance on; a guess.
const SOME: f64 = 0.1;
/// What is less likely than this is doubtful.
const DOUBTFUL: f64 = 0.7;

/// Class probabilities of a surface whose faces fall into regions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Confidence {
    /// The region of each face; empty where nothing was asked.
    pub region_of_face: Vec<u32>,
    /// For each region, how likely each part is, cuts averaged.
    pub rows: Probabilities,
}

impl Confidence {
    /// How likely each face is of the part it was given, 0 to 1; 1 where nothing was asked.
    pub(super) fn of_all(&self, part_of_face: &[u16]) -> Vec<f32> {
        let one = |(face, &part): (usize, &u16)| {
            let row = self.region_of_face.get(face).and_then(|&r| self.rows.get(r as usize));
            let chance = row.map_or(1.0, |row| row.get(usize::from(part)).copied().unwrap_or(0.0));
            chance.clamp(0.0, 1.0)
        };
        part_of_face.iter().enumerate().map(one).collect()
    }

    /// The chances of all parts at a face.
    fn row(&self, face: usize) -> &[f32] {
        let row = self.region_of_face.get(face).and_then(|&r| self.rows.get(r as usize));
        row.map_or(&[], |row| row)
    }
}

/// A piece of a part that may be another part's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Doubtful {
    /// The other part.
    pub other: usize,
    /// How likely the piece is of that, 0 to 1.
    pub chance: f64,
    /// How large it is, as a share of the part's surface.
    pub share: f64,
    /// A point on it.
    pub at: DVec3,
}

/// What is said of the parts that were found.
pub(crate) struct Found<'a> {
    /// The surface.
    pub mesh: &'a Mesh,
    /// The area of each face, any unit.
    pub areas: &'a [f64],
    /// The connected component of each face.
    pub component: &'a [u32],
    /// The part each was given.
    pub part_of_face: &'a [u16],
    /// How likely each is of that part.
    pub own: &'a [f32],
    /// How likely each part is of each face.
    pub chances: &'a Confidence,
    /// What other ways make of the same surface.
    pub others: &'a [Vec<u16>],
    /// How much of the surface is one fused mesh over several parts, 0 to 1.
    pub fused: f64,
    /// For each part, which parts are called alike, itself among them.
    pub alike: &'a [Vec<usize>],
}

impl Found<'_> {
    /// The numbers of [`NAMES`] for each part.
    pub(crate) fn numbers(&self) -> Vec<[f64; COUNT]> {
        let parts = self.alike.len();
        let all: f64 = self.areas.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let mut sums = vec![Sums::default(); parts];
        for (face, (&area, &part)) in self.areas.iter().zip(self.part_of_face).enumerate() {
            let share = area / all;
            let row = self.chances.row(face);
            let own = f64::from(self.own[face]);
            for (other, sum) in sums.iter_mut().enumerate() {
                let is_own = other == usize::from(part);
                let said = row.get(other).map_or(0.0, |c| f64::from(*c));
                sum.expected += share * if is_own { own } else { said.min(1.0 - own) };
            }
            let next = row.iter().enumerate().filter(|(p, _)| *p != usize::from(part));
            let next = next.map(|(_, c)| f64::from(*c)).fold(0.0, f64::max);
            let Some(sum) = sums.get_mut(usize::from(part)) else { continue };
            sum.area += share;
            sum.own += share * own;
            sum.margin += share * (own - next);
            sum.doubtful += if own < DOUBTFUL { share } else { 0.0 };
            sum.faces += 1.0;
            *sum.pieces.entry(self.component[face]).or_default() += share;
        }
        let agreed: Vec<Vec<f64>> = self.others.iter().map(|o| self.agreement(o, parts)).collect();
        (0..parts).map(|part| self.of_part(part, &sums, &agreed)).collect()
    }

    /// For each part, the piece of it that most of another part may be lost in: faces of one component whose
    /// second likeliest part is the same.
    pub(crate) fn doubts(&self) -> Vec<Option<Doubtful>> {
        let mut own = vec![0.0; self.alike.len()];
        let mut pieces: BTreeMap<(usize, usize, u32), Piece> = BTreeMap::new();
        for (face, (&area, &part)) in self.areas.iter().zip(self.part_of_face).enumerate() {
            let part = usize::from(part);
            own[part] += area;
            if self.own[face] >= 1.0 {
                continue;
            }
            let row = self.chances.row(face).iter().enumerate().filter(|(p, _)| *p != part);
            let likelier = |a: (usize, f32), b: (usize, f32)| if b.1 > a.1 { b } else { a };
            let next = row.map(|(p, c)| (p, *c)).reduce(likelier);
            let Some((other, chance)) = next.filter(|(_, c)| f64::from(*c) >= SOME) else {
                continue;
            };
            let piece = pieces.entry((part, other, self.component[face])).or_default();
            let weight = area * f64::from(chance);
            piece.area += area;
            piece.weight += weight;
            piece.middle += self.mesh.centroid(face) * weight;
            piece.faces.push(face);
        }
        let mut doubts: Vec<Option<(f64, Doubtful)>> = vec![None; own.len()];
        for ((part, other, _), piece) in pieces {
            let middle = piece.middle / piece.weight;
            let off = |face: &usize| self.mesh.centroid(*face).distance_squared(middle);
            let nearest = piece.faces.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            let Some(&face) = nearest else { continue };
            let (share, chance) = (piece.area / own[part], piece.weight / piece.area);
            let doubt = Doubtful { other, chance, share, at: self.mesh.centroid(face) };
            if doubts[part].is_none_or(|(most, _)| piece.weight > most) {
                doubts[part] = Some((piece.weight, doubt));
            }
        }
        doubts.into_iter().map(|doubt| doubt.map(|d| d.1)).collect()
    }

    fn of_part(&self, part: usize, sums: &[Sums], agreed: &[Vec<f64>]) -> [f64; COUNT] {
        let sum = &sums[part];
        let area = sum.area.max(f64::MIN_POSITIVE);
        let missed = (sum.expected - sum.own).max(0.0);
        let of_others = agreed.iter().map(|ious| ious[part]);
        let least = of_others.clone().fold(1.0, f64::min);
        let mean = of_others.sum::<f64>() / agreed.len().max(1) as f64;
        let largest = sum.pieces.values().copied().fold(0.0, f64::max);
        let mut alike: Vec<f64> = self.alike[part].iter().map(|&p| sums[p].area).collect();
        alike.sort_by(f64::total_cmp);
        let usual = alike.get(alike.len() / 2).copied().unwrap_or(area).max(f64::MIN_POSITIVE);
        [
            sum.own / (area + missed),
            sum.own / area,
            sum.doubtful / area,
            sum.margin / area,
            missed / area,
            least,
            mean,
            sum.area,
            (area / usual).clamp(1e-3, 1e3).ln(),
            (1.0 + sum.faces).ln(),
            (1.0 + sum.pieces.len() as f64).ln(),
            largest / area,
            self.fused,
        ]
    }

    /// How much other labels agree about each part: intersection over union by area.
    fn agreement(&self, other: &[u16], parts: usize) -> Vec<f64> {
        let (mut both, mut either) = (vec![0.0; parts], vec![0.0; parts]);
        for ((&a, &b), &area) in self.part_of_face.iter().zip(other).zip(self.areas) {
            let (a, b) = (usize::from(a), usize::from(b));
            if a == b {
                both[a] += area;
                either[a] += area;
            } else {
                either[a] += area;
                either[b] += area;
            }
        }
        let iou = |(both, either): (&f64, &f64)| if *either > 0.0 { both / either } else { 1.0 };
        both.iter().zip(&either).map(iou).collect()
    }
}

/// Faces that may be of one other part.
#[derive(Clone, Debug, Default)]
struct Piece {
    area: f64,
    /// The area that other part is expected to have of it.
    weight: f64,
    middle: DVec3,
    faces: Vec<usize>,
}

/// Sums over the faces of a part; areas are shares of the surface.
#[derive(Clone, Debug, Default)]
struct Sums {
    area: f64,
    /// The area it would have if every chance came true.
    expected: f64,
    own: f64,
    margin: f64,
    doubtful: f64,
    faces: f64,
    pieces: BTreeMap<u32, f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(name: &str) -> usize {
        NAMES.iter().position(|n| *n == name).unwrap()
    }

    /// Four faces of area 1, in a row, in two components: two of the base, two of part 1, of which one is
    /// doubtful.
    fn told<T>(others: &[Vec<u16>], ask: impl FnOnce(&Found) -> T) -> T {
        let corner = |i: u32, x: f64, y: f64| DVec3::new(f64::from(i) + x, y, 0.0);
        let corners =
            (0..4).flat_map(|i| [corner(i, 0., 0.), corner(i, 1., 0.), corner(i, 0., 2.)]);
        let faces = (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh::new(corners.collect(), faces).unwrap();
        let rows = vec![vec![0.9, 0.1], vec![0.2, 0.8], vec![0.5, 0.5]];
        let chances = Confidence { region_of_face: vec![0, 0, 1, 2], rows };
        let part_of_face = [0, 0, 1, 1];
        let own = chances.of_all(&part_of_face);
        let (areas, component) = ([1.0; 4], [0, 0, 1, 1]);
        let alike = [vec![0], vec![1]];
        let found = Found {
            mesh: &mesh,
            areas: &areas,
            component: &component,
            part_of_face: &part_of_face,
            own: &own,
            chances: &chances,
            others,
            fused: 0.0,
            alike: &alike,
        };
        ask(&found)
    }

    #[test]
    fn what_a_part_is_expected_to_share_with_the_truth_follows_from_chances() {
        let told = told(&[], |found| found.numbers());
        // Of part 1: 0.8 and 0.5 of its own two faces, and 0.1 of each of the base's.
        let expected = told[1][number("expected_iou")];
        assert!((expected - 1.3 / 2.2).abs() < 1e-6, "{expected}");
        assert!((told[1][number("own_doubtful")] - 0.5).abs() < 1e-9);
        assert!((told[1][number("missed")] - 0.1).abs() < 1e-6);
        assert!((told[0][number("own_margin")] - 0.8).abs() < 1e-6);
    }

    #[test]
    fn other_labellings_agree_as_far_as_their_areas_overlap() {
        let told = told(&[vec![0, 0, 1, 1], vec![0, 0, 0, 1]], |found| found.numbers());
        assert_eq!([told[1][number("others_least")], told[1][number("others_mean")]], [0.5, 0.75]);
        assert_eq!(told[0][number("others_least")], 2.0 / 3.0);
    }

    #[test]
    fn a_piece_that_may_be_another_part_s_is_named_with_its_place() {
        let doubts = told(&[], |found| found.doubts());
        let doubt = doubts[1].unwrap();
        assert_eq!((doubt.other, doubt.share), (0, 1.0));
        assert!((doubt.chance - 0.35).abs() < 1e-6, "{doubt:?}");
        // Nearer the face that is more doubtful.
        assert!(doubt.at.x > 3.0, "{doubt:?}");
    }
}
