//! Parts of one kind get one size.
//!
//! Where most of them look alike from their prompts, one that is far larger has something that is
//! not its own. One that is far smaller lacks something. Of two parts with one name, the larger
//! gives up the rest if it would do with as much as the other.

use std::collections::BTreeMap;

use object::DVec3;
use object::mesh::Bounds;

use crate::classic::lexicon::sizes::{named, noun};
use crate::classic::segment::classify::facts::Probabilities;
use crate::classic::segment::refine::surface::Surface;

/// Parts look alike from their prompts if their boxes have this share of their union in common.
const LIKE: f64 = 0.4;
/// A flat box is as thick as this share of its diagonal.
const THICK: f64 = 0.01;
/// A part is far larger than usual if the diagonal of its box is so many times as long, and far smaller
/// if the usual one is.
const FAR: f64 = 2.0;
/// How far beyond its usual place a part may reach, a share of the diagonal.
const MARGIN: f64 = 0.15;
/// What has less than this share of it in a part's place lies outside, what has more than that inside.
const OUTSIDE: f64 = 0.5;
const INSIDE: f64 = 0.8;
/// What lies in a part's place is of it if that is likelier than this.
const SLIGHT: f32 = 0.1;
/// The box of the larger of two parts that are called the same is more than this many times as large.
const LARGER: f64 = 2.0;
/// What it has in its place is at most so many times as much as the other has, or as much less.
const AS_MUCH: f64 = 3.0;
/// How far beyond its place it may reach, a share of that place's size each way, and at least this share of
/// its diagonal.
const LEEWAY: f64 = 0.1;

/// A part among those of its kind.
struct Sibling {
    part: u16,
    /// Where its prompt lies.
    at: DVec3,
    /// Its box, seen from there.
    seen: Bounds,
}

/// Two parts that are called the same, of which the larger keeps to its place.
pub(crate) struct Twins {
    larger: u16,
    /// What both hang on.
    parent: u16,
    /// The place of the larger.
    place: Bounds,
}

/// What has become of class probabilities.
#[derive(Default)]
pub(crate) struct Settled {
    /// Whether any of them has changed.
    pub changed: bool,
    /// Pairs whose larger part is to keep to its place.
    pub twins: Vec<Twins>,
}

/// Corrects class probabilities of parts that are far larger or far smaller than most of their
/// kind.
///
/// The place of a part is where the others of its kind lie, seen from their prompts. What a larger
/// part has outside of its place is taken from it. What the parent has inside the place of a
/// smaller part is given to it, unless that is unlikely. Of a pair only the larger is trimmed.
pub(crate) fn settle(
    surface: &Surface,
    region: &[usize],
    labels: &[u16],
    probabilities: &mut Probabilities,
) -> Settled {
    let mut corners = vec![Vec::new(); surface.condition.tree.len()];
    for (face, &a) in region.iter().enumerate() {
        corners[usize::from(labels[a])].extend(surface.skin.mesh.corners(face));
    }
    let boxes: Vec<Option<Bounds>> =
        corners.into_iter().map(|c| (!c.is_empty()).then(|| Bounds::of(c))).collect();
    let mut settled = Settled::default();
    for kind in kinds(surface) {
        let sibling = |part: u16| {
            let seed = surface.seeds.iter().find(|s| s.part == part)?;
            let at = surface.skin.mesh.centroid(seed.face as usize);
            Some(Sibling { part, at, seen: moved(boxes[usize::from(part)]?, -at) })
        };
        let siblings: Vec<Sibling> = kind.into_iter().filter_map(sibling).collect();
        if let [a, b] = &siblings[..] {
            if let Some((twins, inside)) = twins(surface, region, labels, [a, b]) {
                let (part, heir) = (twins.larger, Some(twins.parent));
                settled.changed |= trim((part, heir), &inside, labels, probabilities);
                settled.twins.push(twins);
            }
            continue;
        }
        let Some(usual) = usual(&siblings) else { continue };
        for Sibling { part, at, seen } in &siblings {
            let ratio = seen.diagonal() / usual.diagonal().max(f64::MIN_POSITIVE);
            let place = moved(usual, *at);
            if ratio > FAR {
                let place = place.grown(MARGIN * place.diagonal());
                let inside = shares(surface, region, &place);
                settled.changed |= trim((*part, None), &inside, labels, probabilities);
            } else if ratio < FAR.recip() {
                let parent = surface.condition.tree.parent(usize::from(*part));
                let giver = parent.map_or(*part, |p| p as u16);
                let inside = shares(surface, region, &place);
                settled.changed |= grow(*part, giver, &inside, labels, probabilities);
            }
        }
    }
    settled
}

