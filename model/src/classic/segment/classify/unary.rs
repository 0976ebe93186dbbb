//! Features of a segment and a part: they tell whether the segment belongs to the part, given the
//! class probabilities so far.

use object::DVec3;
use object::mesh::Bounds;

use crate::classic::learned::forest::chances;
use crate::classic::learned::pack::place;
use crate::classic::lexicon::sizes::SizePrior;
use crate::classic::lexicon::words::{ROLE_NAMES, ROLES};
use crate::classic::segment::classify::affinity::{
    AFFINITY_FEATURES, AFFINITY_NAMES, Affinity, Prompted,
};
use crate::classic::segment::classify::facts::{
    Beside, Known, LEVEL, Probabilities, SegmentFacts, alike_sides, coaxial, flush, gap, overlap,
};
use crate::classic::segment::classify::pairwise::{SegmentPair, segment_pairs_of};
use crate::classic::segment::grow::fused_unary::within;
use crate::classic::segment::grow::merge::Link;
use crate::classic::segment::oversegment::contact::Touch;
use crate::classic::segment::oversegment::flood::{around, costs_from};
use crate::classic::segment::oversegment::hurdles::Hurdles;
use crate::classic::segment::oversegment::patches::Seam;
use crate::classic::segment::oversegment::units::measure;
use crate::classic::segment::prompts::placed::traits;
use crate::classic::segment::prompts::roles::PartTraits;
use crate::classic::segment::prompts::seeds::Seed;
use crate::classic::segment::prompts::shape;
use crate::classic::segment::prompts::shape::{
    Company, SHAPE_FEATURES, each_pair, look, roundness, same,
};

/// Features of a segment and a part that stay the same in all rounds.
const STEADY: usize = 29;
/// Those that follow from what is believed.
const ESTIMATED: usize = 13;
/// What is known of a part beside its shape.
const PART: usize = ROLES.len() + 4 + 4;
/// All features of a segment and a part.
pub const FEATURES: usize = STEADY + ESTIMATED + AFFINITY_FEATURES + 2 * SHAPE_FEATURES + PART;
/// What is known of a segment and a part.
pub type Features = [f32; FEATURES];
/// What the features that stay the same are called, in order.
const STEADY_NAMES: [&str; STEADY] = [
    "merged_here",
    "prompt_distance",
    "prompt_plane",
    "prompt_normal",
    "way_along_surface",
    "way_over_least",
    "way",
    "is_nearest",
    "weakest_border",
    "seed_centre_distance",
    "seed_box_distance",
    "seed_evidence",
    "seed_touches",
    "seed_inside",
    "seed_holds",
    "seed_contact",
    "box_in_seed",
    "seed_in_box",
    "size_to_seed",
    "is_seed_copy",
    "is_other_seed_copy",
    "seed_coaxial",
    "seed_flush",
    "seed_alike_sides",
    "parent_evidence",
    "child_evidence",
    "size_within",
    "share_within",
    "part_count",
];
/// What those that follow from class probabilities are called, in order.
const ESTIMATED_NAMES: [&str; ESTIMATED] = [
    "contact_agreed",
    "evidence_agreed",
    "best_border_agreed",
    "copies_agreed",
    "has_copies",
    "part_share",
    "size_gain",
    "box_in_part",
    "part_growth",
    "probability",
    "inside_part",
    "holds_part",
    "contact_with_part",
];
/// What is known of a part beside its role is called, in order.
const PART_NAMES: [&str; PART - ROLES.len()] = [
    "joint_hinge",
    "joint_slide",
    "joint_endless",
    "joint_none",
    "several_alike",
    "carries",
    "hangs_on_base",
    "is_base",
];

