//! Arguments of `kinfold studio`.

use std::path::PathBuf;

use clap::Args;
use object::mesh::UpAxis;

use super::parse::{up_axis, url};

/// The port that is listened on where nobody names one.
pub const PORT: u16 = 7411;

const STUDIO_HELP: &str = "\
Examples:
  kinfold studio oven.jpg --mesh oven.glb     begins with nothing: name parts, click on each, build
  kinfold studio oven.jpg --mesh oven.glb --condition oven.json      goes on with a condition
  kinfold studio oven.kinfold                 corrects an asset that was made
  kinfold studio oven.jpg                     asks whom kinfold.toml names for the mesh
  kinfold studio --mesh oven.glb              parts and joints alone: building needs a photo

What is clicked and dragged stands in the condition file at once; `kinfold make` with that file makes
the same asset. The page is served to this machine alone, to whoever has the address that is printed.
Ctrl-C ends it; nothing is lost.";

/// Arguments of `kinfold studio`.
#[derive(Args, Clone, Debug)]
#[command(after_help = STUDIO_HELP)]
pub struct StudioArgs {
    /// The photo: PNG, JPEG or WebP; or the folder of an asset that was made
    #[arg(value_name = "PHOTO|DIR", required_unless_present = "mesh")]
    pub path: Option<PathBuf>,
    /// A mesh of the object, instead of a generator's: GLB, glTF, OBJ, STL, PLY or USD
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// The up axis of that mesh and of the condition's points: y or z [default: what the condition says,
    /// else y]
    #[arg(long, value_name = "AXIS", value_parser = up_axis, requires = "mesh")]
    pub up: Option<UpAxis>,
    /// The condition that is edited; one that is not there is begun [default: ./NAME.condition.json]
    #[arg(long, value_name = "FILE")]
    pub condition: Option<PathBuf>,
    /// Where an asset goes [default: ./NAME.kinfold]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// A server that speaks chat completions (OpenAI's protocol) and can be asked for a condition, whatever
    /// kinfold.toml says; the key in OPENAI_API_KEY is sent over https, or to this machine
    #[arg(long, value_name = "URL", value_parser = url, requires = "model")]
    pub vlm: Option<String>,
    /// The model of that server
    #[arg(long, value_name = "NAME", requires = "vlm")]
    pub model: Option<String>,
    /// Who else is asked [default: ./kinfold.toml, where there is one]
    #[arg(long, value_name = "FILE", env = "KINFOLD_CONFIG")]
    pub config: Option<PathBuf>,
    /// Let a kinfold.toml found here act this once, without approving it
    #[arg(long)]
    pub trust_config: bool,
    /// Where finished stages are kept [default: ~/.cache/kinfold]
    #[arg(long, value_name = "DIR", env = "KINFOLD_STATE")]
    pub state: Option<PathBuf>,
    /// The port of this machine that is listened on, 0 for any [default: 7411, or another where that is taken]
    #[arg(long, value_name = "N")]
    pub port: Option<u16>,
    /// Open the page in a browser
    #[arg(long)]
    pub open: bool,
    /// Print the address and the files as JSON
    #[arg(long)]
    pub json: bool,
    /// Say nothing on the way
    #[arg(long, short)]
    pub quiet: bool,
}
