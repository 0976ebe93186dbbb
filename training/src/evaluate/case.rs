//! A case: an object with its condition and its truth, as it lies in a folder.

use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use object::condition::{ConditionError, ConditionFile};
use object::glb::GlbError;
use object::{ArticulatedObject, Condition, Mesh};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use super::how::Prompts;
use crate::dataset::any_face;
use crate::metrics::Link;
use crate::truth::{TruthError, TruthFile};

/// Where a case comes from, told from its folder's name; reported apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Set {
    /// `articraft__*`: designed part by part, nearly always its own components.
    Cad,
    /// Assets made for simulators.
    Simulation,
    /// `*-fused`: one closed skin, as generators deliver.
    Fused,
    /// `paper__*`: generator meshes whose truth is another model's prediction.
    Paper,
}

/// A word that is no set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected cad, simulation, fused or paper, found `{0}`")]
pub struct SetError(String);

impl FromStr for Set {
    type Err = SetError;

    fn from_str(text: &str) -> Result<Self, SetError> {
        Self::ALL.into_iter().find(|s| s.name() == text).ok_or_else(|| SetError(text.into()))
    }
}

impl Set {
    /// Every set, in the order of reports.
    pub const ALL: [Self; 4] = [Self::Cad, Self::Simulation, Self::Fused, Self::Paper];

    /// The set of a case of this name.
    pub fn of(case: &str) -> Self {
        match case {
            n if n.starts_with("paper__") => Self::Paper,
            n if n.ends_with(TWIN) => Self::Fused,
            n if n.starts_with("articraft__") => Self::Cad,
            _ => Self::Simulation,
        }
    }

    /// As written in tables and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cad => "cad",
            Self::Simulation => "simulation",
            Self::Fused => "fused",
            Self::Paper => "paper",
        }
    }
}

/// An object, what is asked about it and what the answer should be.
#[derive(Clone, Debug)]
pub struct Case {
    /// The folder's name.
    pub name: String,
    /// Where it lies.
    pub folder: PathBuf,
    /// The surface.
    pub mesh: Mesh,
    /// The question; its parts are the true ones in the same order.
    pub condition: Condition,
    /// The true part of each face.
    pub part_of_face: Vec<u16>,
    /// True parents and motions, object frame, the mesh's unit.
    pub links: Vec<Link>,
}

/// Why a folder is not a case.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    /// A file or folder that cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// No mesh.
    #[error("{path}: {source}")]
    Mesh {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: GlbError,
    },
    /// No condition.
    #[error("{path}: {source}")]
    Condition {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: ConditionError,
    },
    /// No truth.
    #[error("{path}: {source}")]
    Truth {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: TruthError,
    },
    /// Files that do not belong together.
    #[error("{path}: expected {expected}, found {found}")]
    Misfit {
        /// The file.
        path: PathBuf,
        /// The rule.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A folder without cases.
    #[error("{0}: no folder in it holds a truth.json")]
    NoCases(PathBuf),
}

/// The mesh in a case's folder.
pub const MESH: &str = "mesh.glb";
/// What the picture in a case's folder may be called; the first there is.
pub const PICTURES: [&str; 4] = ["image.png", "image.jpg", "image.webp", "render.png"];
const TWIN: &str = "-fused";
const CONDITION: &str = "condition.json";
const TRUTH: &str = "truth.json";
const LABELS: &str = "face_labels.u16le";

/// The case folders in `root`, by name; `root` itself if it is one.
///
/// # Errors
/// [`CaseError::Io`] if `root` cannot be read, [`CaseError::NoCases`] if there is none.
pub fn folders(root: &Path) -> Result<Vec<PathBuf>, CaseError> {
    if root.join(TRUTH).is_file() {
        return Ok(vec![root.to_path_buf()]);
    }
    let entries = fs::read_dir(root).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let mut found: Vec<_> =
        entries.map_err(unreadable(root))?.iter().map(fs::DirEntry::path).collect();
    found.retain(|folder| folder.join(TRUTH).is_file());
    found.sort();
    if found.is_empty() { Err(CaseError::NoCases(root.to_path_buf())) } else { Ok(found) }
}

/// What a case in this folder is called.
pub fn name_of(folder: &Path) -> String {
    folder.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned())
}

/// The name of the object a case shows, which it shares with its fused twin.
pub fn object_of(case: &str) -> &str {
    case.strip_suffix(TWIN).unwrap_or(case)
}

/// The picture of the object in a case's folder: in there, or beside its twin.
pub fn picture(folder: &Path) -> Option<PathBuf> {
    let twin = folder.with_file_name(object_of(&name_of(folder)));
    let places = [folder, &twin].map(|f| PICTURES.map(|name| f.join(name)));
    places.into_iter().flatten().find(|path| path.is_file())
}

fn unreadable(path: &Path) -> impl FnOnce(std::io::Error) -> CaseError {
    let path = path.to_path_buf();
    move |source| CaseError::Io { path, source }
}