/// What the features of a segment and a part are called, in order: the unary features.
pub fn names() -> Vec<String> {
    let shape = |whose: &'static str| shape::NAMES.iter().map(move |n| format!("{whose}.{n}"));
    let all = STEADY_NAMES.iter().chain(&ESTIMATED_NAMES).chain(&AFFINITY_NAMES);
    let all = all.map(ToString::to_string).chain(shape("own")).chain(shape("seed"));
    all.chain(ROLE_NAMES.iter().chain(&PART_NAMES).map(ToString::to_string)).collect()
}
/// Evidence over a border that is not there.
const APART: f64 = -5.0;
/// Most evidence that counts, either way.
const MOST: f64 = 6.0;
/// Shortest and longest way that counts.
const WAYS: (f64, f64) = (0.05, 50.0);
/// Longest way along the surface, as a share of the diagonal.
const LONGEST: f64 = 5.0;
/// Most e-folds by which a way is longer than the shortest.
const LONGER: f64 = 5.0;
/// A seam counts as contact over a strip this wide, as a share of the diagonal.
const STRIP: f64 = 0.01;
/// Log-likelihood of a size, at least.
const UNLIKELY: f64 = -8.0;
/// Where the way to a part stands among what never changes.
const WAY: usize = place(&STEADY_NAMES, "way");
/// ln of a way that is longer than any.
const WAY_MOST: f64 = 5.0;
/// Smallest share of the surface that is told from none.
const LEAST: f64 = 1e-6;
/// What is believed this much is taken for true.
const LIKELY: f32 = 0.5;

/// A surface in segments and what is asked about each, ready for any class probabilities.
#[derive(Clone, Debug)]
pub struct Layout {
    segments: Vec<SegmentFacts>,
    parts: Vec<PartFacts>,
    /// For each segment and part with a prompt, what never changes.
    steady: Vec<Vec<Option<[f64; STEADY]>>>,
    /// Segments side by side.
    segment_pairs: Vec<SegmentPair>,
    affinity: Affinity,
    diagonal: f64,
}

#[derive(Clone, Debug)]
struct PartFacts {
    traits: PartTraits,
    prior: SizePrior,
    parent: Option<usize>,
    seeds: Vec<u32>,
}

impl Layout {
    pub(crate) fn of(known: &Known<'_>) -> Self {
        let diagonal = known.mesh.bounds().diagonal();
        let segments = segments(known, diagonal);
        let parts: Vec<PartFacts> = (0..known.condition.tree.len())
            .map(|part| {
                let is_own = |i: &u32| segments[*i as usize].seed == Some(part as u16);
                PartFacts {
                    traits: traits(known.condition, part),
                    prior: known.priors[part],
                    parent: known.condition.tree.parent(part),
                    seeds: (0..segments.len() as u32).filter(is_own).collect(),
                }
            })
            .collect();
        let (steady, segment_pairs, affinity) = (Vec::new(), Vec::new(), Affinity::default());
        let mut new = Self { segments, parts, steady, segment_pairs, affinity, diagonal };
        new.steady = new.steady(known);
        new.segment_pairs = segment_pairs_of(known, &new.segments, (&new.drawn(), diagonal));
        new
    }

    /// How many segments there are.
    pub fn len(&self) -> usize {
        self.segments.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty()
    }

    /// The part a prompt gives a segment, if any.
    pub fn seed(&self, segment: usize) -> Option<usize> {
        self.segments[segment].seed.map(usize::from)
    }

    /// The part that merging gives a segment, if any.
    pub(crate) fn merged(&self, segment: usize) -> Option<u16> {
        self.segments[segment].merged
    }

    /// A segment's share of the surface, 0 to 1.
    pub fn share(&self, segment: usize) -> f64 {
        self.segments[segment].share
    }

    /// A segment's box, object frame, metres.
    pub fn bounds(&self, segment: usize) -> &Bounds {
        &self.segments[segment].mass.bounds
    }

    /// The segments that a segment meets.
    pub fn beside(&self, segment: usize) -> impl Iterator<Item = usize> {
        self.segments[segment].around.iter().map(|b| b.segment as usize)
    }

    /// Segments that touch or nearly touch, and what is known of each two.
    pub fn segment_pairs(&self) -> &[SegmentPair] {
        &self.segment_pairs
    }

    /// How likely the segments of each pair are of one part, as last told.
    pub fn pair_chances(&self) -> &[f32] {
        self.affinity.chances()
    }

    /// The layout in the light of how likely the segments of each pair are of one part, 0 to 1.
    pub fn told_of_pairs(&mut self, chances: &[f32]) {
        let seed_of: Vec<Option<u16>> = self.segments.iter().map(|p| p.seed).collect();
        let parts: Vec<Prompted> =
            self.parts.iter().map(|p| Prompted { seeds: &p.seeds, parent: p.parent }).collect();
        self.affinity = Affinity::of((&self.segment_pairs, chances), &seed_of, &parts);
    }

