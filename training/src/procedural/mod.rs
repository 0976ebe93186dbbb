//! Objects made by rule, whose parts and joints are known exactly.

mod cabinet;
mod cart;
mod draft;
mod error;
mod families;
mod fan;
mod pedal_bin;
mod piece;
pub mod pitfalls;
mod shapes;

use std::fmt;

use object::condition::{ConditionFile, FileJoints, FilePart, FileSize, SCHEMA};
use object::mesh::UpAxis;
use object::{ArticulatedObject, KinematicTree};

use crate::dataset::Specimen;
pub use error::FamilyError;
use piece::Piece;
use shapes::Shape;

/// An object with its truth and the condition that describes it.
#[derive(Clone, Debug)]
pub struct Made {
    /// Mesh, parts and joints, exact; object frame, metres.
    pub object: ArticulatedObject,
    /// What a person would write about it, points included; glTF frame.
    pub condition: ConditionFile,
}

/// A family of objects: everyday things of one kind.
pub struct Family {
    /// What it is called, such as `cabinet`.
    pub name: &'static str,
    build: fn() -> Vec<Piece>,
}

/// Every family there is.
pub const FAMILIES: [Family; 4] = [
    Family { name: "cabinet", build: cabinet::pieces },
    Family { name: "pedal_bin", build: pedal_bin::pieces },
    Family { name: "cart", build: cart::pieces },
    Family { name: "fan", build: fan::pieces },
];

/// How many families there are.
pub const KINDS: usize = FAMILIES.len() + families::VARIED.len();

/// Which object of our own families: its family, and which of that family's objects, from 0. It is the
/// same object however many families there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Id {
    family: &'static str,
    index: usize,
}

impl Id {
    /// The object of this family with this index.
    ///
    /// # Errors
    /// [`FamilyError::Unknown`] when there is no such family.
    pub fn new(family: &str, index: usize) -> Result<Self, FamilyError> {
        let known = names().find(|name| *name == family);
        let family = known.ok_or_else(|| FamilyError::Unknown(family.to_owned()))?;
        Ok(Self { family, index })
    }

    /// What the object's family is called, such as `pedal_bin`.
    pub fn family(self) -> &'static str {
        self.family
    }

    /// The same in words, such as `pedal bin`.
    pub fn category(self) -> String {
        self.family.replace('_', " ")
    }

    /// Which of its family's objects it is, from 0.
    pub fn index(self) -> usize {
        self.index
    }
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.family, self.index)
    }
}

/// What the families are called, in order.
pub fn names() -> impl Iterator<Item = &'static str> {
    FAMILIES.iter().map(|f| f.name).chain(families::VARIED.iter().map(|f| f.name))
}

/// So many objects of each family: the first of all, then the second of all, and so on.
pub fn each(of: usize) -> impl Iterator<Item = Id> {
    (0..of).flat_map(|index| names().map(move |family| Id { family, index }))
}

/// The first so many of [`each`].
pub fn first(count: usize) -> impl Iterator<Item = Id> {
    each(count.div_ceil(KINDS)).take(count)
}

/// An object; `seed` and id throw its proportions. Those of [`FAMILIES`], which stand in the examples,
/// look always the same.
///
/// # Errors
/// [`FamilyError`] when the family's own rules do not make a valid object.
pub fn generate(id: Id, seed: u64) -> Result<Specimen, FamilyError> {
    if let Some(varied) = families::VARIED.iter().find(|f| f.name == id.family) {
        return (varied.build)(&mut draft::Dice::new(seed, id)).finish(id.to_string());
    }
    let family = FAMILIES.iter().find(|f| f.name == id.family);
    let family = family.ok_or_else(|| FamilyError::Unknown(id.family.into()))?;
    let object = family.make()?.object;
    let wordings = object.tree().parts().iter().map(|p| vec![p.text.clone()]).collect();
    Ok(Specimen { id: id.to_string(), object, wordings })
}

/// The same, each part called by one of its wordings: which one goes by the index.
///
/// # Errors
/// [`FamilyError`] when the family's own rules do not make a valid object.
pub fn worded(id: Id, seed: u64) -> Result<Specimen, FamilyError> {
    let Specimen { id: name, object, wordings } = generate(id, seed)?;
    let mut parts = object.tree().parts().to_vec();
    for (part, wordings) in parts.iter_mut().zip(&wordings) {
        part.text.clone_from(&wordings[id.index % wordings.len().max(1)]);
    }
    let joints = (0..parts.len()).map(|p| object.joints(p).to_vec()).collect();
    let (mesh, labels) = (object.mesh().clone(), object.part_of_face().to_vec());
    let object = ArticulatedObject::new(mesh, KinematicTree::new(parts)?, labels, joints)?;
    Ok(Specimen { id: name, object, wordings })
}

