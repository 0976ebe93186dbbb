//! The promises every implementation is tested against, files and services alike.

use crate::critic::MAX_REASON;
use crate::{
    AdapterError, Critic, CritiqueQuestion, ImageTo3d, KinematicQuestion, Photo, RenderedView, Vlm,
};

/// Checks the promise of [`ImageTo3d`] on one photo.
///
/// # Errors
/// The adapter's own error; the broken promise as the inner `Err`.
pub fn check_image_to_3d(
    adapter: &dyn ImageTo3d,
    photo: &Photo,
) -> Result<Result<(), String>, AdapterError> {
    let identity = adapter.identity()?;
    let (first, second) = (adapter.generate(photo, 1)?, adapter.generate(photo, 1)?);
    if identity.trim().is_empty() || identity != adapter.identity()? {
        return Ok(Err(format!("identity must be steady and say something, found {identity:?}")));
    }
    if first != second {
        return Ok(Err("the same photo and seed gave two different meshes".into()));
    }
    if first.file.is_empty() {
        return Ok(Err("the file the mesh came in must be kept".into()));
    }
    Ok(Ok(()))
}

/// Checks the promise of [`Vlm`] on one mesh.
///
/// # Errors
/// The adapter's own error; the broken promise as the inner `Err`.
pub fn check_vlm(
    adapter: &dyn Vlm,
    photo: &Photo,
    mesh: &object::Mesh,
) -> Result<Result<(), String>, AdapterError> {
    let views: &[RenderedView] = &[];
    let condition = adapter.propose(&KinematicQuestion { photo, mesh, views })?;
    if adapter.identity()? != adapter.identity()? {
        return Ok(Err("identity must be steady".into()));
    }
    if condition.prompts.len() != condition.tree.len() {
        return Ok(Err("expected one prompt per part".into()));
    }
    Ok(condition.check_points(mesh).map_err(|e| e.to_string()))
}

/// Checks the promise of [`Critic`] on one object.
///
/// # Errors
/// The critic's own error; the broken promise as the inner `Err`.
pub fn check_critic(
    critic: &dyn Critic,
    question: &CritiqueQuestion<'_>,
) -> Result<Result<(), String>, AdapterError> {
    let identity = critic.identity()?;
    if identity.trim().is_empty() || identity != critic.identity()? {
        return Ok(Err(format!("identity must be steady and say something, found {identity:?}")));
    }
    let remarks = critic.criticise(question)?;
    let moving = question.object.tree().parts().iter().filter(|p| !p.joints.is_empty());
    if !remarks.iter().map(|r| &r.part).eq(moving.map(|p| &p.name)) {
        return Ok(Err("expected one remark per part that moves, in the order of parts".into()));
    }
    let badly_told =
        |reason: &str| reason.chars().count() > MAX_REASON || reason.chars().any(char::is_control);
    if let Some(remark) = remarks.iter().find(|r| badly_told(&r.reason)) {
        return Ok(Err(format!("a reason must be short and on one line, found {remark:?}")));
    }
    let silent = remarks.iter().find(|r| r.is_flag() && r.reason.is_empty());
    Ok(silent.map_or(Ok(()), |r| Err(format!("a flag must have a reason, found {r:?}"))))
}

#[cfg(test)]
pub(crate) mod tests {
    use object::{ArticulatedObject, Condition, DVec3, JointKind, JointMotion, Mesh, Range};
    use trace::Digest;

    use super::*;
    use crate::critic::{JointFault, Remark};
    use crate::kept::Kept;
    use crate::photo::tests::png;
    use crate::{ConditionFile, Critique, GeneratedMesh, MeshFile, Scripted};