    /// What the prompts say, and of other segments nothing.
    pub(crate) fn prompts(&self) -> Probabilities {
        self.told(|p| p.seed)
    }

    /// What is believed before anything is asked: what merging says.
    pub fn first(&self) -> Probabilities {
        self.told(|p| p.seed.or(p.merged))
    }

    fn told(&self, part_of: impl Fn(&SegmentFacts) -> Option<u16>) -> Probabilities {
        let row = |p: &SegmentFacts| {
            let is = |part: usize| f32::from(u8::from(part_of(p) == Some(part as u16)));
            (0..self.parts.len()).map(is).collect()
        };
        self.segments.iter().map(row).collect()
    }

    /// For each part, what is known of a segment and it; nothing of a part without a prompt, nor of one
    /// that by its words is far too small for the segment where another part is not.
    pub fn features(&self, segment: usize, clusters: &Clusters) -> Vec<Option<Features>> {
        self.each_features(segment, clusters).collect()
    }

    /// The same, part by part.
    pub(crate) fn each_features(
        &self,
        segment: usize,
        clusters: &Clusters,
    ) -> impl Iterator<Item = Option<Features>> {
        let share = self.segments[segment].share;
        let may = move |part: usize| self.parts[part].prior.allows(share);
        let is_asked = |part: usize| self.steady[segment][part].is_some();
        let some_may = (0..self.parts.len()).any(|part| is_asked(part) && may(part));
        let best = self.affinity.best(segment, clusters.probabilities);
        let one = move |part: usize| {
            if some_may && !may(part) {
                return None;
            }
            let steady = self.steady[segment][part].as_ref()?;
            let first = *self.parts[part].seeds.first()? as usize;
            let estimated = self.estimated(segment, part, clusters);
            let look = &self.parts[part].traits;
            let mut told = [0.0; PART];
            told[look.role.min(ROLES.len() - 1)] = 1.0;
            told[ROLES.len() + look.joint.min(3)] = 1.0;
            let flags = [look.like > 1, look.carries, look.hangs_on_base, look.is_base];
            for (t, flag) in told[ROLES.len() + 4..].iter_mut().zip(flags) {
                *t = f64::from(u8::from(flag));
            }
            let shapes = self.segments[segment].shape.iter().chain(&self.segments[first].shape);
            let affinity = self.affinity.features((segment, part), clusters.probabilities, &best);
            let all = steady.iter().chain(&estimated).chain(&affinity).chain(shapes).chain(&told);
            let mut features = [0.0; FEATURES];
            features.iter_mut().zip(all).for_each(|(n, x)| *n = *x as f32);
            Some(features)
        };
        (0..self.parts.len()).map(one)
    }

