//! Understands the truth beside a mesh (`evalcase/1`): labels, tree and joints.

use object::condition::name_from_text;
use object::mesh::FileFrame;
use object::{ArticulatedObject, DVec3, JointKind, JointMotion, KinematicTree, Mesh, Part, Range};
use serde::Deserialize;

use super::Specimen;
use super::shards::Bundle;

/// The schema this module understands.
const SCHEMA: &str = "evalcase/1";

/// What stands in `truth.json`, as far as training needs it.
#[derive(Clone, Debug, Deserialize)]
pub struct Truth {
    schema: String,
    /// Where the object comes from, such as `articraft`.
    pub source: String,
    /// Its identifier there.
    #[serde(default)]
    pub record_id: String,
    /// `train` or `val`, where the object belongs to a split.
    #[serde(default)]
    pub split: String,
    parts: Vec<TruePart>,
}

#[derive(Clone, Debug, Deserialize)]
struct TruePart {
    name: String,
    parent: Option<usize>,
    joints: Vec<TrueJoint>,
}

#[derive(Clone, Debug, Deserialize)]
struct TrueJoint {
    #[serde(rename = "type")]
    kind: JointKind,
    axis: [f64; 3],
    pivot: [f64; 3],
    lower: Option<f64>,
    upper: Option<f64>,
}

impl Truth {
    /// Reads `truth.json`.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let truth: Self = serde_json::from_slice(bytes).map_err(|e| format!("truth.json: {e}"))?;
        if truth.schema != SCHEMA {
            return Err(format!("truth.json: expected schema {SCHEMA}, found {}", truth.schema));
        }
        Ok(truth)
    }

    /// The object that mesh, labels and truth make together.
    ///
    /// # Errors
    /// The first rule they break, in words.
    pub fn specimen(&self, bundle: &Bundle) -> Result<Specimen, String> {
        let mesh = object::glb::read(&bundle.mesh).map_err(|e| format!("mesh.glb: {e}"))?;
        let (pairs, rest) = bundle.labels.as_chunks::<2>();
        if !rest.is_empty() {
            return Err("face_labels.u16le: expected an even number of bytes".into());
        }
        let labels = pairs.iter().map(|b| u16::from_le_bytes(*b)).collect();
        let tree = self.tree()?;
        let motions = self.motions(&mesh);
        let object = ArticulatedObject::new(mesh, tree, labels, motions);
        let object = object.map_err(|e| e.to_string())?;
        let wordings = self.parts.iter().map(|p| vec![p.name.clone()]).collect();
        Ok(Specimen { id: bundle.id.clone(), object, wordings })
    }

    fn tree(&self) -> Result<KinematicTree, String> {
        let mut taken = Vec::new();
        for part in &self.parts {
            let name = name_from_text(&part.name, &taken);
            taken.push(name);
        }
        let part = |(part, name): (&TruePart, String)| Part {
            name,
            text: part.name.clone(),
            parent: part.parent,
            joints: part.joints.iter().map(|j| j.kind).collect(),
        };
        KinematicTree::new(self.parts.iter().zip(taken).map(part).collect())
            .map_err(|e| e.to_string())
    }

    fn motions(&self, mesh: &Mesh) -> Vec<Vec<JointMotion>> {
        let frame = mesh.frame();
        let motions = |p: &TruePart| p.joints.iter().map(|j| j.motion(frame)).collect();
        self.parts.iter().map(motions).collect()
    }
}

impl TrueJoint {
    fn motion(&self, frame: FileFrame) -> JointMotion {
        let range = match self.kind {
            JointKind::Continuous => Range::Continuous,
            // A limit that is missing leaves a range that is not finite, which no object may have.
            _ => Range::Limits {
                lower: self.lower.unwrap_or(f64::NEG_INFINITY),
                upper: self.upper.unwrap_or(f64::INFINITY),
            },
        };
        JointMotion {
            kind: self.kind,
            axis: frame.point_to_object(DVec3::from_array(self.axis)).normalize_or_zero(),
            pivot: frame.point_to_object(DVec3::from_array(self.pivot)),
            range,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bundle(joints: &str) -> Bundle {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::Y];
        let mesh = Mesh::new(vertices, vec![[0, 1, 2], [0, 3, 2]]).unwrap();
        let truth = format!(
            r#"{{"schema":"evalcase/1","source":"articraft","parts":[
            {{"name":"body","parent":null,"joints":[]}},
            {{"name":"left door","parent":0,"joints":[{joints}]}}]}}"#
        );
        Bundle {
            id: "x".into(),
            mesh: object::glb::write(&mesh),
            labels: vec![0, 0, 1, 0],
            truth: truth.into_bytes(),
        }
    }

    fn specimen(joints: &str) -> Result<Specimen, String> {
        let bundle = bundle(joints);
        Truth::read(&bundle.truth)?.specimen(&bundle)
    }

    #[test]
    fn joints_are_turned_upright_like_the_mesh() {
        let joint = r#"{"type":"revolute","axis":[0,2,0],"pivot":[1,2,3],"lower":0,"upper":1.5}"#;
        let found = specimen(joint).unwrap();
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
        assert!(specimen(endless).unwrap_err().contains("range must be finite"));
        let wrong = Bundle { truth: br#"{"schema":"other"}"#.to_vec(), ..Bundle::default() };
        assert!(Truth::read(&wrong.truth).is_err());
        let mut odd = bundle("");
        odd.labels.pop();
        assert!(Truth::read(&odd.truth).unwrap().specimen(&odd).unwrap_err().contains("even"));
    }
}
