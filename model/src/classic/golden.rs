//! Today's behaviour, number by number: what the learned path makes of five small objects.
//!
//! What is expected stands in `model/golden`, a file for each object: every feature by name to 1e-6, what
//! forests and networks are told and say, labels and joints exactly. Where a change is meant to change
//! behaviour, the files are written anew, and their difference is part of the change:
//!
//! ```sh
//! KINFOLD_BLESS=1 cargo test --release -p kinfold-model --lib golden
//! ```
//!
//! That the test notices changes is shown by `model/mutants`.

mod joints;
pub(super) mod objects;
pub(super) mod record;

use std::collections::BTreeMap;
use std::path::PathBuf;

use object::weld::Weld;
use object::{Condition, Mesh};

use crate::classic::golden::record::{Record, Section, Value, runs};
use crate::classic::joints::Labelled;
use crate::classic::segment;
use crate::classic::segment::{Way, labellings};
use crate::classic::{HYPOTHESES, Kept, keep};

/// The objects.
const OBJECTS: [&str; 5] = ["components", "fused", "cut_up", "no_points", "no_texts"];

/// Where what is expected stands; `model/mutants` compiles this file, too, and looks one folder up.
fn path(name: &str) -> PathBuf {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let folders = [here.join("golden"), here.join("../golden")];
    let [own, above] = &folders;
    let folder = if own.is_dir() { own } else { above };
    folder.join(format!("{name}.txt"))
}

/// Compares with what is expected, or writes that anew where `KINFOLD_BLESS` is set.
fn check(name: &str, found: &Record) {
    let path = path(name);
    let head = format!(
        "# What the learned path makes of the object `{name}` of model/src/classic/golden/objects.rs,\n\
         # written by: KINFOLD_BLESS=1 cargo test --release -p kinfold-model --lib golden\n"
    );
    let written = found.written(&head);
    if std::env::var_os("KINFOLD_BLESS").is_some_and(|v| v == "1") {
        std::fs::write(&path, written).unwrap();
        return;
    }
    let expected = Record::read(&std::fs::read_to_string(&path).unwrap());
    let (told, all) = found.differences(&expected);
    assert!(all == 0, "{name}: {all} differences\n  {}", told.join("\n  "));
}

/// The articulator's own way, step by step: labels in every way, then joints in the light of them.
fn of_object((mesh, condition): &(Mesh, Condition)) -> Record {
    let mut record = Record::default();
    let weld = Weld::new(mesh);
    segment::golden::record(&mut record, (mesh, &weld), condition);
    let (labels, others) = labellings(mesh, condition, &weld, (Way::Fitted, &HYPOTHESES));
    record.section("labels");
    record.exact("fitted", runs(&labels.part_of_face));
    for (way, labels) in HYPOTHESES.iter().zip(&others) {
        record.exact(format!("{way:?}"), runs(labels));
    }
    for note in &labels.notes {
        record.exact(format!("note on {}", note.part), format!("{} {}", note.loss, note.message));
    }
    let Kept { tree, part_of_condition, part_of_face } =
        keep(condition, &labels.part_of_face).unwrap();
    record.exact("parts kept", format!("{part_of_condition:?}"));
    let now = |&p: &u16| part_of_condition[usize::from(p)].unwrap_or(tree.root()) as u16;
    let others: Vec<Vec<u16>> = others.iter().map(|o| o.iter().map(now).collect()).collect();
    let category = condition.category.as_str();
    let from = Labelled {
        mesh,
        weld: &weld,
        tree: &tree,
        part_of_face: &part_of_face,
        category,
        given: &[],
    };
    joints::record(&mut record, &from, &others);
    record
}

#[test]
fn components_are_articulated_as_ever() {
    check("components", &of_object(&objects::components()));
}

#[test]
fn a_fused_mesh_is_articulated_as_ever() {
    check("fused", &of_object(&objects::fused()));
}

#[test]
fn what_is_cut_up_is_articulated_as_ever() {
    check("cut_up", &of_object(&objects::cut_up()));
}

#[test]
fn what_nobody_points_at_is_articulated_as_ever() {
    check("no_points", &of_object(&objects::no_points()));
}

#[test]
fn what_nobody_speaks_of_is_articulated_as_ever() {
    check("no_texts", &of_object(&objects::no_texts()));
}

#[test]
fn words_and_amounts_mean_what_they_did() {
    let mut record = Record::default();
    segment::golden::tables(&mut record);
    joints::tables(&mut record);
    check("tables", &record);
}

/// For each table of features, its columns over all objects.
fn columns() -> BTreeMap<String, BTreeMap<String, Vec<f64>>> {
    let mut tables: BTreeMap<String, BTreeMap<String, Vec<f64>>> = BTreeMap::new();
    for name in OBJECTS {
        let record = Record::read(&std::fs::read_to_string(path(name)).unwrap());
        for Section { title, lines } in record.sections() {
            let Some((kind, Value::Exact(rows))) = title
                .split_once(',')
                .map(|t| t.0)
                .zip(lines.first().filter(|l| l.0 == "rows").map(|l| &l.1))
            else {
                continue;
            };
            let count = rows.split(", ").count();
            for (name, value) in &lines[1..] {
                let Value::Numbers(all) = value else { continue };
                let all = if all.len() == 1 { vec![all[0]; count] } else { all.clone() };
                tables.entry(kind.into()).or_default().entry(name.clone()).or_default().extend(all);
            }
        }
    }
    tables
}

