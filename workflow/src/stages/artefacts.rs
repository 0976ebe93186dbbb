//! What the steps hand to each other, and how each stands on disk.

use adapters::critic::Remark;
use adapters::{Critique, GeneratedMesh, Photo};
use asset::{Asset, AssetAppearance, Measures, Shapes};
use model::Articulation;
use object::{Condition, meshfile};
use runner::artefact::{Artefact, CodecError, Note, from_json, to_json};
use serde::{Deserialize, Serialize};
use sim_check::Verdict;

use super::bundle::{self, Files};
use super::tools::Tools;

/// Media type of a [`bundle`].
pub const BUNDLE: &str = "application/vnd.kinfold.bundle";

/// The photo's own bytes.
impl Artefact<Tools> for Photo {
    const NAME: &'static str = "photo";
    const MEDIA_TYPE: &'static str = "image/*";
    const FILE_NAME: &'static str = "photo";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        Ok(self.bytes.clone())
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        Self::read(bytes.to_vec(), "photo").map_err(CodecError::of::<_, Self>)
    }
}

/// The mesh file's own bytes, GLB or OBJ (y up).
impl Artefact<Tools> for GeneratedMesh {
    const NAME: &'static str = "mesh";
    const MEDIA_TYPE: &'static str = "model/gltf-binary";
    const FILE_NAME: &'static str = "mesh.glb";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        Ok(self.file.clone())
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        let mesh = meshfile::read(bytes).map_err(CodecError::of::<_, Self>)?;
        let is_glb = bytes.starts_with(b"glTF");
        let media_type = if is_glb { "model/gltf-binary" } else { "model/obj" };
        Ok(Self { mesh, file: bytes.to_vec(), media_type: media_type.into() })
    }
}

/// Pictures of the mesh, PNG, by name of the view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Views(pub Files);

impl Artefact<Tools> for Views {
    const NAME: &'static str = "views";
    const MEDIA_TYPE: &'static str = BUNDLE;
    const FILE_NAME: &'static str = "views.bundle";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        Ok(bundle::pack(&self.0))
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        bundle::unpack(bytes).map(Self).map_err(CodecError::of::<_, Self>)
    }
}

impl Artefact<Tools> for Condition {
    const NAME: &'static str = "condition";
    const MEDIA_TYPE: &'static str = "application/json";
    const FILE_NAME: &'static str = "condition.json";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        to_json::<_, Self>(self)
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        from_json::<_, Self, _>(bytes)
    }
}

/// What of a condition articulation depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct Prompts(pub Condition);

impl Artefact<Tools> for Prompts {
    const NAME: &'static str = "prompts";
    const MEDIA_TYPE: &'static str = "application/json";
    const FILE_NAME: &'static str = "prompts.json";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        to_json::<_, Self>(&self.0)
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        from_json::<_, Self, _>(bytes).map(Self)
    }
}

impl Artefact<Tools> for Articulation {
    const NAME: &'static str = "object";
    const MEDIA_TYPE: &'static str = "application/json";
    const FILE_NAME: &'static str = "articulation.json";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        to_json::<_, Self>(self)
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        from_json::<_, Self, _>(bytes)
    }

    fn notes(&self) -> Vec<Note> {
        let note = |n: &model::Note| Note {
            message: format!("part `{}`: {}", n.part, n.message),
            loss: n.loss,
        };
        self.notes.iter().map(note).collect()
    }
}

/// Indented, for it goes to people as it is.
impl Artefact<Tools> for Critique {
    const NAME: &'static str = "critique";
    const MEDIA_TYPE: &'static str = "application/json";
    const FILE_NAME: &'static str = "critic.json";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        let mut text = serde_json::to_vec_pretty(self).map_err(CodecError::of::<_, Self>)?;
        text.push(b'\n');
        Ok(text)
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        from_json::<_, Self, _>(bytes)
    }

    /// A note per flag; none of them is a loss, for nothing was to be made of it.
    fn notes(&self) -> Vec<Note> {
        let flag = |r: &Remark| {
            format!("part `{}`: {} looks wrong: {}", r.part, r.fault.words(), r.reason)
        };
        let messages = match self {
            Self::Given(remarks) => remarks.iter().filter(|r| r.is_flag()).map(flag).collect(),
            Self::Lost(why) => vec![format!("no critique: {why}")],
        };
        messages.into_iter().map(|message| Note { message, loss: false }).collect()
    }
}

