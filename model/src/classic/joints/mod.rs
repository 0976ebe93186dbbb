//! From labelled parts to joints: candidate axes, a choice among them, and a range of motion.
//!
//! Each moving part gets a few candidate axes, such as box axes, contact directions and hinge
//! lines. Trees and a small network score every candidate by features of shape, contact, words and
//! free motion. Siblings of one kind vote for each other's candidates, then the likeliest wins. A
//! range says how far the joint goes either way.

pub mod axis_model;
pub mod candidates;
pub mod choices;
pub mod contact;
pub mod context;
pub(crate) mod evidence;
pub mod features;
pub(crate) mod given;
pub mod hypotheses;
pub mod labelled;
pub mod looks;
pub mod motion;
pub mod pins;
pub mod range;
pub mod range_model;
pub mod scene;
pub mod siblings;
pub mod sweep;
pub mod ways;

use object::{DVec3, JointKind, JointMotion, KinematicTree, Mesh, Part, Range};
use rayon::prelude::*;

use crate::articulate::Note;
use crate::classic::joints::axis_model::scores;
use crate::classic::joints::candidates::{directions, slides, turns};
use crate::classic::joints::choices::Choices;
use crate::classic::joints::context::JointContext;
use crate::classic::joints::evidence::Heard;
use crate::classic::joints::features::COUNT;
use crate::classic::joints::hypotheses::united;
pub use crate::classic::joints::labelled::Labelled;
use crate::classic::joints::range::Travel;
use crate::classic::joints::scene::Scene;
use crate::classic::joints::siblings::{Ballot, vote};
use crate::classic::joints::sweep::Axis;
use crate::classic::lexicon::words::{Role, stem};

/// How many axes of an endless joint are tried all the way round.
const SPINS: usize = 16;
/// What turning all the way round is worth against not turning at all.
const ROUND: f64 = 6.0;
/// An axle or a hinge comes this near both its parts somewhere along its line; the verdict asks for
/// 5 % of the diagonal.
const NEAR: f64 = 0.047;
/// Labellings that differ by no more than this share of a part's area are as good as one for its axes; a guess,
/// less than what its samples tell apart.
const ALIKE: f64 = 0.01;
/// Two joints of one part share their axis, as a cap that turns and lifts does.
const SHARED_AXIS: f64 = 3.0;

/// Fitted joints, for each part those of the tree in order, and what was noticed.
#[derive(Clone, Debug, PartialEq)]
pub struct Joints {
    /// The motions, in the mesh's unit and frame.
    pub motions: Vec<Vec<JointMotion>>,
    /// Doubts, in order of part.
    pub notes: Vec<Note>,
}

/// A candidate axis and what speaks for it.
pub struct Candidate {
    /// The axis, in scene units.
    pub axis: Axis,
    /// Its numbers, in the order of [`crate::classic::joints::features::NAMES`].
    pub features: [f64; COUNT],
}

/// Finds axis, pivot and range of every joint, parents before children, siblings together. What else the
/// part of each face might be, in any number of labellings, counts where axes are placed (see
/// [`crate::classic::joints::hypotheses`]); a part that one of them leaves without a face is not asked about there.
pub fn fit_joints(from: &Labelled, others: &[Vec<u16>], seed: u64) -> Joints {
    fit_watched((from, others), seed, |_| ())
}

/// Fitted joints and, parents before children, what else was found.
pub(crate) struct Chosen {
    pub joints: Joints,
    /// The axes that each joint was chosen among.
    pub choices: Vec<Choices>,
    /// For each part with joints, what [`evidence::NAMES`] say of each of them.
    pub evidence: Vec<(usize, Vec<[f64; evidence::COUNT]>)>,
}

