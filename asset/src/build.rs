//! The steps from an articulated object to an asset, in order.
//!
//! ```
//! use asset::{BuildOptions, build};
//! use object::{ArticulatedObject, Condition, DVec3, KinematicTree, Mesh, Part};
//! let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
//! let mesh = Mesh::new(corners, faces)?;
//! let stone = Part { name: "stone".into(), text: "stone".into(), parent: None, joints: vec![] };
//! let tree = KinematicTree::new(vec![stone])?;
//! let object = ArticulatedObject::new(mesh, tree, vec![0; 4], vec![vec![]])?;
//! let condition = Condition::from_json(
//!     r#"{"schema": "kinfold-condition/1", "category": "stone", "size": {"height": 0.5},
//!         "parts": [{"name": "stone", "mass": 3}]}"#,
//! )?;
//! let asset = build(&object, &condition, &[Some(0)], &BuildOptions::default())?;
//! assert_eq!((asset.scale.value, asset.mass()), (0.5, 3.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use glamx::{DQuat, DVec3};
use object::condition::{GivenJoints, Prompt};
use object::mesh::Bounds;
use object::{ArticulatedObject, Condition, KinematicTree, Mesh, Origin, Range, Sourced};
use rayon::prelude::*;

use crate::asset::Asset;
use crate::change::Change;
use crate::collision::piece::ConvexPiece;
use crate::collision::settle::{Collision, collision};
use crate::error::{AssetError, whole_surface};
use crate::joints::{links, stays};
use crate::mass::balance::balance;
use crate::mass::materials::{Substance, substance};
use crate::mass::weigh::{Body, enclosed, weigh};
use crate::parts::{Parts, motions};
use crate::standing::stand;
use crate::surface::caps;
use crate::surface::orient::Scene;
use crate::surface::repair::repair;
use crate::surface::repaired::Surface;
use crate::surface::simplify::{FACE_BUDGET, joined, simplified};

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
    let given = GivenJoints::of(&prompts);
    let placed = placed(object, scale.value, offset)?;
    let kept = given.kept(motions(&placed), (scale.value, offset));
    let placed = placed.with_joints(kept)?;
    let substances = substances(&placed, condition, &prompts);
    let walls: Vec<f64> = substances.iter().map(|s| s.wall.value).collect();
    let (surfaces, object, mut changes) = within_budget(&placed, &walls)?;
    let (object, shortened) = within_a_turn(object)?;
    changes.extend(shortened);
    let wanted = motions(&object);
    let spaces: Vec<Option<f64>> = surfaces.par_iter().map(enclosed).collect();
    let Collision { object, pieces, seen, changes: cleared } =
        collision(&object, (&surfaces, &spaces), &given, options.seed)?;
    changes.extend(cleared);
    let (motions, stopped) = stays::stop(&object, &seen, &given, options.seed);
    let object = object.with_joints(motions)?;
    changes.extend(stopped);
    let stated: Vec<bool> = substances.iter().map(|s| s.mass.is_some()).collect();
    let weighed = surfaces.par_iter().zip(&pieces).zip(&substances);
    let mut bodies: Vec<Body> = weighed.map(|((s, p), m)| weigh(s, p, m)).collect();
    changes.extend(balance(object.tree(), &mut bodies, &stated));
    changes.extend(steadied(object.tree(), &pieces, &mut bodies, &stated));
    let parts = Parts { object, given, wanted, surfaces, seen, pieces, substances, bodies };
    let (mut parts, turn, shift) = stand::upright(parts)?;
    let Parts { object, pieces, bodies, .. } = &mut parts;
    if turn != DQuat::IDENTITY {
        changes.push(stand::told(turn));
        changes.extend(steadied(object.tree(), pieces, bodies, &stated));
    }
    changes.extend(stand::levelled(object, pieces, bodies));
    let size = size(&parts.surfaces, &scale);
    let (links, joints) = links::assemble(parts, options.joints);
    let category = condition.category.clone();
    let name = asset_name(&category);
    let offset = turn * offset + shift;
    Ok(Asset { name, category, scale, turn, offset, size, links, joints, changes })
}

/// Masses under which the parts stand, neighbours within the ratio that solvers bear; those marked
/// as stated stay.
fn steadied(
    tree: &KinematicTree,
    pieces: &[Vec<ConvexPiece>],
    bodies: &mut [Body],
    stated: &[bool],
) -> Vec<Change> {
    let mut changes = stand::weighted(tree, pieces, bodies, stated);
    changes.extend(balance(tree, bodies, stated));
    changes
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
