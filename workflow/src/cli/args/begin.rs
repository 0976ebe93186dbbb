//! Arguments of what one begins with: a condition to write, and points to find for it.

use std::path::PathBuf;

use clap::Args;
use object::mesh::UpAxis;

use super::parse::{bend, pixel, up_axis};

const POINTS_HELP: &str = "\
Examples:
  kinfold points cabinet.glb                      eight views with a grid, and points.json
  kinfold points cabinet.glb --at front:512,300   the point that this pixel shows
  kinfold points cabinet.glb --at front:512,300 --faces
                                                  the faces of the smooth patch around it

A point is written as a condition has it, in the mesh file's own coordinates.";

/// Arguments of `kinfold points`.
#[derive(Args, Debug)]
#[command(after_help = POINTS_HELP)]
pub struct PointsArgs {
    /// The mesh: GLB, glTF, OBJ, STL, PLY or USD
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,
    /// Its up axis: y or z [default: y]
    #[arg(long, value_name = "AXIS", value_parser = up_axis)]
    pub up: Option<UpAxis>,
    /// Say only which point a pixel of a view shows
    #[arg(long, value_name = "VIEW:X,Y", value_parser = pixel)]
    pub at: Option<(String, [f64; 2])>,
    /// Say which faces are around that point, as `faces` of a condition has them: those that follow on
    /// over edges that bend by at most so many degrees [default: 30]; 180 for all that hangs together
    #[arg(long, value_name = "DEGREES", requires = "at", value_parser = bend)]
    #[arg(num_args = 0..=1, default_missing_value = "30", hide_default_value = true)]
    pub faces: Option<f64>,
    /// Where views and table go [default: ./<mesh's name>.points]
    #[arg(long, value_name = "DIR", conflicts_with = "at")]
    pub out: Option<PathBuf>,
    /// Write over files that are there
    #[arg(long, conflicts_with = "at")]
    pub force: bool,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `kinfold init`.
#[derive(Args, Debug)]
pub struct InitArgs {
    /// Where condition.json and kinfold.toml go [default: the working folder]
    #[arg(value_name = "DIR", default_value = ".", hide_default_value = true)]
    pub folder: PathBuf,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
}