/// What the larger part of a pair still has beyond its place once atoms are settled is not of it, down to
/// single faces.
pub(crate) fn keep_to_places(surface: &Surface, pairs: &[Twins], labels: &mut [u16]) {
    for Twins { larger, parent, place } in pairs {
        for (face, label) in labels.iter_mut().enumerate() {
            let is_prompt = || surface.seeds.iter().any(|s| s.face as usize == face);
            if label == larger && !place.holds(surface.skin.mesh.centroid(face)) && !is_prompt() {
                *label = *parent;
            }
        }
    }
}

/// Two parts of one kind as a pair, and how much of each atom lies in the place of the larger one.
///
/// They are a pair if they have the same name, one is far larger, and there is about as much of it
/// in its place as the other has. Its place is the other's box, moved no farther than its prompt
/// asks.
fn twins(
    surface: &Surface,
    region: &[usize],
    labels: &[u16],
    [a, b]: [&Sibling; 2],
) -> Option<(Twins, Vec<f64>)> {
    let called = |f: &Sibling| named(surface.condition.text(usize::from(f.part)));
    let size = |f: &Sibling| volume(&thickened(&f.seen));
    let (larger, smaller) = if size(a) > size(b) { (a, b) } else { (b, a) };
    if called(a) != called(b) || size(larger) < LARGER * size(smaller) {
        return None;
    }
    let own = moved(smaller.seen, smaller.at);
    let way = DVec3::select(
        own.min.cmple(larger.at) & larger.at.cmple(own.max),
        DVec3::ZERO,
        larger.at - smaller.at,
    );
    let place = with_leeway(moved(own, way));
    let inside = shares(surface, region, &place);
    let area = |part: u16, counts: &dyn Fn(usize) -> bool| -> f64 {
        let faces = (0..region.len()).filter(|&f| labels[region[f]] == part && counts(region[f]));
        faces.map(|f| surface.skin.mesh.area(f)).sum()
    };
    let kept = area(larger.part, &|a| inside[a] >= OUTSIDE);
    let theirs = area(smaller.part, &|_| true);
    let is_as_much = kept < AS_MUCH * theirs && theirs < AS_MUCH * kept;
    let parent = surface.condition.tree.parent(usize::from(larger.part))? as u16;
    is_as_much.then_some((Twins { larger: larger.part, parent, place }, inside))
}

fn with_leeway(place: Bounds) -> Bounds {
    let by = (LEEWAY * place.size()).max(DVec3::splat(THICK * place.diagonal()));
    Bounds { min: place.min - by, max: place.max + by }
}

/// Parts of one kind: the same noun and the same parent; nothing is said of kinds whose joints differ.
fn kinds(surface: &Surface) -> Vec<Vec<u16>> {
    let tree = &surface.condition.tree;
    let mut kinds: BTreeMap<(Option<usize>, String), Vec<u16>> = BTreeMap::new();
    for part in (0..tree.len()).filter(|&p| p != tree.root()) {
        let noun = noun(surface.condition.text(part));
        if !noun.is_empty() {
            kinds.entry((tree.parent(part), noun)).or_default().push(part as u16);
        }
    }
    let joints = |part: u16| &tree.parts()[usize::from(part)].joints;
    let alike = |kind: &Vec<u16>| kind.windows(2).all(|pair| joints(pair[0]) == joints(pair[1]));
    kinds.into_values().filter(|kind| kind.len() >= 2 && alike(kind)).collect()
}

/// The box of a part that looks like most of its kind, of several the smallest; nothing where none does.
fn usual(siblings: &[Sibling]) -> Option<Bounds> {
    let like = |a: &Sibling| siblings.iter().filter(|b| overlap(&a.seen, &b.seen) > LIKE).count();
    let size = |a: &Sibling| a.seen.diagonal();
    let best = siblings
        .iter()
        .max_by(|a, b| like(a).cmp(&like(b)).then_with(|| size(b).total_cmp(&size(a))))?;
    (like(best) >= siblings.len().div_ceil(2).max(2)).then_some(best.seen)
}

/// For each atom, how much of it lies in a place, 0 to 1.
fn shares(surface: &Surface, region: &[usize], place: &Bounds) -> Vec<f64> {
    let count = region.iter().max().map_or(0, |last| last + 1);
    let (mut inside, mut all) = (vec![0.0; count], vec![f64::MIN_POSITIVE; count]);
    for (face, &a) in region.iter().enumerate() {
        let area = surface.skin.mesh.area(face);
        let held = surface.skin.mesh.corners(face).into_iter().filter(|&x| place.holds(x)).count();
        all[a] += area;
        inside[a] += area * held as f64 / 3.0;
    }
    inside.iter().zip(all).map(|(inside, all)| inside / all).collect()
}