/// The same, and the axes that each joint was chosen among, and what speaks for it.
pub(crate) fn fit_choosing(from: &Labelled, others: &[Vec<u16>], seed: u64) -> Chosen {
    let (mut choices, mut told) = (Vec::new(), Vec::new());
    let joints = fit_watched((from, others), seed, |fitted| {
        let Fitted { context, heard, voted, travels, .. } = fitted;
        choices.extend(voted.iter().map(|ballot| choices::choices(context, ballot)));
        let each = heard.iter().zip(voted).zip(travels);
        let each = each.map(|((heard, voted), t)| evidence::evidence(context, (heard, voted), t));
        told.push((context.part, each.collect()));
    });
    Chosen { joints, choices, evidence: told }
}

/// How the joints of one part were found.
#[cfg_attr(not(test), allow(dead_code, reason = "only the golden test looks at it"))]
pub(crate) struct Fitted<'a> {
    /// The part and what is around it.
    pub context: &'a JointContext<'a>,
    /// For each of its joints, what was heard of it.
    pub heard: Vec<&'a Heard>,
    /// For each of its joints, the candidates as several labellings have them.
    pub united: Vec<&'a Ballot>,
    /// The same after siblings were heard.
    pub voted: Vec<&'a Ballot>,
    /// What was found.
    pub travels: Vec<Travel>,
}

/// [`fit_joints`], telling of each part how its joints were found.
pub(crate) fn fit_watched(
    (from, others): (&Labelled, &[Vec<u16>]),
    seed: u64,
    mut watch: impl FnMut(&Fitted),
) -> Joints {
    let scene = Scene::new(from, seed);
    let others = Others::new((from, &scene), others, seed);
    let tree = from.tree;
    let mut motions = vec![Vec::new(); tree.len()];
    let mut notes: Vec<Vec<Note>> = vec![Vec::new(); tree.len()];
    for &parent in tree.root_first() {
        let parent_axis = shared_axis(&motions[parent]);
        let context = |p| JointContext::new(&scene, from, p, parent_axis, seed);
        let settings: Vec<JointContext> = tree.children(parent).filter_map(context).collect();
        let heard = |context: &JointContext| {
            let own = ballots(context, tree);
            let theirs = others.ballots((context.part, &own), parent_axis, seed);
            let of = |joint: usize| theirs.iter().filter_map(|b| b.get(joint)).collect::<Vec<_>>();
            let heard = |(joint, own): (usize, Ballot)| {
                let given = context.given(joint);
                let is_placed = given.axis.is_some() || given.pivot.is_some();
                let others = of(joint);
                let united = if is_placed { own.clone() } else { united(own.clone(), &others) };
                Heard { own, others: others.into_iter().cloned().collect(), united }
            };
            own.iter().cloned().enumerate().map(heard).collect::<Vec<Heard>>()
        };
        let heard: Vec<Heard> = settings.par_iter().flat_map(heard).collect();
        let united: Vec<Ballot> = heard.iter().map(|h| h.united.clone()).collect();
        let ballots = vote(&united);
        for context in &settings {
            let own: Vec<&Ballot> = ballots.iter().filter(|b| b.part == context.part).collect();
            let heard = heard.iter().filter(|h| h.united.part == context.part).collect();
            let travels = fit_part(context, &own);
            let name = &tree.parts()[context.part].name;
            notes[context.part] = travels.iter().filter_map(|t| doubt(name, t)).collect();
            let fitted =
                own.iter().zip(&travels).map(|(b, t)| motion(context, (b.joint, b.kind), t));
            motions[context.part] = fitted.collect();
            let united = united.iter().filter(|b| b.part == context.part).collect();
            watch(&Fitted { context, heard, united, voted: own, travels });
        }
    }
    Joints { motions, notes: notes.concat() }
}

/// The same mesh with other labels. Of labels that are alike, joints are fitted once.
struct Others<'a> {
    /// Those unlike the own and one another.
    distinct: Vec<Other<'a>>,
    /// For each, its place among those; nothing for one like the own.
    places: Vec<Option<usize>>,
    tree: &'a KinematicTree,
    /// For the own labels, whether each part has a face.
    is_there: Vec<bool>,
}