/// Features of which the objects show nothing: the same in every row. A swap of two of one table would go
/// unnoticed; so would one of those below.
const ASLEEP: [&str; 93] = [
    "axis: knuckle",
    "axis: knuckle_lever",
    "axis: pin_both",
    "axis: pin_other",
    "axis: word_upright",
    "axis inputs: below_most.carries",
    "axis inputs: below_most.knuckle",
    "axis inputs: below_most.knuckle_lever",
    "axis inputs: below_most.pin_both",
    "axis inputs: below_most.size",
    "axis inputs: below_most.size_parent",
    "axis inputs: below_most.skin",
    "axis inputs: below_most.word_upright",
    "axis inputs: knuckle",
    "axis inputs: knuckle_lever",
    "axis inputs: pin_both",
    "axis inputs: pin_other",
    "axis inputs: role_arm",
    "axis inputs: role_fall_door",
    "axis inputs: role_flap",
    "axis inputs: role_lever",
    "axis inputs: role_lift",
    "axis inputs: role_pointer",
    "axis inputs: role_slider",
    "axis inputs: role_stand",
    "axis inputs: word_upright",
    "pairwise: large.is_single",
    "pairwise: large.members",
    "pairwise: large.weakest_inside",
    "pairwise: small.is_single",
    "pairwise: small.members",
    "pairwise: small.weakest_inside",
    "range: edge_outside",
    "range: firm_more",
    "range: free_more",
    "range: knuckle",
    "range: knuckle_lever",
    "range: loose_more",
    "range: parent_axis",
    "range: parent_axis_way",
    "range: role_arm",
    "range: role_fall_door",
    "range: role_flap",
    "range: role_knob",
    "range: role_lever",
    "range: role_lift",
    "range: role_pointer",
    "range: role_slider",
    "range: role_stand",
    "range: role_wheel",
    "range: skin",
    "range: stuck",
    "range: word_level",
    "range: word_upright",
    "range: world",
    "unary: own.is_single",
    "unary: own.members",
    "unary: own.weakest_inside",
    "unary: role_arm",
    "unary: role_fall_door",
    "unary: role_flap",
    "unary: role_lever",
    "unary: role_lift",
    "unary: role_pointer",
    "unary: role_slider",
    "unary: role_stand",
    "unary: seed.is_single",
    "unary: seed.members",
    "unary: seed.weakest_inside",
    "unary: seed_coaxial",
    "ways: edge_outside",
    "ways: firm_more",
    "ways: free_more",
    "ways: knuckle",
    "ways: knuckle_lever",
    "ways: loose_more",
    "ways: parent_axis",
    "ways: parent_axis_way",
    "ways: role_arm",
    "ways: role_fall_door",
    "ways: role_flap",
    "ways: role_knob",
    "ways: role_lever",
    "ways: role_lift",
    "ways: role_pointer",
    "ways: role_slider",
    "ways: role_stand",
    "ways: role_wheel",
    "ways: skin",
    "ways: stuck",
    "ways: word_level",
    "ways: word_upright",
    "ways: world",
];
/// Features that the objects do not tell from another.
const ALIKE: [(&str, &str); 20] = [
    ("axis: grip", "axis: handle"),
    ("axis: grip_lever", "axis: handle_lever"),
    ("axis: pin_any", "axis: pin_own"),
    ("axis inputs: below_most.grip", "axis inputs: below_most.handle"),
    ("axis inputs: below_most.grip_lever", "axis inputs: below_most.handle_lever"),
    ("axis inputs: grip", "axis inputs: handle"),
    ("axis inputs: grip_lever", "axis inputs: handle_lever"),
    ("axis inputs: pin_any", "axis inputs: pin_own"),
    ("pairwise: large.coaxial", "pairwise: small.coaxial"),
    ("range: along_x", "range: axis_x_either"),
    ("range: axis_z_either", "range: upright"),
    ("range: grip", "range: handle"),
    ("range: grip_lever", "range: handle_lever"),
    ("unary: carries", "unary: is_base"),
    ("unary: carries", "unary: joint_none"),
    ("unary: is_base", "unary: joint_none"),
    ("ways: along_x", "ways: axis_x_either"),
    ("ways: axis_z_either", "ways: upright"),
    ("ways: grip", "ways: handle"),
    ("ways: grip_lever", "ways: handle_lever"),
];

#[test]
fn the_objects_show_every_feature_and_tell_it_from_every_other() {
    let (mut asleep, mut alike) = (Vec::new(), Vec::new());
    for (table, columns) in columns() {
        let columns: Vec<(String, Vec<f64>)> = columns.into_iter().collect();
        for (i, (name, one)) in columns.iter().enumerate() {
            if one.iter().all(|x| record::same(*x, one[0])) {
                asleep.push(format!("{table}: {name}"));
                continue;
            }
            for (other, two) in &columns[i + 1..] {
                if one.len() == two.len() && one.iter().zip(two).all(|(a, b)| record::same(*a, *b))
                {
                    alike.push((format!("{table}: {name}"), format!("{table}: {other}")));
                }
            }
        }
    }
    assert_eq!(asleep, ASLEEP);
    let known = |(a, b): &(&str, &str)| (a.to_string(), b.to_string());
    assert_eq!(alike, ALIKE.iter().map(known).collect::<Vec<_>>());
}
