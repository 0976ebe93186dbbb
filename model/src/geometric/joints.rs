//! From labelled parts to joints: candidates, a choice, a range.

use object::weld::Weld;
use object::{DVec3, JointKind, JointMotion, KinematicTree, Mesh, Part, Range};
use rayon::prelude::*;

use super::candidates::{directions, slides, turns};
use super::features::COUNT;
use super::opinions::united;
use super::range::Travel;
use super::scene::Scene;
use super::score::scores;
use super::setting::Setting;
use super::sweep::Axis;
use super::vote::{Ballot, vote};
use super::words::Role;
use crate::articulate::Note;

/// How many axes of an endless joint are tried all the way round.
const SPINS: usize = 16;
/// What turning all the way round is worth against not turning at all.
const ROUND: f64 = 6.0;
/// An axle or a hinge comes this near both its parts somewhere along its line; the verdict asks for
/// 5 % of the diagonal.
const NEAR: f64 = 0.047;
/// Two joints of one part share their axis, as a cap that turns and lifts does.
const SHARED_AXIS: f64 = 3.0;

/// A mesh whose faces have parts: what joints are fitted to.
#[derive(Clone, Copy, Debug)]
pub struct Labelled<'a> {
    /// The surface.
    pub mesh: &'a Mesh,
    /// Its connectivity.
    pub weld: &'a Weld,
    /// Parts and joint kinds; every part has a face.
    pub tree: &'a KinematicTree,
    /// The part of each face.
    pub part_of_face: &'a [u16],
    /// What the object is, in words; may be empty.
    pub category: &'a str,
}

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
    /// Its numbers, in the order of [`super::features::NAMES`].
    pub features: [f64; COUNT],
}

/// Finds axis, pivot and range of every joint, parents before children, siblings together. What else the
/// part of each face might be, in any number of labellings, counts where axes are placed (see
/// [`super::opinions`]); a part that one of them leaves without a face is not asked about there.
pub fn fit_joints(from: &Labelled, others: &[Vec<u16>], seed: u64) -> Joints {
    fit_watched((from, others), seed, |_| ())
}

/// How the joints of one part were found.
#[cfg_attr(not(test), allow(dead_code, reason = "only the golden test looks at it"))]
pub(super) struct Fitted<'a> {
    /// The part and what is around it.
    pub setting: &'a Setting<'a>,
    /// For each of its joints, the candidates as several labellings have them.
    pub united: Vec<&'a Ballot>,
    /// The same after siblings were heard.
    pub voted: Vec<&'a Ballot>,
    /// What was found.
    pub travels: Vec<Travel>,
}

/// [`fit_joints`], telling of each part how its joints were found.
pub(super) fn fit_watched(
    (from, others): (&Labelled, &[Vec<u16>]),
    seed: u64,
    mut watch: impl FnMut(&Fitted),
) -> Joints {
    let scene = Scene::new(from, seed);
    let others: Vec<Other> = others.iter().map(|labels| Other::new(from, labels, seed)).collect();
    let tree = from.tree;
    let mut motions = vec![Vec::new(); tree.len()];
    let mut notes: Vec<Vec<Note>> = vec![Vec::new(); tree.len()];
    for &parent in tree.root_first() {
        let parent_axis = shared_axis(&motions[parent]);
        let setting = |p| Setting::new(&scene, from, p, parent_axis, seed);
        let settings: Vec<Setting> = tree.children(parent).filter_map(setting).collect();
        let heard = |setting: &Setting| {
            let of = |other: &Other| other.ballots(setting.part, parent_axis, seed);
            let theirs: Vec<Vec<Ballot>> = others.par_iter().filter_map(of).collect();
            let of = |joint: usize| theirs.iter().filter_map(|b| b.get(joint)).collect::<Vec<_>>();
            let own = ballots(setting, tree).into_iter().enumerate();
            own.map(|(joint, own)| united(own, &of(joint))).collect::<Vec<Ballot>>()
        };
        let united: Vec<Ballot> = settings.par_iter().flat_map(heard).collect();
        let ballots = vote(&united);
        for setting in &settings {
            let own: Vec<&Ballot> = ballots.iter().filter(|b| b.part == setting.part).collect();
            let travels = fit_part(setting, &own);
            let name = &tree.parts()[setting.part].name;
            notes[setting.part] = travels.iter().filter_map(|t| doubt(name, t)).collect();
            let fitted = own.iter().zip(&travels).map(|(b, t)| motion(setting, b.kind, t));
            motions[setting.part] = fitted.collect();
            let united = united.iter().filter(|b| b.part == setting.part).collect();
            watch(&Fitted { setting, united, voted: own, travels });
        }
    }
    Joints { motions, notes: notes.concat() }
}

/// The same mesh with other labels.
struct Other<'a> {
    from: Labelled<'a>,
    scene: Scene,
    /// Whether each part has a face.
    is_there: Vec<bool>,
}

impl<'a> Other<'a> {
    fn new(from: &Labelled<'a>, part_of_face: &'a [u16], seed: u64) -> Self {
        let from = Labelled { part_of_face, ..*from };
        let mut is_there = vec![false; from.tree.len()];
        part_of_face.iter().for_each(|&part| is_there[usize::from(part)] = true);
        Self { from, scene: Scene::new(&from, seed), is_there }
    }

