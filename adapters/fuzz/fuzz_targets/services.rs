//! Whoever makes meshes, asked through the driver of all jobs, with time imagined.

use std::sync::{Arc, OnceLock};

use adapters::generators::gradio::App;
use adapters::generators::hosted::{Dialect, FAL, REPLICATE, TRIPO};
use adapters::generators::hunyuan::Manner;
use adapters::generators::{
    Comfy, Generated, Generator, Gradio, Hosted, Hunyuan, MemoryLedger, Meshy, Patience, Stability,
    Tencent, stability,
};
use adapters::net::pace::ImaginedPace;
use adapters::net::redirect::Following;
use adapters::transport::Deny;
use adapters::{AdapterError, ImageTo3d, Photo};
use serde_json::json;

use super::Script;

/// Asks one of ten protocols for a mesh.
pub fn ask(who: u8, script: Script) -> Result<(), AdapterError> {
    let key = || "canary-key".to_owned().into();
    let hunyuan = |manner| Hunyuan { manner, ..Hunyuan::new("http://127.0.0.1:8081") };
    let (base, faces) = ("https://h.example".to_owned(), 30_000);
    match who {
        0 => made(hunyuan(Manner::Wait), script),
        1 => made(hunyuan(Manner::Queue), script),
        2 => {
            let (base, calls) = ("http://127.0.0.1:7860".to_owned(), App::Trellis.calls());
            made(Gradio { base, calls }, script)
        }
        3 => made(Meshy { base, key: key(), model: "meshy-6".into(), faces }, script),
        4 => made(hosted(&FAL, "fal-ai/trellis-2", "image_url"), script),
        5 => made(hosted(&TRIPO, "v3.1-20260211", "file"), script),
        6 => made(hosted(&REPLICATE, "someone/some-model", "image"), script),
        7 => made(comfy(), script),
        8 => made(Stability { base, key: key(), model: stability::Model::PointAware }, script),
        _ => {
            let (id, model, clock) = (key(), "3.1".to_owned(), Arc::new(trace::FixedClock(0)));
            made(Tencent { base, id, key: key(), region: None, model, faces, clock }, script)
        }
    }
}

fn made(generator: impl Generator, script: Script) -> Result<(), AdapterError> {
    let (pace, ledger) = (Arc::new(ImaginedPace::default()), Arc::new(MemoryLedger::default()));
    let transport = Arc::new(Following(script));
    let patience = Patience::default();
    let on_record = Arc::new(Deny);
    Generated { generator, transport, on_record, pace, ledger, patience }
        .generate(photo(), 7)
        .map(drop)
}

fn hosted(dialect: &'static Dialect, model: &str, image_key: &str) -> Hosted {
    Hosted {
        dialect,
        base: dialect.base.into(),
        key: "canary-key".to_owned().into(),
        model: model.into(),
        image_key: image_key.into(),
        input: serde_json::Map::new(),
    }
}

fn comfy() -> Comfy {
    let node = |class: &str| json!({ "class_type": class, "inputs": {} });
    let graph = [("1", "LoadImage"), ("2", "KSampler")];
    Comfy {
        base: "http://127.0.0.1:8188".into(),
        graph: graph.into_iter().map(|(id, class)| (id.to_owned(), node(class))).collect(),
        image_node: "1".into(),
        seed_node: Some("2".into()),
    }
}

/// A photo that every service takes.
pub fn photo() -> &'static Photo {
    static PHOTO: OnceLock<Photo> = OnceLock::new();
    PHOTO.get_or_init(|| {
        let picture = view::Picture::blank([160, 132], [90, 120, 60, 255]);
        let png = view::encode_png(&picture).expect("a picture");
        Photo::read(png, "photo").expect("a photo")
    })
}
