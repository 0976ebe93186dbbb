//! The kinds of defects that are planted, and what a right checker should say of each.
//!
//! They were written down before any check was measured by them. What people get wrong in models that
//! they wrote, exported or converted is the source; the seventeen of simcheck's `mutate` are among them.

use super::language::Language;

/// One kind of defect.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Its id, such as `limits-swapped`.
    pub id: &'static str,
    /// What is changed in the model.
    pub change: &'static str,
    /// What is wrong of the model then.
    pub wrong: &'static str,
    /// The formats in which it can be written.
    pub formats: &'static [Language],
    /// The rules of kinfold that should find it; any finding that was not there before where there is
    /// none.
    pub rules: &'static [&'static str],
}

use Language::{Mjcf, Sdf, Urdf};

const ALL: &[Language] = &[Urdf, Mjcf, Sdf];
const UM: &[Language] = &[Urdf, Mjcf];
const US: &[Language] = &[Urdf, Sdf];
const U: &[Language] = &[Urdf];
const M: &[Language] = &[Mjcf];

const fn kind(
    id: &'static str,
    (change, wrong): (&'static str, &'static str),
    formats: &'static [Language],
    rules: &'static [&'static str],
) -> Kind {
    Kind { id, change, wrong, formats, rules }
}

/// Any finding that was not there before.
const ANY: &[&str] = &[];

