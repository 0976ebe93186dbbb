//! The articulator that asks the network: sample, describe, digest, label, vote, fit.

use std::io::{Read, Seek};

use burn::tensor::Device;
use object::articulated::{JointMotion, Range};
use object::condition::GivenJoint;
use object::kinematics::JointKind;
use object::sample::{SurfacePoint, sample_surface};
use object::weld::{Weld, nearest_face, nearest_on_triangle};
use object::{ArticulatedObject, Condition, DVec3, Mesh};

use crate::articulate::{Articulate, ArticulateError, Articulation, Note};
use crate::classic::joints::given;
use crate::features::geometric::Surroundings;
use crate::features::{
    FeatureError, GeometricFeatures, NgramText, PointFeatures, TextFeatures, UnitCube,
};
use crate::fit::survive::{Survivors, survivors};
use crate::fit::{
    Bounds, Displacement, FaceVotes, Mode, fit_axis, label_faces, slide_bounds, turn_bounds,
};
use crate::net::{
    Example, JointCase, JointRows, Memory, MotionType, Network, NetworkError, PartPrompt, Points,
    Precision, Vote,
};
use crate::weights::{WeightsError, load_network};

/// The network with its encoders.
#[derive(Debug)]
pub struct Neural {
    network: Network,
    text: Box<dyn TextFeatures>,
    identity: String,
}

/// Why the network could not be set up.
#[derive(Debug, thiserror::Error)]
pub enum NeuralError {
    /// The weights cannot be used.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// Weights trained with an encoder that is not here.
    #[error("the weights want the {what} encoder `{wanted}`, here is `{here}`")]
    Encoder {
        /// `text` or `point`.
        what: &'static str,
        /// What the weights say.
        wanted: String,
        /// What this program has.
        here: String,
    },
    /// A network that reads texts of another width.
    #[error("the network reads texts of {wanted} numbers, the encoder `{encoder}` gives {found}")]
    TextWidth {
        /// What the network's sizes say.
        wanted: usize,
        /// The encoder.
        encoder: String,
        /// Its width.
        found: usize,
    },
}

/// One query point's vote on one joint of the condition.
#[derive(Clone, Copy, Debug)]
struct Ballot {
    query: u32,
    part: u16,
    motion: MotionType,
    vote: Vote,
}

/// Queries, their labels, and their votes.
struct Survey {
    queries: Vec<SurfacePoint>,
    label: Vec<u16>,
    ballots: Vec<Ballot>,
}

impl Neural {
    /// Reads a network from safetensors, with the embedded encoders and in full precision; `name`
    /// becomes part of its identity, so it must change when the weights do.
    ///
    /// # Errors
    /// [`NeuralError`] when the weights do not fit or want other encoders.
    pub fn load(weights: impl Read + Seek, name: &str) -> Result<Self, NeuralError> {
        Self::load_with(weights, Box::new(NgramText), name, Precision::Full)
    }

    /// The same with another encoder of texts, the one the weights were trained with, and in a
    /// precision that becomes part of its identity, too.
    ///
    /// # Errors
    /// [`NeuralError`] when the weights do not fit or want other encoders.
    pub fn load_with(
        weights: impl Read + Seek,
        text: Box<dyn TextFeatures>,
        name: &str,
        precision: Precision,
    ) -> Result<Self, NeuralError> {
        let (network, header) = load_network(weights, &Device::flex(), precision)?;
        same("text", &header.text, &text.identity())?;
        same("point", &header.points, &GeometricFeatures.identity())?;
        let (wanted, found) = (network.config().text, text.width());
        if wanted != found {
            return Err(NeuralError::TextWidth { wanted, encoder: text.identity(), found });
        }
        Ok(Self { text, ..Self::new(network, name) })
    }

    /// A network that is already at hand, with the embedded encoders.
    pub fn new(network: Network, name: &str) -> Self {
        let precision = match network.precision() {
            Precision::Full => "",
            Precision::Half => " half",
        };
        let identity = format!("neural/1 {name}{precision}");
        Self { network, text: Box::new(NgramText), identity }
    }