    const CONDITION: &str = r#"{"schema": "kinfold-condition/1", "parts": [
        {"name": "body", "point": [0.2, 0, -0.2]},
        {"name": "flap", "parent": "body", "joint": "revolute", "point": [0.6, 0.2, 0]}]}"#;

    fn mesh() -> Mesh {
        let v = [(0., 0., 0.), (1., 0., 0.), (0., 1., 0.), (0., 0., 1.)];
        let v = v.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec();
        Mesh::new(v, vec![[0, 1, 2], [0, 3, 1]]).unwrap()
    }

    #[test]
    fn scripted_and_file_adapters_keep_both_promises() {
        let dir = tempfile::tempdir().unwrap();
        let photo = Photo::read(png(32, 32), "photo").unwrap();
        let file = object::glb::write(&mesh());
        let path = dir.path().join("mesh.glb");
        std::fs::write(&path, &file).unwrap();
        let mesh_file = MeshFile { path, ..Default::default() };
        let made = mesh_file.generate(&photo, 0).unwrap();
        assert_eq!(made.file, file);
        check_image_to_3d(&mesh_file, &photo).unwrap().unwrap();

        let path = dir.path().join("condition.json");
        std::fs::write(&path, CONDITION).unwrap();
        check_vlm(&ConditionFile { path, ..Default::default() }, &photo, &made.mesh)
            .unwrap()
            .unwrap();

        let condition = Condition::from_json(CONDITION).unwrap();
        let generated =
            GeneratedMesh { mesh: mesh(), file, media_type: "model/gltf-binary".into() };
        let remarks = vec![];
        let scripted = Scripted { name: "flap".into(), mesh: generated, condition, remarks };
        check_image_to_3d(&scripted, &photo).unwrap().unwrap();
        check_vlm(&scripted, &photo, &mesh()).unwrap().unwrap();
    }

    /// The body with its flap, which turns by a right angle.
    pub(crate) fn flap() -> ArticulatedObject {
        let tree = Condition::from_json(CONDITION).unwrap().tree;
        let (axis, pivot) = (DVec3::X, DVec3::ZERO);
        let range = Range::Limits { lower: 0.0, upper: std::f64::consts::FRAC_PI_2 };
        let turn = JointMotion { kind: JointKind::Revolute, axis, pivot, range };
        ArticulatedObject::new(mesh(), tree, vec![0, 1], vec![vec![], vec![turn]]).unwrap()
    }

    #[test]
    fn scripted_and_kept_critics_keep_their_promise_and_a_broken_one_is_told() {
        let (photo, object) = (Photo::read(png(32, 32), "photo").unwrap(), flap());
        let digest = Digest::of(b"object");
        let question =
            CritiqueQuestion { photo: &photo, object: &object, digest: &digest, views: &[] };
        let remark = |part: &str, reason: &str| Remark {
            part: part.into(),
            fault: JointFault::Axis,
            reason: reason.into(),
        };
        let check = |remarks: Vec<Remark>| {
            let answer = Critique::Given(remarks);
            check_critic(&Kept { identity: "someone".into(), answer }, &question).unwrap()
        };
        check(vec![remark("flap", "it turns about its middle")]).unwrap();
        check(vec![]).unwrap_err();
        check(vec![remark("body", "it does not move")]).unwrap_err();
        check(vec![remark("flap", "")]).unwrap_err();
        check(vec![remark("flap", "two\nlines")]).unwrap_err();
        check(vec![remark("flap", &"x".repeat(302))]).unwrap_err();
        let answer = Critique::Lost("nobody answered".into());
        let lost = check_critic(&Kept { identity: "someone".into(), answer }, &question);
        assert_eq!(lost.unwrap_err().to_string(), "nobody answered");
        let file = object::glb::write(&mesh());
        let scripted = Scripted {
            name: "flap".into(),
            mesh: GeneratedMesh { mesh: mesh(), file, media_type: "model/gltf-binary".into() },
            condition: Condition::from_json(CONDITION).unwrap(),
            remarks: vec![remark("flap", "it turns about its middle")],
        };
        check_critic(&scripted, &question).unwrap().unwrap();
    }

    #[test]
    fn a_file_that_is_not_there_is_named() {
        let missing = MeshFile { path: "nowhere/mesh.glb".into(), ..Default::default() };
        let error = missing.identity().unwrap_err().to_string();
        assert!(error.starts_with("nowhere/mesh.glb: "), "{error}");
    }
}
