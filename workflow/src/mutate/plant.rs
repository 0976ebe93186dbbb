//! One defect of each kind, planted in a model.

use super::kinds::{KINDS, Kind};
use super::model::Model;
use super::planted::{Made, Planted};
use super::{axes, limits, meshes, shapes, structure, weights};

/// How a kind is planted: the model, and the word that its draw begins with.
type Plant = fn(&Model, &str) -> Made;

/// How each kind is planted.
#[rustfmt::skip]
const PLANTS: [(&str, Plant); KINDS.len()] = [
    ("xml-broken", structure::broken),
    ("number-nan", structure::not_a_number),
    ("number-comma", structure::comma),
    ("number-missing", structure::two_numbers),
    ("link-missing", structure::link_missing),
    ("link-twice", structure::link_twice),
    ("joint-twice", structure::joint_twice),
    ("two-roots", structure::two_roots),
    ("two-parents", structure::two_parents),
    ("cycle", structure::cycle),
    ("parent-child-swapped", structure::upside_down),
    ("joint-type-unknown", structure::unknown_type),
    ("joint-fixed", structure::fixed),
    ("joint-endless", structure::endless),
    ("joint-turns-for-slides", structure::other_motion),
    ("mimic-missing", structure::mimic_missing),
    ("mimic-itself", structure::mimic_itself),
    ("mimic-too-far", structure::mimic_too_far),
    ("limits-swapped", limits::swapped),
    ("limits-degrees", limits::degrees),
    ("limits-missing", limits::missing),
    ("limits-empty", limits::empty),
    ("limits-infinite", limits::infinite),
    ("limits-without-rest", limits::without_rest),
    ("range-into-body", limits::into_body),
    ("axis-zero", axes::zero),
    ("axis-long", axes::long),
    ("axis-flipped", axes::flipped),
    ("axis-other-frame", axes::other_frame),
    ("axis-missing", axes::missing),
    ("pivot-off", axes::pivot_off),
    ("part-detached", axes::detached),
    ("part-turned", axes::turned),
    ("joint-into-parent", axes::into_parent),
    ("below-floor", axes::below_floor),
    ("mass-zero", weights::mass_zero),
    ("mass-negative", weights::mass_negative),
    ("mass-grams", weights::grams),
    ("mass-tonnes", weights::tonnes),
    ("inertial-missing", weights::missing),
    ("inertia-zero", weights::inertia_zero),
    ("inertia-negative", weights::inertia_negative),
    ("inertia-triangle", weights::triangle),
    ("inertia-millimetres", weights::inertia_millimetres),
    ("inertia-placeholder", weights::placeholder),
    ("inertia-turned", weights::inertia_turned),
    ("com-outside", weights::com_outside),
    ("com-millimetres", weights::com_millimetres),
    ("visual-missing", shapes::visual_missing),
    ("collision-missing", shapes::collision_missing),
    ("collision-off", shapes::collision_off),
    ("collision-large", shapes::collision_large),
    ("collision-masked", shapes::all_masked),
    ("scale-millimetres", shapes::millimetres),
    ("scale-small", shapes::small),
    ("scale-mirrored", shapes::mirrored),
    ("size-zero", shapes::size_zero),
    ("quaternion-zero", shapes::quaternion),
    ("mesh-missing", meshes::missing),
    ("mesh-elsewhere", meshes::elsewhere),
    ("mesh-other-case", meshes::other_case),
    ("mesh-empty", meshes::empty),
    ("mesh-cut-off", meshes::cut_off),
    ("mesh-nan", meshes::not_a_number),
    ("mesh-inside-out", meshes::inside_out),
    ("mesh-open", meshes::open),
    ("texture-missing", shapes::texture),
    ("material-undefined", shapes::material),
    ("effort-zero", limits::effort),
    ("velocity-zero", limits::velocity),
    ("damping-negative", limits::damping),
    ("friction-negative", limits::friction),
    ("drive-missing", limits::drive),
    ("control-wide", limits::control),
];

/// Plants a defect of a kind: what it is, and the text then.
///
/// # Errors
/// Why this model has no place for it.
pub fn plant(kind: &Kind, model: &Model) -> Result<(Planted, String), String> {
    if !kind.formats.contains(&model.language) {
        return Err(format!("{} has no words for it", model.language.name()));
    }
    let how = PLANTS.iter().find(|(id, _)| *id == kind.id);
    let (word, plant) = how.ok_or("nobody plants it")?;
    // What a geometry library breaks down on is no place for a defect.
    let made = || plant(model, word);
    let planted = std::panic::catch_unwind(std::panic::AssertUnwindSafe(made));
    let planted = planted.map_err(|_| "a geometry library broke down on it")??;
    let text = match &planted.text {
        Some(text) => text.clone(),
        None => model.source.with(&planted.edits).ok_or("its changes touch each other")?,
    };
    if text == model.source.whole() && planted.files.is_empty() {
        return Err("it would change nothing".into());
    }
    Ok((planted, text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_planted_and_in_its_order() {
        assert!(PLANTS.iter().zip(&KINDS).all(|((id, _), kind)| *id == kind.id));
    }
}
