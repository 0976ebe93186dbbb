//! The steps from an articulated object to an asset, in order.

use glamx::{DQuat, DVec3};
use object::articulated::ObjectError;
use object::condition::Prompt;
use object::mesh::{Bounds, MeshError};
use object::{ArticulatedObject, Condition, JointMotion, Mesh, Origin, Range, Sourced};
use rayon::prelude::*;

use crate::asset::Asset;
use crate::balance::balance;
use crate::caps;
use crate::change::Change;
use crate::collision::{self, Collision};
use crate::hulls::{ConvexPiece, HullError};
use crate::links;
use crate::mass::{Body, weigh};
use crate::materials::{Substance, substance};
use crate::orient::Scene;
use crate::repair::{Surface, repair};
use crate::simplify::{FACE_BUDGET, joined, simplified};
use crate::standing;
use crate::stays;

/// What may be chosen when an asset is built.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildOptions {
    /// Where axes, pivots and ranges of the object's joints come from; default: the model.
    pub joints: Origin,
    /// Seed of everything that samples.
    pub seed: u64,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { joints: Origin::Model, seed: 0 }
    }
}

/// Why no asset can be built.
#[derive(Debug, thiserror::Error)]
pub enum AssetError {
    /// The map from condition to object does not fit them.
    #[error("the condition has {parts} parts, but {found} are mapped to the object")]
    PartMap {
        /// Parts of the condition.
        parts: usize,
        /// Entries of the map.
        found: usize,
    },
    /// A part of the condition is mapped to a part that is not there.
    #[error("part `{part}` of the condition is mapped to part {index}, but the object has {parts}")]
    UnknownPart {
        /// The condition's part.
        part: String,
        /// The index given.
        index: usize,
        /// Parts of the object.
        parts: usize,
    },
    /// The object has no extent where the condition gives its size.
    #[error("the scale must be a finite number above 0, found {found}: {how}")]
    Scale {
        /// The scale.
        found: f64,
        /// How it came about.
        how: String,
    },
    /// A part without a face that has an area, or a surface that cannot be placed.
    #[error("{part}: no usable surface")]
    Surface {
        /// The part, or the whole object.
        part: String,
        /// The broken rule.
        #[source]
        source: MeshError,
    },
    /// No collision pieces for a part.
    #[error("part `{part}` gets no collision pieces")]
    Collision {
        /// The part.
        part: String,
        /// Why.
        #[source]
        source: HullError,
    },
    /// Every collision piece of a part had to give way to others.
    #[error("part `{0}` keeps no collision piece clear of the other parts")]
    NoPieceLeft(String),
    /// An intermediate result broke a rule of articulated objects.
    #[error(transparent)]
    Object(#[from] ObjectError),
}

/// Everything known about the parts once they are placed, repaired, cleared and weighed.
pub(crate) struct Parts {
    /// Metres, asset frame; joints as cleared.
    pub(crate) object: ArticulatedObject,
    /// Motions before they were cleared, for the record.
    pub(crate) wanted: Vec<Vec<JointMotion>>,
    pub(crate) surfaces: Vec<Surface>,
    /// The surfaces less what other parts hide for good.
    pub(crate) seen: Vec<Mesh>,
    pub(crate) pieces: Vec<Vec<ConvexPiece>>,
    pub(crate) substances: Vec<Substance>,
    pub(crate) bodies: Vec<Body>,
}

/// Builds the asset of an articulated object.
///
/// `part_of_condition` gives, for each part of the condition, its index in the object (`None` if it
/// got no face); materials, masses and friction are taken from there.
///
/// # Errors
/// [`AssetError`], naming the part, the rule and what was found.
pub fn build(
    object: &ArticulatedObject,
    condition: &Condition,
    part_of_condition: &[Option<usize>],
    options: &BuildOptions,
) -> Result<Asset, AssetError> {
    let prompts = prompts(object, condition, part_of_condition)?;
    let (scale, offset) = placement(object, condition)?;
    let placed = placed(object, scale.value, offset)?;
    let substances = substances(&placed, condition, &prompts);
    let walls: Vec<f64> = substances.iter().map(|s| s.wall.value).collect();
    let (surfaces, object, mut changes) = within_budget(&placed, &walls)?;
    let (object, shortened) = within_a_turn(object)?;
    changes.extend(shortened);
    let wanted = motions(&object);
    let Collision { object, pieces, seen, changes: cleared } =
        collision::collision(&object, &surfaces, options)?;
    changes.extend(cleared);
    let (motions, stopped) = stays::stop(&object, &seen, options.seed);
    let object = object.with_joints(motions)?;
    changes.extend(stopped);
    let weighed = surfaces.par_iter().zip(&pieces).zip(&substances);
    let mut bodies: Vec<Body> = weighed.map(|((s, p), m)| weigh(s, p, m)).collect();
    let stated: Vec<bool> = substances.iter().map(|s| s.mass.is_some()).collect();
    changes.extend(balance(object.tree(), &mut bodies, &stated));
    changes.extend(standing::weighted(&object, &pieces, &mut bodies, &stated));
    changes.extend(balance(object.tree(), &mut bodies, &stated));
    let parts = Parts { object, wanted, surfaces, seen, pieces, substances, bodies };
    let (mut parts, turn, shift) = standing::upright(parts)?;
    if turn != DQuat::IDENTITY {
        changes.push(standing::told(turn));
        let Parts { object, pieces, bodies, .. } = &mut parts;
        changes.extend(standing::weighted(object, pieces, bodies, &stated));
        changes.extend(balance(object.tree(), bodies, &stated));
    }
    changes.extend(standing::levelled(&parts.object, &mut parts.pieces, &parts.bodies));
    let size = size(&parts.surfaces, &scale);
    let (links, joints) = links::assemble(parts, options.joints);
    let category = condition.category.clone();
    let name = asset_name(&category);
    let offset = turn * offset + shift;
    Ok(Asset { name, category, scale, turn, offset, size, links, joints, changes })
}

fn asset_name(category: &str) -> String {
    let ascii: String = category.chars().filter(char::is_ascii).collect();
    let named = ascii.chars().any(|c| c.is_ascii_alphanumeric());
    object::condition::name_from_text(if named { &ascii } else { "object" }, &[])
}

/// For each part of the object, what the condition says of it.
fn prompts<'a>(
    object: &ArticulatedObject,
    condition: &'a Condition,
    part_of_condition: &[Option<usize>],
) -> Result<Vec<Option<&'a Prompt>>, AssetError> {
    let (parts, found) = (condition.tree.len(), part_of_condition.len());
    if parts != found {
        return Err(AssetError::PartMap { parts, found });
    }
    let mut prompts = vec![None; object.tree().len()];
    for ((part, prompt), index) in
        condition.tree.parts().iter().zip(&condition.prompts).zip(part_of_condition)
    {
        let Some(index) = *index else { continue };
        let parts = prompts.len();
        let unknown = || AssetError::UnknownPart { part: part.name.clone(), index, parts };
        *prompts.get_mut(index).ok_or_else(unknown)? = Some(prompt);
    }
    Ok(prompts)
}

