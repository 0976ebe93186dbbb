//! Features of a motion: what a part leaves and what it comes to when it sets off one way.
//!
//! They are told of an axis the way round that it is asked about; asked about the other way round, those
//! that have a sign change it. Lengths are shares of the object's diagonal, or of the part's own length.

use object::DVec3;

use crate::classic::joints::context::JointContext;
use crate::classic::joints::scene::Body;
use crate::classic::joints::sweep::{Axis, Sweep};

/// How many numbers describe a motion.
pub const COUNT: usize = NAMES.len();

/// What the numbers are, in order.
pub const NAMES: [&str; 72] = [
    "free_firm",
    "free_soft",
    "free_loose",
    "back_firm",
    "back_soft",
    "back_loose",
    "freer_firm",
    "freer_soft",
    "freer_loose",
    "shut",
    "to_the_eye",
    "leaves",
    "lever",
    "parent_length",
    "axis_x",
    "axis_y",
    "axis_z",
    "way_x",
    "way_y",
    "way_z",
    "axis_x_either",
    "axis_y_either",
    "axis_z_either",
    "at_x",
    "at_y",
    "at_z",
    "from_parent_x",
    "from_parent_y",
    "from_parent_z",
    "way_from_middle",
    "way_from_parent",
    "axis_from_middle",
    "axis_from_parent",
    "axis_low",
    "axis_high",
    "axis_parent_ahead",
    "axis_parent_behind",
    "axis_parent_length",
    "axis_rest_low",
    "axis_rest_high",
    "axis_length",
    "way_low",
    "way_high",
    "way_parent_ahead",
    "way_parent_behind",
    "way_parent_length",
    "way_rest_low",
    "way_rest_high",
    "way_length",
    "touch_way",
    "touch_axis",
    "touch_far",
    "arm_up",
    "out_way",
    "out_arm",
    "out_axis",
    "out_most",
    "arm_length",
    "handle_way",
    "grip_way",
    "handle_arm",
    "grip_arm",
    "size_x",
    "size_y",
    "size_z",
    "parent_size_x",
    "parent_size_y",
    "parent_size_z",
    "siblings",
    "joints",
    "parent_axis_way",
    "parent_axis",
];

/// Step of the sweep that is looked at, share of the diagonal.
const STEP: f64 = 0.006;
/// Shares of probes that may be stopped: nearly none, a tenth, a third.
const SHARES: [f64; 3] = [0.02, 0.1, 0.33];
/// What is told is rounded to multiples of this. Parts often end exactly where others do: no tree may tell
/// such from what is off by the last digit, which depends on where an object stands.
const GRAIN: f64 = 1e-5;
/// No length that others are measured in is shorter.
const SHORTEST: f64 = 1e-3;

/// What is told of both ways of an axis.
pub(crate) struct Motions {
    /// How far the part goes freely, ahead and back, in radians or lengths of the part: stopped by few,
    /// some and many probes.
    pub free: [[f64; 3]; 2],
    /// What speaks for either way, in the order of [`NAMES`].
    pub told: [[f64; COUNT]; 2],
}