    /// What class probabilities make of each part as a whole.
    pub fn clusters<'a>(&self, probabilities: &'a Probabilities) -> Clusters<'a> {
        let cluster = |part: usize| {
            let (mut share, mut bounds) = (0.0, Bounds::of([]));
            for (p, b) in self.segments.iter().zip(probabilities) {
                share += p.share * f64::from(b[part]);
                if b[part] > LIKELY {
                    let (a, b) = (&bounds, &p.mass.bounds);
                    bounds = Bounds { min: a.min.min(b.min), max: a.max.max(b.max) };
                }
            }
            Cluster { share, bounds }
        };
        let logs = |row: &Vec<f32>| row.iter().map(|p| (f64::from(*p) + 1e-3).ln()).collect();
        let logs = probabilities.iter().map(logs).collect();
        Clusters { probabilities, logs, list: (0..self.parts.len()).map(cluster).collect() }
    }

    fn estimated(&self, segment: usize, part: usize, clusters: &Clusters) -> [f64; ESTIMATED] {
        let own = &self.segments[segment];
        let chance = |i: u32| f64::from(clusters.probabilities[i as usize][part]);
        let (mut contact, mut touched) = (0.0, 0.0);
        let (mut agreed, mut asked) = (0.0, 0.0);
        let (mut best, mut inside, mut holds) = (-MOST - 2.0, 0.0, 0.0);
        for b in &own.around {
            let (c, odds) = (chance(b.segment), b.odds);
            contact += b.contact * c;
            touched += b.contact;
            agreed += odds * c;
            asked += odds;
            best = f64::max(best, b.evidence + clusters.logs[b.segment as usize][part]);
            inside += b.inside * c;
            holds += b.holds * c;
        }
        let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        let copies = own.copies.len() as f64;
        let alike: f64 = own.copies.iter().map(|&c| chance(c)).sum();
        let cluster = &clusters.list[part];
        let mine = f64::from(clusters.probabilities[segment][part]);
        let rest = (cluster.share - own.share * mine).max(0.0);
        let prior = self.parts[part].prior;
        let score = |share: f64| prior.score(share.max(LEAST)).max(UNLIKELY);
        let (b, whole) = (&own.mass.bounds, &cluster.bounds);
        let both = Bounds { min: whole.min.min(b.min), max: whole.max.max(b.max) };
        let grows = if whole.min.x.is_finite() && whole.max.x >= whole.min.x {
            (both.diagonal() / whole.diagonal().max(LEVEL * self.diagonal)).ln()
        } else {
            MOST
        };
        [
            ratio(contact, touched),
            ratio(agreed, asked),
            best.clamp(-MOST - 2.0, MOST),
            ratio(alike, copies),
            f64::from(u8::from(copies > 0.0)),
            rest.max(LEAST).ln(),
            score(rest + own.share) - score(rest),
            overlap(b, whole),
            grows.min(MOST),
            mine,
            inside.min(1.0),
            holds.min(3.0),
            contact.min(3.0),
        ]
    }

    /// Which parts draw each segment: how likely each is by its looks alone, and by nearness alone.
    fn drawn(&self) -> Vec<[Vec<f32>; 2]> {
        let one = |segment: usize| {
            let shape = &self.segments[segment].shape;
            let traits = self.parts.iter().map(|p| p.traits.fit(shape) as f32);
            let near = |s: &Option<[f64; STEADY]>| s.map_or(-WAY_MOST, |s| -s[WAY]) as f32;
            let near = self.steady[segment].iter().map(near);
            [chances(&traits.collect::<Vec<_>>()), chances(&near.collect::<Vec<_>>())]
        };
        (0..self.segments.len()).map(one).collect()
    }

    fn steady(&self, known: &Known<'_>) -> Vec<Vec<Option<[f64; STEADY]>>> {
        let (parts, roads) = (0..self.parts.len(), self.roads(known.links));
        let seeded = |n: u32| self.segments[n as usize].seed.is_some();
        let hurdles = Hurdles::of(&roads.doubts, seeded);
        let sight = |part: usize| self.sight(known, (&roads, &hurdles), part);
        let sights: Vec<Option<Sight>> = parts.map(sight).collect();
        let row = |i: usize| {
            let way = |s: &Sight| s.way[i];
            let nearest = sights.iter().flatten().map(way).fold(f64::INFINITY, f64::min);
            let one = |(part, s): (usize, &Option<Sight>)| {
                s.as_ref().map(|s| self.pair(i, part, s, nearest))
            };
            sights.iter().enumerate().map(one).collect()
        };
        (0..self.segments.len()).map(row).collect()
    }

    fn roads(&self, links: &[Link]) -> Roads {
        let by = |cost: &dyn Fn(&Link) -> f64| {
            let ways: Vec<_> = links.iter().map(|l| (l.a, l.b, cost(l))).collect();
            around(self.segments.len(), &ways)
        };
        let centre = |p: u32| self.segments[p as usize].mass.centre();
        Roads {
            barriers: by(&|l| l.barrier.max(0.0)),
            doubts: by(&|l| (MOST - l.evidence).clamp(0.0, 2.0 * MOST)),
            distances: by(&|l| centre(l.a).distance(centre(l.b)) / self.diagonal),
        }
    }

    /// The surface seen from a part's prompts; nothing where it has none.
    fn sight(
        &self,
        known: &Known<'_>,
        (roads, hurdles): (&Roads, &Hurdles<'_>),
        part: usize,
    ) -> Option<Sight> {
        let seeds = &self.parts[part].seeds;
        seeds.first()?;
        let seeded = |n: u32| self.segments[n as usize].seed.is_some();
        let capped = |all: Vec<f64>, most: f64| -> Vec<f64> {
            all.into_iter().map(|cost| cost.min(most)).collect()
        };
        let (shortest, longest) = WAYS;
        let way = capped(costs_from(&roads.barriers, seeds, seeded), longest);
        let within = within(&way, |i| self.segments[i].share);
        let way = way.into_iter().map(|w| (w + shortest).ln()).collect();
        let own = known.seeds.iter().filter(|s| usize::from(s.part) == part);
        let spot = |s: &Seed| {
            let face = s.face as usize;
            (known.mesh.centroid(face), known.mesh.normal(face))
        };
        let mut spots: Vec<(DVec3, DVec3)> = own.map(spot).collect();
        if let (Some(point), [spot]) = (known.condition.prompts[part].point, &mut spots[..]) {
            spot.0 = point;
        }
        let hurdle = capped(hurdles.from(seeds), 2.0 * MOST);
        let along = capped(costs_from(&roads.distances, seeds, |_| false), LONGEST);
        Some(Sight { way, hurdle, within, along, spots })
    }

    fn pair(&self, segment: usize, part: usize, sight: &Sight, nearest: f64) -> [f64; STEADY] {
        let (own, facts) = (&self.segments[segment], &self.parts[part]);
        let seeds = || facts.seeds.iter().map(|&s| &self.segments[s as usize]);
        let to_box = |p: &SegmentFacts| gap(&own.mass.bounds, &p.mass.bounds) / self.diagonal;
        let to_centre =
            |p: &SegmentFacts| own.mass.centre().distance(p.mass.centre()) / self.diagonal;
        let least =
            |of: &dyn Fn(&SegmentFacts) -> f64| seeds().map(of).fold(f64::INFINITY, f64::min);
        let most = |of: &dyn Fn(&SegmentFacts) -> f64| seeds().map(of).fold(0.0, f64::max);
        let touch = self.between(segment, part);
        let area: f64 = seeds().map(|p| p.share).sum();
        let twin = |p: &SegmentFacts| f64::from(u8::from(same(&own.mass, &p.mass)));
        let other_twin = own
            .copies
            .iter()
            .any(|&c| self.segments[c as usize].seed.is_some_and(|s| usize::from(s) != part));
        let direct = |other: Option<usize>| {
            other
                .and_then(|p| self.between(segment, p))
                .map_or(APART, |b| b.evidence.clamp(APART, MOST))
        };
        let children = (0..self.parts.len()).filter(|&p| self.parts[p].parent == Some(part));
        let child = children.map(|p| direct(Some(p))).fold(APART, f64::max);
        let way = sight.way[segment];
        let centre = own.mass.centre();
        let near = |a: &&(DVec3, DVec3), b: &&(DVec3, DVec3)| {
            a.0.distance_squared(centre).total_cmp(&b.0.distance_squared(centre))
        };
        let spot = sight.spots.iter().min_by(near);
        let (point, normal) = spot.map_or((centre, DVec3::ZERO), |s| *s);
        let off = (centre - point).dot(normal).abs() / self.diagonal;
        [
            f64::from(u8::from(own.merged == Some(part as u16))),
            (point.distance(centre) / self.diagonal + 0.01).ln(),
            (off + 0.003).ln(),
            own.normal.dot(normal),
            (sight.along[segment] + 0.02).ln(),
            (way - nearest).min(LONGER),
            way,
            f64::from(u8::from(way <= nearest)),
            sight.hurdle[segment] / MOST,
            (least(&to_centre) + 0.01).ln(),
            (least(&to_box) + 0.003).ln(),
            direct(Some(part)),
            f64::from(u8::from(touch.is_some())),
            touch.map_or(0.0, |b| b.inside.min(1.0)),
            touch.map_or(0.0, |b| b.holds.min(1.0)),
            touch.map_or(0.0, |b| b.contact.min(2.0)),
            most(&|p| overlap(&own.mass.bounds, &p.mass.bounds)),
            most(&|p| overlap(&p.mass.bounds, &own.mass.bounds)),
            (own.share.max(LEAST) / area.max(LEAST)).ln().clamp(-MOST, MOST),
            most(&twin),
            f64::from(u8::from(other_twin)),
            most(&|p| coaxial(own, p, self.diagonal)),
            most(&|p| flush(own, p, self.diagonal)),
            most(&|p| alike_sides(own, p)),
            direct(facts.parent),
            child,
            facts.prior.score(sight.within[segment]).max(UNLIKELY),
            sight.within[segment].ln(),
            (self.parts.len() as f64).ln(),
        ]
    }

    /// The best border between a segment and the prompted segments of a part.
    fn between(&self, segment: usize, part: usize) -> Option<Beside> {
        let own = self.segments[segment].around.iter();
        let of_part = own.filter(|b| self.parts[part].seeds.contains(&b.segment));
        of_part.copied().max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    }
}

