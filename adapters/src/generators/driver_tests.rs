//! The driver against fakes of every protocol, well and in every trouble.

use super::*;
use crate::contract::check_image_to_3d;
use crate::generators::fake::{Fake, Protocol, Trouble, glb_file};
use crate::generators::gradio::App;
use crate::generators::hosted::{Dialect, FAL, REPLICATE, TRIPO};
use crate::generators::hunyuan::Manner;
use crate::generators::{
    Comfy, Gradio, Hosted, Hunyuan, MemoryLedger, Meshy, Stability, stability,
};
use crate::net::pace::ImaginedPace;
use crate::net::redirect::Following;
use crate::photo::tests::png;
use crate::{Response, TransportError};

const ALL: [Protocol; 9] = [
    Protocol::Hunyuan,
    Protocol::HunyuanQueue,
    Protocol::Gradio,
    Protocol::Meshy,
    Protocol::Fal,
    Protocol::Tripo,
    Protocol::Replicate,
    Protocol::Comfy,
    Protocol::Stability,
];
/// Services that are looked at again and again.
const JOBS: [Protocol; 6] = [
    Protocol::HunyuanQueue,
    Protocol::Meshy,
    Protocol::Fal,
    Protocol::Tripo,
    Protocol::Replicate,
    Protocol::Comfy,
];
/// Services with a bill, whose jobs have numbers.
const PAID: [Protocol; 4] = [Protocol::Meshy, Protocol::Fal, Protocol::Tripo, Protocol::Replicate];
/// Services that give the mesh in answer to the submit.
const AT_ONCE: [Protocol; 2] = [Protocol::Hunyuan, Protocol::Stability];

/// Services with jobs.
fn with_jobs() -> impl Iterator<Item = Protocol> {
    ALL.into_iter().filter(|p| !AT_ONCE.contains(p))
}

struct ToFake(Arc<Fake>);

impl Transport for ToFake {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        self.0.send(request)
    }
}

/// One service with one user.
struct Bench {
    fake: Arc<Fake>,
    pace: Arc<ImaginedPace>,
    ledger: Arc<MemoryLedger>,
}

impl Bench {
    fn new(protocol: Protocol, trouble: Trouble) -> Self {
        let fake = Arc::new(Fake::new(protocol, trouble));
        Self { fake, pace: Arc::default(), ledger: Arc::default() }
    }

    fn adapter(&self) -> Box<dyn ImageTo3d> {
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
            Protocol::Hunyuan => self.generated(hunyuan(Manner::Wait)),
            Protocol::HunyuanQueue => self.generated(hunyuan(Manner::Queue)),
            Protocol::Gradio => self.generated(Gradio {
                base: "http://127.0.0.1:7860".into(),
                calls: App::Trellis.calls(),
            }),
            Protocol::Meshy => {
                let (base, key) =
                    (super::super::meshy::BASE.into(), "canary-key".to_owned().into());
                self.generated(Meshy { base, key, model: "meshy-6".into(), faces: 30_000 })
            }
            Protocol::Fal => self.generated(hosted(&FAL, "fal-ai/trellis-2/extra", "image_url")),
            Protocol::Tripo => self.generated(hosted(&TRIPO, "v3.1-20260211", "file")),
            Protocol::Comfy => {
                let node = |class: &str| serde_json::json!({ "class_type": class, "inputs": {} });
                let graph = [("1", "LoadImage"), ("2", "KSampler")];
                let graph = graph.map(|(id, class)| (id.to_owned(), node(class)));
                self.generated(Comfy {
                    base: "http://127.0.0.1:8188".into(),
                    graph: graph.into_iter().collect(),
                    image_node: "1".into(),
                    seed_node: Some("2".into()),
                })
            }
            Protocol::Stability => self.generated(Stability {
                base: super::super::stability::BASE.into(),
                key: "canary-key".to_owned().into(),
                model: stability::Model::PointAware,
            }),
            Protocol::Replicate => {
                self.generated(hosted(&REPLICATE, "someone/some-model", "image"))
            }
        }
    }

    fn generated(&self, generator: impl Generator + 'static) -> Box<dyn ImageTo3d> {
        let transport: Arc<dyn Transport> = Arc::new(Following(ToFake(Arc::clone(&self.fake))));
        let (pace, ledger) = (Arc::clone(&self.pace), Arc::clone(&self.ledger));
        Box::new(Generated { generator, transport, pace, ledger, patience: Patience::default() })
    }

    fn ask(&self) -> Result<GeneratedMesh, AdapterError> {
        self.adapter().generate(&photo(), 7)
    }

    fn told(&self) -> String {
        let error = self.ask().unwrap_err();
        let told = format!("{error} {error:?}");
        assert!(!told.contains("canary"), "{told}");
        error.to_string()
    }

    fn counts(&self) -> [u32; 3] {
        *self.fake.counts.lock().unwrap()
    }
}

