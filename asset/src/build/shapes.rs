//! The shapes of an asset's parts, before anything is weighed.

use glamx::DVec3;
use object::condition::{GivenJoints, TrueSize};
use object::mesh::Bounds;
use object::{ArticulatedObject, Confidence, JointMotion, Mesh, Range};
use rayon::prelude::*;

use crate::build::measures::Measures;
use crate::change::Change;
use crate::collision::piece::ConvexPiece;
use crate::collision::settle::{Collision, collision};
use crate::error::{AssetError, whole_surface};
use crate::joints::stays;
use crate::mass::materials::thickness;
use crate::mass::weigh::enclosed;
use crate::parts::motions;
use crate::surface::caps;
use crate::surface::orient::Scene;
use crate::surface::repair::repair;
use crate::surface::repaired::Surface;
use crate::surface::simplify::{FACE_BUDGET, joined, simplified};

/// The parts of an asset as they look, collide and move, before anything is weighed: metres, z up, the
/// base centred at x = y = 0 and all above z = 0. Made by [`shape`], finished by [`crate::finish`].
#[derive(Clone, Debug, PartialEq)]
pub struct Shapes {
    /// Metres per unit of the object's mesh.
    pub(crate) scale: f64,
    /// Where the origin of the object's frame lies, metres.
    pub(crate) offset: DVec3,
    /// For each part of the condition, its index in the object.
    pub(crate) part_of_condition: Vec<Option<usize>>,
    /// Diagonals of the parts before they were repaired, metres.
    pub(crate) diagonals: Vec<f64>,
    /// All surfaces one after the other, joints as cleared.
    pub(crate) object: ArticulatedObject,
    /// Motions before they were cleared.
    pub(crate) wanted: Vec<Vec<JointMotion>>,
    /// Repaired surfaces, closed where they move.
    pub(crate) surfaces: Vec<Surface>,
    /// The surfaces less what other parts hide for good.
    pub(crate) seen: Vec<Mesh>,
    /// Convex pieces of each part.
    pub(crate) pieces: Vec<Vec<ConvexPiece>>,
    /// What was altered so far.
    pub(crate) changes: Vec<Change>,
    /// How likely the object is right, if that is known; places in its mesh's frame and unit.
    pub(crate) confidence: Option<Confidence>,
}

impl Shapes {
    /// The same, with how likely the object is right that they were made of.
    #[must_use]
    pub fn with_confidence(self, confidence: Option<Confidence>) -> Self {
        Self { confidence, ..self }
    }
}

/// Repairs an object's surfaces, makes its collision pieces and clears them along every range.
///
/// `part_of_condition` gives, for each part of the condition, its index in the object (`None` if it
/// got no face). Nothing of the condition but its measures is asked for.
///
/// # Errors
/// [`AssetError`], naming the part, the rule and what was found.
pub fn shape(
    object: &ArticulatedObject,
    measures: &Measures,
    part_of_condition: &[Option<usize>],
    seed: u64,
) -> Result<Shapes, AssetError> {
    let tree = object.tree();
    let own = measures.of_parts(part_of_condition, tree)?;
    let (scale, offset) = placement(object, measures.size)?;
    let placed = object.scaled(scale, offset).map_err(whole_surface)?;
    let diagonals = diagonals(&placed);
    let named = own.iter().zip(tree.parts());
    let walls = named.map(|(own, part)| measures.wall(own, &part.text)).zip(&diagonals);
    let walls: Vec<f64> = walls.map(|(wall, diagonal)| thickness(wall, *diagonal)).collect();
    let given: GivenJoints = own.into_iter().map(|part| part.joints).collect();
    let kept = given.kept(motions(&placed), (scale, offset));
    let placed = placed.with_joints(kept)?;
    let (surfaces, object, mut changes) = within_budget(&placed, &walls)?;
    let (object, shortened) = within_a_turn(object)?;
    changes.extend(shortened);
    let wanted = motions(&object);
    let spaces: Vec<Option<f64>> = surfaces.par_iter().map(enclosed).collect();
    let Collision { object, pieces, seen, changes: cleared } =
        collision(&object, (&surfaces, &spaces), &given, seed)?;
    changes.extend(cleared);
    let (motions, stopped) = stays::stop(&object, &seen, &given, seed);
    let object = object.with_joints(motions)?;
    changes.extend(stopped);
    let part_of_condition = part_of_condition.to_vec();
    Ok(Shapes {
        scale,
        offset,
        part_of_condition,
        diagonals,
        object,
        wanted,
        surfaces,
        seen,
        pieces,
        changes,
        confidence: None,
    })
}

