//! Every provider there is, for people who choose one.

use serde::Serialize;

use crate::terms::{MIT, OF_YOUR_ACCOUNT, TENCENT_CLOUD, TENCENT_COMMUNITY, Terms, UNTOLD};

/// A provider as it stands in a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Provider {
    /// `image_to_3d` or `vlm`.
    pub section: &'static str,
    /// Its word in the configuration.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// Keys of its section, and variables.
    pub needs: &'static str,
    /// What is known of its licence.
    pub terms: Terms,
}

const fn mesh(
    name: &'static str,
    what: &'static str,
    needs: &'static str,
    terms: Terms,
) -> Provider {
    Provider { section: "image_to_3d", name, what, needs, terms }
}

const fn vlm(
    name: &'static str,
    what: &'static str,
    needs: &'static str,
    terms: Terms,
) -> Provider {
    Provider { section: "vlm", name, what, needs, terms }
}

/// The variables that hold keys where a configuration names no other; none of them is told to
/// anybody, whoever is asked.
pub const KEY_VARIABLES: [&str; 10] = [
    "ANTHROPIC_API_KEY",
    "FAL_KEY",
    "GEMINI_API_KEY",
    "MESHY_API_KEY",
    "OPENAI_API_KEY",
    "REPLICATE_API_TOKEN",
    "STABILITY_API_KEY",
    "TENCENTCLOUD_SECRET_ID",
    "TENCENTCLOUD_SECRET_KEY",
    "TRIPO_API_KEY",
];

/// All of them, those that need no account first.
pub const PROVIDERS: [Provider; 13] = [
    mesh("command", "a program on this machine", "program, arguments", UNTOLD),
    mesh("hunyuan", "Hunyuan3D's api_server, 2.0 or 2.1", "base; queue", TENCENT_COMMUNITY),
    mesh("gradio", "a Gradio app: TRELLIS, TRELLIS.2, or your own", "base, app or calls", MIT),
    mesh(
        "comfyui",
        "a ComfyUI server with a workflow of yours",
        "base, workflow, image_node; seed_node",
        UNTOLD,
    ),
    mesh(
        "stability",
        "Stability's SF3D and SPAR3D",
        "model, STABILITY_API_KEY; base, key_env",
        OF_YOUR_ACCOUNT,
    ),
    mesh("meshy", "Meshy", "model, MESHY_API_KEY; faces, base, key_env", OF_YOUR_ACCOUNT),
    mesh(
        "fal",
        "fal's queue, any image-to-3D endpoint",
        "model, FAL_KEY; image_key, input",
        OF_YOUR_ACCOUNT,
    ),
    mesh("tripo", "Tripo's API, version 3", "model, TRIPO_API_KEY; input", OF_YOUR_ACCOUNT),
    mesh(
        "replicate",
        "a model on Replicate",
        "model, REPLICATE_API_TOKEN; image_key, input",
        OF_YOUR_ACCOUNT,
    ),
    mesh(
        "tencent",
        "Tencent Cloud's Hunyuan3D 3.0 and 3.1",
        "model, TENCENTCLOUD_SECRET_ID, TENCENTCLOUD_SECRET_KEY; faces, region, base, id_env, key_env",
        TENCENT_CLOUD,
    ),
    vlm(
        "openai",
        "OpenAI, and every server that speaks chat completions",
        "model; base for a server of your own, else OPENAI_API_KEY",
        OF_YOUR_ACCOUNT,
    ),
    vlm("anthropic", "Anthropic", "model, ANTHROPIC_API_KEY", OF_YOUR_ACCOUNT),
    vlm("gemini", "Gemini", "model, GEMINI_API_KEY", OF_YOUR_ACCOUNT),
];