/// What is believed of the parts as wholes.
#[derive(Clone, Debug)]
pub struct Clusters<'a> {
    probabilities: &'a Probabilities,
    /// Their logarithms, none of them far below −7.
    logs: Vec<Vec<f64>>,
    list: Vec<Cluster>,
}

#[derive(Clone, Copy, Debug)]
struct Cluster {
    share: f64,
    bounds: Bounds,
}

/// The neighbours of each segment, by what it costs to get there.
struct Roads {
    barriers: Vec<Vec<(u32, f64)>>,
    /// How much the evidence of a border falls short of the most there is.
    doubts: Vec<Vec<(u32, f64)>>,
    /// As shares of the diagonal.
    distances: Vec<Vec<(u32, f64)>>,
}

/// The surface seen from a part's prompts; one number of each kind per segment.
struct Sight {
    /// ln of the cheapest way.
    way: Vec<f64>,
    /// Least evidence on the way where that is most, from the most there is down.
    hurdle: Vec<f64>,
    /// Share of the surface that is no farther away.
    within: Vec<f64>,
    /// Shortest way along the surface, as a share of the diagonal.
    along: Vec<f64>,
    /// Where the prompts lie, and how the surface looks there.
    spots: Vec<(DVec3, DVec3)>,
}

fn segments(known: &Known<'_>, diagonal: f64) -> Vec<SegmentFacts> {
    let units = measure(known.masses, &known.cut.of_face);
    let total: f64 = units.iter().map(|u| u.mass.area).sum();
    let around = borders(known, &units.iter().map(|u| u.mass.area).collect::<Vec<_>>(), diagonal);
    let mut copies = vec![Vec::new(); units.len()];
    each_pair(&units.iter().map(|u| &u.mass).collect::<Vec<_>>(), |a, b| {
        copies[a].push(b as u32);
        copies[b].push(a as u32);
    });
    let whole = known.mesh.bounds();
    let one = |(i, (around, copies)): (usize, (Vec<Beside>, Vec<u32>))| {
        let mass = units[i].mass;
        let left = around.iter().map(|b| b.evidence).fold(f64::NEG_INFINITY, f64::max);
        let company = Company { copies: copies.len(), count: 1, formed: f64::INFINITY, left };
        let (round, axis) = roundness(&mass);
        SegmentFacts {
            mass,
            normal: known.cut.segments[i].normal,
            shape: look(&mass, (total, &whole), company),
            round,
            axis,
            share: mass.area / total.max(f64::MIN_POSITIVE),
            seed: known.cut.segments[i].seed,
            merged: known.merged[i],
            copies,
            around,
        }
    };
    around.into_iter().zip(copies).enumerate().map(one).collect()
}

