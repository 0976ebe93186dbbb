//! Features of a candidate axis: what speaks for and against it, each about −2 to 2.

use object::DVec3;

use crate::classic::joints::candidates::{SHAFT_REACH, planes, shaft_support};
use crate::classic::joints::contact::Touch;
use crate::classic::joints::context::JointContext;
use crate::classic::joints::pins::{Ring, rings_along};
use crate::classic::joints::scene::Body;
use crate::classic::joints::sweep::{Axis, Sweep};
use crate::classic::learned::pack::place;

/// How many numbers describe a candidate.
pub const COUNT: usize = NAMES.len();

/// What the numbers are, in order: the shape, slip, freedom, words, line, guide, likeness, joint,
/// stand, pin and side groups below.
pub const NAMES: [&str; 85] = [
    "upright",
    "long",
    "thin",
    "middle",
    "contact_flat",
    "contact_faces_child",
    "contact_faces_parent",
    "outward",
    "arm",
    "parent_axis",
    "world",
    "faces",
    "slip",
    "slip_contact",
    "slip_parent",
    "firm_less",
    "firm_more",
    "free_less",
    "free_more",
    "loose_less",
    "loose_more",
    "one_way",
    "stuck",
    "outward_free",
    "outward_one_way",
    "word_upright",
    "word_level",
    "off_centre",
    "off_centre_squared",
    "contact_near",
    "contact_mean",
    "contact_mean_far",
    "edge",
    "edge_outside",
    "edge_miss",
    "corner",
    "away",
    "away_level",
    "high",
    "high_far",
    "shaft_child",
    "shaft_parent",
    "shaft_best",
    "round",
    "gap_parent",
    "gap_child",
    "off_contact",
    "contact_length",
    "handle",
    "handle_lever",
    "twin",
    "twin_far",
    "grip",
    "grip_lever",
    "knuckle",
    "knuckle_lever",
    "low_away",
    "room",
    "room_both",
    "parent_long",
    "nested",
    "nests",
    "bearing",
    "mirror_child",
    "mirror_parent",
    "spun",
    "seen_less",
    "seen_more",
    "skin",
    "carries",
    "size",
    "size_parent",
    "front",
    "front_along",
    "rolls",
    "along_x",
    "right",
    "back",
    "pin_own",
    "pin_other",
    "pin_both",
    "pin_any",
    "wheels",
    "beyond",
    "overhang",
];

/// How many of [`NAMES`], from the first on, are asked about where ranges are found: those before this one.
pub(crate) const TOLD: usize = place(&NAMES, "pin_own");

/// How far candidates are swept to be compared: radians, and shares of the diagonal.
const LOOK_TURN: f64 = 0.5;
const LOOK_SLIDE: f64 = 0.12;
/// Step of that sweep.
const LOOK_STEP: f64 = 0.01;
/// Points a body is compared with its own image by, about.
const FEW: usize = 40;
/// What is said of turns that hardly move the part's middle, less than this share of its size.
const UNTOLD: f64 = -0.5;
const SETS_OFF: f64 = 0.05;
/// A share that is told from none.
const UNSEEN: f64 = 0.03;
/// Places of a part that are looked at from far off, about, and how much a face must face the eye.
const LOOKS: usize = 120;
const GRAZING: f64 = 0.2;
/// How often one looks whether a line runs in the middle of something round, and how far beyond the
/// part's ends, as a share of its length.
const PIN_LOOKS: usize = 32;
const PIN_ENDS: f64 = 0.1;
/// Shares of probes that may be stopped: firmly nearly none, freely a tenth, loosely a third.
const SHARES: [f64; 3] = [0.03, 0.12, 0.33];

