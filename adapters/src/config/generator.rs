//! Who makes meshes, as a section of the configuration says.

mod build;

pub(crate) use build::Spoken;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::generators::comfy::Workflow;
use crate::generators::gradio::{App, Call};
use crate::generators::hosted::{FAL, REPLICATE, TRIPO};
use crate::generators::{meshy, stability, tencent};
use crate::net::redact;
use crate::terms::{MIT, OF_YOUR_ACCOUNT, TENCENT_CLOUD, TENCENT_COMMUNITY, Terms, UNTOLD};

/// Who makes meshes. Keys are named by the variable that holds them and never stand in the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "provider", rename_all = "snake_case", deny_unknown_fields)]
pub enum GeneratorConfig {
    /// A program on this machine; of its arguments `{image}`, `{mesh}` and `{seed}` are filled in.
    Command {
        /// The program.
        program: String,
        /// Its arguments.
        arguments: Vec<String>,
        /// Seconds it may take; 900 if left out.
        seconds: Option<u64>,
    },
    /// A Hunyuan3D `api_server`.
    Hunyuan {
        /// Its address, such as `http://127.0.0.1:8081`.
        base: String,
        /// Ask for a job and look after it, instead of one long request.
        #[serde(default)]
        queue: bool,
    },
    /// A Gradio server: TRELLIS, TRELLIS.2, or any app whose functions are told.
    Gradio {
        /// Its address, such as `http://127.0.0.1:7860`.
        base: String,
        /// An app whose functions are known.
        app: Option<App>,
        /// Or the functions to call, in order.
        calls: Option<Vec<Call>>,
    },
    /// A `ComfyUI` server with a workflow of the user's.
    Comfyui {
        /// Its address, such as `http://127.0.0.1:8188`.
        base: String,
        /// The workflow in API format: a file beside the configuration.
        workflow: Workflow,
        /// Id of the node that takes the photo, under `image`.
        image_node: String,
        /// Id of the node that takes the seed, under `seed`.
        seed_node: Option<String>,
    },
    /// Meshy; its key in `MESHY_API_KEY` unless `key_env` names another variable.
    Meshy {
        /// Such as `meshy-6`.
        model: String,
        /// Faces wanted, 100 to 300,000; 30,000 if left out.
        faces: Option<u32>,
        /// The service's address; the vendor's own if left out.
        base: Option<String>,
        /// The variable that holds the key.
        key_env: Option<String>,
    },
    /// Stability; its key in `STABILITY_API_KEY`.
    Stability {
        /// `stable-fast-3d` or `stable-point-aware-3d`.
        model: stability::Model,
        /// The service's address; the vendor's own if left out.
        base: Option<String>,
        /// The variable that holds the key.
        key_env: Option<String>,
    },
    /// Tencent Cloud; its keys in `TENCENTCLOUD_SECRET_ID` and `TENCENTCLOUD_SECRET_KEY`.
    Tencent {
        /// `3.0` or `3.1`.
        model: String,
        /// Faces wanted, 3,000 to 1,500,000; 30,000 if left out.
        faces: Option<u32>,
        /// Such as `ap-guangzhou`, where the account wants one.
        region: Option<String>,
        /// The service's address; the vendor's own if left out.
        base: Option<String>,
        /// The variable that holds the secret id.
        id_env: Option<String>,
        /// The variable that holds the secret key.
        key_env: Option<String>,
    },
    /// fal; its key in `FAL_KEY`.
    Fal(HostedConfig),
    /// Tripo; its key in `TRIPO_API_KEY`.
    Tripo(HostedConfig),
    /// Replicate; its key in `REPLICATE_API_TOKEN`.
    Replicate(HostedConfig),
}

/// An account at a hosted service.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HostedConfig {
    /// Model or endpoint, such as `fal-ai/trellis-2`.
    model: String,
    /// The key of the input under which the photo goes, where models differ in it.
    image_key: Option<String>,
    /// Further inputs of the model.
    #[serde(default)]
    input: Map<String, Value>,
    /// The service's address; the vendor's own if left out.
    base: Option<String>,
    /// The variable that holds the key.
    key_env: Option<String>,
}

const FAL_KEY: &str = "FAL_KEY";
const MESHY_KEY: &str = "MESHY_API_KEY";
const REPLICATE_KEY: &str = "REPLICATE_API_TOKEN";
const STABILITY_KEY: &str = "STABILITY_API_KEY";
const TENCENT_ID: &str = "TENCENTCLOUD_SECRET_ID";
const TENCENT_KEY: &str = "TENCENTCLOUD_SECRET_KEY";
const TRIPO_KEY: &str = "TRIPO_API_KEY";

/// Where a provider's keys stand and go where nothing else is said.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Usual {
    /// The service's address.
    pub base: Option<&'static str>,
    /// The variable that says whose key it is.
    pub id: Option<&'static str>,
    /// The variable that holds the key.
    pub key: Option<&'static str>,
}