/// Metres per unit, and where the object's origin comes to lie: the base centred, all above z = 0.
fn placement(
    object: &ArticulatedObject,
    condition: &Condition,
) -> Result<(Sourced<f64>, DVec3), AssetError> {
    let mesh = object.mesh();
    let scale = match &condition.size {
        Some(size) => {
            let how = format!("{:?} extent is {} m", size.of, size.metres).to_lowercase();
            Sourced::new(size.scale_for(mesh), condition.origin, how)
        }
        None => Sourced::new(1.0, Origin::Default, "no size given: the file's unit is the metre"),
    };
    if !(scale.value.is_finite() && scale.value > 0.0) {
        return Err(AssetError::Scale { found: scale.value, how: scale.how });
    }
    let root = object.tree().root();
    let base = Bounds::of(object.faces_of(root).flat_map(|f| mesh.corners(f)));
    let foot = base.centre().with_z(mesh.bounds().min.z);
    let offset = foot * -scale.value;
    Ok((scale, offset))
}

fn placed(
    object: &ArticulatedObject,
    scale: f64,
    offset: DVec3,
) -> Result<ArticulatedObject, AssetError> {
    object.scaled(scale, offset).map_err(whole_surface)
}

/// The error of a rule that the object as a whole breaks.
pub(crate) fn whole_surface(source: MeshError) -> AssetError {
    AssetError::Surface { part: "whole object".into(), source }
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
    let moves = caps::moving(object);
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

/// The motions of every part.
pub(crate) fn motions(object: &ArticulatedObject) -> Vec<Vec<JointMotion>> {
    (0..object.tree().len()).map(|p| object.joints(p).to_vec()).collect()
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
        if motion.kind.turns() && upper - lower > TAU {
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

fn substances(
    object: &ArticulatedObject,
    condition: &Condition,
    prompts: &[Option<&Prompt>],
) -> Vec<Substance> {
    let parts = object.tree().parts().iter().zip(prompts).enumerate();
    parts
        .map(|(part, (described, prompt))| {
            let corners = object.faces_of(part).flat_map(|f| object.mesh().corners(f));
            substance(condition, *prompt, &described.text, Bounds::of(corners).diagonal())
        })
        .collect()
}

fn size(surfaces: &[Surface], scale: &Sourced<f64>) -> Sourced<DVec3> {
    let all = surfaces.iter().flat_map(|s| s.mesh.vertices().iter().copied());
    Sourced::new(Bounds::of(all).size(), scale.origin, "box of the scaled surface")
}
