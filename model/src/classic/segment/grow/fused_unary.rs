//! What speaks for each part at each segment of a fused mesh: the distance to its prompt, its
//! plane, its size.

use object::{Condition, DVec3, Mesh};

use crate::classic::learned::pack::{Pack, PackError};
use crate::classic::learned::shipped::Shipped;
use crate::classic::lexicon::sizes::SizePrior;
use crate::classic::segment::grow::evidence::groove;
use crate::classic::segment::grow::merge::Link;
use crate::classic::segment::oversegment::flood::{around, costs_from};
use crate::classic::segment::oversegment::hurdles::Hurdles;
use crate::classic::segment::oversegment::segments::{Cut, Segment};
use crate::classic::segment::prompts::seeds::Seed;

/// How many features are known of a segment and a part.
pub const FEATURES: usize = 9;
/// Features of a segment and a part.
pub type Features = [f64; FEATURES];
/// What the features are called, in order.
pub const NAMES: [&str; FEATURES] = [
    "way_over_least",
    "prompt_distance",
    "way_along_surface",
    "deepest_groove",
    "size_within",
    "prompt_plane",
    "prompt_normal",
    "share_within",
    "base_share",
];

static SHIPPED: Shipped<Weights> = Shipped::new(
    "fused_unary",
    include_bytes!("../../../../weights/fused_unary.pack"),
    Weights::read,
);

/// What packs of this are called inside.
pub const KIND: &str = "fused_unary";
/// Their table of features: [`NAMES`].
pub const TABLE: &str = "segment and part";
/// The section of parts that are not the base, and that of the base.
pub const SECTIONS: [&str; 2] = ["child", "base"];
/// The setting that says the log-odds of the base beforehand.
pub const BASE_BIAS: &str = "base_bias";

/// What each number adds to the log-odds of a part: of a multinomial logistic regression; the pack says
/// on what.
#[derive(Debug, Default)]
struct Weights {
    child: Features,
    base: Features,
    base_bias: f64,
}

impl Weights {
    fn read(pack: &Pack<'_>) -> Result<Self, PackError> {
        pack.is(KIND)?;
        pack.asks(TABLE, &NAMES)?;
        let one = |section: &str| {
            let mut features = [0.0; FEATURES];
            features.copy_from_slice(&pack.numbers(section, FEATURES)?);
            Ok(features)
        };
        let [child, base] = SECTIONS;
        Ok(Self { child: one(child)?, base: one(base)?, base_bias: pack.setting(BASE_BIAS)? })
    }
}

/// Refuses a pack that this program cannot read.
pub(crate) fn check() -> Result<(), PackError> {
    SHIPPED.check()
}

/// The name and the digest of the pack.
pub(crate) fn digest_of_pack() -> (&'static str, String) {
    SHIPPED.digest()
}

/// Longest way over grooves that counts, and the shortest that does: what cannot be reached is
/// the longest.
const WAYS: (f64, f64) = (0.05, 50.0);
/// Longest way along the surface, as a share of the diagonal.
const LONGEST: f64 = 5.0;
/// Deepest groove that counts, radians.
const DEEPEST: f64 = 2.0;
/// Log-likelihood of a size, at least.
const UNLIKELY: f64 = -8.0;
/// Smallest share of the surface that is told from none.
const LEAST: f64 = 1e-6;
/// Most e-folds by which a way is longer than the shortest.
const LONGER: f64 = 5.0;
/// How far parts without a prompt are from everything.
const NOWHERE: f64 = 1e3;

/// A surface in segments, and what is asked about it.
pub(crate) struct FusedSurface<'a> {
    pub mesh: &'a Mesh,
    pub condition: &'a Condition,
    pub cut: &'a Cut,
    pub links: &'a [Link],
    pub seeds: &'a [Seed],
    pub priors: &'a [SizePrior],
}

/// For each segment and part, how little speaks for it: log-odds against.
pub(crate) fn against(fused_surface: &FusedSurface<'_>) -> Vec<Vec<f64>> {
    let root = fused_surface.condition.tree.root();
    let Weights { child, base, base_bias } = SHIPPED.get();
    let against = |(part, features): (usize, Option<Features>)| {
        let Some(x) = features else { return NOWHERE };
        if part == root { -base_bias - sum(base, &x) } else { -sum(child, &x) }
    };
    let row = |row: Vec<Option<Features>>| row.into_iter().enumerate().map(against).collect();
    features(fused_surface).into_iter().map(row).collect()
}

fn sum(weights: &Features, features: &Features) -> f64 {
    weights.iter().zip(features).map(|(w, x)| w * x).sum()
}