impl Artefact<Tools> for Measures {
    const NAME: &'static str = "measures";
    const MEDIA_TYPE: &'static str = "application/json";
    const FILE_NAME: &'static str = "measures.json";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        to_json::<_, Self>(self)
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        from_json::<_, Self, _>(bytes)
    }
}

impl Artefact<Tools> for Shapes {
    const NAME: &'static str = "shapes";
    const MEDIA_TYPE: &'static str = "application/json";
    const FILE_NAME: &'static str = "shapes.json";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        to_json::<_, Self>(self)
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        from_json::<_, Self, _>(bytes)
    }
}

impl Artefact<Tools> for Asset {
    const NAME: &'static str = "asset";
    const MEDIA_TYPE: &'static str = "application/json";
    const FILE_NAME: &'static str = "asset-build.json";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        to_json::<_, Self>(self)
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        from_json::<_, Self, _>(bytes)
    }
}

/// A description of the links, and pictures.
impl Artefact<Tools> for AssetAppearance {
    const NAME: &'static str = "appearance";
    const MEDIA_TYPE: &'static str = BUNDLE;
    const FILE_NAME: &'static str = "appearance.bundle";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        Ok(bundle::pack(&self.to_files()))
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        let files = bundle::unpack(bytes).map_err(CodecError::of::<_, Self>)?;
        Self::from_files(files).map_err(CodecError::of::<_, Self>)
    }

    /// What of the mesh file did not come along. None is a loss: parts, joints and masses are whole.
    fn notes(&self) -> Vec<Note> {
        let note = |message: &String| Note { message: message.clone(), loss: false };
        AssetAppearance::notes(self).iter().map(note).collect()
    }
}

/// The files of a URDF package, by path relative to the package.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UrdfPackage(pub Files);

impl Artefact<Tools> for UrdfPackage {
    const NAME: &'static str = "urdf";
    const MEDIA_TYPE: &'static str = BUNDLE;
    const FILE_NAME: &'static str = "urdf.bundle";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        Ok(bundle::pack(&self.0))
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        bundle::unpack(bytes).map(Self).map_err(CodecError::of::<_, Self>)
    }
}

/// Several files, by path relative to their folder.
macro_rules! package {
    ($(#[$doc:meta])* $name:ident, $kind:literal, $file:literal) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Eq)]
        pub struct $name(pub Files);

        impl From<asset::Package> for $name {
            fn from(package: asset::Package) -> Self {
                Self(package.files)
            }
        }

        impl Artefact<Tools> for $name {
            const NAME: &'static str = $kind;
            const MEDIA_TYPE: &'static str = BUNDLE;
            const FILE_NAME: &'static str = $file;

            fn encode(&self) -> Result<Vec<u8>, CodecError> {
                Ok(bundle::pack(&self.0))
            }

            fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
                bundle::unpack(bytes).map(Self).map_err(CodecError::of::<_, Self>)
            }
        }
    };
}

package!(
    /// The asset as an SDFormat model that names the URDF package's meshes, and its `model.config`.
    Sdf, "sdf", "sdf.bundle"
);
package!(
    /// The asset as a ROS 2 package.
    Ros, "ros", "ros.bundle"
);
package!(
    /// The asset as a SimReady package.
    Simready, "simready", "simready.bundle"
);

