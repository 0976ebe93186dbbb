//! The shape descriptor of a candidate: features that say something about which part it may be.

use glamx::DSymmetricEigen3;
use object::DVec3;
use object::mesh::Bounds;

use crate::classic::learned::pack::place;
use crate::classic::segment::oversegment::units::{Mass, Units};
use crate::classic::segment::prompts::candidates::{Candidate, Candidates};

/// How many shape features there are.
pub(crate) const SHAPE_FEATURES: usize = 27;
/// What the shape features are called, in order.
pub(crate) const NAMES: [&str; SHAPE_FEATURES] = [
    "area",
    "area_squared",
    "long_side",
    "short_by_middle",
    "middle_by_long",
    "thin_x",
    "thin_y",
    "thin_z",
    "tall",
    "at_z",
    "at_z_squared",
    "off_x",
    "at_y",
    "off_y",
    "from_front",
    "from_back",
    "from_top",
    "from_bottom",
    "from_side",
    "round",
    "round_about_z",
    "round_about_y",
    "members",
    "weakest_inside",
    "strongest_outside",
    "copies",
    "is_single",
];
/// The cue that says how often a candidate repeats.
pub(crate) const COPIES: usize = place(&NAMES, "copies");
/// Most evidence that counts, either way.
const EVIDENCE: f64 = 5.0;
/// How many larger ones a thing is compared with: of ten thousand screws not all pairs are looked at.
const NEXT: usize = 500;
/// Copies differ in area and in box by less than this share.
const ALIKE: f64 = 0.03;

/// The shape features of one candidate:
///
/// - size and proportions;
/// - where it lies in the object's box (−1 to 1 along x, y, z; front at −y), and how far it is from
///   the sides of that box;
/// - how round it is, and about which axis;
/// - how well it hangs together;
/// - how often it repeats.
pub(crate) type Shape = [f64; SHAPE_FEATURES];

/// The shape features of every candidate.
pub(crate) fn shape(candidates: &Candidates, units: &Units) -> Vec<Shape> {
    let total: f64 = units.list.iter().map(|u| u.mass.area).sum();
    let copies = copies(&candidates.list);
    let one = |(c, copies): (&Candidate, &usize)| {
        let company =
            Company { copies: *copies, count: c.span().len(), formed: c.formed, left: c.left };
        look(&c.mass, (total, &units.bounds), company)
    };
    candidates.list.iter().zip(&copies).map(one).collect()
}

/// What is known of something beside its shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Company {
    /// How many copies of it there are.
    pub copies: usize,
    /// How many units it is made of.
    pub count: usize,
    /// Evidence over the weakest border inside it.
    pub formed: f64,
    /// Evidence over its strongest border.
    pub left: f64,
}

/// The shape features of something in an object of this area and box.
pub(crate) fn look(mass: &Mass, (total, whole): (f64, &Bounds), company: Company) -> Shape {
    let b = &mass.bounds;
    let diagonal = whole.diagonal().max(f64::MIN_POSITIVE);
    let across = whole.size().max(DVec3::splat(1e-3 * diagonal));
    let at = (b.centre() - whole.centre()) / (across / 2.0);
    let (front, back) = ((b.min - whole.min) / across, (whole.max - b.max) / across);
    let size = b.size().max(DVec3::splat(1e-4 * diagonal));
    let mut sides = size.to_array();
    sides.sort_by(f64::total_cmp);
    let [short, middle, long] = sides;
    let flat = 1.0 - short / middle;
    let thin = |axis: usize| if size[axis] == short { flat } else { 0.0 };
    let tall = if size.z == long { 1.0 - middle / long } else { 0.0 };
    let share = (mass.area / total.max(f64::MIN_POSITIVE)).max(1e-7).log10();
    let (round, axis) = roundness(mass);
    [
        share,
        share * share,
        (long / diagonal).log10(),
        (short / middle).log10(),
        (middle / long).log10(),
        thin(0),
        thin(1),
        thin(2),
        tall,
        at.z,
        at.z * at.z,
        at.x.abs(),
        at.y,
        at.y.abs(),
        front.y,
        back.y,
        back.z,
        front.z,
        front.x.min(back.x),
        round,
        round * axis.z.abs(),
        round * axis.y.abs(),
        (company.count as f64).ln(),
        company.formed.clamp(-EVIDENCE, EVIDENCE),
        company.left.clamp(-EVIDENCE, EVIDENCE),
        (1.0 + company.copies as f64).ln(),
        f64::from(u8::from(company.count == 1)),
    ]
}

/// How near the spread is to that of a solid of revolution, 0 to 1, and its axis.
pub(crate) fn roundness(mass: &Mass) -> (f64, DVec3) {
    let spread = mass.spread();
    if !spread.is_finite() {
        return (0.0, DVec3::Z);
    }
    let eigen = DSymmetricEigen3::new(spread);
    let e = eigen.eigenvalues.max(DVec3::ZERO);
    let v = eigen.eigenvectors;
    let alike = |a: f64, b: f64| (-20.0 * (a - b).abs() / a.max(b).max(f64::MIN_POSITIVE)).exp();
    let found =
        [(alike(e.y, e.z), v.x_axis), (alike(e.x, e.z), v.y_axis), (alike(e.x, e.y), v.z_axis)];
    let larger = |a: (f64, DVec3), b: (f64, DVec3)| if b.0 > a.0 { b } else { a };
    let best = found.into_iter().reduce(larger).unwrap_or((0.0, DVec3::Z));
    if best.1.is_finite() && best.0.is_finite() { best } else { (0.0, DVec3::Z) }
}

/// Whether two candidates are copies of each other, by area and by the sides of their boxes.
pub(crate) fn alike(a: &Candidate, b: &Candidate) -> bool {
    same(&a.mass, &b.mass) && !a.overlaps(b)
}

/// Whether two things have the same area and boxes of the same sides.
pub(crate) fn same(a: &Mass, b: &Mass) -> bool {
    let close = |a: f64, b: f64| (a - b).abs() <= ALIKE * a.abs().max(b.abs());
    let sides = |mass: &Mass| {
        let mut sides = mass.bounds.size().to_array();
        sides.sort_by(f64::total_cmp);
        sides
    };
    close(a.area, b.area) && sides(a).iter().zip(sides(b)).all(|(&s, t)| close(s, t))
}

/// Tells every pair of things that are the same, each with the [`NEXT`] next larger ones at most.
pub(crate) fn each_pair(masses: &[&Mass], mut found: impl FnMut(usize, usize)) {
    let area = |i: usize| masses[i].area;
    let mut order: Vec<usize> = (0..masses.len()).collect();
    order.sort_by(|&a, &b| area(a).total_cmp(&area(b)).then(a.cmp(&b)));
    for (i, &a) in order.iter().enumerate() {
        let most = area(a) * (1.0 + 2.0 * ALIKE);
        let next = order[i + 1..].iter().copied().take(NEXT);
        next.take_while(|&b| area(b) <= most)
            .filter(|&b| same(masses[a], masses[b]))
            .for_each(|b| found(a, b));
    }
}

/// How many copies each candidate has.
fn copies(list: &[Candidate]) -> Vec<usize> {
    let masses: Vec<&Mass> = list.iter().map(|c| &c.mass).collect();
    let mut copies = vec![0; list.len()];
    each_pair(&masses, |a, b| {
        if !list[a].overlaps(&list[b]) {
            copies[a] += 1;
            copies[b] += 1;
        }
    });
    copies
}
