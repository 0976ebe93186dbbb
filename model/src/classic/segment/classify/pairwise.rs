//! Features of two neighbouring segments: they tell whether both are of one part, whatever part
//! that is.

use std::collections::BTreeMap;

use crate::classic::segment::classify::facts::{
    Known, SegmentFacts, alike_sides, coaxial, flush, gap, overlap,
};
use crate::classic::segment::grow::merge::Link;
use crate::classic::segment::oversegment::contact::{REACH, Touch};
use crate::classic::segment::oversegment::patches::Seam;
use crate::classic::segment::prompts::shape;
use crate::classic::segment::prompts::shape::{SHAPE_FEATURES, same};

/// Features of two segments beside what each looks like.
const BETWEEN: usize = 52;
/// All features of two segments.
pub const PAIR_FEATURES: usize = BETWEEN + 2 * SHAPE_FEATURES;
/// What is known of two segments, the smaller one first.
pub type PairFeatures = [f32; PAIR_FEATURES];
/// What the features beside each one's looks are called, in order.
const BETWEEN_NAMES: [&str; BETWEEN] = [
    "drawn_alike_by_looks",
    "drawn_as_one_by_looks",
    "drawn_alike_by_nearness",
    "drawn_as_one_by_nearness",
    "part_count",
    "segment_count",
    "small.touch_depth",
    "small.touch_apart",
    "small.touch_spot",
    "small.touch_flat",
    "small.touching",
    "small.inside",
    "small.reaching",
    "large.touch_depth",
    "large.touch_apart",
    "large.touch_spot",
    "large.touch_flat",
    "large.touching",
    "large.inside",
    "large.reaching",
    "gap",
    "evidence",
    "seam_groove_share",
    "seam_ridge_share",
    "seam_groove",
    "seam_ridge",
    "seam_by_size",
    "seam_length",
    "seam_of_small",
    "seam_of_large",
    "small.fill",
    "large.fill",
    "small.coaxial",
    "large.coaxial",
    "flush",
    "alike_sides",
    "is_copy",
    "normals",
    "centre_distance",
    "box_distance",
    "small_in_large",
    "large_in_small",
    "size_ratio",
    "merged_as_one",
    "small.has_prompt",
    "large.has_prompt",
    "copies_here",
    "small.rank",
    "large.rank",
    "evidence_lead",
    "neighbour_count",
    "common_neighbours",
];

/// What the features of two segments are called, in order: the pairwise features.
pub fn names() -> Vec<String> {
    let shape = |whose: &'static str| shape::NAMES.iter().map(move |n| format!("{whose}.{n}"));
    let between = BETWEEN_NAMES.iter().map(ToString::to_string);
    between.chain(shape("small")).chain(shape("large")).collect()
}

/// Most neighbours that count.
const CROWD: f64 = 50.0;
/// Most evidence that counts, either way.
const MOST: f64 = 8.0;
/// Lengths and areas below this are none, metres and m².
const LEAST: f64 = 1e-12;
/// What is said of the seam of segments that have none.
const NO_SEAM: Seam = Seam { length: 0.0, concave: -1.0, convex: -1.0, sharp: 0.0, ridge: 0.0 };

/// Two segments that touch or nearly touch.
#[derive(Clone, Debug)]
pub struct SegmentPair {
    /// The smaller segment.
    pub small: u32,
    /// The larger segment.
    pub large: u32,
    /// What is known of both.
    pub features: PairFeatures,
}