/// A file's own bytes.
macro_rules! file {
    ($(#[$doc:meta])* $name:ident, $kind:literal, $media_type:literal, $file:literal) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Eq)]
        pub struct $name(pub Vec<u8>);

        impl From<Vec<u8>> for $name {
            fn from(bytes: Vec<u8>) -> Self {
                Self(bytes)
            }
        }

        impl From<String> for $name {
            fn from(text: String) -> Self {
                Self(text.into_bytes())
            }
        }

        impl Artefact<Tools> for $name {
            const NAME: &'static str = $kind;
            const MEDIA_TYPE: &'static str = $media_type;
            const FILE_NAME: &'static str = $file;

            fn encode(&self) -> Result<Vec<u8>, CodecError> {
                Ok(self.0.clone())
            }

            fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
                Ok(Self(bytes.to_vec()))
            }
        }
    };
}

file!(
    /// The asset as an MJCF model that names the URDF package's meshes.
    Mjcf, "mjcf", "application/xml", "asset.xml"
);
file!(
    /// The asset as a USD layer in text form.
    Usd, "usd", "model/vnd.usda", "asset.usda"
);
file!(
    /// The asset as a USD layer with its pictures in one file.
    Usdz, "usdz", "model/vnd.usdz+zip", "asset.usdz"
);
file!(
    /// The asset as one GLB file, with its motion.
    Glb, "glb", "model/gltf-binary", "asset.glb"
);

file!(
    /// Configurations of the asset for Isaac Lab.
    IsaacLab, "isaaclab", "text/x-python", "asset_isaaclab.py"
);

file!(
    /// The asset as a page for a browser.
    Page, "page", "text/html", "viewer.html"
);

/// Pictures of the asset, by name: [`Pictures::PARTS`] and [`Pictures::MOTION`]. Empty where nothing of it
/// can be seen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pictures(pub Files);

impl Pictures {
    /// Its parts, coloured and named, with their axes.
    pub const PARTS: &'static str = "parts.png";
    /// Its joints at work, animated.
    pub const MOTION: &'static str = "motion.webp";
}

impl Artefact<Tools> for Pictures {
    const NAME: &'static str = "pictures";
    const MEDIA_TYPE: &'static str = BUNDLE;
    const FILE_NAME: &'static str = "pictures.bundle";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        Ok(bundle::pack(&self.0))
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        bundle::unpack(bytes).map(Self).map_err(CodecError::of::<_, Self>)
    }
}

/// What the check found, and the asset in motion for the trace.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// The verdict.
    pub verdict: Verdict,
    /// Every joint through its range, one after the other; empty if the asset does not load.
    pub motion: Vec<Frame>,
    /// Each link's visual surface in its own frame, as GLB.
    pub scene: Files,
}

/// One moment of the motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Joint values by name, radians or metres.
    pub joints: Vec<(String, f64)>,
    /// Where the links stand.
    pub links: Vec<LinkPose>,
}

/// A link's frame in its parent link's, or in the world for the root.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinkPose {
    /// Parent link, or `world`.
    pub parent: String,
    /// The link.
    pub link: String,
    /// Metres.
    pub translation: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
}

const VERDICT: &str = "verdict.json";
const MOTION: &str = "motion.json";
const SCENE: &str = "scene/";

impl Artefact<Tools> for Checked {
    const NAME: &'static str = "verdict";
    const MEDIA_TYPE: &'static str = BUNDLE;
    const FILE_NAME: &'static str = "checked.bundle";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        let mut files: Files =
            self.scene.iter().map(|(n, b)| (format!("{SCENE}{n}"), b.clone())).collect();
        files.insert(VERDICT.into(), self.verdict.to_json().into_bytes());
        files.insert(MOTION.into(), to_json::<_, Self>(&self.motion)?);
        Ok(bundle::pack(&files))
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        let files = bundle::unpack(bytes).map_err(CodecError::of::<_, Self>)?;
        let file = |name: &str| {
            files.get(name).ok_or_else(|| CodecError::of::<_, Self>(format!("{name} is missing")))
        };
        let scene =
            files.iter().filter_map(|(n, b)| Some((n.strip_prefix(SCENE)?.into(), b.clone())));
        Ok(Self {
            verdict: from_json::<_, Self, _>(file(VERDICT)?)?,
            motion: from_json::<_, Self, _>(file(MOTION)?)?,
            scene: scene.collect(),
        })
    }
}