    fn survey(
        &self,
        scene: &Scene,
        condition: &Condition,
        seed: u64,
    ) -> Result<Survey, NeuralFailure> {
        let config = self.network.config();
        let shape = scene.points(&sample_surface(scene.mesh, config.points, seed))?;
        let parts = scene.prompts(condition, self.text.as_ref())?;
        let example = Example { shape, parts, ..Example::default() };
        let question = self.network.question(&example).map_err(NetworkError::from)?;
        let memory = self.network.digest(&question)?;
        let queries = sample_surface(scene.mesh, config.queries, seed.wrapping_add(1));
        let mut survey = Survey { queries, label: vec![], ballots: vec![] };
        for from in (0..survey.queries.len()).step_by(config.chunk) {
            let to = survey.queries.len().min(from + config.chunk);
            self.ask(scene, condition, &memory, (from, to), &mut survey)?;
        }
        Ok(survey)
    }

    /// Labels one chunk of queries and takes their votes on the joints of the parts they chose.
    fn ask(
        &self,
        scene: &Scene,
        condition: &Condition,
        memory: &Memory,
        (from, to): (usize, usize),
        survey: &mut Survey,
    ) -> Result<(), NeuralFailure> {
        let points = scene.points(&survey.queries[from..to])?;
        let labels = self.network.labels(memory, &points)?;
        let (rows, asked) = joint_rows(condition, &labels.part);
        let votes = self.network.votes(memory, &labels, &rows)?;
        let ballots = asked.into_iter().zip(votes).map(|((query, part, motion), vote)| Ballot {
            query: from as u32 + query,
            part,
            motion,
            vote,
        });
        survey.ballots.extend(ballots);
        survey.label.extend(labels.part);
        Ok(())
    }
}

fn same(what: &'static str, wanted: &str, here: &str) -> Result<(), NeuralError> {
    if wanted == here {
        return Ok(());
    }
    Err(NeuralError::Encoder { what, wanted: wanted.into(), here: here.into() })
}

/// For every query, every motion type of its part: rows for the joint head, and who was asked what.
#[allow(clippy::type_complexity)]
fn joint_rows(condition: &Condition, label: &[u16]) -> (JointRows, Vec<(u32, u16, MotionType)>) {
    let mut rows = JointRows::default();
    let mut asked = Vec::new();
    for (p, part) in condition.tree.parts().iter().enumerate() {
        for motion in part.joints.iter().map(|&kind| motion_type(kind)) {
            let case = rows.cases.len() as u32;
            let parent = part.parent.unwrap_or(p) as u32;
            rows.cases.push(JointCase { parent, child: p as u32, motion });
            let mine = (0u32..).zip(label).filter(|(_, l)| usize::from(**l) == p);
            for (query, _) in mine {
                rows.query.push(query);
                rows.case.push(case);
                asked.push((query, p as u16, motion));
            }
        }
    }
    (rows, asked)
}

fn motion_type(kind: JointKind) -> MotionType {
    if kind.turns() { MotionType::Revolute } else { MotionType::Prismatic }
}

/// A mesh, measured, in its unit cube.
struct Scene<'a> {
    mesh: &'a Mesh,
    weld: Weld,
    frame: UnitCube,
    surroundings: Surroundings,
}

impl<'a> Scene<'a> {
    fn new(mesh: &'a Mesh) -> Result<Self, FeatureError> {
        let (weld, frame) = (Weld::new(mesh), UnitCube::of(mesh));
        let surroundings = Surroundings::new(mesh, &weld, frame)?;
        Ok(Self { mesh, weld, frame, surroundings })
    }

    fn points(&self, points: &[SurfacePoint]) -> Result<Points, FeatureError> {
        let single = |v: DVec3| v.to_array().map(|x| x as f32);
        Ok(Points {
            positions: points.iter().map(|p| single(self.frame.inside(p.position))).collect(),
            normals: Some(points.iter().map(|p| single(p.normal)).collect()),
            features: self.surroundings.encode(points)?,
        })
    }