/// Takes what lies outside from a part, for an heir or for whoever is likeliest. Whether there was any.
fn trim(
    (part, heir): (u16, Option<u16>),
    inside: &[f64],
    labels: &[u16],
    probabilities: &mut Probabilities,
) -> bool {
    let is_outside = |region: &usize| labels[*region] == part && inside[*region] < OUTSIDE;
    let outside: Vec<usize> = (0..inside.len()).filter(is_outside).collect();
    for &region in &outside {
        probabilities[region][usize::from(part)] = 0.0;
        heir.iter().for_each(|&heir| probabilities[region][usize::from(heir)] += 1.0);
    }
    !outside.is_empty()
}

fn grow(
    part: u16,
    giver: u16,
    inside: &[f64],
    labels: &[u16],
    probabilities: &mut Probabilities,
) -> bool {
    let own = usize::from(part);
    let is_missed = |&region: &usize| {
        labels[region] == giver && inside[region] > INSIDE && probabilities[region][own] > SLIGHT
    };
    let missed: Vec<usize> = (0..inside.len()).filter(is_missed).collect();
    missed.iter().for_each(|&region| probabilities[region][own] += 1.0);
    !missed.is_empty()
}

fn moved(bounds: Bounds, by: DVec3) -> Bounds {
    Bounds { min: bounds.min + by, max: bounds.max + by }
}

fn volume(x: &Bounds) -> f64 {
    x.size().max(DVec3::ZERO).element_product()
}

fn thickened(x: &Bounds) -> Bounds {
    x.grown(THICK / 2.0 * x.diagonal())
}

