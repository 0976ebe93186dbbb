//! The two-drawer test: words alone say which drawer is which.
#![allow(clippy::unwrap_used)]

use model::classic::segment::{Way, label_faces};
use object::origin::Origin;
use object::weld::Weld;
use object::{Condition, KinematicTree, Mesh};
use training::dataset::Specimen;
use training::procedural::{Id, generate};

/// How many objects of each kind are asked about, and how many must come out right.
const ASKED: usize = 10;
const RIGHT: usize = 9;
/// A drawer is right when its faces agree with the truth in this share of their area.
const AGREES: f64 = 0.8;
/// A seed that nothing was chosen with.
const SEED: u64 = 2718;

/// Two words and the drawers they mean.
struct Pair {
    specimen: Specimen,
    parts: [usize; 2],
}

/// The first objects of a family with drawers whose texts begin with both words.
fn pairs(family: &str, words: [&str; 2]) -> Vec<Pair> {
    let pair = |index: usize| {
        let specimen = generate(Id::new(family, index).unwrap(), SEED).unwrap();
        let says = |word: &str| {
            let starts = |w: &Vec<String>| w[0].starts_with(word) && w[0].contains("drawer");
            specimen.wordings.iter().position(starts)
        };
        let parts = [says(words[0])?, says(words[1])?];
        Some(Pair { specimen, parts })
    };
    (0..).filter_map(pair).take(ASKED).collect()
}

/// The object's own condition without any point, its texts in the wording `turn` where there are
/// several, and those of the two drawers as given.
fn condition(pair: &Pair, drawers: [&str; 2], turn: usize) -> Condition {
    let mut parts = pair.specimen.object.tree().parts().to_vec();
    for (part, wordings) in parts.iter_mut().zip(&pair.specimen.wordings) {
        part.text = wordings[turn % wordings.len()].clone();
    }
    for (part, text) in pair.parts.into_iter().zip(drawers) {
        parts[part].text = text.into();
    }
    Condition::of_tree("", KinematicTree::new(parts).unwrap(), Origin::User)
}

fn agreement(mesh: &Mesh, found: &[u16], truth: &[u16], [found_as, true_as]: [usize; 2]) -> f64 {
    let (mut both, mut either) = (0.0, 0.0);
    for (face, (&f, &t)) in found.iter().zip(truth).enumerate() {
        let (f, t) = (usize::from(f) == found_as, usize::from(t) == true_as);
        both += if f && t { mesh.area(face) } else { 0.0 };
        either += if f || t { mesh.area(face) } else { 0.0 };
    }
    both / f64::max(either, f64::MIN_POSITIVE)
}

/// Whether both drawers are found where their words say, and change places with their words.
fn is_right(pair: &Pair, [one, other]: [&str; 2], turn: usize) -> bool {
    let object = &pair.specimen.object;
    let (mesh, [p, q]) = (object.mesh(), pair.parts);
    let ask = |texts: [&str; 2], are: [[usize; 2]; 2]| {
        let condition = condition(pair, texts, turn);
        let labels = label_faces(mesh, &condition, &Weld::new(mesh), Way::Fitted);
        let noted = |part: usize| {
            let name = &condition.tree.parts()[part].name;
            labels.notes.iter().any(|n| n.part == *name && n.message.contains("by its words"))
        };
        assert!(noted(p) && noted(q), "{}: a part placed by words has a note", pair.specimen.id);
        let agree = |is| agreement(mesh, &labels.part_of_face, object.part_of_face(), is);
        are.into_iter().all(|is| agree(is) >= AGREES)
    };
    ask([one, other], [[p, p], [q, q]]) && ask([other, one], [[p, q], [q, p]])
}

fn check(family: &str, words: [&str; 2]) {
    let pairs = pairs(family, words);
    let texts = words.map(|w| format!("{w} drawer"));
    let texts = [texts[0].as_str(), texts[1].as_str()];
    let right = pairs.iter().enumerate().filter(|(i, pair)| is_right(pair, texts, *i));
    let right: Vec<_> = right.map(|(_, pair)| pair.specimen.id.clone()).collect();
    assert!(right.len() >= RIGHT, "{family}: only {right:?} of {ASKED} came out right");
}

#[test]
fn the_left_and_the_right_drawer_of_a_desk_are_told_apart_by_words_alone() {
    check("desk", ["left", "right"]);
}

#[test]
fn the_left_and_the_right_drawer_of_a_cabinet_are_told_apart_by_words_alone() {
    check("cupboard", ["left", "right"]);
}

#[test]
fn the_upper_and_the_lower_of_two_drawers_are_told_apart_by_words_alone() {
    let kind = "drawer_unit";
    let mut pairs = pairs(kind, ["top", "bottom"]);
    pairs.retain(|p| p.specimen.object.tree().len() == 3);
    let texts = ["upper drawer", "lower drawer"];
    let right = pairs.iter().enumerate().filter(|(i, pair)| is_right(pair, texts, *i)).count();
    assert_eq!(right, pairs.len());
    assert!(right > 0);
}
