//! Any bytes as the answer of every service: an error or a result, never a crash.
#![no_main]

use adapters::asking::parts;
use adapters::chat::openai::LengthKey;
use adapters::chat::{Anthropic, Codec, Gemini, OpenAi};
use adapters::generators::gradio::App;
use adapters::generators::hosted::{FAL, REPLICATE, TRIPO};
use adapters::generators::{Ask, Generator, Gradio, Hosted, Hunyuan, JobHandle, Meshy};
use adapters::net::redact;
use adapters::usage::Usage;
use adapters::{Photo, Request, Response, Transport, TransportError};
use libfuzzer_sys::fuzz_target;

/// Answers everything with the same bytes.
struct Says(Response);

impl Transport for Says {
    fn send(&self, _: &Request) -> Result<Response, TransportError> {
        Ok(self.0.clone())
    }
}

fn generators() -> Vec<Box<dyn Generator>> {
    let hosted = |dialect: &'static _| Hosted {
        dialect,
        base: "https://h.example".into(),
        key: "key-of-ours".to_owned().into(),
        model: "someone/some-model".into(),
        image_key: "image".into(),
        input: serde_json::Map::new(),
    };
    let (base, key) = ("https://h.example".to_owned(), "key-of-ours".to_owned().into());
    vec![
        Box::new(Hunyuan::new("http://127.0.0.1:8081")),
        Box::new(Gradio { base: "http://127.0.0.1:7860".into(), calls: App::Trellis.calls() }),
        Box::new(Meshy { base, key, model: "m".into(), faces: 30_000 }),
        Box::new(hosted(&FAL)),
        Box::new(hosted(&TRIPO)),
        Box::new(hosted(&REPLICATE)),
    ]
}

fn codecs() -> Vec<Box<dyn Codec>> {
    let (base, model) = ("http://127.0.0.1:8000".to_owned(), "m".to_owned());
    let key = || "key-of-ours".to_owned().into();
    let length = LengthKey::Plain;
    let openai = OpenAi { base: base.clone(), key: None, model: model.clone(), temperature: None, length };
    vec![
        Box::new(openai),
        Box::new(Anthropic { base: base.clone(), key: key(), model: model.clone() }),
        Box::new(Gemini { base, key: key(), model }),
    ]
}

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, body)) = bytes.split_first() else { return };
    let status = [200, 202, 404, 422, 500][usize::from(kind % 5)];
    let response = Response { status, headers: vec![], body: body.to_vec() };
    let says = Says(response.clone());
    let photo = Photo { bytes: vec![1, 2, 3], media_type: "image/png".into(), size: [16, 16] };
    let mut job = JobHandle::new("job-1");
    for (name, value) in [("call", "2"), ("session", "s"), ("path", "/p.png"), ("seed", "7")] {
        job.kept.insert(name.into(), value.into());
    }
    for generator in generators() {
        let _ = generator.submit(&says, &Ask { photo: &photo, seed: 7 }).is_ok();
        let _ = generator.poll(&says, &job).is_ok();
    }
    for codec in codecs() {
        let _ = codec.reply("step", &response).is_ok();
    }
    let _ = Usage::reported(&response);
    let key = [("authorization".to_owned(), "Bearer key-of-ours".to_owned().into())];
    let kept = redact::body(body, &key);
    assert!(!kept.windows(11).any(|w| w == b"key-of-ours"), "a key was kept");
    if let Ok(value) = serde_json::from_slice(body) {
        let _ = parts::judged(value, 8).is_ok();
    }
});
