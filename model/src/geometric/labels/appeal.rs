//! What speaks for each part at each piece of a skin: the way to its prompt, its plane, its size.

use object::{Condition, DVec3, Mesh};

use super::super::pack::{Pack, PackError};
use super::super::shipped::Shipped;
use super::evidence::groove;
use super::flood::{around, costs_from, hurdles_from};
use super::lexicon::SizePrior;
use super::merge::Link;
use super::pieces::{Cut, Piece};
use super::seeds::Seed;

/// How many numbers are known of a piece and a part.
pub const NUMBERS: usize = 9;
/// Numbers of a piece and a part.
pub type Numbers = [f64; NUMBERS];
/// What the numbers are called, in order.
pub const NAMES: [&str; NUMBERS] = [
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

static SHIPPED: Shipped<Weights> =
    Shipped::new("fused_unary", include_bytes!("../../../weights/fused_unary.pack"), Weights::read);

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
    child: Numbers,
    base: Numbers,
    base_bias: f64,
}

impl Weights {
    fn read(pack: &Pack<'_>) -> Result<Self, PackError> {
        pack.is(KIND)?;
        pack.asks(TABLE, &NAMES)?;
        let one = |section: &str| {
            let mut numbers = [0.0; NUMBERS];
            numbers.copy_from_slice(&pack.numbers(section, NUMBERS)?);
            Ok(numbers)
        };
        let [child, base] = SECTIONS;
        Ok(Self { child: one(child)?, base: one(base)?, base_bias: pack.setting(BASE_BIAS)? })
    }
}

/// Refuses a pack that this program cannot read.
pub(super) fn check() -> Result<(), PackError> {
    SHIPPED.check()
}

/// The name and the digest of the pack.
pub(super) fn digest_of_pack() -> (&'static str, String) {
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

/// A surface in pieces, and what is asked about it.
pub(super) struct Skin<'a> {
    pub mesh: &'a Mesh,
    pub condition: &'a Condition,
    pub cut: &'a Cut,
    pub links: &'a [Link],
    pub seeds: &'a [Seed],
    pub priors: &'a [SizePrior],
}

/// For each piece and part, how little speaks for it: log-odds against.
pub(super) fn against(skin: &Skin<'_>) -> Vec<Vec<f64>> {
    let root = skin.condition.tree.root();
    let Weights { child, base, base_bias } = SHIPPED.get();
    let against = |(part, numbers): (usize, Option<Numbers>)| {
        let Some(x) = numbers else { return NOWHERE };
        if part == root { -base_bias - sum(base, &x) } else { -sum(child, &x) }
    };
    let row = |row: Vec<Option<Numbers>>| row.into_iter().enumerate().map(against).collect();
    numbers(skin).into_iter().map(row).collect()
}

fn sum(weights: &Numbers, numbers: &Numbers) -> f64 {
    weights.iter().zip(numbers).map(|(w, x)| w * x).sum()
}

/// For each piece and part, what is known of the two; nothing of a part without a prompt.
pub(super) fn numbers(skin: &Skin<'_>) -> Vec<Vec<Option<Numbers>>> {
    let ground = Ground::of(&skin.cut.pieces, skin.links, skin.mesh.bounds().diagonal());
    let parts = 0..skin.condition.tree.len();
    let sights: Vec<_> = parts.clone().map(|p| Sight::of(skin, &ground, p)).collect();
    let row = |i: usize| {
        let way = |s: &Sight| s.way[i];
        let nearest = sights.iter().flatten().map(way).fold(f64::INFINITY, f64::min);
        let numbers = |s: &Option<Sight>| s.as_ref().map(|s| s.numbers(&ground, i, nearest));
        sights.iter().map(numbers).collect()
    };
    (0..skin.cut.pieces.len()).map(row).collect()
}

/// The links between pieces, by what it costs to pass over them.
struct Ground<'a> {
    pieces: &'a [Piece],
    diagonal: f64,
    /// Grooves and distances.
    barriers: Vec<Vec<(u32, f64)>>,
    /// Distances alone, as shares of the diagonal.
    distances: Vec<Vec<(u32, f64)>>,
    /// Depths of grooves alone, radians.
    grooves: Vec<Vec<(u32, f64)>>,
}

impl<'a> Ground<'a> {
    fn of(pieces: &'a [Piece], links: &[Link], diagonal: f64) -> Self {
        let by = |cost: &dyn Fn(&Link) -> f64| {
            let ways: Vec<_> = links.iter().map(|l| (l.a, l.b, cost(l))).collect();
            around(pieces.len(), &ways)
        };
        let centre = |p: u32| pieces[p as usize].centre;
        let barriers = by(&|l| l.barrier.max(0.0));
        let distances = by(&|l| centre(l.a).distance(centre(l.b)) / diagonal);
        let grooves = by(&|l| groove(l.evidence));
        Self { pieces, diagonal, barriers, distances, grooves }
    }
}

/// The surface seen from a part's prompt; one number of each kind per piece.
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
    fn of(skin: &Skin<'_>, ground: &Ground<'_>, part: usize) -> Option<Self> {
        let seed = skin.seeds.iter().find(|s| usize::from(s.part) == part)?;
        let (face, pieces) = (seed.face as usize, ground.pieces);
        let start = skin.cut.of_face[face];
        let seeded = |n: u32| pieces[n as usize].seed.is_some();
        let capped = |costs: Vec<f64>, most: f64| -> Vec<f64> {
            costs.into_iter().map(|c| c.min(most)).collect()
        };
        let (shortest, longest) = WAYS;
        let way = capped(costs_from(&ground.barriers, start, seeded), longest);
        let along = capped(costs_from(&ground.distances, start, |_| false), LONGEST);
        let hurdle = capped(hurdles_from(&ground.grooves, start, seeded), DEEPEST);
        Some(Self {
            is_base: part == skin.condition.tree.root(),
            prior: skin.priors[part],
            point: skin.condition.prompts[part].point.unwrap_or(skin.mesh.centroid(face)),
            normal: skin.mesh.normal(face),
            within: within(&way, |i| pieces[i].share),
            way: way.into_iter().map(|w| (w + shortest).ln()).collect(),
            along,
            hurdle,
        })
    }

    /// What is known of piece `i`; `nearest` is the least ln of its ways to any prompt.
    fn numbers(&self, ground: &Ground<'_>, i: usize, nearest: f64) -> Numbers {
        let piece = &ground.pieces[i];
        let apart = piece.centre.distance(self.point) / ground.diagonal;
        let off = (piece.centre - self.point).dot(self.normal).abs() / ground.diagonal;
        [
            (self.way[i] - nearest).min(LONGER),
            (apart + 0.01).ln(),
            (self.along[i] + 0.02).ln(),
            self.hurdle[i],
            self.prior.score(self.within[i]).max(UNLIKELY),
            (off + 0.003).ln(),
            piece.normal.dot(self.normal),
            self.within[i].ln(),
            if self.is_base { piece.share.max(LEAST).ln() } else { 0.0 },
        ]
    }
}

/// For each piece, the share of the surface that is no farther away.
pub(super) fn within(ways: &[f64], share: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..ways.len()).collect();
    order.sort_by(|&a, &b| ways[a].total_cmp(&ways[b]));
    let (mut within, mut sum) = (vec![0.0; ways.len()], 0.0);
    for i in order {
        sum += share(i);
        within[i] = f64::max(sum, LEAST);
    }
    within
}