impl Family {
    /// Builds the family's object.
    ///
    /// # Errors
    /// [`FamilyError`] when the family's own rules do not make a valid object.
    pub fn make(&self) -> Result<Made, FamilyError> {
        let pieces = (self.build)();
        let mut all = Shape::default();
        let mut labels = Vec::new();
        for (label, piece) in pieces.iter().enumerate() {
            labels.extend(std::iter::repeat_n(label as u16, piece.shape.faces.len()));
            all.add(&piece.shape);
        }
        let tree = KinematicTree::new(pieces.iter().map(Piece::part).collect())?;
        let motions = pieces.iter().map(|p| p.motions.clone()).collect();
        let object = ArticulatedObject::new(all.mesh()?, tree, labels, motions)?;
        let condition = self.condition(&pieces, &object);
        Ok(Made { object, condition })
    }

    fn condition(&self, pieces: &[Piece], object: &ArticulatedObject) -> ConditionFile {
        let parts = pieces.iter().map(|p| FilePart {
            name: p.name.into(),
            text: Some(p.text.into()),
            parent: p.parent.map(|i| pieces[i].name.into()),
            joint: FileJoints::from_kinds(p.motions.iter().map(|m| m.kind).collect()),
            point: Some(object.mesh().frame().point_to_file(p.point).to_array()),
            material: Some(p.material.into()),
            ..FilePart::default()
        });
        ConditionFile {
            schema: SCHEMA.into(),
            category: self.name.replace('_', " "),
            up: Some(UpAxis::Y),
            size: Some(FileSize::Height(object.mesh().bounds().size().z)),
            parts: parts.collect(),
            ..ConditionFile::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use object::pose::{Configuration, part_poses};
    use object::weld::nearest_face;
    use object::{DVec3, JointMotion, Range};

    use super::*;

    /// The first throw of the dice of `desk-3` and seed 7.
    const THROWN: f64 = 0.7665068315035475;

    #[test]
    fn a_part_is_called_by_one_of_its_wordings_and_all_else_stays() {
        let id = Id::new("appliance", 2).unwrap();
        let (made, called) = (generate(id, 5).unwrap(), worded(id, 5).unwrap());
        let parts = called.object.tree().parts();
        let is_own = |p: usize| made.wordings[p].contains(&parts[p].text);
        assert!((0..parts.len()).all(is_own));
        assert!(made.wordings.iter().any(|w| w.len() > 1), "there is something to choose");
        assert_eq!(called.object.mesh(), made.object.mesh());
        assert_eq!(called.object.part_of_face(), made.object.part_of_face());
        let joints = |s: &Specimen, p| s.object.joints(p).to_vec();
        assert!((0..parts.len()).all(|p| joints(&called, p) == joints(&made, p)));
    }

    #[test]
    fn every_family_makes_a_closed_object_whose_condition_fits() {
        for family in FAMILIES {
            let made = family.make().unwrap();
            let mesh = made.object.mesh();
            let condition = made.condition.resolve().unwrap();
            condition.check_points(mesh).unwrap();
            assert_eq!(condition.tree, *made.object.tree(), "{}", family.name);
            let weld = object::weld::Weld::new(mesh);
            let mut edges = std::collections::BTreeMap::<[u32; 2], i32>::new();
            for f in &weld.faces {
                for (a, b) in [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])] {
                    *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
                }
            }
            assert!(edges.values().all(|&n| n == 0), "{}: every edge both ways", family.name);
            for (part, prompt) in condition.prompts.iter().enumerate() {
                let (face, _) = nearest_face(mesh, prompt.point.unwrap());
                assert_eq!(usize::from(made.object.part_of_face()[face]), part, "{}", family.name);
            }
        }
    }

