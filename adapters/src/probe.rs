//! Whether whoever is configured answers, and can do what it will be asked for.

use std::sync::Arc;
use std::time::Duration;

use trace::Digest;

use crate::asking::Asking;
use crate::asking::dots::Pointing;
use crate::config::{Config, GeneratorConfig, VlmConfig, VlmProvider};
use crate::generators::gradio::{Call, Configured};
use crate::net::discreet::Discreet;
use crate::net::redactor::Redactor;
use crate::transport::{Method, Request};
use crate::{AdapterError, World};

/// What was found out about one matter.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Finding {
    /// What was looked at.
    pub what: String,
    /// Whether all is well.
    pub well: bool,
    /// What was found.
    pub found: String,
    /// What to do about it, where there is something to be done.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
}

impl Finding {
    fn well(what: &str, found: impl Into<String>) -> Self {
        Self { what: what.into(), well: true, found: found.into(), hint: None }
    }

    fn ill(what: &str, found: impl Into<String>, hint: impl Into<String>) -> Self {
        let hint = Some(hint.into()).filter(|h: &String| !h.is_empty());
        Self { what: what.into(), well: false, found: found.into(), hint }
    }

    fn failed(what: &str, error: &AdapterError) -> Self {
        Self::ill(what, error.to_string(), error.hint().unwrap_or_default())
    }

    /// The same without what must not be told.
    fn without(self, redactor: &Redactor) -> Self {
        let text = |text: String| redactor.text(&text).into_owned();
        Self { found: text(self.found), hint: self.hint.map(text), ..self }
    }
}

/// What was found without what must not be told, and a world that is asked so.
fn discreet(config: &Config, world: &World) -> (Redactor, World) {
    let known = config.redactor(world);
    let inner = Arc::clone(&world.transport);
    let transport = Arc::new(Discreet { inner, known: known.clone() });
    (known, World { transport, ..world.clone() })
}

/// Looks at the generator: its key, its program, and, unless `ask` forbids it, whether its server
/// answers. Costs nothing.
pub fn generator(
    config: &Config,
    generator: &GeneratorConfig,
    world: &World,
    ask: Ask,
) -> Vec<Finding> {
    let (redactor, world) = &discreet(config, world);
    let mut found = key("image_to_3d", generator.id_variable(), world);
    found.extend(key("image_to_3d", generator.key_variable(), world));
    match (generator, generator.base()) {
        (GeneratorConfig::Command { program, .. }, _) => found.push(on_path(program, world)),
        (GeneratorConfig::Gradio { base, .. }, _) if ask != Ask::Nobody => {
            found.push(functions(base, &generator.gradio_calls(), world));
        }
        (_, Some(base)) if ask != Ask::Nobody => found.push(answers("image_to_3d", base, world)),
        (_, _) => {}
    }
    found.into_iter().map(|f| f.without(redactor)).collect()
}

/// Looks at the model: its key, whether its server answers, and, where `ask` says so, whether it can
/// point: one short call, which may cost a little.
pub fn vlm(config: &Config, vlm: &VlmConfig, world: &World, ask: Ask) -> Vec<Finding> {
    let (redactor, world) = &discreet(config, world);
    let mut found = key("vlm", vlm.key_variable(), world);
    let list = match vlm.provider {
        VlmProvider::Openai => format!("{}/models", vlm.base().trim_end_matches('/')),
        VlmProvider::Anthropic => format!("{}/v1/models", vlm.base().trim_end_matches('/')),
        VlmProvider::Gemini => format!("{}/v1beta/models", vlm.base().trim_end_matches('/')),
    };
    if ask != Ask::Nobody {
        found.push(answers("vlm", &list, world));
    }
    if ask == Ask::ThreeDots && found.iter().all(|f| f.well) {
        found.push(dots(config, vlm, world));
    }
    found.into_iter().map(|f| f.without(redactor)).collect()
}

/// Whether the model is asked anything, or anybody.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// Nobody is asked whether they are there, either.
    Nobody,
    /// Nothing.
    Nothing,
    /// Where three dots are.
    ThreeDots,
}

fn key(section: &str, variable: Option<&str>, world: &World) -> Vec<Finding> {
    let Some(variable) = variable else { return vec![] };
    let what = format!("{section} key");
    let set = (world.variable)(variable).is_some_and(|v| !v.trim().is_empty());
    vec![if set {
        Finding::well(&what, format!("{variable} is set"))
    } else {
        Finding::ill(&what, format!("{variable} is not set"), "put the key into that variable")
    }]
}

fn on_path(program: &str, world: &World) -> Finding {
    let what = "image_to_3d program";
    let path = (world.variable)("PATH").unwrap_or_default();
    let places = std::env::split_paths(&path).map(|folder| folder.join(program));
    let here = std::path::PathBuf::from(program);
    match std::iter::once(here).chain(places).find(|p| p.is_file()) {
        Some(place) => Finding::well(what, place.display().to_string()),
        None => Finding::ill(what, format!("{program} is not there"), "name it with its folder"),
    }
}

/// Whether anybody answers at an address, whatever it is; keys are not sent.
fn answers(section: &str, address: &str, world: &World) -> Finding {
    let what = format!("{section} server");
    let host = crate::net::redact::host(address);
    let request = Request::new("probe", Method::Get, address);
    match world.transport.send(&request.within(Duration::from_secs(15), 4 << 20)) {
        Ok(response) => Finding::well(&what, format!("{host} answers ({})", response.status)),
        Err(error) => Finding::ill(
            &what,
            error.to_string(),
            "start it, or correct `base` in the configuration",
        ),
    }
}

/// Whether a Gradio server answers and has every function that will be called.
fn functions(base: &str, calls: &[Call], world: &World) -> Finding {
    let what = "image_to_3d server";
    let host = crate::net::redact::host(base);
    match Configured::of(base, world.transport.as_ref()) {
        Ok(server) => match server.lacks(calls) {
            None => Finding::well(what, format!("{host} answers and has every function")),
            Some(function) => Finding::ill(
                what,
                format!("{host} has no function `{function}`, only {}", server.told()),
                "start the app that `app` names, or name its functions under `calls`",
            ),
        },
        Err(error) => Finding::ill(
            what,
            error.to_string(),
            "start it, or correct `base` in the configuration",
        ),
    }
}

fn dots(config: &Config, vlm: &VlmConfig, world: &World) -> Finding {
    let what = "vlm points";
    let question = Digest::of(format!("dots {}", vlm.model).as_bytes());
    // How it points today is the question: an earlier answer is none.
    if let Err(error) = world.calls.set_aside(&question, "") {
        return Finding::failed(what, &error);
    }
    let world = config.vlm_world(vlm, world, &question);
    let asking = vlm.codec(&world).map(|codec| Asking {
        codec,
        transport: Arc::clone(&world.transport),
        convention: vlm.convention(),
        max_tokens: 4096,
    });
    match asking.and_then(|a| a.points_at_dots()) {
        Ok(Pointing::Right) => Finding::well(what, format!("{} points at three dots", vlm.model)),
        Ok(Pointing::Otherwise(convention)) => {
            let word = serde_json::to_value(convention).unwrap_or_default();
            let found = format!("{} writes points in another way", vlm.model);
            Finding::ill(what, found, format!("set points = {word} in [vlm]"))
        }
        Ok(Pointing::Cannot(found)) => Finding::ill(what, found, "choose a model that can point"),
        Err(error) => Finding::failed(what, &error),
    }
}
