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

mod measures;
mod shapes;
mod stored;

use glamx::{DQuat, DVec3};
use object::condition::{GivenJoints, Prompt};
use object::mesh::Bounds;
use object::{ArticulatedObject, Condition, KinematicTree, Origin, Sourced};
use rayon::prelude::*;

use crate::asset::Asset;
use crate::build::shapes::scaled_by;
use crate::change::Change;
use crate::collision::piece::ConvexPiece;
use crate::error::AssetError;
use crate::joints::links;
use crate::mass::balance::balance;
use crate::mass::materials::{Substance, substance};
use crate::mass::weigh::{Body, weigh};
use crate::parts::Parts;
use crate::standing::stand;
use crate::surface::repaired::Surface;

pub use self::measures::Measures;
pub use self::shapes::{Shapes, shape};

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

/// Builds the asset of an articulated object: its shapes, and then all that is weighed.
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
    prompts(object.tree(), condition, part_of_condition)?;
    let measures = Measures::in_full(condition);
    let shapes = shape(object, &measures, part_of_condition, options.seed)?;
    finish(shapes, condition, options.joints)
}

/// Makes the asset of shapes: masses, the stance they ask for, links and the drives of joints.
///
/// `condition` is one whose [`Measures`] the shapes were made by; `joints` tells where axes, pivots and
/// ranges come from that it does not give. [`build()`] is [`shape`] and this.
///
/// # Errors
/// [`AssetError`], naming the part, the rule and what was found.
pub fn finish(shapes: Shapes, condition: &Condition, joints: Origin) -> Result<Asset, AssetError> {
    let prompts = prompts(shapes.object.tree(), condition, &shapes.part_of_condition)?;
    let substances = substances(&shapes, condition, &prompts);
    let scale = scale(&shapes, condition);
    let confidence = shapes.confidence.clone();
    let given = GivenJoints::of(&prompts);
    let Shapes { offset, object, wanted, surfaces, seen, pieces, mut changes, .. } = shapes;
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
    let (links, joints) = links::assemble(parts, joints);
    let category = condition.category.clone();
    let name = asset_name(&category);
    let offset = turn * offset + shift;
    let place = |at: DVec3| turn * (scale.value * at) + offset;
    let confidence = confidence.map(|confidence| confidence.moved(place, |axis| turn * axis));
    Ok(Asset { name, category, scale, turn, offset, size, links, joints, changes, confidence })
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
    tree: &KinematicTree,
    condition: &'a Condition,
    part_of_condition: &[Option<usize>],
) -> Result<Vec<Option<&'a Prompt>>, AssetError> {
    let (parts, found) = (condition.tree.len(), part_of_condition.len());
    if parts != found {
        return Err(AssetError::PartMap { parts, found });
    }
    let mut prompts = vec![None; tree.len()];
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

fn substances(
    shapes: &Shapes,
    condition: &Condition,
    prompts: &[Option<&Prompt>],
) -> Vec<Substance> {
    let parts = shapes.object.tree().parts().iter().zip(prompts).zip(&shapes.diagonals);
    parts
        .map(|((part, said), diagonal)| substance(condition, *said, &part.text, *diagonal))
        .collect()
}

fn scale(shapes: &Shapes, condition: &Condition) -> Sourced<f64> {
    let origin = if condition.size.is_some() { condition.origin } else { Origin::Default };
    Sourced::new(shapes.scale, origin, scaled_by(condition.size))
}

fn size(surfaces: &[Surface], scale: &Sourced<f64>) -> Sourced<DVec3> {
    let all = surfaces.iter().flat_map(|s| s.mesh.vertices().iter().copied());
    Sourced::new(Bounds::of(all).size(), scale.origin, "box of the scaled surface")
}