/// What two boxes have in common, as a share of their union.
fn overlap(a: &Bounds, b: &Bounds) -> f64 {
    let [a, b] = [a, b].map(thickened);
    let both = volume(&Bounds { min: a.min.max(b.min), max: a.max.min(b.max) });
    both / (volume(&a) + volume(&b) - both).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use object::weld::Weld;
    use object::{Condition, Mesh};

    use super::*;
    use crate::classic::segment::prompts::seeds::Seed;
    use crate::classic::segment::skin::Skin;

    /// How many squares the strip has.
    const SQUARES: u32 = 20;
    /// Where four keys of three squares each lie, and where their prompts do.
    const KEYS: [u32; 4] = [1, 6, 11, 16];

    /// A strip of squares, each two faces.
    fn strip() -> Mesh {
        let at = |i: u32| DVec3::new(f64::from(i / 2), f64::from(i % 2), 0.0);
        let square = |i: u32| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]];
        let corners = (0..2 * SQUARES + 2).map(at).collect();
        Mesh::new(corners, (0..SQUARES).flat_map(square).collect()).unwrap()
    }

    /// A board with keys of these names.
    fn keyboard(names: &[&str]) -> Condition {
        let key = |name: &&str| {
            format!(r#"{{"name": "{name}", "parent": "board", "joint": "prismatic"}}"#)
        };
        let keys: Vec<String> = names.iter().map(key).collect();
        let parts = format!(r#"{{"name": "board"}}, {}"#, keys.join(", "));
        let text = format!(r#"{{"schema": "kinfold-condition/1", "up": "z", "parts": [{parts}]}}"#);
        Condition::from_json(&text).unwrap()
    }

    /// The part of each square after what is believed of it is settled, and whether anything changed: a
    /// square is an atom unless it is one with another, and the prompts lie on some squares.
    fn asked(
        condition: &Condition,
        before: &[u16],
        (prompts, one): (&[u32], &[(usize, usize)]),
    ) -> (Vec<u16>, bool) {
        let row = |part: &u16| {
            let mut row = vec![0.2; condition.tree.len()];
            row[usize::from(*part)] = 0.8;
            row
        };
        let mut probabilities: Probabilities = before.iter().map(row).collect();
        let seed = |(i, square): (usize, &u32)| Seed { face: 2 * square, part: i as u16 + 1 };
        let seeds: Vec<Seed> = prompts.iter().enumerate().map(seed).collect();
        let mesh = strip();
        let skin = Skin::of(&mesh, &Weld::new(&mesh));
        let surface = Surface { skin: &skin, condition, seeds: &seeds };
        let of = |square: usize| one.iter().find(|o| o.0 == square).map_or(square, |o| o.1);
        let region: Vec<usize> = (0..2 * SQUARES as usize).map(|face| of(face / 2)).collect();
        let settled = settle(&surface, &region, before, &mut probabilities);
        let likeliest = |row: &Vec<f32>| {
            (0..row.len()).reduce(|a, b| if row[b] > row[a] { b } else { a }).unwrap() as u16
        };
        let mut labels: Vec<u16> = region.iter().map(|&a| likeliest(&probabilities[a])).collect();
        keep_to_places(&surface, &settled.twins, &mut labels);
        (labels.into_iter().step_by(2).collect(), settled.changed)
    }

    /// The part of each square before and after, and whether anything changed; of four keys the last has
    /// those of `last`.
    fn settled(last: &[u32]) -> (Vec<u16>, Vec<u16>, bool) {
        let key_at = |square: u32| {
            let key = KEYS[..3].iter().position(|k| (*k..k + 3).contains(&square));
            let key = key.or(last.contains(&square).then_some(3));
            key.map_or(0, |k| k as u16 + 1)
        };
        let before: Vec<u16> = (0..SQUARES).map(key_at).collect();
        let condition = keyboard(&["key_1", "key_2", "key_3", "key_4"]);
        let (after, changed) = asked(&condition, &before, (&KEYS.map(|k| k + 1), &[]));
        (before, after, changed)
    }

    /// The same of two keys of three squares at both ends, of which the last has more, and where some
    /// squares are one.
    fn pair(names: [&str; 2], more: &[u32], one: &[(usize, usize)]) -> (Vec<u16>, bool) {
        let part_at = |square: u32| match square {
            0..3 => 1,
            17..20 => 2,
            _ if more.contains(&square) => 2,
            _ => 0,
        };
        let before: Vec<u16> = (0..SQUARES).map(part_at).collect();
        asked(&keyboard(&names), &before, (&[1, 18], one))
    }

    #[test]
    fn a_key_as_large_as_the_others_stays_as_it_is() {
        let (before, after, changed) = settled(&[16, 17, 18]);
        assert!(!changed && before == after);
        assert!(!settled(&[16, 17, 18, 19]).2, "a little larger is no matter");
    }

    #[test]
    fn what_a_key_far_larger_than_the_others_has_beyond_its_place_is_not_its_own() {
        let (before, after, changed) = settled(&[9, 10, 14, 16, 17, 18]);
        assert!(changed && before[9] == 4 && before[14] == 4);
        assert_eq!(after[9..], [0, 0, 3, 3, 3, 0, 0, 4, 4, 4, 0]);
    }

    #[test]
    fn what_a_key_far_smaller_than_the_others_lacks_is_its_own() {
        let (before, after, changed) = settled(&[17]);
        assert!(changed && before[16] == 0);
        assert_eq!(after[14..], [0, 0, 4, 4, 4, 0]);
    }

    #[test]
    fn of_two_that_are_called_the_same_the_larger_keeps_to_its_place() {
        let (keys, more) = (["left_key", "right_key"], [8, 9, 12, 16]);
        let alike = [[1; 3].as_slice(), &[0; 14], &[2; 3]].concat();
        assert_eq!(pair(keys, &more, &[]), (alike.clone(), true));
        assert_eq!(pair(keys, &more, &[(16, 17)]).0, alike, "down to the faces of one atom");
        assert_eq!(pair(keys, &[], &[]), (alike, false), "as large as the other");
    }

    #[test]
    fn two_that_are_called_otherwise_may_differ() {
        let (labels, changed) = pair(["hour_hand", "minute_hand"], &[8, 9, 12], &[]);
        assert!(!changed && labels[8] == 2);
    }

    #[test]
    fn a_part_with_nothing_in_its_place_is_no_pair() {
        let before = [[1; 3].as_slice(), &[0; 5], &[2; 9], &[0; 3]].concat();
        let asked = asked(&keyboard(&["left_key", "right_key"]), &before, (&[1, 18], &[]));
        assert_eq!(asked, (before, false));
    }

    #[test]
    fn where_no_two_are_alike_nothing_is_usual() {
        let sibling = |width: f64| {
            let seen = Bounds { min: DVec3::ZERO, max: DVec3::new(width, 1.0, 1.0) };
            Sibling { part: 0, at: DVec3::ZERO, seen }
        };
        assert!(usual(&[1.0, 3.0, 9.0].map(sibling)).is_none());
        assert!(usual(&[1.0, 1.1, 9.0].map(sibling)).is_some_and(|b| b.max.x == 1.0));
        assert!(usual(&[]).is_none());
    }

    #[test]
    fn flat_boxes_overlap_too() {
        let flat = |width: f64| Bounds { min: DVec3::ZERO, max: DVec3::new(width, 1.0, 0.0) };
        assert!(overlap(&flat(1.0), &flat(1.2)) > 0.7 && overlap(&flat(1.0), &flat(4.0)) < 0.3);
    }
}
