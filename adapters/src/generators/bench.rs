//! A fake service, its user and the time between them, for tests.

use std::sync::Arc;

use super::fake::{Fake, Protocol, Trouble};
use super::gradio::App;
use super::hosted::{Dialect, FAL, REPLICATE, TRIPO};
use super::hunyuan::Manner;
use super::{
    Comfy, Generated, Generator, Gradio, Hosted, Hunyuan, MemoryLedger, Meshy, Patience, Stability,
    Tencent, stability,
};
use crate::net::pace::ImaginedPace;
use crate::net::redirect::Following;
use crate::photo::tests::png;
use crate::{
    AdapterError, GeneratedMesh, ImageTo3d, Photo, Request, Response, Transport, TransportError,
};

/// Every protocol there is.
pub(crate) const ALL: [Protocol; 10] = [
    Protocol::Hunyuan,
    Protocol::HunyuanQueue,
    Protocol::Gradio,
    Protocol::Meshy,
    Protocol::Fal,
    Protocol::Tripo,
    Protocol::Replicate,
    Protocol::Comfy,
    Protocol::Stability,
    Protocol::Tencent,
];

struct ToFake(Arc<Fake>);

impl Transport for ToFake {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        self.0.send(request)
    }
}

/// One service with one user.
pub(crate) struct Bench {
    pub(crate) fake: Arc<Fake>,
    pub(crate) pace: Arc<ImaginedPace>,
    ledger: Arc<MemoryLedger>,
}

impl Bench {
    pub(crate) fn new(protocol: Protocol, trouble: Trouble) -> Self {
        let fake = Arc::new(Fake::new(protocol, trouble));
        Self { fake, pace: Arc::default(), ledger: Arc::default() }
    }

    pub(crate) fn adapter(&self) -> Box<dyn ImageTo3d> {
        self.adapter_through(Arc::new(ToFake(Arc::clone(&self.fake))))
    }

    /// The service as it is spoken to through something.
    pub(crate) fn adapter_through(&self, transport: Arc<dyn Transport>) -> Box<dyn ImageTo3d> {
        let hosted = |dialect: &'static Dialect, model: &str, image_key: &str| Hosted {
            dialect,
            base: dialect.base.into(),
            key: "canary-key".to_owned().into(),
            model: model.into(),
            image_key: image_key.into(),
            input: serde_json::Map::new(),
        };
        let hunyuan = |manner| Hunyuan { manner, ..Hunyuan::new("http://127.0.0.1:8081/") };
        match self.fake.protocol {
            Protocol::Hunyuan => self.generated(&transport, hunyuan(Manner::Wait)),
            Protocol::HunyuanQueue => self.generated(&transport, hunyuan(Manner::Queue)),
            Protocol::Gradio => self.generated(
                &transport,
                Gradio { base: "http://127.0.0.1:7860".into(), calls: App::Trellis.calls() },
            ),
            Protocol::Meshy => {
                let (base, key) = (super::meshy::BASE.into(), "canary-key".to_owned().into());
                self.generated(
                    &transport,
                    Meshy { base, key, model: "meshy-6".into(), faces: 30_000 },
                )
            }
            Protocol::Fal => {
                self.generated(&transport, hosted(&FAL, "fal-ai/trellis-2/extra", "image_url"))
            }
            Protocol::Tripo => self.generated(&transport, hosted(&TRIPO, "v3.1-20260211", "file")),
            Protocol::Comfy => {
                let node = |class: &str| serde_json::json!({ "class_type": class, "inputs": {} });
                let graph = [("1", "LoadImage"), ("2", "KSampler")];
                let graph = graph.map(|(id, class)| (id.to_owned(), node(class)));
                self.generated(
                    &transport,
                    Comfy {
                        base: "http://127.0.0.1:8188".into(),
                        graph: graph.into_iter().collect(),
                        image_node: "1".into(),
                        seed_node: Some("2".into()),
                    },
                )
            }
            Protocol::Stability => self.generated(
                &transport,
                Stability {
                    base: super::stability::BASE.into(),
                    key: "canary-key".to_owned().into(),
                    model: stability::Model::PointAware,
                },
            ),
            Protocol::Tencent => self.generated(
                &transport,
                Tencent {
                    base: super::tencent::BASE.into(),
                    id: "canary-id".to_owned().into(),
                    key: "canary-key".to_owned().into(),
                    region: None,
                    model: "3.1".into(),
                    faces: 30_000,
                    clock: Arc::new(trace::FixedClock(0)),
                },
            ),
            Protocol::Replicate => {
                self.generated(&transport, hosted(&REPLICATE, "someone/some-model", "image"))
            }
        }
    }

    fn generated(
        &self,
        transport: &Arc<dyn Transport>,
        generator: impl Generator + 'static,
    ) -> Box<dyn ImageTo3d> {
        let transport: Arc<dyn Transport> = Arc::new(Following(Arc::clone(transport)));
        let (pace, ledger) = (Arc::clone(&self.pace), Arc::clone(&self.ledger));
        let (on_record, patience) = (Arc::new(crate::transport::Deny), Patience::default());
        Box::new(Generated { generator, transport, on_record, pace, ledger, patience })
    }

    pub(crate) fn ask(&self) -> Result<GeneratedMesh, AdapterError> {
        self.adapter().generate(&photo(), 7)
    }

    pub(crate) fn told(&self) -> String {
        let error = self.ask().unwrap_err();
        let told = format!("{error} {error:?}");
        assert!(!told.contains("canary"), "{told}");
        error.to_string()
    }

    /// What was posted, in order.
    pub(crate) fn posted(&self) -> Vec<Request> {
        self.fake.posted.lock().unwrap().clone()
    }

    pub(crate) fn counts(&self) -> [u32; 3] {
        *self.fake.counts.lock().unwrap()
    }
}

/// A photo that every service takes.
pub(crate) fn photo() -> Photo {
    Photo::read(png(160, 132), "photo").unwrap()
}