/// The pairs of all links, in their order, each pair once.
pub(crate) fn segment_pairs_of(
    known: &Known<'_>,
    segments: &[SegmentFacts],
    (drawn, diagonal): (&[[Vec<f32>; 2]], f64),
) -> Vec<SegmentPair> {
    let mut links: BTreeMap<(u32, u32), Link> = BTreeMap::new();
    for link in known.links.iter().filter(|l| l.a != l.b) {
        let pair = (link.a.min(link.b), link.a.max(link.b));
        let best = links.entry(pair).or_insert(*link);
        if link.evidence > best.evidence {
            *best = *link;
        }
    }
    let mut around = vec![Vec::new(); segments.len()];
    for (&(a, b), link) in &links {
        around[a as usize].push((b, link.evidence));
        around[b as usize].push((a, link.evidence));
    }
    let mut seamed = vec![0.0; segments.len()];
    for (&(a, b), seam) in &known.cut.seams {
        seamed[a as usize] += seam.length;
        seamed[b as usize] += seam.length;
    }
    let ground = Ground { known, segments, drawn, diagonal, around, seamed };
    links.iter().map(|(&pair, link)| ground.segment_pair(pair, link)).collect()
}

struct Ground<'a> {
    known: &'a Known<'a>,
    segments: &'a [SegmentFacts],
    /// Which parts draw each segment, by looks and by nearness.
    drawn: &'a [[Vec<f32>; 2]],
    diagonal: f64,
    /// The neighbours of each segment in order, with the evidence of the border.
    around: Vec<Vec<(u32, f64)>>,
    /// Length of all seams of each segment.
    seamed: Vec<f64>,
}