impl JointContext<'_> {
    /// What is told of an axis, along it and against it; free motion up to `most`, in radians or lengths of
    /// the part.
    pub(crate) fn motions(&self, axis: &Axis, most: f64) -> Motions {
        let unit = self.length(axis);
        let sweep =
            Sweep { scene: self.scene, probes: &self.probes, still: &self.still, step: STEP };
        let free =
            [*axis, axis.reversed()].map(|a| sweep.free(&a, most * unit, SHARES).map(|f| f / unit));
        let eye = self.comes_to_the_eye(axis).map_or(0.0, |comes| if comes { 1.0 } else { -1.0 });
        let told = [0, 1].map(|way| {
            let (axis, eye) = if way == 0 { (*axis, eye) } else { (axis.reversed(), -eye) };
            self.motion(&axis, [free[way], free[1 - way]], eye)
        });
        Motions { free, told }
    }

    fn motion(&self, axis: &Axis, [free, back]: [[f64; 3]; 2], eye: f64) -> [f64; COUNT] {
        let (body, parent, d) = (self.body, self.parent, axis.direction);
        let unit = self.length(axis);
        let way = axis.velocity(body.centroid).normalize_or_zero();
        let lever = self.probes.iter().map(|p| axis.radius(p.start)).fold(0.0, f64::max);
        let (low, high) = parent.extent(d);
        let shut = f64::from(u8::from(self.is_shut(axis)));
        let away = body.centroid - parent.bounds.centre();
        let leaves = way.dot(away.normalize_or_zero());
        let from_parent = body.centroid - parent.centroid;
        let touch = self.contact.centroid(body.centroid) - body.centroid;
        let arm = (body.centroid - axis.pivot).reject_from_normalized(d);
        let (reach, arm) = (arm.length(), arm.normalize_or_zero());
        let out = self.outward();
        let [handle, grip] =
            [self.handle, self.grip].map(|h| h.map_or(DVec3::ZERO, |h| h - body.centroid));
        let freer = [0, 1, 2].map(|i| free[i] - back[i]);
        let own = [shut, eye, leaves, lever, (high - low) / unit];
        let places = [body.centroid, from_parent].map(|v| v.to_array());
        let along = [way.dot(body.centroid), way.dot(from_parent)];
        let axial = [d.dot(body.centroid), d.dot(from_parent)];
        let vectors = [d, way, d.abs()].map(|v| v.to_array());
        let [beside_axis, beside_way] = [self.beside(d), self.beside(way)];
        let contact = [touch.dot(way), touch.dot(d), touch.length()];
        let outside =
            [arm.z, out.dot(way), out.dot(arm), out.dot(d), out.abs().max_element(), reach];
        let hands = [handle.dot(way), grip.dot(way), handle.dot(arm), grip.dot(arm)];
        let sizes = [body, parent].map(|b| b.bounds.size().to_array());
        let before = self.parent_axis.unwrap_or(DVec3::ZERO);
        let joint =
            [self.siblings as f64, self.joints as f64, before.dot(way), before.dot(d).abs()];
        let all = free.into_iter().chain(back).chain(freer).chain(own);
        let all = all.chain(vectors.concat()).chain(places.concat()).chain(along).chain(axial);
        let all = all.chain(beside_axis).chain(beside_way).chain(contact).chain(outside);
        let all = all.chain(hands).chain(sizes.concat()).chain(joint);
        let mut told = [0.0; COUNT];
        told.iter_mut().zip(all).for_each(|(to, from)| *to = (from / GRAIN).round() * GRAIN);
        told
    }

    /// How the part lies along a direction beside what it hangs on and all that stays, in lengths of its
    /// own; last that length.
    fn beside(&self, d: DVec3) -> [f64; 8] {
        let extent = |body: &Body| body.extent(d);
        let ((low, high), (from, to)) = (extent(self.body), extent(self.parent));
        let length = (high - low).max(SHORTEST);
        let still = self.still.iter().filter_map(|&s| self.scene.bodies.get(s));
        let rest = still.map(|s| extent(s)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (first, last) = rest.unwrap_or((from, to));
        let lengths =
            [low - from, high - to, to - low, high - from, to - from, low - first, high - last];
        let mut beside = [length; 8];
        beside.iter_mut().zip(lengths).for_each(|(to, from)| *to = from / length);
        beside
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classic::joints::labelled::Labelled;
    use crate::classic::joints::scene::Scene;
    use crate::classic::learned::pack::place;
    use object::weld::Weld;
    use object::{JointKind, KinematicTree, Mesh, Part};

    /// A box from a corner, of a size, as triangles.
    fn cuboid(low: DVec3, size: DVec3, triangles: &mut Vec<[DVec3; 3]>) {
        let at = |i: usize| {
            low + size * DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64)
        };
        for [a, b, c, d] in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            triangles.extend([[at(a), at(b), at(c)], [at(a), at(c), at(d)]]);
        }
    }

    #[test]
    fn a_drawer_before_its_back_wall_is_told_what_lies_ahead_and_what_lies_behind() {
        let mut triangles = Vec::new();
        // A wall behind, at y from 1 to 1.1; before it a drawer that ends at it.
        cuboid(DVec3::new(0.0, 1.0, 0.0), DVec3::new(1.0, 0.1, 1.0), &mut triangles);
        let base = triangles.len();
        cuboid(DVec3::new(0.2, 0.5, 0.2), DVec3::new(0.6, 0.5, 0.6), &mut triangles);
        let mesh = Mesh::of_triangles(&triangles).unwrap();
        let labels: Vec<u16> = (0..triangles.len()).map(|f| u16::from(f >= base)).collect();
        let part = |name: &str, parent, joints| Part {
            name: name.into(),
            text: name.into(),
            parent,
            joints,
        };
        let slide = vec![JointKind::Prismatic];
        let tree =
            KinematicTree::new(vec![part("wall", None, vec![]), part("drawer", Some(0), slide)]);
        let (tree, weld) = (tree.unwrap(), Weld::new(&mesh));
        let (category, given) = ("cabinet", &[][..]);
        let from = Labelled {
            mesh: &mesh,
            weld: &weld,
            tree: &tree,
            part_of_face: &labels,
            category,
            given,
        };
        let scene = Scene::new(&from, 1);
        let context = JointContext::new(&scene, &from, 1, None, 1).unwrap();
        let axis = Axis { direction: -DVec3::Y, pivot: DVec3::ZERO, turns: false };
        let told = context.motions(&axis, 2.0);
        let of = |way: usize, name: &str| told.told[way][place(&NAMES, name)];
        // Ahead it is free as far as one looks, back it meets the wall at once.
        assert_eq!(of(0, "free_firm"), 2.0);
        assert!(of(1, "free_firm") < 0.05, "{}", of(1, "free_firm"));
        assert_eq!(of(0, "back_firm"), of(1, "free_firm"));
        assert_eq!(of(0, "freer_firm"), -of(1, "freer_firm"));
        assert_eq!((of(0, "axis_y"), of(1, "axis_y"), of(1, "axis_y_either")), (-1.0, 1.0, 1.0));
        // Its rear end is where the wall begins: one length of its own before the wall's.
        assert!((of(0, "axis_low") - 0.1 / 0.5).abs() < 2e-5, "{}", of(0, "axis_low"));
        assert!((of(0, "axis_high") - 1.0).abs() < 2e-5, "{}", of(0, "axis_high"));
        assert!((of(1, "axis_low") + of(0, "axis_high")).abs() < 2e-5);
        assert!((of(0, "axis_parent_ahead") - 0.0).abs() < 2e-5, "{}", of(0, "axis_parent_ahead"));
        assert_eq!((of(0, "siblings"), of(0, "joints")), (1.0, 1.0));
        assert!(of(0, "leaves") > 0.999 && of(1, "leaves") == -of(0, "leaves"));
    }
}