impl JointContext<'_> {
    /// All numbers of one candidate, in the order of [`NAMES`].
    pub fn features(&self, axis: &Axis, directions: &[DVec3], mirror: [f64; 2]) -> [f64; COUNT] {
        let shape = self.shape(axis, directions);
        let (slip, free) = (self.slip(axis), self.freedom(axis));
        let upright = axis.direction.z.powi(2);
        let said = |word: bool| if word { upright } else { 0.0 };
        let words = [said(self.meaning.upright), said(self.meaning.level)];
        let line = if axis.turns { self.line(axis, directions) } else { [0.0; 30] };
        let guide = self.guide(axis, directions);
        let [less, more] = self.seen(axis);
        let likeness = [mirror[0], mirror[1], self.spun(axis), less, more];
        let all = shape.iter().chain(&slip).chain(&free).chain(&words).chain(&line);
        let joint = self.joint();
        let stand = self.stand(axis);
        let all = all.chain(&guide).chain(&likeness).chain(&joint).chain(&stand);
        let (pins, side) =
            if axis.turns { (self.pins(axis), self.side(axis)) } else { ([0.0; 4], [0.0; 3]) };
        let all = all.chain(&pins).chain(&side);
        let mut out = [0.0; COUNT];
        out.iter_mut().zip(all).for_each(|(o, v)| *o = *v);
        out
    }

    fn shape(&self, axis: &Axis, directions: &[DVec3]) -> [f64; 11] {
        let d = axis.direction;
        let size = |d: DVec3| {
            let (low, high) = self.body.extent(d);
            (high - low).max(1e-4)
        };
        let [u, v] = planes(directions, d)[0];
        let (along, a, b) = (size(d), size(u), size(v));
        let mid = along.max(a).max(b).min(along.max(a.min(b)));
        let faces = |t: &[Touch]| {
            let w: f64 = t.iter().map(|t| t.weight).sum();
            t.iter().map(|t| t.weight * t.normal.dot(d).powi(2)).sum::<f64>() / w.max(1e-9)
        };
        let centre = self.contact.centroid(self.body.centroid);
        let spread = |f: &dyn Fn(DVec3) -> f64| {
            self.contact.all().map(|t| t.weight * f(t.position - centre)).sum::<f64>()
        };
        let flat = spread(&|r| r.dot(d).powi(2)) / spread(&|r| r.length_squared()).max(1e-12);
        let out = self.outward();
        let arm = self.body.centroid - centre;
        [
            d.z * d.z,
            along / along.max(a).max(b),
            along.min(a).min(b) / along,
            (mid / along).min(2.0) / 2.0,
            flat,
            faces(&self.contact.child),
            faces(&self.contact.parent),
            out.dot(d).abs() / out.abs().max_element().max(0.1),
            (arm.dot(d) / size(arm.normalize_or(d)).max(1e-3)).abs().min(1.0),
            self.parent_axis.map_or(0.0, |p| p.dot(d).powi(2)),
            f64::from(d.abs().max_element() > 0.999),
        ]
    }

    /// How much of the surface would be pushed through itself: 0 slides along, 1 head on.
    fn slip(&self, axis: &Axis) -> [f64; 4] {
        let ratio = |points: &mut dyn Iterator<Item = (DVec3, DVec3, f64)>| {
            let (mut through, mut all) = (0.0, 1e-12);
            for (x, n, w) in points {
                let v = axis.velocity(x);
                through += w * v.dot(n).powi(2);
                all += w * v.length_squared();
            }
            through / all
        };
        let touch = |t: &Touch| (t.position, t.normal, t.weight);
        let faces = self.body.samples.iter().map(|s| s.normal.dot(axis.direction).powi(2));
        let count = self.body.samples.len().max(1) as f64;
        [
            faces.sum::<f64>() / count,
            ratio(&mut self.body.samples.iter().map(|s| (s.position, s.normal, 1.0))),
            ratio(&mut self.contact.child.iter().map(touch)),
            ratio(&mut self.contact.parent.iter().map(touch)),
        ]
    }

    /// Free motion, less and more of both ways: stopped by few, some and many probes; how one-sided
    /// it is, whether it leads nowhere, and whether it leads away from the parent.
    fn freedom(&self, axis: &Axis) -> [f64; 10] {
        let sweep =
            Sweep { scene: self.scene, probes: &self.few, still: &self.still, step: LOOK_STEP };
        let limit = if axis.turns { LOOK_TURN } else { LOOK_SLIDE };
        let [a, b] =
            [*axis, axis.reversed()].map(|x| sweep.free(&x, limit, SHARES).map(|f| f / limit));
        let both = |i: usize| [a[i].min(b[i]), a[i].max(b[i])];
        let [firm, free, loose] = [both(0), both(1), both(2)];
        let out = self.outward();
        let leaves = axis.velocity(self.body.centroid).normalize_or_zero().dot(out)
            / out.abs().max_element().max(0.1);
        let (out, back) = if leaves > 0.0 { (a[1], b[1]) } else { (b[1], a[1]) };
        let leaves = leaves.abs().min(1.0);
        let stuck = f64::from(free[1] < 0.15);
        let ways = [free[1] - free[0], stuck, leaves * out, leaves * (out - back)];
        [firm[0], firm[1], free[0], free[1], loose[0], loose[1], ways[0], ways[1], ways[2], ways[3]]
    }

    /// Where the line of a turn runs: through the part, its edges, its contact, a shaft.
    fn line(&self, axis: &Axis, directions: &[DVec3]) -> [f64; 30] {
        let (d, body) = (axis.direction, self.body);
        let radii = body
            .probes
            .iter()
            .map(|&p| (p - body.bounds.centre()).reject_from_normalized(d).length());
        let radius = radii.fold(1e-3, f64::max);
        let off = axis.radius(body.centroid) / radius;
        let [u, v] = planes(directions, d)[0];
        let place = |w: DVec3| {
            let (low, high) = body.extent(w);
            (axis.pivot.dot(w) - (low + high) / 2.0) / ((high - low) / 2.0).max(2e-3)
        };
        let (a, b) = (place(u).abs().min(3.0), place(v).abs().min(3.0));
        let edge = a.max(b);
        let weight: f64 = self.contact.all().map(|t| t.weight).sum::<f64>().max(1e-9);
        let near = self.contact.all().filter(|t| t.weight > 0.3);
        let near = near.map(|t| axis.radius(t.position)).fold(0.5, f64::min);
        let mean =
            self.contact.all().map(|t| t.weight * axis.radius(t.position)).sum::<f64>() / weight;
        let level = 1.0 - d.z * d.z;
        let shift = (axis.pivot - body.centroid).reject_from_normalized(d);
        let half = (body.bounds.size().z / 2.0).max(1e-3);
        let high = (shift.z / half).clamp(-1.5, 1.5) * level;
        let away = shift.dot(self.outward().normalize_or_zero()) / radius;
        let flat = self.outward().with_z(0.0).normalize_or_zero();
        let support = [&self.contact.child, &self.contact.parent].map(|side| {
            let side: Vec<&Touch> =
                side.iter().filter(|t| axis.radius(t.position) < SHAFT_REACH).collect();
            let most = side.iter().map(|t| t.weight).sum::<f64>().clamp(4.0, 36.0);
            (shaft_support(&side, d, axis.pivot) / most).min(1.0)
        });
        let gaps = self.gaps(axis);
        let touch = self.contact.centroid(body.centroid);
        let length = self.contact_length(axis);
        let clues = self.clues(shift, radius);
        [
            off.min(2.0),
            off.min(2.0).powi(2),
            near / radius.max(0.02),
            (mean / radius).min(2.0),
            (mean * 4.0).min(1.0),
            edge.min(1.0),
            (edge - 1.0).max(0.0),
            (edge - 1.0).abs().min(1.0),
            a.min(b).min(1.5),
            away.clamp(-1.5, 1.5),
            (shift.dot(flat) / radius).clamp(-1.5, 1.5),
            high,
            high.abs(),
            support[0],
            support[1],
            support[0].max(support[1]),
            self.roundness(axis, radius),
            gaps[0],
            gaps[1],
            (axis.radius(touch) / radius).min(2.0),
            length,
            clues[0][0],
            clues[0][1],
            clues[1][0],
            clues[1][1],
            clues[2][0],
            clues[2][1],
            clues[3][0],
            clues[3][1],
            (-shift.z / half).clamp(-1.5, 1.5) * level * (1.0 - edge).abs().min(1.0),
        ]
    }

    /// On which side of four things the line lies:
    ///
    /// - the handle, which is far from a hinge;
    /// - the twin of a pair of doors, whose hinges are far apart;
    /// - what a hand grips;
    /// - what sticks out where the part meets its parent, as hinges do.
    fn clues(&self, shift: DVec3, radius: f64) -> [[f64; 2]; 4] {
        [self.handle, self.twin, self.grip, self.knuckle].map(|to| {
            let to = to.map_or(DVec3::ZERO, |t| t - self.body.centroid);
            let cosine = shift.normalize_or_zero().dot(to.normalize_or_zero());
            [
                (shift.dot(to) / radius.powi(2)).clamp(-1.5, 1.5),
                cosine * (shift.length() / radius).min(1.0),
            ]
        })
    }

    /// Share of the part's surface that a turn about the line maps onto itself, nearly.
    fn roundness(&self, axis: &Axis, radius: f64) -> f64 {
        let fits = |x: DVec3, n: DVec3| {
            let v = axis.velocity(x);
            v.dot(n).abs() < 0.12 * v.length().max(0.1 * radius)
        };
        let round = self.body.samples.iter().filter(|s| fits(s.position, s.normal)).count();
        round as f64 / self.body.samples.len().max(1) as f64
    }

    /// Smallest distance of the line from the parent and from the part, within the part's length.
    fn gaps(&self, axis: &Axis) -> [f64; 2] {
        let (low, high) = self.body.extent(axis.direction);
        let base = axis.pivot - axis.direction * axis.direction.dot(axis.pivot);
        let at = |i: i32| base + axis.direction * (low + (high - low) * f64::from(i) / 6.0);
        let least = |body: &Body| {
            let gap = |i| body.nearest(at(i), 0.2).map_or(0.2, |n| n.distance);
            (0..=6).map(gap).fold(0.2, f64::min) * 5.0
        };
        [least(self.parent), least(self.body)]
    }

    /// Distance from a line to the farther of the part and its parent, 0 inside them, where on the
    /// line that is least; at most 0.2.
    pub fn gap(&self, axis: &Axis) -> f64 {
        let middle = axis.pivot - axis.direction * axis.direction.dot(axis.pivot);
        let at = |i: i32| {
            let p = middle + axis.direction * (f64::from(i) / 40.0);
            let from = |body: &Body| match body.nearest(p, 0.2) {
                Some(near) if near.is_behind(p) => 0.0,
                Some(near) => near.distance,
                None => 0.2,
            };
            from(self.body).max(from(self.parent))
        };
        (-24..=24).map(at).fold(0.2, f64::min)
    }

    /// How much of the part's length along the axis is contact near the line.
    fn contact_length(&self, axis: &Axis) -> f64 {
        let (low, high) = self.body.extent(axis.direction);
        let mut bins = [false; 8];
        for t in self.contact.all().filter(|t| t.weight > 0.2 && axis.radius(t.position) < 0.03) {
            let s = (t.position.dot(axis.direction) - low) / (high - low).max(1e-3);
            if (0.0..1.0).contains(&s) {
                bins[(s * 8.0) as usize] = true;
            }
        }
        bins.iter().filter(|b| **b).count() as f64 / 8.0
    }

    /// How well the parent guides the motion: its room along the axis, its room on both sides of
    /// the part, and its own length there. Also how far each lies in the other's shadow along the
    /// axis, and whether the parent holds a turn's line at both ends.
    fn guide(&self, axis: &Axis, directions: &[DVec3]) -> [f64; 6] {
        let d = axis.direction;
        let [u, v] = planes(directions, d)[0];
        let both = |w: DVec3| [self.body.extent(w), self.parent.extent(w)];
        let [(low, high), (from, to)] = both(d);
        let longer = (high - low).max(to - from).max(1e-3);
        let across = |w: DVec3| {
            let [(a, b), (c, e)] = both(w);
            let common = (b.min(e) - a.max(c)).max(0.0);
            [common / (b - a).max(1e-3), common / (e - c).max(1e-3)].map(|s| s.min(1.0))
        };
        let shadow = [across(u), across(v)];
        let widest = [d, u, v].map(|w| both(w)[1]).map(|(a, b)| b - a);
        [
            ((to - from) - (high - low)) / longer,
            (to - high).min(low - from) / longer,
            (to - from) / widest.into_iter().fold(1e-3, f64::max),
            shadow[0][0] * shadow[1][0],
            shadow[0][1] * shadow[1][1],
            if axis.turns { self.bearing(axis) } else { 0.0 },
        ]
    }

    /// Contact close to the line near the weaker end of the part, as a share of that near the
    /// stronger: 1 for an axle held on both sides.
    fn bearing(&self, axis: &Axis) -> f64 {
        let (low, high) = self.body.extent(axis.direction);
        let third = (high - low) / 3.0;
        let near = self.contact.all().filter(|t| axis.radius(t.position) < 0.04);
        let (mut first, mut last) = (0.0, 0.0);
        for t in near {
            let s = t.position.dot(axis.direction);
            first += if s < low + third { t.weight } else { 0.0 };
            last += if s > high - third { t.weight } else { 0.0 };
        }
        let (weak, strong): (f64, f64) = if first < last { (first, last) } else { (last, first) };
        weak / (strong + 2.0)
    }

    /// How much of the part is seen from far away, looking along the way it would leave, from
    /// either end. The smaller value comes first, on a logarithmic scale. What is shut is seen from
    /// where it opens.
    fn seen(&self, axis: &Axis) -> [f64; 2] {
        let leaves = axis.velocity(self.body.centroid);
        let reach = if axis.turns { self.body.bounds.diagonal() } else { 1.0 };
        if leaves.length() < SETS_OFF * reach {
            return [UNTOLD; 2];
        }
        let d = leaves.normalize();
        let u = d.any_orthonormal_vector();
        let size = |w: DVec3| {
            let (low, high) = self.body.extent(w);
            (high - low).max(1e-3)
        };
        let shown = [d, -d].map(|d| self.shows(d) / (size(u) * size(d.cross(u))));
        let [a, b] = shown.map(|s| (UNSEEN + s.clamp(0.0, 1.5)).log10());
        [a.min(b), a.max(b)]
    }

    /// The area of the part that one sees who looks at it from far off, against `d`, to about a degree.
    pub(crate) fn shows(&self, d: DVec3) -> f64 {
        self.body.shown_along(d, |d| {
            let body = self.body;
            let step = body.samples.len() / LOOKS + 1;
            let few = body.samples.iter().step_by(step);
            let share = body.area * step as f64 / body.samples.len().max(1) as f64;
            let faces = few.filter(|s| s.normal.dot(d) > GRAZING);
            let seen = faces.filter(|s| self.scene.is_open_along(s.position, d));
            seen.map(|s| s.normal.dot(d) * share).sum()
        })
    }

    /// How well the part, and what it hangs on, repeat in the mirror across `d` through the part's
    /// middle: 1 exactly, 0 not at all.
    pub fn mirror(&self, d: DVec3) -> [f64; 2] {
        let middle = self.body.bounds.centre().dot(d);
        let flip = |x: DVec3| x - d * (2.0 * (x.dot(d) - middle));
        [self.body, self.parent].map(|body| repeats(body, flip))
    }

    /// How well the part repeats when it is turned about a line through its middle by a share of a
    /// turn, the best of a few shares; 0 for lines elsewhere.
    fn spun(&self, axis: &Axis) -> f64 {
        let radius = self.body.bounds.diagonal() / 2.0;
        if !axis.turns || axis.radius(self.body.centroid) > 0.15 * radius {
            return 0.0;
        }
        let turned = |n: f64| {
            let pose = axis.pose(std::f64::consts::TAU / n);
            repeats(self.body, |x| pose * x)
        };
        [3.0, 4.0, 5.0].map(turned).into_iter().fold(0.0, f64::max)
    }

    /// What is true of the joint whichever its axis: whether the part was cut out of one fused mesh,
    /// whether it carries others, how large it is and how large beside its parent.
    fn joint(&self) -> [f64; 4] {
        let size = |body: &Body| body.bounds.diagonal().max(1e-3);
        let (own, parent) = (size(self.body), size(self.parent));
        let flag = |is: bool| if is { 1.0 } else { 0.0 };
        let ratio = (own / parent).log10().clamp(-1.5, 1.5);
        [flag(self.body.is_open()), flag(self.carries), own.log10().max(-2.0), ratio]
    }

    /// How the axis lies to a person in front of the object, who looks along +y at its front:
    ///
    /// - how far a turn's line is towards the handles of other parts, and how much the axis points
    ///   there;
    /// - how much the axis points along the axles of wheels;
    /// - how much the axis points to the side;
    /// - how far its line is to the right and to the back of the part.
    fn stand(&self, axis: &Axis) -> [f64; 6] {
        let d = axis.direction;
        let reached = self.reached.unwrap_or_default();
        let shift = if axis.turns {
            let radius = self.body.bounds.diagonal() / 2.0;
            (axis.pivot - self.body.centroid).reject_from_normalized(d) / radius.max(1e-3)
        } else {
            DVec3::ZERO
        };
        let [front, right, back] =
            [reached, DVec3::X, DVec3::Y].map(|way| shift.dot(way).clamp(-1.5, 1.5));
        let along = |way: DVec3| way.dot(d).powi(2);
        [front, along(reached), along(self.rolling.unwrap_or_default()), d.x * d.x, right, back]
    }

    /// Along how much of the part a turn's line runs in the middle of something thin and round.
    /// Four values: thin and round things of the part itself; of another part; of both, as in the
    /// knuckles of a hinge; of any.
    fn pins(&self, axis: &Axis) -> [f64; 4] {
        let (low, high) = self.body.extent(axis.direction);
        let base = axis.pivot - axis.direction * axis.direction.dot(axis.pivot);
        let (start, length) =
            (low - PIN_ENDS * (high - low), (1.0 + 2.0 * PIN_ENDS) * (high - low));
        let along = |i: usize| start + length * (i as f64 + 0.5) / PIN_LOOKS as f64;
        let places: [DVec3; PIN_LOOKS] = std::array::from_fn(|i| base + axis.direction * along(i));
        let found = rings_along(self.scene, &places, axis.direction);
        let own = |ring: &Ring| usize::from(ring.part) == self.part;
        let share = |is: &dyn Fn(&Vec<Ring>) -> bool| {
            found.iter().filter(|rings| is(rings)).count() as f64 / PIN_LOOKS as f64
        };
        let [own, other] =
            [share(&|r| r.iter().any(own)), share(&|r| r.iter().any(|ring| !own(ring)))];
        [own, other, (2.0 * own.min(other)).sqrt(), share(&|r| !r.is_empty())]
    }

    /// How far a turn's line is towards the wheels of other parts. How far it lies beyond the
    /// parent, seen from the part's middle. How far the part itself sticks out there.
    fn side(&self, axis: &Axis) -> [f64; 3] {
        let radius = (self.body.bounds.diagonal() / 2.0).max(1e-3);
        let shift = (axis.pivot - self.body.centroid).reject_from_normalized(axis.direction);
        let wheels = shift.dot(self.wheeled.unwrap_or_default()) / radius;
        let way = shift.normalize_or_zero();
        if shift.length() < SETS_OFF * radius {
            return [wheels.clamp(-1.5, 1.5), 0.0, 0.0];
        }
        let ([_, end], [_, own]) = (self.parent.extent(way).into(), self.body.extent(way).into());
        let far =
            [axis.pivot.dot(way), own].map(|far: f64| ((far - end) / radius).clamp(-1.0, 1.0));
        [wheels.clamp(-1.5, 1.5), far[0], far[1]]
    }
}

/// How close some of a body's points come to it when they are moved: 1 onto it, 0 a tenth of its
/// size off on average.
fn repeats(body: &Body, moved: impl Fn(DVec3) -> DVec3) -> f64 {
    let far = (0.1 * body.bounds.diagonal()).max(1e-4);
    let few = || body.samples.iter().step_by(body.samples.len() / FEW + 1);
    let off = |x: DVec3| body.nearest(moved(x), far).map_or(far, |n| n.distance);
    let sum: f64 = few().map(|s| off(s.position)).sum();
    1.0 - sum / far / few().count().max(1) as f64
}