impl Ground<'_> {
    fn segment_pair(&self, (a, b): (u32, u32), link: &Link) -> SegmentPair {
        let area = |i: u32| self.segments[i as usize].mass.area;
        let (small, large) = if area(a) <= area(b) { (a, b) } else { (b, a) };
        let pair = Pair {
            small,
            large,
            facts: [small, large].map(|i| &self.segments[i as usize]),
            touches: [(small, large), (large, small)]
                .map(|pair| self.known.touches.get(&pair).copied().unwrap_or(Touch::NONE)),
            seam: self.known.cut.seams.get(&(a, b)).copied().unwrap_or(NO_SEAM),
            evidence: link.evidence,
        };
        let [small_looks, large_looks] = pair.facts.map(|p| &p.shape);
        let all = self.drawn_alike(&pair).into_iter().chain(self.contact(&pair));
        let all = all.chain(self.seam(&pair)).chain(self.shapes(&pair)).chain(self.company(&pair));
        let mut features = [0.0; PAIR_FEATURES];
        let all = all.chain(small_looks.iter().copied()).chain(large_looks.iter().copied());
        features.iter_mut().zip(all).for_each(|(n, x)| *n = x as f32);
        SegmentPair { small, large, features }
    }

    /// Whether the same parts draw both segments, and how many parts and segments there are.
    fn drawn_alike(&self, pair: &Pair) -> [f64; 6] {
        let alike = |by: usize| {
            let [a, b] = [pair.small, pair.large].map(|i| &self.drawn[i as usize][by]);
            let both = a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>();
            let best =
                |row: &[f32]| (0..row.len()).reduce(|x, y| if row[y] > row[x] { y } else { x });
            [both, flag(best(a) == best(b))]
        };
        let [[traits, looked], [near, nearest]] = [alike(0), alike(1)];
        let parts = self.drawn[pair.small as usize][0].len() as f64;
        [traits, looked, near, nearest, parts.ln(), (self.segments.len() as f64).ln()]
    }

    /// How both touch: seen from the small segment and from the large one, how deep, how far apart, over
    /// how large a spot, how flat that is, and what share of the surface touches, is inside, is near.
    fn contact(&self, pair: &Pair) -> [f64; 16] {
        let [small, large] = pair.facts;
        let size = small.mass.bounds.diagonal().max(LEAST);
        let seen = |t: &Touch, from: &SegmentFacts| {
            let touches = t.touching > 0.0;
            let apart = (t.reaching - t.inside).max(0.0);
            let share = |area: f64| (area / from.mass.area.max(LEAST)).min(1.0);
            [
                t.depth / self.diagonal,
                if apart > 0.0 { t.apart / apart / self.diagonal } else { -REACH },
                if touches { (t.bounds.diagonal() / size).min(5.0) } else { 0.0 },
                if touches { t.normal.length() / t.touching.max(LEAST) } else { -1.0 },
                share(t.touching),
                share(t.inside),
                share(t.reaching),
            ]
        };
        let [a, b] = &pair.touches;
        let (from_small, from_large) = (seen(a, small), seen(b, large));
        let gap = a.gap.min(b.gap) / (REACH * self.diagonal);
        let all = from_small
            .into_iter()
            .chain(from_large)
            .chain([gap.min(1.0), pair.evidence.clamp(-MOST, MOST)]);
        let mut features = [0.0; 16];
        features.iter_mut().zip(all).for_each(|(n, x)| *n = x);
        features
    }

    /// The border of two patches of one component.
    fn seam(&self, pair: &Pair) -> [f64; 8] {
        let (seam, [small, _]) = (&pair.seam, pair.facts);
        let of = |segment: u32| seam.length / self.seamed[segment as usize].max(LEAST);
        [
            seam.sharp,
            seam.ridge,
            seam.concave,
            seam.convex,
            (seam.length / small.mass.area.max(LEAST).sqrt()).min(20.0),
            seam.length / self.diagonal,
            of(pair.small),
            of(pair.large),
        ]
    }

    /// How both lie to each other and how alike they are.
    fn shapes(&self, pair: &Pair) -> [f64; 14] {
        let ([s, l], diagonal) = (pair.facts, self.diagonal);
        let (sb, lb) = (&s.mass.bounds, &l.mass.bounds);
        [
            fill(s, diagonal),
            fill(l, diagonal),
            coaxial(s, l, diagonal),
            coaxial(l, s, diagonal),
            flush(s, l, diagonal),
            alike_sides(s, l),
            flag(same(&s.mass, &l.mass)),
            s.normal.dot(l.normal),
            s.mass.centre().distance(l.mass.centre()) / diagonal,
            gap(sb, lb) / diagonal,
            overlap(sb, lb),
            overlap(lb, sb),
            (s.share.max(1e-6) / l.share.max(1e-6)).ln(),
            flag(s.merged.is_some() && s.merged == l.merged),
        ]
    }

    /// Prompts on them, copies of the small one at the large one too, and how this border stands among
    /// those with other neighbours.
    fn company(&self, pair: &Pair) -> [f64; 8] {
        let Pair { small, large, facts: [s, l], evidence, .. } = *pair;
        let around = |of: u32| &self.around[of as usize];
        let twins = s.copies.iter().filter(|&&c| self.meets(c, large)).count() as f64;
        let rank = |of: u32, other: u32| {
            let better = around(of).iter().filter(|n| n.0 != other && n.1 > evidence).count();
            (better as f64).min(CROWD)
        };
        let rest = around(small).iter().filter(|n| n.0 != large).map(|n| n.1);
        let common = around(small).iter().filter(|n| self.meets(n.0, large)).count() as f64;
        [
            flag(s.seed.is_some()),
            flag(l.seed.is_some()),
            (1.0 + twins).ln(),
            rank(small, large),
            rank(large, small),
            (evidence - rest.fold(-MOST, f64::max)).clamp(-MOST, MOST),
            (around(small).len() as f64).min(CROWD).ln(),
            common.min(CROWD),
        ]
    }

    fn meets(&self, a: u32, b: u32) -> bool {
        self.around[a as usize].binary_search_by_key(&b, |n| n.0).is_ok()
    }
}

/// Two segments and what passes between them.
struct Pair<'a> {
    small: u32,
    large: u32,
    /// The small one, then the large one.
    facts: [&'a SegmentFacts; 2],
    /// Seen from the small one, then from the large one.
    touches: [Touch; 2],
    seam: Seam,
    evidence: f64,
}

fn flag(is: bool) -> f64 {
    f64::from(u8::from(is))
}

/// How much of its box's sides a segment's surface would cover: 0.5 to 1 for a box, less for a frame.
fn fill(segment: &SegmentFacts, diagonal: f64) -> f64 {
    let d = segment.mass.bounds.size().max(object::DVec3::splat(1e-4 * diagonal));
    (segment.mass.area / (2.0 * (d.x * d.y + d.y * d.z + d.x * d.z))).min(5.0)
}