/// How a scale comes about.
pub(crate) fn scaled_by(size: Option<TrueSize>) -> String {
    match size {
        Some(size) => format!("{:?} extent is {} m", size.of, size.metres).to_lowercase(),
        None => "no size given: the file's unit is the metre".into(),
    }
}

/// Metres per unit, and where the object's origin comes to lie: the base centred, all above z = 0.
fn placement(
    object: &ArticulatedObject,
    size: Option<TrueSize>,
) -> Result<(f64, DVec3), AssetError> {
    let mesh = object.mesh();
    let scale = size.map_or(1.0, |size| size.scale_for(mesh));
    if !(scale.is_finite() && scale > 0.0) {
        return Err(AssetError::Scale { found: scale, how: scaled_by(size) });
    }
    let root = object.tree().root();
    let base = Bounds::of(object.faces_of(root).flat_map(|f| mesh.corners(f)));
    let foot = base.centre().with_z(mesh.bounds().min.z);
    Ok((scale, foot * -scale))
}

fn diagonals(object: &ArticulatedObject) -> Vec<f64> {
    let corners = |part: usize| object.faces_of(part).flat_map(|f| object.mesh().corners(f));
    (0..object.tree().len()).map(|part| Bounds::of(corners(part)).diagonal()).collect()
}

/// Repaired and closed surfaces within the budget of faces. Closing a surface adds to it, so that
/// what is too much with it is simplified a little further.
fn within_budget(
    placed: &ArticulatedObject,
    walls: &[f64],
) -> Result<(Vec<Surface>, ArticulatedObject, Vec<Change>), AssetError> {
    let mut budget = FACE_BUDGET;
    loop {
        let (simple, mut changes) = simplified(placed.clone(), budget)?;
        let (surfaces, object, closed) = repaired(&simple, walls)?;
        let faces = object.mesh().faces().len();
        if faces <= FACE_BUDGET || budget <= FACE_BUDGET / 4 {
            changes.extend(closed);
            return Ok((surfaces, object, changes));
        }
        budget = budget * 9 / 10 * FACE_BUDGET / faces;
    }
}

/// Every part's repaired surface, closed where it moves, and the object made of them.
fn repaired(
    object: &ArticulatedObject,
    walls: &[f64],
) -> Result<(Vec<Surface>, ArticulatedObject, Vec<Change>), AssetError> {
    let scene = Scene::new(object.mesh());
    let moves = caps::moving(object.tree());
    let one = |part: usize| {
        let name = &object.tree().parts()[part].name;
        let broken = |source| AssetError::Surface { part: format!("part `{name}`"), source };
        let mesh = object.mesh().submesh(object.faces_of(part)).map_err(broken)?;
        let surface = repair(&mesh, scene.as_ref()).map_err(broken)?;
        if !moves[part] {
            return Ok((surface, None));
        }
        let surface = caps::ready(surface, scene.as_ref()).map_err(broken)?;
        caps::close(surface, name, walls[part]).map_err(broken)
    };
    let parts: Vec<usize> = (0..object.tree().len()).collect();
    let parts = parts.into_par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
    let (surfaces, changes): (Vec<Surface>, Vec<_>) = parts.into_iter().unzip();
    let meshes: Vec<&Mesh> = surfaces.iter().map(|s| &s.mesh).collect();
    let (mesh, labels) = joined(&meshes).map_err(whole_surface)?;
    let object = object.with_surface(mesh, labels)?;
    Ok((surfaces, object, changes.into_iter().flatten().collect()))
}

/// Hinges with limits that span more than a turn, shortened at both ends alike.
fn within_a_turn(
    object: ArticulatedObject,
) -> Result<(ArticulatedObject, Vec<Change>), AssetError> {
    use std::f64::consts::TAU;
    let (mut motions, mut changes) = (motions(&object), Vec::new());
    for (part, motion) in
        motions.iter_mut().enumerate().flat_map(|(p, ms)| ms.iter_mut().map(move |m| (p, m)))
    {
        let Range::Limits { lower, upper } = motion.range else { continue };
        // What a person gives is a turn at most, but for rounding.
        if motion.kind.turns() && upper - lower > TAU * (1.0 + 1e-9) {
            let k = TAU / (upper - lower) * (1.0 - 1e-12);
            motion.range = Range::Limits { lower: lower * k, upper: upper * k };
            let said = |l: f64, u: f64| format!("{l:.4} to {u:.4} rad");
            let (before, after) = (said(lower, upper), said(lower * k, upper * k));
            let why = "a hinge with limits spans at most one turn (J3)";
            let name = &object.tree().parts()[part].name;
            changes.push(Change::new(name, "range", before, after, why));
        }
    }
    Ok((object.with_joints(motions)?, changes))
}