fn photo() -> Photo {
    Photo::read(png(32, 24), "photo").unwrap()
}

#[test]
fn every_service_keeps_the_promise() {
    for protocol in ALL {
        let bench = Bench::new(protocol, Trouble::None);
        check_image_to_3d(&*bench.adapter(), &photo()).unwrap().unwrap();
        assert_eq!(bench.ask().unwrap().file, glb_file(), "{protocol:?}");
        let submits = bench.counts()[0];
        let expected = if AT_ONCE.contains(&protocol) { 3 } else { 2 };
        assert_eq!(submits, expected, "{protocol:?}: once per photo and seed");
        let sent = format!("{:?}", bench.fake.bodies.lock().unwrap());
        assert!(!sent.contains("canary"), "no key stands in a body");
    }
}

#[test]
fn a_job_known_by_its_number_is_never_asked_for_again() {
    for protocol in JOBS {
        let bench = Bench::new(protocol, Trouble::Endless);
        let told = bench.told();
        assert!(told.contains("job job-1: still not done after 900s"), "{told}");
        assert!(bench.pace.elapsed() <= Duration::from_secs(900));
        bench.fake.now(Trouble::None);
        bench.ask().unwrap();
        assert_eq!(bench.counts()[0], 1, "{protocol:?}");
    }
}

#[test]
fn a_paid_submit_whose_answer_is_lost_is_not_repeated() {
    for protocol in PAID {
        let bench = Bench::new(protocol, Trouble::SubmitAnswerLost);
        assert!(bench.told().contains("stopped before its end"), "{protocol:?}");
        bench.fake.now(Trouble::None);
        assert!(bench.told().contains("may have been charged"), "{protocol:?}");
        assert_eq!(bench.counts()[0], 1, "{protocol:?}");
    }
}

#[test]
fn a_submit_that_cannot_be_read_or_failed_inside_is_not_repeated_either() {
    for protocol in PAID {
        for trouble in [Trouble::SubmitBody("<html>ok</html>"), Trouble::SubmitStatus(500, "oh")] {
            let bench = Bench::new(protocol, trouble);
            bench.told();
            bench.fake.now(Trouble::None);
            assert!(bench.told().contains("may have been charged"), "{protocol:?} {trouble:?}");
        }
    }
}

#[test]
fn a_submit_that_never_arrived_or_was_refused_may_be_repeated() {
    let refused = Trouble::SubmitStatus(402, "no credits");
    for protocol in PAID {
        for (trouble, arrived) in [(Trouble::SubmitUnheard, 1), (refused, 2)] {
            let bench = Bench::new(protocol, trouble);
            bench.told();
            bench.fake.now(Trouble::None);
            bench.ask().unwrap();
            assert_eq!(bench.counts()[0], arrived, "{protocol:?} {trouble:?}");
        }
        let error = Bench::new(protocol, refused).ask().unwrap_err();
        let told = "submit: the answer must be a success, found 402 no credits";
        assert!(error.to_string().ends_with(told), "{error}");
        assert_eq!(error.hint(), Some("the account at the service is empty"));
    }
}

#[test]
fn a_free_server_is_asked_again_after_a_lost_answer() {
    let bench = Bench::new(Protocol::Hunyuan, Trouble::SubmitAnswerLost);
    assert!(bench.ask().unwrap_err().is_transient());
    bench.fake.now(Trouble::None);
    bench.ask().unwrap();
}

#[test]
fn lost_looks_do_not_end_a_job() {
    for protocol in JOBS {
        Bench::new(protocol, Trouble::LooksLost).ask().unwrap();
    }
}