    fn prompts(
        &self,
        condition: &Condition,
        encoder: &dyn TextFeatures,
    ) -> Result<Vec<PartPrompt>, FeatureError> {
        let prompt = |(part, prompt): (&object::Part, &object::condition::Prompt)| {
            let text = if part.text.is_empty() { None } else { Some(encoder.embed(&part.text)?) };
            let on_surface = |p: DVec3| {
                let face = nearest_face(self.mesh, p).0;
                let position = nearest_on_triangle(p, self.mesh.corners(face));
                SurfacePoint { position, normal: self.mesh.normal(face), face: face as u32 }
            };
            let point = prompt.point.map(|p| self.points(&[on_surface(p)])).transpose()?;
            Ok(PartPrompt { text, point })
        };
        condition.tree.parts().iter().zip(&condition.prompts).map(prompt).collect()
    }
}

/// What can go wrong between mesh and votes.
#[derive(Debug, thiserror::Error)]
enum NeuralFailure {
    #[error(transparent)]
    Features(#[from] FeatureError),
    #[error(transparent)]
    Network(#[from] NetworkError),
}

impl From<NeuralFailure> for ArticulateError {
    fn from(failure: NeuralFailure) -> Self {
        Self::Network(failure.to_string())
    }
}

impl Articulate for Neural {
    fn identity(&self) -> String {
        self.identity.clone()
    }

    fn articulate(
        &self,
        mesh: &Mesh,
        condition: &Condition,
        seed: u64,
    ) -> Result<Articulation, ArticulateError> {
        condition.check_points(mesh)?;
        let scene = Scene::new(mesh).map_err(NeuralFailure::from)?;
        let survey = self.survey(&scene, condition, seed)?;
        let face: Vec<u32> = survey.queries.iter().map(|q| q.face).collect();
        let votes = FaceVotes { face: &face, part: &survey.label, parts: condition.tree.len() };
        let mut part_of_face = label_faces(mesh, &scene.weld, votes, Mode::Automatic);
        condition.paint(&mut part_of_face);
        let found = survivors(condition, &part_of_face)?;
        let fit = Fit { scene: &scene, survey: &survey, part_of_face: &part_of_face };
        let (motions, mut notes) = fit.all(condition, &found);
        notes.extend(unheard(condition));
        let scale = condition.size.map_or(1.0, |size| size.scale_for(mesh));
        let given = given::of_parts(condition, &found.part_of_condition, scale);
        let keep = |(motions, given): (Vec<JointMotion>, Vec<GivenJoint>)| {
            let with = |(i, m)| given.get(i).map_or(m, |given| settled(m, given));
            motions.into_iter().enumerate().map(with).collect::<Vec<_>>()
        };
        let motions = motions.into_iter().zip(given).map(keep).collect();
        let Survivors { tree, part_of_condition, part_of_face } = found;
        let object = ArticulatedObject::new(mesh.clone(), tree, part_of_face, motions)?;
        Ok(Articulation { object, part_of_condition, notes, confidence: None })
    }
}

/// What the network was told and has no ear for, part by part: it takes one point.
fn unheard(condition: &Condition) -> impl Iterator<Item = Note> + '_ {
    let parts = condition.tree.parts().iter().zip(&condition.prompts);
    let more = parts.filter(|(_, prompt)| !(prompt.also.is_empty() && prompt.not.is_empty()));
    more.map(|(part, _)| Note {
        part: part.name.clone(),
        message:
            "the network takes one point: further ones, and those that are not of it, do not count"
                .into(),
        loss: true,
    })
}

/// From votes to joints.
struct Fit<'a> {
    scene: &'a Scene<'a>,
    survey: &'a Survey,
    part_of_face: &'a [u16],
}