/// Every kind, by what of the model it is about.
#[rustfmt::skip]
pub const KINDS: [Kind; 74] = [
    // Text.
    kind("xml-broken", ("the last closing tag is left out", "the file is not XML"), ALL, &["F1"]),
    kind("number-nan", ("a coordinate becomes `nan`", "a place is no number"), ALL, &["F1"]),
    kind("number-comma", ("a coordinate is written with a decimal comma", "a place is no number"), ALL, &["F1"]),
    kind("number-missing", ("a place has two coordinates instead of three", "a place is no vector"), ALL, &["F1"]),
    // Tree.
    kind("link-missing", ("a joint names a link that is not there", "a reference leads nowhere"), US, &["T1"]),
    kind("link-twice", ("a link gets the name of another one", "a name stands for two things"), ALL, &["F3"]),
    kind("joint-twice", ("a joint gets the name of another one", "a name stands for two things"), ALL, &["F3"]),
    kind("two-roots", ("a joint is left out", "a part hangs on nothing"), US, &["T1"]),
    kind("two-parents", ("a link is put below a second one", "a link has two parents"), US, &["T1"]),
    kind("cycle", ("the root is put below one of its own descendants", "links form a circle"), US, &["T1"]),
    kind("parent-child-swapped", ("parent and child of a joint change places", "the tree is upside down"), US, ANY),
    kind("joint-type-unknown", ("a joint gets the type that another format has for it", "the type is none of this format"), ALL, &["F1", "T2"]),
    kind("joint-fixed", ("a joint that moves becomes fixed; its range stays", "what should move does not"), US, ANY),
    kind("joint-endless", ("a hinge with a range becomes continuous", "a door turns round and round, through its body"), U, ANY),
    kind("joint-turns-for-slides", ("a slide becomes a hinge, or a hinge a slide", "a part moves in another way"), ALL, ANY),
    kind("mimic-missing", ("a joint follows one that is not there", "a reference leads nowhere"), UM, &["F1", "T1", "T2"]),
    kind("mimic-itself", ("a joint follows itself", "a follower has no leader"), U, &["T2"]),
    kind("mimic-too-far", ("a follower goes ten times as far as its own range", "a joint is told to leave its range"), U, ANY),
    // Limits.
    kind("limits-swapped", ("lower and upper limit change places", "no motion is possible between them"), ALL, &["F1", "J2"]),
    kind("limits-degrees", ("limits in radians are written in degrees", "a joint turns dozens of times"), US, &["J3"]),
    kind("limits-missing", ("the limits of a joint with a range are left out", "how far it goes is not told"), ALL, ANY),
    kind("limits-empty", ("both limits become 0", "no motion is possible between them"), ALL, &["F1", "J2"]),
    kind("limits-infinite", ("the upper limit becomes infinite", "a range has no end"), UM, &["F1", "J2"]),
    kind("limits-without-rest", ("the range is shifted past the rest pose", "the model stands outside its own limits"), ALL, &["J2"]),
    kind("range-into-body", ("the range goes on until the part stands in its neighbour", "parts pass through each other"), ALL, &["C2"]),
    // Axes and pivots.
    kind("axis-zero", ("an axis becomes 0 0 0", "it has no direction"), ALL, &["F1", "J1"]),
    kind("axis-long", ("an axis has length 2", "programs scale the motion or do not"), US, &["J1"]),
    kind("axis-flipped", ("an axis points the other way, into a neighbour", "a part opens inward"), ALL, ANY),
    kind("axis-other-frame", ("an axis is written in another frame", "a part moves across its guide or hinge"), ALL, ANY),
    kind("axis-missing", ("the axis of a joint is left out", "it falls back to a default direction"), ALL, ANY),
    kind("pivot-off", ("a hinge stands apart from its parts; nothing moves at rest", "a part turns about a line in the air"), UM, &["J5"]),
    kind("part-detached", ("a part is moved away from what it hangs on", "a part floats in the air"), ALL, ANY),
    kind("part-turned", ("a part is turned by a right angle at its joint", "a part stands across its place"), ALL, ANY),
    kind("joint-into-parent", ("a part is moved into the one it hangs on", "parts overlap at rest"), ALL, &["C1"]),
    kind("below-floor", ("the whole object is lowered by a tenth of its size", "it stands in the floor"), UM, &["U3"]),
    // Mass.
    kind("mass-zero", ("a mass becomes 0", "a moving body weighs nothing"), ALL, &["F1", "M1"]),
    kind("mass-negative", ("a mass becomes negative", "no body has it"), ALL, &["F1", "M1"]),
    kind("mass-grams", ("a mass in kilograms is written in grams", "a part weighs a thousand times as much"), ALL, ANY),
    kind("mass-tonnes", ("a mass in kilograms is written in tonnes", "a part weighs a thousandth"), ALL, ANY),
    kind("inertial-missing", ("mass and inertia of a moving part are left out", "what it weighs is not told"), US, &["M1"]),
    kind("inertia-zero", ("all moments become 0", "it turns without effort"), ALL, &["F1", "M1", "M3"]),
    kind("inertia-negative", ("a moment becomes negative", "no body has it"), ALL, &["F1", "M3"]),
    kind("inertia-triangle", ("a moment is larger than the other two together", "no body has it"), ALL, &["F1", "M3"]),
    kind("inertia-millimetres", ("moments are written in kg·mm²", "they are a million times too large"), ALL, &["M4"]),
    kind("inertia-placeholder", ("all moments become 1", "they are no measure of this part"), ALL, &["M4"]),
    kind("inertia-turned", ("largest and smallest moment of a long part change places", "they are another body's"), ALL, &["M4"]),
    kind("com-outside", ("the centre of mass is moved away by the size of the model", "it lies in the air"), ALL, &["M5"]),
    kind("com-millimetres", ("the centre of mass is written in millimetres", "it lies in the air"), ALL, &["M5"]),
    // Shapes.
    kind("visual-missing", ("what is seen of a part is left out", "a part is touched and not seen"), ALL, ANY),
    kind("collision-missing", ("the collision geometry of a moving part is left out", "a part cannot be touched"), ALL, ANY),
    kind("collision-off", ("the collision geometry of a part stands beside it", "what is seen and what is touched differ"), ALL, &["G3"]),
    kind("collision-large", ("the collision geometry of a part is three times as large", "what is seen and what is touched differ"), ALL, ANY),
    kind("collision-masked", ("the contact masks of all shapes are 0", "nothing touches anything"), M, ANY),
    kind("scale-millimetres", ("all meshes are taken in millimetres for metres", "the model is a thousand times too large"), ALL, &["U1", "U2"]),
    kind("scale-small", ("all meshes are a thousand times smaller", "the model is as small as a grain"), ALL, &["U1", "U2"]),
    kind("scale-mirrored", ("a mesh is mirrored by a negative scale", "its faces look inward, or its parts change sides"), UM, &["U1"]),
    kind("size-zero", ("a side of a primitive becomes 0", "a shape has no volume"), ALL, ANY),
    kind("quaternion-zero", ("a turn is written as 0 0 0 0", "it is no turn"), M, ANY),
    // Files.
    kind("mesh-missing", ("a mesh file is named that is not there", "a shape cannot be had"), ALL, &["F2"]),
    kind("mesh-elsewhere", ("a mesh is named by a path of another machine", "a shape cannot be had"), ALL, &["F2"]),
    kind("mesh-other-case", ("the name of a mesh file is written in other case", "a shape cannot be had where case counts"), ALL, &["F2"]),
    kind("mesh-empty", ("a mesh file has no bytes", "a shape cannot be had"), ALL, &["F2"]),
    kind("mesh-cut-off", ("a mesh file ends in its middle", "a shape cannot be had, or half of it"), ALL, ANY),
    kind("mesh-nan", ("a vertex of a mesh is `nan`", "a surface has no place"), ALL, ANY),
    kind("mesh-inside-out", ("all faces of a mesh are turned round", "a body looks inward"), ALL, &["G1", "G2"]),
    kind("mesh-open", ("faces of a closed collision mesh are left out", "a body has a hole"), ALL, ANY),
    kind("texture-missing", ("a texture is named that is not there", "a picture cannot be had"), UM, ANY),
    kind("material-undefined", ("a shape names a material that is not there", "a reference leads nowhere"), UM, ANY),
    // Drives and contact.
    kind("effort-zero", ("the largest effort of a joint becomes 0", "nothing can move it"), US, &["J4"]),
    kind("velocity-zero", ("the largest velocity of a joint becomes 0", "nothing can move it"), US, &["J4"]),
    kind("damping-negative", ("the damping of a joint becomes negative", "it gains energy"), ALL, ANY),
    kind("friction-negative", ("the friction of a joint becomes negative", "it gains energy"), ALL, ANY),
    kind("drive-missing", ("a transmission or an actuator names a joint that is not there", "a reference leads nowhere"), UM, ANY),
    kind("control-wide", ("an actuator may be sent three times as far as its joint goes", "a drive pushes against its own stop"), M, ANY),
];

/// The kind of an id.
pub fn known(id: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|k| k.id == id)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim_check::profile::RULES;

    #[test]
    fn every_kind_has_a_name_of_its_own_and_rules_of_the_profile() {
        let mut ids: Vec<_> = KINDS.iter().map(|k| k.id).collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), KINDS.len());
        let known = |id: &&str| RULES.iter().any(|r| r.id == *id);
        assert!(KINDS.iter().all(|k| !k.formats.is_empty() && k.rules.iter().all(known)));
    }

    #[test]
    fn at_least_forty_kinds_can_be_written_in_each_format() {
        for language in ALL {
            let count = KINDS.iter().filter(|k| k.formats.contains(language)).count();
            assert!(count >= 40, "{language:?}: {count}");
        }
    }
}