#[test]
fn a_dead_or_forgotten_job_is_told_and_the_next_run_asks_anew() {
    let (dead, gone) = ("the service gave it up: no object", "the service no longer knows it");
    let died = with_jobs().map(|p| (p, Trouble::Dead, dead));
    // Hunyuan calls a job it lost "processing", and ComfyUI says nothing of it.
    let knows = |p: &Protocol| !matches!(p, Protocol::HunyuanQueue | Protocol::Comfy);
    let forgot = with_jobs().filter(knows).map(|p| (p, Trouble::Forgotten, gone));
    for (protocol, trouble, words) in died.chain(forgot) {
        let bench = Bench::new(protocol, trouble);
        let told = bench.told();
        assert!(told.contains(words), "{protocol:?}: {told}");
        bench.fake.now(Trouble::None);
        bench.ask().unwrap();
        assert_eq!(bench.counts()[0], 2, "{protocol:?}");
    }
}

#[test]
fn an_expired_address_is_asked_for_again_without_a_new_job() {
    for protocol in PAID {
        let bench = Bench::new(protocol, Trouble::Expired);
        let told = bench.told();
        assert!(told.contains("download") && told.contains("403 an HTML page"), "{told}");
        bench.fake.now(Trouble::None);
        bench.ask().unwrap();
        assert_eq!(bench.counts()[0], 1, "{protocol:?}");
    }
}

#[test]
fn an_address_inside_the_house_is_not_fetched() {
    for protocol in PAID {
        let bench = Bench::new(protocol, Trouble::PrivateFile);
        assert!(bench.told().contains("private"), "{protocol:?}");
        assert_eq!(bench.counts()[2], 0);
    }
}

#[test]
fn a_server_of_ones_own_is_fetched_from_by_its_own_address_alone() {
    let bench = Bench::new(Protocol::Gradio, Trouble::None);
    bench.ask().unwrap();
    assert_eq!(bench.counts(), [1, 3, 1], "three functions, one file");
}

#[test]
fn what_is_no_mesh_is_refused_with_what_it_is() {
    let file = |protocol, bytes| Bench::new(protocol, Trouble::File(bytes)).told();
    for protocol in ALL {
        let told = file(protocol, b"glTF\x02\0\0\0 but not really a GLB file");
        assert!(told.contains("GLB: "), "{protocol:?}: {told}");
        assert!(file(protocol, b"<html>").contains("GLB"), "{protocol:?}");
    }
}

#[test]
fn pages_torn_json_and_foreign_words_in_answers_are_told() {
    let bodies = ["<html>sorry</html>", "{\"status\": \"IN_", "{}", "{\"status\": \"HM\"}", ""];
    for protocol in JOBS {
        // ComfyUI says nothing of a job that goes on.
        for body in bodies.iter().filter(|b| protocol != Protocol::Comfy || **b != "{}") {
            let told = Bench::new(protocol, Trouble::LookBody(body)).told();
            assert!(told.contains("status"), "{protocol:?} {body}: {told}");
        }
    }
    let hostile = r#"{"result": "../x", "uid": "a/b", "event_id": "?", "request_id": "..",
        "data": {"task_id": "a b"}, "id": "%2e", "prompt_id": "."}"#;
    for protocol in with_jobs() {
        let told = Bench::new(protocol, Trouble::SubmitBody(hostile)).told();
        assert!(told.contains("must be letters, digits"), "{protocol:?}: {told}");
    }
    for body in ["event: complete\ndata: [", "event: heartbeat\n", "<html>", "data: x", ""] {
        let told = Bench::new(Protocol::Gradio, Trouble::LookBody(body)).told();
        assert!(told.contains("stream") || told.contains("must be JSON"), "{body}: {told}");
    }
}

#[test]
fn only_keys_a_server_knows_are_sent() {
    let bench = Bench::new(Protocol::Hunyuan, Trouble::None);
    bench.ask().unwrap();
    let body = bench.fake.bodies.lock().unwrap()[0].clone();
    let keys: std::collections::BTreeSet<_> = body.as_object().unwrap().keys().collect();
    let known = ["image", "num_inference_steps", "octree_resolution", "seed", "texture", "type"];
    assert!(keys.into_iter().eq(known.iter()), "{body}");
}