impl Fit<'_> {
    fn all(&self, condition: &Condition, found: &Survivors) -> (Vec<Vec<JointMotion>>, Vec<Note>) {
        let (mut motions, mut notes) = (Vec::new(), Vec::new());
        for (p, part) in condition.tree.parts().iter().enumerate() {
            let note = |message: &str, loss| Note {
                part: part.name.clone(),
                message: message.into(),
                loss,
            };
            if found.part_of_condition[p].is_none() {
                notes.push(note(
                    "no face of the mesh was found to belong to it, so it is left out",
                    true,
                ));
                continue;
            }
            let fit = |&kind: &JointKind| {
                let (motion, doubt) = self.joint(p as u16, kind);
                notes.extend(doubt.map(|d| {
                    note(d, motion.range == still(kind) && kind != JointKind::Continuous)
                }));
                motion
            };
            motions.push(part.joints.iter().map(fit).collect());
        }
        (motions, notes)
    }

    /// Votes of queries that both chose the part and lie on a face that ended up with it; of all
    /// that chose it where no face of theirs did.
    fn ballots(&self, part: u16, motion: MotionType) -> Vec<&Ballot> {
        let all = self.survey.ballots.iter().filter(|b| b.part == part && b.motion == motion);
        let all: Vec<&Ballot> = all.collect();
        let stayed = |b: &&&Ballot| {
            let face = self.survey.queries[b.query as usize].face;
            self.part_of_face[face as usize] == part
        };
        let kept: Vec<&Ballot> = all.iter().filter(stayed).copied().collect();
        if kept.is_empty() { all } else { kept }
    }

    fn joint(&self, part: u16, kind: JointKind) -> (JointMotion, Option<&'static str>) {
        let ballots = self.ballots(part, motion_type(kind));
        let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let outside = |v: [f32; 3]| self.scene.frame.outside(wide(v));
        let votes = ballots.iter().map(|b| (wide(b.vote.direction), outside(b.vote.closest)));
        let Some(axis) = fit_axis(votes) else {
            return (
                self.unknown(part, kind),
                Some("no points agree on its axis; a still joint about its middle is given"),
            );
        };
        let points: Vec<Displacement> = ballots
            .iter()
            .map(|b| Displacement {
                rest: self.survey.queries[b.query as usize].position,
                lower: outside(b.vote.lower),
                upper: outside(b.vote.upper),
            })
            .collect();
        let bounds =
            if kind.turns() { turn_bounds(axis, &points) } else { slide_bounds(axis, &points) };
        let (range, doubt) = range_of(kind, bounds);
        (JointMotion { kind, axis: axis.direction, pivot: axis.pivot, range }, doubt)
    }

    /// A joint nobody voted for: upright, through the middle of the part's faces, not moving.
    fn unknown(&self, part: u16, kind: JointKind) -> JointMotion {
        let mine = (0..self.part_of_face.len()).filter(|&f| self.part_of_face[f] == part);
        let (mut sum, mut weight) = (DVec3::ZERO, f64::MIN_POSITIVE);
        for face in mine {
            let area = self.scene.mesh.area(face);
            sum += self.scene.mesh.centroid(face) * area;
            weight += area;
        }
        JointMotion { kind, axis: DVec3::Z, pivot: sum / weight, range: still(kind) }
    }
}

/// A joint that was found, with what a person says of it in its place.
fn settled(found: JointMotion, given: &GivenJoint) -> JointMotion {
    let mut motion = found;
    if let Some(axis) = given.axis {
        if motion.axis.dot(axis) < 0.0 {
            motion.range = motion.range.reversed();
        }
        motion.axis = axis;
    }
    motion.pivot = given.pivot.unwrap_or(motion.pivot);
    if motion.kind == JointKind::Continuous {
        return motion;
    }
    if let Some(range) = given.range {
        motion.range = range;
    } else if let Some(open_by) = given.open_by {
        let (_, upper) = motion.range.ends();
        motion.range = Range::Limits { lower: -open_by, upper: upper.max(0.0) };
    }
    motion
}

fn still(kind: JointKind) -> Range {
    match kind {
        JointKind::Continuous => Range::Continuous,
        _ => Range::Limits { lower: 0.0, upper: 0.0 },
    }
}

/// The range of a joint of this kind, and what is doubtful about it.
fn range_of(kind: JointKind, bounds: Option<Bounds>) -> (Range, Option<&'static str>) {
    use std::f64::consts::PI;
    match (kind, bounds) {
        (JointKind::Continuous, _) => (Range::Continuous, None),
        (_, None) => {
            (still(kind), Some("how far it moves could not be told; it is given as still"))
        }
        (_, Some(Bounds::Limits { lower, upper })) => (Range::Limits { lower, upper }, None),
        (_, Some(Bounds::FullTurn)) => {
            let doubt =
                "it seems to turn without end: say `continuous`; half a turn each way is given";
            (Range::Limits { lower: -PI, upper: PI }, Some(doubt))
        }
    }
}
