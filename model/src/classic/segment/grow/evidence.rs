//! Evidence that two neighbouring segments are of one part, as log-odds: above 0 for, below 0
//! against.

use std::collections::BTreeMap;

use crate::classic::learned::pack::{Pack, PackError};
use crate::classic::learned::shipped::Shipped;
use crate::classic::segment::grow::merge::Link;
use crate::classic::segment::oversegment::contact::{REACH, Touch};
use crate::classic::segment::oversegment::patches::Seam;
use crate::classic::segment::oversegment::segment::Segment;

/// How much a contact counts beside seams when both lie between two clusters: as much as a seam of
/// this share of the diagonal.
const CONTACT_WEIGHT: f64 = 0.05;
/// Log-odds that two patches are one part over a border that does not turn inward.
const SMOOTH: f64 = 4.0;
/// What a radian of groove takes away from that, up to one radian.
const PER_RADIAN: f64 = 8.0;

static SHIPPED: Shipped<Contacts> =
    Shipped::new("contacts", include_bytes!("../../../../weights/contacts.pack"), Contacts::read);

/// What packs of contacts are called inside.
pub const KIND: &str = "contacts";
/// Their table of features: [`NAMES`].
pub const TABLE: &str = "contact";
/// Their section.
pub const SECTION: &str = "log_odds";
/// The features of two segments that touch or nearly touch.
pub const NAMES: [&str; 10] = [
    "constant",
    "meets",
    "swallowed_root",
    "swallowed",
    "touching_root",
    "reaching",
    "gap",
    "twin",
    "log_share",
    "log_extent",
];

/// A weight for each feature of a contact.
#[derive(Debug, Default)]
struct Contacts(Vec<f64>);

impl Contacts {
    fn read(pack: &Pack<'_>) -> Result<Self, PackError> {
        pack.is(KIND)?;
        pack.asks(TABLE, &NAMES)?;
        Ok(Self(pack.numbers(SECTION, NAMES.len())?))
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

/// Links between segments that touch or nearly touch.
///
/// The log-odds are a logistic regression; the pack says on which data. For one part speak:
///
/// - one segment reaches into the other, since parts of one link are often a union of solids;
/// - a large share of the smaller segment is in contact;
/// - their areas are equal, as in repeated segments, or one is small.
///
/// Against it speak a larger gap, and a large share of the bigger segment that is close by without
/// need.
pub(crate) fn of_contacts(
    touches: &BTreeMap<(u32, u32), Touch>,
    segments: &[Segment],
    diagonal: f64,
) -> Vec<Link> {
    let link = |([a, b], features): ([u32; 2], Features)| {
        let evidence =
            SHIPPED.get().0.iter().zip(features).map(|(weight, x)| weight * x).sum::<f64>();
        let apart = segments[a as usize].centre.distance(segments[b as usize].centre) / diagonal;
        let barrier = 0.3 * softplus(-evidence) + apart;
        Link { a, b, evidence, weight: CONTACT_WEIGHT, barrier }
    };
    contacts(touches, segments, diagonal).into_iter().map(link).collect()
}

/// The features of a contact, in the order of [`NAMES`].
pub type Features = [f64; NAMES.len()];

/// Segments that touch or nearly touch, each two once, and the features of their contact.
pub(crate) fn contacts(
    touches: &BTreeMap<(u32, u32), Touch>,
    segments: &[Segment],
    diagonal: f64,
) -> Vec<([u32; 2], Features)> {
    let mut contacts = Vec::new();
    for (&(a, b), ab) in touches {
        let back = touches.get(&(b, a));
        if a > b && back.is_some() {
            continue;
        }
        let ba = back.copied().unwrap_or(Touch::NONE);
        let (pa, pb) = (&segments[a as usize], &segments[b as usize]);
        let features = if pa.area <= pb.area {
            features((pa, ab), (pb, &ba), diagonal)
        } else {
            features((pb, &ba), (pa, ab), diagonal)
        };
        contacts.push(([a, b], features));
    }
    contacts
}

fn features(small: (&Segment, &Touch), large: (&Segment, &Touch), diagonal: f64) -> Features {
    let ((small, from_small), (large, from_large)) = (small, large);
    let share = |part: f64, whole: &Segment| (part / whole.area.max(f64::MIN_POSITIVE)).min(1.0);
    let swallowed = share(from_small.inside, small);
    let meet = from_small.inside + from_large.inside > 0.0;
    let twin = (large.area - small.area) < 0.01 * large.area;
    let gap = (from_small.gap.min(from_large.gap) / (REACH * diagonal)).min(1.0);
    let extent = small.bounds.size().max_element() / diagonal;
    [
        1.0,
        f64::from(meet),
        swallowed.sqrt(),
        swallowed,
        share(from_small.touching, small).sqrt(),
        share(from_large.reaching, large),
        gap,
        f64::from(twin),
        (small.share + 1e-6).log10(),
        (extent + 1e-4).log10(),
    ]
}

/// Links between patches of one fused mesh: a groove parts, anything else does not.
pub(crate) fn of_seams(
    seams: &BTreeMap<(u32, u32), Seam>,
    segments: &[Segment],
    diagonal: f64,
) -> Vec<Link> {
    let link = |(&(a, b), s): (&(u32, u32), &Seam)| {
        let evidence = SMOOTH - PER_RADIAN * s.concave.min(1.0);
        let apart = segments[a as usize].centre.distance(segments[b as usize].centre) / diagonal;
        let turn = |angle: f64| 1.0 - angle.min(std::f64::consts::FRAC_PI_2).cos();
        let barrier = 10.0 * turn(s.concave) + 0.5 * turn(s.convex) + apart;
        Link { a, b, evidence, weight: s.length / diagonal, barrier }
    };
    seams.iter().map(link).collect()
}

/// How deep a groove of these log-odds would be, radians.
pub(crate) fn groove(evidence: f64) -> f64 {
    ((SMOOTH - evidence) / PER_RADIAN).max(0.0)
}

fn softplus(x: f64) -> f64 {
    x.max(0.0) + (-x.abs()).exp().ln_1p()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_groove_parts_and_a_ridge_does_not() {
        let segment = Segment {
            seed: None,
            share: 0.5,
            area: 1.0,
            centre: object::DVec3::ZERO,
            bounds: object::mesh::Bounds::of([object::DVec3::ZERO, object::DVec3::ONE]),
            normal: object::DVec3::ZERO,
        };
        let seam = |concave, convex| Seam { length: 1.0, concave, convex, sharp: 0.0, ridge: 0.0 };
        let seams = BTreeMap::from([((0, 1), seam(1.2, 0.0)), ((1, 2), seam(0.0, 1.2))]);
        let links = of_seams(&seams, &vec![segment; 3], 2.0);
        assert!(links[0].evidence < 0.0 && links[1].evidence > 0.0);
        assert!(links[0].barrier > links[1].barrier);
        assert_eq!(links[0].weight, 0.5);
        assert_eq!([0, 1].map(|i| groove(links[i].evidence)), [1.0, 0.0]);
    }
}
