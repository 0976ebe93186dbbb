//! Whoever was asked, once more: what was answered then, and nothing else.
//!
//! Whose configuration it is does not matter, since nothing built here can act. All of it reaches
//! the world through [`Replayed`] alone, and a section that names a program has no adapter here.

use std::path::PathBuf;
use std::sync::Arc;

use trace::FixedClock;

use crate::budget::MemoryBook;
use crate::generators::MemoryLedger;
use crate::net::calls::Unkept;
use crate::net::pace::ImaginedPace;
use crate::net::tape::{Bodies, Exchange, Replayed};
use crate::transport::Deny;
use crate::{AdapterError, Config, Critic, ImageTo3d, Vlm, World};

/// What was said for one question, to be said again.
pub struct Replay {
    /// It is made here and handed to nobody, so that no other transport can come into it.
    world: World,
}

impl Replay {
    /// Says again what stands in these calls.
    pub fn new(calls: Vec<Exchange>, bodies: Bodies) -> Self {
        Self {
            world: World {
                transport: Arc::new(Replayed::new(calls, bodies)),
                on_record: Arc::new(Deny),
                calls: Arc::new(Unkept),
                pace: Arc::new(ImaginedPace::default()),
                clock: Arc::new(FixedClock(0)),
                ledger: Arc::new(MemoryLedger::default()),
                book: Arc::new(MemoryBook::default()),
                gates: Arc::default(),
                // Nobody who is only spoken to has files.
                scratch: PathBuf::new(),
                keeper: None,
                onlooker: None,
                // Keys are never in a record; what was answered to them is.
                variable: |_| Some("0".to_owned()),
            },
        }
    }

    /// Whoever made meshes; none if nobody is configured, or a program, which is never run again.
    ///
    /// # Errors
    /// [`AdapterError`] for a section that makes no sense.
    pub fn image_to_3d(&self, config: &Config) -> Result<Option<Box<dyn ImageTo3d>>, AdapterError> {
        config.spoken(&self.world)
    }

    /// Whoever said what the parts are; none if nobody is configured.
    ///
    /// # Errors
    /// [`AdapterError`] for a section that makes no sense.
    pub fn vlm(&self, config: &Config) -> Result<Option<Box<dyn Vlm>>, AdapterError> {
        config.vlm(&self.world)
    }

    /// Whoever said what looks wrong; none unless that was asked for.
    ///
    /// # Errors
    /// [`AdapterError`] for a section that makes no sense.
    pub fn critic(&self, config: &Config) -> Result<Option<Box<dyn Critic>>, AdapterError> {
        config.critic(&self.world)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::Photo;
    use crate::photo::tests::png;

    fn config(section: serde_json::Value) -> Config {
        serde_json::from_value(json!({ "image_to_3d": section, "vlm": null })).unwrap()
    }

    fn replay() -> Replay {
        Replay::new(vec![], Bodies::new())
    }

    #[test]
    fn a_program_has_no_adapter_whatever_it_is_called() {
        for program in ["sh", "/bin/true", "no-such-program", ""] {
            let section = json!({
                "provider": "command", "program": program, "arguments": ["-c", "exit 0"],
                "seconds": 18446744073709551615_u64,
            });
            assert!(replay().image_to_3d(&config(section)).unwrap().is_none(), "{program}");
        }
    }

    /// Every provider there is: what is not in the record is refused, and nobody is asked.
    #[test]
    fn every_other_provider_is_answered_by_the_record_alone() {
        let photo = Photo::read(png(256, 256), "p").unwrap();
        let host = "http://127.0.0.1:1";
        let sections = [
            json!({ "provider": "hunyuan", "base": host, "queue": true }),
            json!({ "provider": "gradio", "base": host, "app": "trellis" }),
            json!({ "provider": "comfyui", "base": host, "workflow": { "1": { "inputs": {} } },
                "image_node": "1" }),
            json!({ "provider": "stability", "base": host, "model": "stable-fast-3d" }),
            json!({ "provider": "meshy", "base": host, "model": "m" }),
            json!({ "provider": "tencent", "base": host, "model": "3.0" }),
            json!({ "provider": "fal", "base": host, "model": "m" }),
            json!({ "provider": "tripo", "base": host, "model": "m" }),
            json!({ "provider": "replicate", "base": host, "model": "o/n" }),
        ];
        for section in sections {
            let asked = replay().image_to_3d(&config(section.clone())).unwrap().unwrap();
            let error = asked.generate(&photo, 1).unwrap_err().to_string();
            assert!(error.contains("not in the record"), "{section}: {error}");
        }
    }

    /// A stranger's configuration may name a file where a workflow was read.
    #[test]
    fn no_file_is_read_that_a_configuration_names() {
        let section = json!({ "provider": "comfyui", "base": "http://h", "workflow": "/etc/passwd",
            "image_node": "1" });
        let error = replay().image_to_3d(&config(section)).err().unwrap().to_string();
        assert!(error.contains("the name of a file"), "{error}");
    }

    #[test]
    fn rates_prices_and_waits_of_any_size_take_no_time() {
        let photo = Photo::read(png(32, 32), "p").unwrap();
        let config: Config = serde_json::from_value(json!({
            "image_to_3d": { "provider": "hunyuan", "base": "http://h", "queue": true },
            "vlm": null,
            "manners": { "image_to_3d": { "rate": { "at_once": 0, "per_minute": 0 } } },
        }))
        .unwrap();
        let asked = replay().image_to_3d(&config).unwrap().unwrap();
        assert!(asked.generate(&photo, u64::MAX).is_err());
    }
}