    /// The scored candidates of each joint of a part; nothing where the part or what it hangs on has no
    /// face.
    fn ballots(&self, part: usize, parent_axis: Option<DVec3>, seed: u64) -> Option<Vec<Ballot>> {
        let tree = self.from.tree;
        if !(self.is_there[part] && self.is_there[tree.parent(part)?]) {
            return None;
        }
        let setting = Setting::new(&self.scene, &self.from, part, parent_axis, seed)?;
        Some(ballots(&setting, tree))
    }
}

/// The axis the children of a part may share: its turn's, else its slide's.
pub fn shared_axis(motions: &[JointMotion]) -> Option<DVec3> {
    let turn = motions.iter().find(|m| m.kind.turns());
    turn.or(motions.first()).map(|m| m.axis)
}

/// The scored candidates of each joint of one part.
fn ballots(setting: &Setting, tree: &KinematicTree) -> Vec<Ballot> {
    let Part { joints, text, .. } = &tree.parts()[setting.part];
    let role = setting.meaning.role;
    let stem: String = text.chars().filter(|c| !c.is_ascii_digit()).collect();
    let ballot = |(joint, &kind): (usize, &JointKind)| {
        let role = if kind == JointKind::Continuous { endless(role) } else { role };
        let found = candidates(setting, kind);
        let features: Vec<&[f64; COUNT]> = found.iter().map(|c| &c.features).collect();
        let scores = scores(&features, kind, role).into_iter();
        let axes = scores.zip(&found).map(|(score, c)| (score, c.axis)).collect();
        Ballot { part: setting.part, joint, kind, role, stem: stem.clone(), axes }
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
fn fit_part(setting: &Setting, ballots: &[&Ballot]) -> Vec<Travel> {
    let mut order: Vec<usize> = (0..ballots.len()).collect();
    order.sort_by_key(|&i| !ballots[i].kind.turns());
    let mut found: Vec<Option<Travel>> = vec![None; ballots.len()];
    for i in order {
        let shared = found.iter().flatten().next().map(|t| t.axis.direction);
        found[i] = fit_one(setting, ballots[i], shared);
    }
    found.into_iter().flatten().collect()
}

/// The likeliest axis that comes near what stays.
fn fit_one(setting: &Setting, ballot: &Ballot, shared: Option<DVec3>) -> Option<Travel> {
    let alike = |a: &Axis| shared.map_or(0.0, |s| SHARED_AXIS * s.dot(a.direction).powi(8));
    let mut ranked: Vec<(f64, Axis)> =
        ballot.axes.iter().map(|(s, a)| (s + alike(a), *a)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    if let Some(first) = ranked.iter().position(|(_, a)| comes_near(setting, a)) {
        ranked.drain(..first);
    }
    let &(_, axis) = ranked.first()?;
    if ballot.kind == JointKind::Continuous {
        let axis = spinning(setting, &ranked).unwrap_or(axis);
        let travel = Travel { axis, range: Range::Continuous, stuck: false, rough: false };
        return Some(travel.facing());
    }
    Some(setting.travel(&axis, ballot.role).facing())
}

/// Whether an axis comes near both what moves and what stays; a slide's may be anywhere.
pub(super) fn comes_near(setting: &Setting, axis: &Axis) -> bool {
    !axis.turns || setting.gap(axis) < NEAR
}

/// The axis about which the part turns all the way round, the likeliest if there are several; where
/// the part is stopped about each of them, what it does before that counts with the likelihood.
fn spinning(setting: &Setting, ranked: &[(f64, Axis)]) -> Option<Axis> {
    let best = ranked.first()?.0;
    let near = ranked.iter().take(SPINS).filter(|(_, a)| comes_near(setting, a));
    let worth = |&(score, axis): &(f64, Axis)| (score - best + ROUND * setting.spin(&axis), axis);
    let all: Vec<(f64, Axis)> = near.map(worth).collect();
    all.into_iter().reduce(|a, b| if b.0 > a.0 { b } else { a }).map(|(_, axis)| axis)
}

/// All candidates of one joint, measured.
pub fn candidates(setting: &Setting, kind: JointKind) -> Vec<Candidate> {
    let from = setting.sources();
    let directions = directions(&from);
    let axes = if kind.turns() { turns(&from, &directions) } else { slides(&from, &directions) };
    let mirrors: Vec<(DVec3, [f64; 2])> =
        directions.par_iter().map(|&d| (d, setting.mirror(d))).collect();
    let measure = |axis: &Axis| {
        let mirror = mirrors.iter().find(|(d, _)| *d == axis.direction);
        let mirror = mirror.map_or([0.0; 2], |m| m.1);
        Candidate { axis: *axis, features: setting.features(axis, &directions, mirror) }
    };
    axes.par_iter().map(measure).collect()
}

/// The joint in the mesh's own frame and unit.
fn motion(setting: &Setting, kind: JointKind, travel: &Travel) -> JointMotion {
    let scene = setting.scene;
    let pivot = setting.pivot(&travel.axis) * scene.unit + scene.origin;
    let range = match travel.range {
        Range::Limits { lower, upper } if !kind.turns() => {
            Range::Limits { lower: lower * scene.unit, upper: upper * scene.unit }
        }
        angle => angle,
    };
    JointMotion { kind, axis: travel.axis.direction.normalize(), pivot, range }
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