impl<'a> Others<'a> {
    fn new((from, scene): (&Labelled<'a>, &Scene), others: &'a [Vec<u16>], seed: u64) -> Self {
        let is_there = has_face(from.tree, from.part_of_face);
        let mut new = Self { distinct: Vec::new(), places: Vec::new(), tree: from.tree, is_there };
        for labels in others {
            let is_known = |known: &Other| known.from.part_of_face == labels;
            let known = new.distinct.iter().position(is_known);
            if labels != from.part_of_face && known.is_none() {
                let known = std::iter::once(scene).chain(new.distinct.iter().map(|o| &o.scene));
                let known: Vec<&Scene> = known.collect();
                let from_labels = from.part_of_face;
                let from = Labelled { part_of_face: labels, ..*from };
                let is_there = has_face(from.tree, labels);
                let other = Scene::beside(&known, &from, seed);
                let is_same = are_alike(from.mesh, [labels, from_labels], from.tree.len());
                new.places.push(Some(new.distinct.len()));
                new.distinct.push(Other { from, scene: other, is_there, is_same });
            } else {
                new.places.push(known);
            }
        }
        new
    }

    /// What each says of a part whose own ballots are known, but for those in which the part or what it hangs
    /// on has no face. What labels that differ elsewhere alone would say are the own ballots.
    fn ballots(
        &self,
        (part, own): (usize, &[Ballot]),
        parent_axis: Option<DVec3>,
        seed: u64,
    ) -> Vec<Vec<Ballot>> {
        let of = |other: &Other| match other.is_alike(part) {
            true => Some(own.to_vec()),
            false => other.ballots(part, parent_axis, seed),
        };
        let distinct: Vec<Option<Vec<Ballot>>> = self.distinct.par_iter().map(of).collect();
        let is_there = are_there((self.tree, &self.is_there), part);
        let of = |place: &Option<usize>| match place {
            Some(place) => distinct[*place].clone(),
            None => is_there.then(|| own.to_vec()),
        };
        self.places.iter().filter_map(of).collect()
    }
}

/// For each part, whether two labellings of a mesh agree on its faces but for [`ALIKE`] of its area.
fn are_alike(mesh: &Mesh, [one, other]: [&[u16]; 2], parts: usize) -> Vec<bool> {
    let (mut all, mut apart) = (vec![0.0; parts], vec![0.0; parts]);
    for (face, (&one, &other)) in one.iter().zip(other).enumerate() {
        let area = mesh.area(face);
        all[usize::from(other)] += area;
        if one != other {
            [one, other].into_iter().for_each(|part| apart[usize::from(part)] += area);
        }
    }
    all.iter().zip(apart).map(|(all, apart)| apart <= ALIKE * all).collect()
}

/// For each part, whether it has a face.
fn has_face(tree: &KinematicTree, part_of_face: &[u16]) -> Vec<bool> {
    let mut is_there = vec![false; tree.len()];
    part_of_face.iter().for_each(|&part| is_there[usize::from(part)] = true);
    is_there
}

/// Whether a part and what it hangs on have faces.
fn are_there((tree, is_there): (&KinematicTree, &[bool]), part: usize) -> bool {
    is_there[part] && tree.parent(part).is_some_and(|parent| is_there[parent])
}

/// The same mesh with some other labels.
struct Other<'a> {
    from: Labelled<'a>,
    scene: Scene,
    /// Whether each part has a face.
    is_there: Vec<bool>,
    /// Whether each part has the faces that the own labels give it, but for [`ALIKE`].
    is_same: Vec<bool>,
}

