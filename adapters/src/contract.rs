//! The promises every implementation is tested against, files and services alike.

use crate::{AdapterError, ImageTo3d, KinematicQuestion, Photo, RenderedView, Vlm};

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

#[cfg(test)]
mod tests {
    use object::{Condition, DVec3, Mesh};

    use super::*;
    use crate::photo::tests::png;
    use crate::{ConditionFile, GeneratedMesh, MeshFile, Scripted};

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
        let mesh_file = MeshFile { path };
        let made = mesh_file.generate(&photo, 0).unwrap();
        assert_eq!(made.file, file);
        check_image_to_3d(&mesh_file, &photo).unwrap().unwrap();

        let path = dir.path().join("condition.json");
        std::fs::write(&path, CONDITION).unwrap();
        check_vlm(&ConditionFile { path }, &photo, &made.mesh).unwrap().unwrap();

        let condition = Condition::from_json(CONDITION).unwrap();
        let generated =
            GeneratedMesh { mesh: mesh(), file, media_type: "model/gltf-binary".into() };
        let scripted = Scripted { name: "flap".into(), mesh: generated, condition };
        check_image_to_3d(&scripted, &photo).unwrap().unwrap();
        check_vlm(&scripted, &photo, &mesh()).unwrap().unwrap();
    }

    #[test]
    fn a_file_that_is_not_there_is_named() {
        let missing = MeshFile { path: "nowhere/mesh.glb".into() };
        let error = missing.identity().unwrap_err().to_string();
        assert!(error.starts_with("nowhere/mesh.glb: "), "{error}");
    }
}