impl Case {
    /// Reads `mesh.glb`, `condition.json`, `truth.json` and `face_labels.u16le`.
    ///
    /// # Errors
    /// [`CaseError`], naming the file, the rule and what was found.
    pub fn read(folder: &Path) -> Result<Self, CaseError> {
        let at = |file: &str| folder.join(file);
        let bytes = |file: &str| fs::read(at(file)).map_err(unreadable(&at(file)));
        let text = |file: &str| fs::read_to_string(at(file)).map_err(unreadable(&at(file)));
        let mesh = object::glb::read(&bytes(MESH)?)
            .map_err(|source| CaseError::Mesh { path: at(MESH), source })?;
        let condition = Condition::from_json(&text(CONDITION)?)
            .map_err(|source| CaseError::Condition { path: at(CONDITION), source })?;
        let broken = |source| CaseError::Truth { path: at(TRUTH), source };
        let truth = TruthFile::from_json(&bytes(TRUTH)?).map_err(broken)?;
        let links = truth.links(mesh.frame()).map_err(broken)?;
        check_parents(&condition, &links, &at(TRUTH))?;
        let labels = bytes(LABELS)?;
        let part_of_face = labels.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]]));
        let case = Self {
            name: name_of(folder),
            folder: folder.to_path_buf(),
            mesh,
            condition,
            part_of_face: part_of_face.collect(),
            links,
        };
        case.check_labels(labels.len(), &at(LABELS))?;
        Ok(case)
    }

    /// Reads a case folder, with the point prompts where they are wanted.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_with(folder: &Path, prompts: Prompts, seed: u64) -> Result<Self, CaseError> {
        let case = Self::read(folder)?;
        Ok(match prompts {
            Prompts::AsGiven => case,
            Prompts::Anywhere => case.prompted_anywhere(seed),
        })
    }

    /// The same with every point prompt anywhere on the true part, drawn by a seed and the case's name; a part
    /// without a point gets none.
    fn prompted_anywhere(mut self, seed: u64) -> Self {
        let own = blake3::hash(self.name.as_bytes());
        let own = own
            .as_bytes()
            .iter()
            .take(8)
            .fold(seed, |all, &b| all.wrapping_mul(257) ^ u64::from(b));
        let mut dice = Pcg64Mcg::seed_from_u64(own);
        for (part, prompt) in self.condition.prompts.iter_mut().enumerate() {
            let is_own = |face: &usize| usize::from(self.part_of_face[*face]) == part;
            let faces: Vec<usize> = (0..self.part_of_face.len()).filter(is_own).collect();
            let face = any_face(&self.mesh, &faces, &mut dice);
            if let (Some(_), Some(face)) = (prompt.point, face) {
                prompt.point = Some(self.mesh.centroid(face));
                prompt.also.clear();
            }
        }
        self
    }

    fn check_labels(&self, bytes: usize, path: &Path) -> Result<(), CaseError> {
        let (faces, parts) = (self.mesh.faces().len(), self.links.len());
        let misfit =
            |expected, found| Err(CaseError::Misfit { path: path.into(), expected, found });
        if bytes != 2 * faces {
            return misfit(format!("{} bytes, two per face", 2 * faces), format!("{bytes}"));
        }
        match self.part_of_face.iter().find(|p| usize::from(**p) >= parts) {
            Some(label) => misfit(format!("labels below {parts}"), format!("{label}")),
            None => Ok(()),
        }
    }
}

/// The question is about the true parts: as many, hung together alike.
fn check_parents(condition: &Condition, links: &[Link], path: &Path) -> Result<(), CaseError> {
    let asked: Vec<_> = condition.tree.parts().iter().map(|p| p.parent).collect();
    let known: Vec<_> = links.iter().map(|l| l.parent).collect();
    if asked == known {
        return Ok(());
    }
    let expected = format!("the condition's parents {asked:?}");
    Err(CaseError::Misfit { path: path.into(), expected, found: format!("{known:?}") })
}

/// Writes an object whose parts and joints are known as a case others can be measured with.
///
/// # Errors
/// [`CaseError::Io`] when the disk refuses.
pub fn write(
    folder: &Path,
    object: &ArticulatedObject,
    condition: &ConditionFile,
) -> Result<(), CaseError> {
    let labels = object.part_of_face().iter().flat_map(|p| p.to_le_bytes()).collect();
    let json = |value: Result<String, serde_json::Error>| {
        let text = value.map_err(|e| unreadable(folder)(e.into()))?;
        Ok::<_, CaseError>((text + "\n").into_bytes())
    };
    let files = [
        (MESH, object::glb::write(object.mesh())),
        (CONDITION, json(serde_json::to_string_pretty(condition))?),
        (TRUTH, json(serde_json::to_string_pretty(&TruthFile::of(object)))?),
        (LABELS, labels),
    ];
    fs::create_dir_all(folder).map_err(unreadable(folder))?;
    files.iter().try_for_each(|(name, bytes)| {
        let path = folder.join(name);
        fs::write(&path, bytes).map_err(unreadable(&path))
    })
}
