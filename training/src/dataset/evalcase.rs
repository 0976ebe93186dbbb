//! An object from its mesh, its labels and its truth (`evalcase/1`).

use object::condition::name_from_text;
use object::{ArticulatedObject, KinematicTree, Part};

use super::Specimen;
use super::shards::Bundle;
use crate::truth::{TruthFile, TruthPart};

/// The object that the files of a bundle make together.
///
/// # Errors
/// The first rule they break, in words.
pub fn specimen(bundle: &Bundle) -> Result<Specimen, String> {
    let truth = TruthFile::from_json(&bundle.truth).map_err(|e| format!("truth.json: {e}"))?;
    let mesh = object::glb::read(&bundle.mesh).map_err(|e| format!("mesh.glb: {e}"))?;
    let (pairs, rest) = bundle.labels.as_chunks::<2>();
    if !rest.is_empty() {
        return Err("face_labels.u16le: expected an even number of bytes".into());
    }
    let labels = pairs.iter().map(|b| u16::from_le_bytes(*b)).collect();
    let motions = truth.motions(mesh.frame()).map_err(|e| format!("truth.json: {e}"))?;
    let object = ArticulatedObject::new(mesh, tree(&truth)?, labels, motions);
    let object = object.map_err(|e| e.to_string())?;
    let wordings = truth.parts.iter().map(|p| vec![p.name.clone()]).collect();
    Ok(Specimen { id: bundle.id.clone(), object, wordings })
}

fn tree(truth: &TruthFile) -> Result<KinematicTree, String> {
    let mut taken = Vec::new();
    for part in &truth.parts {
        let name = name_from_text(&part.name, &taken);
        taken.push(name);
    }
    let part = |(part, name): (&TruthPart, String)| Part {
        name,
        text: part.name.clone(),
        parent: part.parent,
        joints: part.joints.iter().map(|j| j.kind).collect(),
    };
    KinematicTree::new(truth.parts.iter().zip(taken).map(part).collect()).map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use object::{DVec3, Mesh};

    use super::*;

    fn bundle(joints: &str) -> Bundle {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::Y];
        let mesh = Mesh::new(vertices, vec![[0, 1, 2], [0, 3, 2]]).unwrap();
        let truth = format!(
            r#"{{"schema":"evalcase/1","source":"articraft","parts":[
            {{"id":0,"name":"body","parent":null,"joints":[]}},
            {{"id":1,"name":"left door","parent":0,"joints":[{joints}]}}]}}"#
        );
        Bundle {
            id: "x".into(),
            mesh: object::glb::write(&mesh),
            labels: vec![0, 0, 1, 0],
            truth: truth.into_bytes(),
        }
    }

    fn made(joints: &str) -> Result<Specimen, String> {
        specimen(&bundle(joints))
    }

    #[test]
    fn joints_are_turned_upright_like_the_mesh() {
        let joint = r#"{"type":"revolute","axis":[0,1,0],"pivot":[1,2,3],"lower":0,"upper":1.5}"#;
        let found = made(joint).unwrap();
        let motion = found.object.joints(1)[0];
        let up = found.object.mesh().frame().point_to_object(DVec3::Y);
        assert!((motion.axis - up).length() < 1e-12);
        assert_eq!(found.wordings[1], ["left door"]);
        assert_eq!(found.object.tree().parts()[1].name, "left_door");
    }

    #[test]
    fn truth_that_breaks_a_rule_is_refused_in_words() {
        let endless =
            r#"{"type":"prismatic","axis":[0,1,0],"pivot":[0,0,0],"lower":0,"upper":null}"#;
        assert!(made(endless).unwrap_err().contains("two ends"));
        let long = r#"{"type":"revolute","axis":[0,2,0],"pivot":[0,0,0],"lower":0,"upper":1}"#;
        assert!(made(long).unwrap_err().contains("length 1"));
        let other = br#"{"schema":"other","parts":[]}"#.to_vec();
        let wrong = Bundle { truth: other, ..bundle("") };
        assert!(specimen(&wrong).unwrap_err().contains("`other` is unknown"));
        let mut odd = bundle("");
        odd.labels.pop();
        assert!(specimen(&odd).unwrap_err().contains("even"));
    }
}
