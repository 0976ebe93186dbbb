//! Arguments of `kinfold make`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use adapters::terms::Policy;
use clap::Args;
use object::mesh::UpAxis;
use sim_check::Tier;
use trace::{Time, moment};

use super::own::Own;
use super::parse::{made_tier, probability, up_axis, url};
use crate::stages::Export;

const MAKE_HELP: &str = "\
Examples:
  kinfold make kettle.jpg                    asks whom kinfold.toml names for mesh and condition
  kinfold make kettle.jpg --mesh kettle.glb --condition kettle.json          asks nobody
  kinfold make --mesh kettle.usdz --condition kettle.json                    the same without a photo
  kinfold make kettle.jpg --mesh kettle.glb --vlm http://127.0.0.1:8000/v1 --model NAME
                                             asks a server of yours what the parts are
  kinfold make kettle.jpg --export mjcf,usd,glb --out kettle                 in four formats
  kinfold make kettle.jpg --dry-run          says which stages would run, and why

A wrong part, axis or range is corrected in the condition (`points`, `not`, `axis`, `range`), and
the same command makes the asset anew. `kinfold init` writes a condition with every field explained.

Exit codes: 0 done, 1 failed, 2 misused, 3 below the tier asked for or something lost";

/// Arguments of `kinfold make`.
#[derive(Args, Clone, Debug)]
#[command(after_help = MAKE_HELP)]
pub struct MakeArgs {
    /// The photo: PNG, JPEG or WebP; not needed where mesh and condition are given
    #[arg(value_name = "PHOTO", required_unless_present_all = ["mesh", "condition"])]
    pub photo: Option<PathBuf>,
    /// A mesh of the object, instead of a generator's: GLB, glTF, OBJ, STL, PLY or USD, with what lies
    /// beside it
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// The up axis of that mesh and of the condition's points: y or z [default: what the condition says,
    /// else y]
    #[arg(long, value_name = "AXIS", value_parser = up_axis, requires = "mesh")]
    pub up: Option<UpAxis>,
    /// A kinematic condition, instead of a vision-language model's
    #[arg(long, value_name = "FILE")]
    pub condition: Option<PathBuf>,
    /// Move points of that condition that lie off the mesh to the nearest on it, instead of refusing them
    #[arg(long, requires = "condition")]
    pub snap: bool,
    /// A server that speaks chat completions (OpenAI's protocol) and is asked for the condition, whatever
    /// kinfold.toml says; the key in OPENAI_API_KEY is sent over https, or to this machine
    #[arg(long, value_name = "URL", value_parser = url, requires = "model")]
    #[arg(conflicts_with = "condition")]
    pub vlm: Option<String>,
    /// The model of that server
    #[arg(long, value_name = "NAME", requires = "vlm")]
    pub model: Option<String>,
    /// Who else is asked for them [default: ./kinfold.toml, where there is one]
    #[arg(long, value_name = "FILE", env = "KINFOLD_CONFIG")]
    pub config: Option<PathBuf>,
    /// Let a kinfold.toml found here act this once, without approving it
    #[arg(long)]
    pub trust_config: bool,
    /// What the asset is meant for: any, or words of commercial, eu, uk and kr with - between, such as
    /// commercial-eu; providers that are not known to allow it are refused before anything is spent
    #[arg(long, value_name = "POLICY", default_value = "any", env = "KINFOLD_POLICY")]
    pub policy: Policy,
    /// Where the asset goes [default: ./<photo's name>.kinfold, or the mesh's]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Formats to write, with commas between: urdf (always written), mjcf, usd, usdz, glb, sdf, ros,
    /// isaaclab, simready
    #[arg(long, value_name = "FORMAT", value_enum, value_delimiter = ',', default_value = "urdf")]
    #[arg(hide_possible_values = true)]
    pub export: Vec<Export>,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// The tier asked for: an asset below it exits 3, and takes no better one's place
    #[arg(long, value_name = "TIER", default_value = "kinematic", value_parser = made_tier)]
    pub tier: Tier,
    /// The probability asked for that every part and joint is right, 0 to 1: an asset below it exits 3
    #[arg(long, value_name = "P", value_parser = probability)]
    pub min_confidence: Option<f64>,
    /// Print the one question whose answer would make the asset likeliest right, and what to add to the
    /// condition for each answer
    #[arg(long)]
    pub ask: bool,
    /// Where finished stages are kept [default: ~/.cache/kinfold]
    #[arg(long, value_name = "DIR", env = "KINFOLD_STATE")]
    pub state: Option<PathBuf>,
    /// Where another run is at work in one of the folders, be refused instead of waiting for it
    #[arg(long)]
    pub no_wait: bool,
    /// Say which stages would run, and why; change nothing
    #[arg(long, conflicts_with = "graph")]
    pub dry_run: bool,
    /// Print the flow as Graphviz and stop
    #[arg(long)]
    pub graph: bool,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
    /// Time written into the trace, for runs that repeat byte for byte: RFC 3339 or nanoseconds
    #[arg(long, value_name = "TIME", value_parser = moment::parse)]
    pub clock: Option<Time>,
    /// Say nothing on the way
    #[arg(long, short)]
    pub quiet: bool,
    /// Whom a program brings that asks for the asset
    #[arg(skip)]
    pub own: Own,
}

/// What is written whatever is asked for.
const ALWAYS: [Export; 3] = [Export::Urdf, Export::Page, Export::Pictures];

impl MakeArgs {
    /// What the asset is called after: the photo, else the mesh.
    pub fn named(&self) -> &Path {
        self.photo.as_deref().or(self.mesh.as_deref()).unwrap_or(Path::new("object"))
    }

    /// Whether nobody whom a configuration names is asked for the mesh.
    pub fn has_mesh(&self) -> bool {
        self.mesh.is_some() || self.own.image_to_3d.is_some()
    }

    /// Whether nobody whom a configuration names is asked for the condition.
    pub fn has_condition(&self) -> bool {
        self.condition.is_some() || self.own.vlm.is_some()
    }

    /// The formats asked for, each once, in a fixed order; URDF, the page and the pictures always.
    pub fn exports(&self) -> Vec<Export> {
        let asked = self.export.iter().copied().chain(ALWAYS);
        asked.collect::<BTreeSet<_>>().into_iter().collect()
    }
}