    fn assert_closed(mesh: &object::Mesh, name: &str) {
        let weld = object::weld::Weld::new(mesh);
        let mut edges = std::collections::BTreeMap::<[u32; 2], i32>::new();
        for f in &weld.faces {
            for (a, b) in [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])] {
                *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|&n| n == 0), "{name}: every edge both ways");
    }

    #[test]
    fn there_are_more_than_thirty_families_and_every_object_of_each_is_sound() {
        const { assert!(KINDS > 30) };
        for id in each(8) {
            let made = generate(id, 7).unwrap();
            let parts = made.object.tree().len();
            assert!(parts >= 2 && made.wordings.len() == parts, "{}", made.id);
            assert!(made.wordings.iter().all(|w| !w.is_empty()), "{}", made.id);
            assert!(made.object.mesh().signed_volume() > 0.0, "{}", made.id);
            assert_closed(made.object.mesh(), &made.id);
            assert!(made.object.tree().degrees_of_freedom() > 0, "{}", made.id);
        }
    }

    /// The ids of a family's objects.
    fn ids_of(family: &str) -> impl Iterator<Item = Id> {
        (0..).map(move |index| Id::new(family, index).unwrap())
    }

    /// The middle of a part's surface.
    fn middle(object: &ArticulatedObject, part: usize) -> DVec3 {
        let mesh = object.mesh();
        let sum = object.faces_of(part).map(|f| mesh.centroid(f) * mesh.area(f)).sum::<DVec3>();
        sum / object.faces_of(part).map(|f| mesh.area(f)).sum::<f64>()
    }

    #[test]
    fn what_is_turned_on_a_tap_or_a_valve_sits_about_its_axis() {
        let mut on_top = 0;
        for number in ids_of("faucet").take(40) {
            let made = generate(number, 7).unwrap().object;
            if made.tree().len() != 2 || made.joints(1)[0].axis != DVec3::Z {
                continue;
            }
            let pivot = made.joints(1)[0].pivot;
            let corners: Vec<DVec3> =
                made.faces_of(1).flat_map(|f| made.mesh().corners(f)).collect();
            for side in 0..8 {
                let turn = f64::from(side) * std::f64::consts::FRAC_PI_4;
                let way = DVec3::new(turn.cos(), turn.sin(), 0.0);
                let reach = corners.iter().map(|c| (c - pivot).dot(way)).fold(0.0, f64::max);
                assert!(reach > 0.006, "{number}: {reach} m from its axis towards {way}");
            }
            on_top += 1;
        }
        assert!(on_top > 10, "of 40 taps {on_top} are turned on top");
    }

    #[test]
    fn a_toggle_goes_as_far_to_one_side_as_it_leans_to_the_other() {
        for family in ["light_switch", "control_box"] {
            let mut toggles = 0;
            for number in ids_of(family).take(12) {
                let made = generate(number, 7).unwrap().object;
                let end = |part: usize| match made.joints(part)[0] {
                    JointMotion { kind, range: Range::Limits { lower: 0.0, upper }, .. } => {
                        kind.turns().then_some((part, upper))
                    }
                    _ => None,
                };
                let ends: Vec<(usize, f64)> = (1..made.tree().len()).filter_map(end).collect();
                let mut there = object::pose::Configuration::rest(made.tree());
                ends.iter().for_each(|&(part, upper)| there.0[part][0] = upper);
                let moved = crate::dataset::pose::posed(&made, &there).unwrap();
                for (part, _) in ends {
                    let pivot = made.joints(part)[0].pivot;
                    let [here, there] = [&made, &moved].map(|o| middle(o, part) - pivot);
                    let aside = DVec3::new(1.0, 0.0, 1.0);
                    if (here * aside).length() > 1e-3 {
                        assert!(
                            ((here + there) * aside).length() < 1e-9,
                            "{number}: {here}, {there}"
                        );
                        toggles += 1;
                    }
                }
            }
            assert!(toggles > 5, "{family}: {toggles} toggles lean");
        }
    }

    /// Bounds of each box of a part that is made of boxes.
    fn boxes(object: &ArticulatedObject, part: usize, first: usize) -> Vec<object::mesh::Bounds> {
        let faces: Vec<usize> = object.faces_of(part).collect();
        let corners = |faces: &[usize]| {
            faces.iter().flat_map(|&f| object.mesh().corners(f)).collect::<Vec<_>>()
        };
        let bounds = |faces: &[usize]| object::mesh::Bounds::of(corners(faces));
        faces.chunks(12).take(first).map(bounds).collect()
    }

    #[test]
    fn what_runs_in_a_slot_stays_in_it_from_one_end_to_the_other() {
        for family in ["slot_lever", "sliders"] {
            for number in ids_of(family).take(20) {
                let made = generate(number, 7).unwrap().object;
                let walls = boxes(&made, 0, usize::MAX);
                for (part, end) in (1..made.tree().len()).flat_map(|p| [(p, 0), (p, 1)]) {
                    let Range::Limits { lower, upper } = made.joints(part)[0].range else {
                        panic!()
                    };
                    assert!(upper - lower > 0.01, "{number}: {lower} to {upper}");
                    let mut there = object::pose::Configuration::rest(made.tree());
                    there.0[part][0] = [lower, upper][end];
                    let moved = crate::dataset::pose::posed(&made, &there).unwrap();
                    let stem = boxes(&moved, part, 1)[0];
                    let hit = walls.iter().find(|w| {
                        (w.min.cmplt(stem.max - 1e-9) & stem.min.cmplt(w.max - 1e-9)).all()
                    });
                    assert!(hit.is_none(), "{number}: {stem:?} in {hit:?}");
                }
            }
        }
    }

    #[test]
    fn a_lid_that_is_lifted_leaves_its_neck_and_rings_on_the_jar() {
        let (mut lifted, mut ringed) = (0, 0);
        for number in ids_of("jar").take(80) {
            let made = generate(number, 7).unwrap().object;
            let JointMotion { kind, axis, range: Range::Limits { upper, .. }, .. } =
                made.joints(1)[0]
            else {
                continue;
            };
            if kind.turns() || axis != DVec3::Z {
                continue;
            }
            let mut there = Configuration::rest(made.tree());
            there.0[1][0] = upper;
            let moved = crate::dataset::pose::posed(&made, &there).unwrap();
            let height = |part: usize| {
                let corners = moved.faces_of(part).flat_map(|f| moved.mesh().corners(f));
                object::mesh::Bounds::of(corners)
            };
            let (jar, lid) = (height(0), height(1));
            assert!(lid.min.z > jar.max.z, "{number}: {lid:?} lifted from {jar:?}");
            let weld = object::weld::Weld::new(made.mesh());
            let components = weld.components().0;
            let of_jar: std::collections::BTreeSet<_> =
                made.faces_of(0).map(|f| components[f]).collect();
            assert!(of_jar.len() >= 2, "{number}: the neck is a body of its own");
            ringed += usize::from(of_jar.len() > 2);
            lifted += 1;
        }
        assert!(lifted > 10 && ringed > 5, "{lifted} lifted, {ringed} with rings");
    }

    #[test]
    fn objects_differ_in_their_proportions_and_repeat() {
        let size = |id, seed| generate(id, seed).unwrap().object.mesh().bounds().size();
        let desks: Vec<Id> = ids_of("desk").take(2).collect();
        assert_eq!(size(desks[0], 1), size(desks[0], 1));
        assert_ne!(size(desks[0], 1), size(desks[1], 1));
        assert_ne!(size(desks[0], 1), size(desks[0], 2));
    }

    #[test]
    fn an_object_is_named_by_family_and_index_and_thrown_by_nothing_else() {
        let id = Id::new("desk", 3).unwrap();
        assert_eq!((id.to_string(), id.category()), ("desk-3".into(), "desk".into()));
        assert_eq!(generate(id, 7).unwrap().id, "desk-3");
        let throw = |seed| draft::Dice::new(seed, id).between(0.0, 1.0);
        assert!((throw(7) - THROWN).abs() < 1e-12, "{}", throw(7));
        assert_ne!(throw(7), throw(8));
        let told = Id::new("sofa", 0).unwrap_err().to_string();
        assert_eq!(told, "there is no family `sofa`");
    }

    #[test]
    fn each_family_has_its_turn_and_then_again() {
        let all: Vec<Id> = first(KINDS + 2).collect();
        assert_eq!(all.len(), KINDS + 2);
        assert_eq!(
            [all[0], all[KINDS]].map(|id| (id.family(), id.index())),
            [("cabinet", 0), ("cabinet", 1)]
        );
        assert_eq!(each(2).count(), 2 * KINDS);
        assert!(each(2).zip(&all).all(|(a, b)| a == *b));
    }

    #[test]
    fn the_left_drawer_of_a_desk_lies_to_the_left_of_who_stands_before_it() {
        for number in ids_of("desk").take(5) {
            let made = generate(number, 3).unwrap();
            let x = |part| middle(&made.object, part).x;
            assert!(made.wordings[1][0].starts_with("left") && x(1) < x(2));
        }
    }

    #[test]
    fn the_cabinets_door_swings_outward_about_its_left_edge() {
        let made = FAMILIES[0].make().unwrap();
        let tree = made.object.tree();
        let door = tree.parts().iter().position(|p| p.name == "door").unwrap();
        let q = Configuration::rest(tree).with(door, 0, 1.0);
        let pose = part_poses(&made.object, &q)[door];
        let front = made.object.mesh().bounds().min.y;
        let handle_side = DVec3::new(0.3, front, 0.3);
        assert!((pose * handle_side).y < front - 0.2, "the door opens towards the viewer");
    }
}
