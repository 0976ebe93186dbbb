//! A URDF package and its verdict to a page for a browser.

mod found;
mod shown;

use std::sync::Arc;

use runner::{Stage, StageError};
use serde_json::Value;
use sim_check::CheckOptions;
use sim_check::read::load;

use super::artefacts::{Checked, Page, UrdfPackage};
use super::check_in_sim::{Passing, URDF};
use super::code;
use super::seen::dress;
use super::tools::Tools;

pub use shown::{Subject, scene};

/// Name of the sidecar in a package.
const SIDECAR: &str = "asset.json";

/// A URDF package and its verdict to a page for a browser.
pub struct WritePage;

impl Stage<Tools> for WritePage {
    type Input = (Arc<UrdfPackage>, Arc<Checked>);
    type Output = Page;
    const NAME: &'static str = "write-page";

    fn code(&self) -> String {
        code::version(&[code::PAGE, code::SIM_CHECK, code::VIEW])
    }

    fn run(&self, (urdf, checked): Self::Input, tools: &Tools) -> Result<Page, StageError> {
        let folder = Passing::write(&urdf.0, &tools.scratch)?;
        let mut loaded = load::read(&folder.path().join(URDF), &CheckOptions::default());
        if let Some(robot) = &mut loaded.robot {
            dress(robot, &urdf.0);
        }
        let sidecar = urdf.0.get(SIDECAR).and_then(|b| serde_json::from_slice::<Value>(b).ok());
        let subject = Subject {
            name: &loaded.name,
            robot: loaded.robot.as_ref(),
            verdict: Some(&checked.verdict),
            sidecar: sidecar.as_ref(),
            notes: vec![],
        };
        Ok(Page(page::write(&scene(&subject)).into_bytes()))
    }
}