/// For each segment and part, what is known of the two; nothing of a part without a prompt.
pub(crate) fn features(fused_surface: &FusedSurface<'_>) -> Vec<Vec<Option<Features>>> {
    let ground = Ground::of(
        &fused_surface.cut.segments,
        fused_surface.links,
        fused_surface.mesh.bounds().diagonal(),
    );
    let parts = 0..fused_surface.condition.tree.len();
    let seeded = |n: u32| ground.segments[n as usize].seed.is_some();
    let hurdles = Hurdles::of(&ground.grooves, seeded);
    let sights = parts.map(|p| Sight::of(fused_surface, (&ground, &hurdles), p));
    let sights: Vec<_> = sights.collect();
    let row = |i: usize| {
        let way = |s: &Sight| s.way[i];
        let nearest = sights.iter().flatten().map(way).fold(f64::INFINITY, f64::min);
        let features = |s: &Option<Sight>| s.as_ref().map(|s| s.features(&ground, i, nearest));
        sights.iter().map(features).collect()
    };
    (0..fused_surface.cut.segments.len()).map(row).collect()
}

/// The links between segments, by what it costs to pass over them.
struct Ground<'a> {
    segments: &'a [Segment],
    diagonal: f64,
    /// Grooves and distances.
    barriers: Vec<Vec<(u32, f64)>>,
    /// Distances alone, as shares of the diagonal.
    distances: Vec<Vec<(u32, f64)>>,
    /// Depths of grooves alone, radians.
    grooves: Vec<Vec<(u32, f64)>>,
}

impl<'a> Ground<'a> {
    fn of(segments: &'a [Segment], links: &[Link], diagonal: f64) -> Self {
        let by = |cost: &dyn Fn(&Link) -> f64| {
            let ways: Vec<_> = links.iter().map(|l| (l.a, l.b, cost(l))).collect();
            around(segments.len(), &ways)
        };
        let centre = |p: u32| segments[p as usize].centre;
        let barriers = by(&|l| l.barrier.max(0.0));
        let distances = by(&|l| centre(l.a).distance(centre(l.b)) / diagonal);
        let grooves = by(&|l| groove(l.evidence));
        Self { segments, diagonal, barriers, distances, grooves }
    }
}

/// The surface seen from a part's prompt; one number of each kind per segment.
struct Sight {
    is_base: bool,
    prior: SizePrior,
    point: DVec3,
    normal: DVec3,
    /// ln of the cheapest way over grooves and distances.
    way: Vec<f64>,
    /// Shortest way along the surface, as a share of the diagonal.
    along: Vec<f64>,
    /// Deepest groove on the way, radians, where that is shallowest.
    hurdle: Vec<f64>,
    /// Share of the surface that is no farther away over grooves and distances.
    within: Vec<f64>,
}

impl Sight {
    /// Nothing where the part has no prompt.
    fn of(
        fused_surface: &FusedSurface<'_>,
        (ground, hurdles): (&Ground<'_>, &Hurdles<'_>),
        part: usize,
    ) -> Option<Self> {
        let seed = fused_surface.seeds.iter().find(|s| usize::from(s.part) == part)?;
        let (face, segments) = (seed.face as usize, ground.segments);
        let start = fused_surface.cut.of_face[face];
        let seeded = |n: u32| segments[n as usize].seed.is_some();
        let capped = |costs: Vec<f64>, most: f64| -> Vec<f64> {
            costs.into_iter().map(|c| c.min(most)).collect()
        };
        let (shortest, longest) = WAYS;
        let way = capped(costs_from(&ground.barriers, &[start], seeded), longest);
        let along = capped(costs_from(&ground.distances, &[start], |_| false), LONGEST);
        let hurdle = capped(hurdles.from(&[start]), DEEPEST);
        Some(Self {
            is_base: part == fused_surface.condition.tree.root(),
            prior: fused_surface.priors[part],
            point: fused_surface.condition.prompts[part]
                .point
                .unwrap_or(fused_surface.mesh.centroid(face)),
            normal: fused_surface.mesh.normal(face),
            within: within(&way, |i| segments[i].share),
            way: way.into_iter().map(|w| (w + shortest).ln()).collect(),
            along,
            hurdle,
        })
    }

    /// What is known of segment `i`; `nearest` is the least ln of its ways to any prompt.
    fn features(&self, ground: &Ground<'_>, i: usize, nearest: f64) -> Features {
        let segment = &ground.segments[i];
        let apart = segment.centre.distance(self.point) / ground.diagonal;
        let off = (segment.centre - self.point).dot(self.normal).abs() / ground.diagonal;
        [
            (self.way[i] - nearest).min(LONGER),
            (apart + 0.01).ln(),
            (self.along[i] + 0.02).ln(),
            self.hurdle[i],
            self.prior.score(self.within[i]).max(UNLIKELY),
            (off + 0.003).ln(),
            segment.normal.dot(self.normal),
            self.within[i].ln(),
            if self.is_base { segment.share.max(LEAST).ln() } else { 0.0 },
        ]
    }
}

/// For each segment, the share of the surface that is no farther away.
pub(crate) fn within(ways: &[f64], share: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..ways.len()).collect();
    order.sort_by(|&a, &b| ways[a].total_cmp(&ways[b]));
    let (mut within, mut sum) = (vec![0.0; ways.len()], 0.0);
    for i in order {
        sum += share(i);
        within[i] = f64::max(sum, LEAST);
    }
    within
}