/// The neighbours of each segment.
fn borders(known: &Known<'_>, areas: &[f64], diagonal: f64) -> Vec<Vec<Beside>> {
    let mut borders = vec![Vec::new(); areas.len()];
    let share = |part: f64, of: u32| (part / areas[of as usize].max(f64::MIN_POSITIVE)).min(1.0);
    for link in known.links {
        let [ab, ba] = [(link.a, link.b), (link.b, link.a)]
            .map(|pair| known.touches.get(&pair).copied().unwrap_or(Touch::NONE));
        let pair = (link.a.min(link.b), link.a.max(link.b));
        let strip = |s: &Seam| s.length * STRIP * diagonal;
        let seam = known.cut.seams.get(&pair).map_or(0.0, strip);
        let small = areas[link.a as usize].min(areas[link.b as usize]).max(f64::MIN_POSITIVE);
        let contact = (ab.touching.max(ba.touching) + seam) / small;
        let [of_a, of_b] = [share(ab.inside, link.a), share(ba.inside, link.b)];
        let evidence = link.evidence;
        let odds = 1.0 / (1.0 + (-evidence).exp());
        let a = Beside { segment: link.b, evidence, odds, contact, inside: of_a, holds: of_b };
        let b = Beside { segment: link.a, evidence, odds, contact, inside: of_b, holds: of_a };
        borders[link.a as usize].push(a);
        borders[link.b as usize].push(b);
    }
    borders
}