impl Other<'_> {
    /// Whether a part, all that it carries and what it hangs on have nearly the same faces as by the own labels:
    /// what else is labelled otherwise hardly tells on its axes.
    fn is_alike(&self, part: usize) -> bool {
        let tree = self.from.tree;
        let is_same = |p: usize| self.is_same.get(p).copied().unwrap_or_default();
        tree.parent(part).is_some_and(is_same)
            && (0..tree.len()).filter(|&p| tree.is_under(p, part)).all(is_same)
    }

    /// The scored candidates of each joint of a part; nothing where the part or what it hangs on has no
    /// face.
    fn ballots(&self, part: usize, parent_axis: Option<DVec3>, seed: u64) -> Option<Vec<Ballot>> {
        let tree = self.from.tree;
        if !are_there((tree, &self.is_there), part) {
            return None;
        }
        let context = JointContext::new(&self.scene, &self.from, part, parent_axis, seed)?;
        Some(ballots(&context, tree))
    }
}

/// The axis the children of a part may share: its turn's, else its slide's.
pub fn shared_axis(motions: &[JointMotion]) -> Option<DVec3> {
    let turn = motions.iter().find(|m| m.kind.turns());
    turn.or(motions.first()).map(|m| m.axis)
}

/// The scored candidates of each joint of one part.
fn ballots(context: &JointContext, tree: &KinematicTree) -> Vec<Ballot> {
    let Part { joints, text, .. } = &tree.parts()[context.part];
    let role = context.meaning.role;
    let stem = stem(text);
    let ballot = |(joint, &kind): (usize, &JointKind)| {
        let role = if kind == JointKind::Continuous { endless(role) } else { role };
        let found = candidates(context, kind);
        let features: Vec<&[f64; COUNT]> = found.iter().map(|c| &c.features).collect();
        let scores = scores(&features, kind, role).into_iter();
        let axes = scores.zip(&found).map(|(score, c)| (score, c.axis)).collect();
        let given = context.given(joint);
        let axes = given::narrowed(axes, &given, context.scene, kind.turns());
        Ballot { part: context.part, joint, kind, role, stem: stem.clone(), axes }
    };
    joints.iter().enumerate().map(ballot).collect()
}

/// What a part is that turns without end: no hinge does, so a lid that does is a screw cap.
pub fn endless(role: Role) -> Role {
    match role {
        Role::Door | Role::FallDoor | Role::Lid | Role::Flap => Role::Knob,
        other => other,
    }
}

/// The joints of one part: the turn is found first, the slide then prefers its axis.
fn fit_part(context: &JointContext, ballots: &[&Ballot]) -> Vec<Travel> {
    let mut order: Vec<usize> = (0..ballots.len()).collect();
    order.sort_by_key(|&i| !ballots[i].kind.turns());
    let mut found: Vec<Option<Travel>> = vec![None; ballots.len()];
    for i in order {
        let shared = found.iter().flatten().next().map(|t| t.axis.direction);
        found[i] = fit_one(context, ballots[i], shared);
    }
    found.into_iter().flatten().collect()
}