impl GeneratorConfig {
    /// Its word in the configuration.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Command { .. } => "command",
            Self::Hunyuan { .. } => "hunyuan",
            Self::Gradio { .. } => "gradio",
            Self::Comfyui { .. } => "comfyui",
            Self::Meshy { .. } => "meshy",
            Self::Stability { .. } => "stability",
            Self::Tencent { .. } => "tencent",
            Self::Fal(_) => FAL.name,
            Self::Tripo(_) => TRIPO.name,
            Self::Replicate(_) => REPLICATE.name,
        }
    }

    /// The functions of a Gradio server that will be called, in order; none of any other.
    pub(crate) fn gradio_calls(&self) -> Vec<Call> {
        match self {
            Self::Gradio { app, calls, .. } => {
                calls.clone().or(app.map(App::calls)).unwrap_or_default()
            }
            _ => Vec::new(),
        }
    }

    /// Whether it is a server of the user's own, where asking twice costs time alone.
    pub fn is_own_server(&self) -> bool {
        matches!(self, Self::Hunyuan { .. } | Self::Gradio { .. } | Self::Comfyui { .. })
    }

    /// What is known of its licence.
    pub fn terms(&self) -> Terms {
        match self {
            Self::Hunyuan { .. } => TENCENT_COMMUNITY,
            Self::Tencent { .. } => TENCENT_CLOUD,
            Self::Gradio { app: Some(App::Trellis | App::Trellis2), .. } => MIT,
            Self::Command { .. } | Self::Gradio { .. } | Self::Comfyui { .. } => UNTOLD,
            _ => OF_YOUR_ACCOUNT,
        }
    }

    /// The variable that holds its key, where it has one.
    pub fn key_variable(&self) -> Option<&str> {
        let named = match self {
            Self::Meshy { key_env, .. }
            | Self::Stability { key_env, .. }
            | Self::Tencent { key_env, .. } => key_env,
            Self::Fal(c) | Self::Tripo(c) | Self::Replicate(c) => &c.key_env,
            _ => &None,
        };
        named.as_deref().or(self.usual().key)
    }

    /// The variable that says whose key it is, where a key does not say that itself.
    pub fn id_variable(&self) -> Option<&str> {
        let Self::Tencent { id_env, .. } = self else { return None };
        id_env.as_deref().or(self.usual().id)
    }

    /// The server's address, where it has one of its own.
    pub fn base(&self) -> Option<&str> {
        match self {
            Self::Command { .. } => None,
            Self::Hunyuan { base, .. } | Self::Gradio { base, .. } | Self::Comfyui { base, .. } => {
                Some(base)
            }
            Self::Stability { base, .. } => Some(base.as_deref().unwrap_or(stability::BASE)),
            Self::Meshy { base, .. } => Some(base.as_deref().unwrap_or(meshy::BASE)),
            Self::Tencent { base, .. } => Some(base.as_deref().unwrap_or(tencent::BASE)),
            Self::Fal(c) => Some(c.base.as_deref().unwrap_or(FAL.base)),
            Self::Tripo(c) => Some(c.base.as_deref().unwrap_or(TRIPO.base)),
            Self::Replicate(c) => Some(c.base.as_deref().unwrap_or(REPLICATE.base)),
        }
    }

    /// Where its keys stand and go where nothing else is said.
    pub(super) fn usual(&self) -> Usual {
        let usual = |base, key| Usual { base: Some(base), id: None, key: Some(key) };
        match self {
            Self::Command { .. } | Self::Hunyuan { .. } | Self::Gradio { .. } => Usual::default(),
            Self::Comfyui { .. } => Usual::default(),
            Self::Stability { .. } => usual(stability::BASE, STABILITY_KEY),
            Self::Meshy { .. } => usual(meshy::BASE, MESHY_KEY),
            Self::Tencent { .. } => {
                Usual { id: Some(TENCENT_ID), ..usual(tencent::BASE, TENCENT_KEY) }
            }
            Self::Fal(_) => usual(FAL.base, FAL_KEY),
            Self::Tripo(_) => usual(TRIPO.base, TRIPO_KEY),
            Self::Replicate(_) => usual(REPLICATE.base, REPLICATE_KEY),
        }
    }

    /// The same as it may be kept in a trace.
    pub(super) fn redacted(mut self) -> Self {
        match &mut self {
            Self::Hunyuan { base, .. }
            | Self::Gradio { base, .. }
            | Self::Comfyui { base, .. }
            | Self::Stability { base: Some(base), .. }
            | Self::Tencent { base: Some(base), .. }
            | Self::Meshy { base: Some(base), .. } => *base = redact::url(base),
            Self::Fal(c) | Self::Tripo(c) | Self::Replicate(c) => {
                c.base = c.base.take().map(|base| redact::url(&base));
            }
            Self::Command { .. }
            | Self::Stability { base: None, .. }
            | Self::Tencent { base: None, .. }
            | Self::Meshy { base: None, .. } => {}
        }
        self
    }
}
