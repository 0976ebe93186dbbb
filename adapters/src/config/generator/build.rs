//! From a section of the configuration to the adapter it names.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use super::{GeneratorConfig, HostedConfig};
use crate::bounded::read_limited;
use crate::generators::comfy::Workflow;
use crate::generators::hosted::{Dialect, FAL, REPLICATE, TRIPO};
use crate::generators::hunyuan::Manner;
use crate::generators::{
    Comfy, Command, Generated, Generator, Gradio, Hosted, Hunyuan, Meshy, Patience, Stability,
    Tencent, meshy, stability, tencent,
};
use crate::recorded::Builds;
use crate::{AdapterError, ImageTo3d, World};

/// Largest workflow, bytes.
const MAX_WORKFLOW: u64 = 4 << 20;

impl GeneratorConfig {
    /// Reads the files it names, which lie in `folder`.
    ///
    /// # Errors
    /// [`AdapterError::Io`] or [`AdapterError::Format`], naming the file.
    pub(in crate::config) fn read_files(&mut self, folder: &Path) -> Result<(), AdapterError> {
        let Self::Comfyui { workflow, .. } = self else { return Ok(()) };
        let Workflow::File(name) = workflow else { return Ok(()) };
        let path = folder.join(name);
        let graph = serde_json::from_slice(&read_limited(&path, MAX_WORKFLOW)?);
        *workflow = Workflow::Graph(graph.map_err(|e| AdapterError::Format {
            path: path.display().to_string(),
            expected: "a ComfyUI workflow in API format",
            found: e.to_string(),
        })?);
        Ok(())
    }
}

/// The adapter as it is written: the one place where a program becomes one.
impl Builds for GeneratorConfig {
    fn adapter(&self, world: &World) -> Result<Box<dyn ImageTo3d>, AdapterError> {
        if let Self::Command { program, arguments, seconds } = self.clone() {
            let deadline = Duration::from_secs(seconds.unwrap_or(900));
            let World { scratch, pace, ledger, keeper, onlooker, .. } = world.clone();
            return Ok(Box::new(Command {
                program,
                arguments,
                deadline,
                scratch,
                pace,
                ledger,
                keeper,
                onlooker,
            }));
        }
        Spoken(self.clone()).adapter(world)
    }

    fn is_program(&self) -> bool {
        matches!(self, Self::Command { .. })
    }
}

/// Somebody who is spoken to, over the world's transport, and who does nothing on this machine.
#[derive(Clone)]
pub(crate) struct Spoken(GeneratorConfig);

impl Spoken {
    /// None for a program.
    pub(in crate::config) fn of(config: GeneratorConfig) -> Option<Self> {
        (!matches!(config, GeneratorConfig::Command { .. })).then_some(Self(config))
    }
}

impl Builds for Spoken {
    fn adapter(&self, world: &World) -> Result<Box<dyn ImageTo3d>, AdapterError> {
        use GeneratorConfig as Who;
        let key = || world.key(self.0.key_variable().unwrap_or_default());
        Ok(match self.0.clone() {
            Who::Command { program, .. } => {
                let found = "a program is not spoken to".into();
                return Err(AdapterError::Program { program, found });
            }
            Who::Hunyuan { base, queue } => {
                let manner = if queue { Manner::Queue } else { Manner::Wait };
                generated(Hunyuan { manner, ..Hunyuan::new(base) }, world)
            }
            Who::Gradio { base, .. } => {
                let calls = Some(self.0.gradio_calls()).filter(|c| !c.is_empty());
                let calls = calls.ok_or_else(|| AdapterError::Format {
                    path: "[image_to_3d]".into(),
                    expected: "`app` or `calls` of the Gradio server",
                    found: "neither".into(),
                })?;
                generated(Gradio { base, calls }, world)
            }
            Who::Comfyui { base, workflow, image_node, seed_node } => {
                let Workflow::Graph(graph) = workflow else {
                    return Err(AdapterError::Format {
                        path: "[image_to_3d]".into(),
                        expected: "the workflow itself, read from its file",
                        found: "the name of a file".into(),
                    });
                };
                generated(Comfy { base, graph, image_node, seed_node }, world)
            }
            Who::Stability { model, base, .. } => {
                let base = base.unwrap_or_else(|| stability::BASE.into());
                generated(Stability { base, key: key()?, model }, world)
            }
            Who::Meshy { model, faces, base, .. } => {
                let base = base.unwrap_or_else(|| meshy::BASE.into());
                let faces = faces.unwrap_or(30_000);
                generated(Meshy { base, key: key()?, model, faces }, world)
            }
            Who::Tencent { model, faces, region, base, .. } => {
                let id = world.key(self.0.id_variable().unwrap_or_default())?;
                let base = base.unwrap_or_else(|| tencent::BASE.into());
                let (faces, clock) = (faces.unwrap_or(30_000), Arc::clone(&world.clock));
                let key = key()?;
                generated(Tencent { base, id, key, region, model, faces, clock }, world)
            }
            Who::Fal(config) => generated(config.hosted(&FAL, "image_url", key()?), world),
            Who::Tripo(config) => generated(config.hosted(&TRIPO, "file", key()?), world),
            Who::Replicate(config) => generated(config.hosted(&REPLICATE, "image", key()?), world),
        })
    }
}

impl HostedConfig {
    fn hosted(
        self,
        dialect: &'static Dialect,
        usual_key: &str,
        key: secrecy::SecretString,
    ) -> Hosted {
        let Self { model, image_key, input, base, .. } = self;
        let base = base.unwrap_or_else(|| dialect.base.into());
        let image_key = image_key.unwrap_or_else(|| usual_key.into());
        Hosted { dialect, base, key, model, image_key, input }
    }
}

fn generated(generator: impl Generator + 'static, world: &World) -> Box<dyn ImageTo3d> {
    let World { transport, on_record, pace, ledger, .. } = world.clone();
    let patience = Patience::default();
    Box::new(Generated { generator, transport, on_record, pace, ledger, patience })
}