/// The likeliest axis that comes near what stays.
fn fit_one(context: &JointContext, ballot: &Ballot, shared: Option<DVec3>) -> Option<Travel> {
    let given = context.given(ballot.joint);
    let alike = |a: &Axis| shared.map_or(0.0, |s| SHARED_AXIS * s.dot(a.direction).powi(8));
    let mut ranked: Vec<(f64, Axis)> =
        ballot.axes.iter().map(|(s, a)| (s + alike(a), *a)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let near = |(_, axis): &(f64, Axis)| given.pivot.is_some() || comes_near(context, axis);
    if let Some(first) = ranked.iter().position(near) {
        ranked.drain(..first);
    }
    let &(_, axis) = ranked.first()?;
    if ballot.kind == JointKind::Continuous {
        let axis = spinning(context, &ranked).unwrap_or(axis);
        let (range, said) = (Range::Continuous, None);
        let travel = Travel { axis, range, stuck: false, rough: false, said };
        return Some(given::kept(context, travel.facing(), &given, ballot.role));
    }
    let travel = context.travel(&axis, ballot.role);
    // Positive is opening where ends are given, so it is not turned round for looks.
    let has_ends = given.open_by.is_some() || given.range.is_some();
    let travel = if has_ends { travel } else { travel.facing() };
    Some(given::kept(context, travel, &given, ballot.role))
}

/// Whether an axis comes near both what moves and what stays; a slide's may be anywhere.
pub(crate) fn comes_near(context: &JointContext, axis: &Axis) -> bool {
    !axis.turns || context.gap(axis) < NEAR
}

/// The axis about which the part turns all the way round, the likeliest if there are several; where
/// the part is stopped about each of them, what it does before that counts with the likelihood.
fn spinning(context: &JointContext, ranked: &[(f64, Axis)]) -> Option<Axis> {
    let best = ranked.first()?.0;
    let near = ranked.iter().take(SPINS).filter(|(_, a)| comes_near(context, a));
    let worth = |&(score, axis): &(f64, Axis)| (score - best + ROUND * context.spin(&axis), axis);
    let all: Vec<(f64, Axis)> = near.map(worth).collect();
    all.into_iter().reduce(|a, b| if b.0 > a.0 { b } else { a }).map(|(_, axis)| axis)
}

/// All candidates of one joint, measured.
pub fn candidates(context: &JointContext, kind: JointKind) -> Vec<Candidate> {
    let from = context.sources();
    let directions = directions(&from);
    let axes = if kind.turns() { turns(&from, &directions) } else { slides(&from, &directions) };
    let mirrors: Vec<(DVec3, [f64; 2])> =
        directions.par_iter().map(|&d| (d, context.mirror(d))).collect();
    let measure = |axis: &Axis| {
        let mirror = mirrors.iter().find(|(d, _)| *d == axis.direction);
        let mirror = mirror.map_or([0.0; 2], |m| m.1);
        Candidate { axis: *axis, features: context.features(axis, &directions, mirror) }
    };
    axes.par_iter().map(measure).collect()
}

/// The joint in the mesh's own frame and unit; what is given of it stands there as it was given.
fn motion(
    context: &JointContext,
    (joint, kind): (usize, JointKind),
    travel: &Travel,
) -> JointMotion {
    let scene = context.scene;
    let given = context.given(joint);
    let pivot = context.pivot(&travel.axis) * scene.unit + scene.origin;
    let range = if kind.turns() { travel.range } else { travel.range.scaled(scene.unit) };
    let axis = given.axis.unwrap_or_else(|| travel.axis.direction.normalize());
    let range = given.range.unwrap_or(range);
    JointMotion { kind, axis, pivot: given.pivot.unwrap_or(pivot), range }
}

fn doubt(part: &str, travel: &Travel) -> Option<Note> {
    let message = if travel.stuck {
        "no free motion was found along any likely axis, so the range is a small guess"
    } else if travel.rough {
        "the motion rubs against what stays behind, so its range may need cutting"
    } else {
        return None;
    };
    Some(Note { part: part.into(), message: message.into(), loss: false })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labellings_are_alike_about_a_part_while_they_agree_on_all_but_a_hundredth_of_it() {
        let triangle = |i: u32| {
            [DVec3::X, DVec3::Y, DVec3::ZERO].map(|corner| corner + DVec3::Z * f64::from(i))
        };
        let triangles: Vec<[DVec3; 3]> = (0..350).map(triangle).collect();
        let mesh = Mesh::of_triangles(&triangles).unwrap();
        let own: Vec<u16> = (0..350).map(|i| [0, 0, 1, 2][i / 100]).collect();
        let moved = |faces: std::ops::Range<usize>| {
            let mut other = own.clone();
            other[faces].fill(1);
            are_alike(&mesh, [&own, &other], 3)
        };
        assert_eq!(moved(0..0), [true, true, true]);
        assert_eq!(moved(0..1), [true, true, true]);
        assert_eq!(moved(0..2), [false, false, true]);
        assert_eq!(moved(300..301), [true, true, false]);
    }
}
