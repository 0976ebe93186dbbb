//! The driver against fakes of every protocol, well and in every trouble.

use super::*;
use crate::contract::check_image_to_3d;
use crate::generators::fake::{Fake, Protocol, Trouble, glb_file};
use crate::generators::hunyuan::Manner;
use crate::generators::{Hunyuan, MemoryLedger, Meshy};
use crate::net::pace::ImaginedPace;
use crate::net::redirect::Following;
use crate::photo::tests::png;
use crate::{Response, TransportError};

const ALL: [Protocol; 3] = [Protocol::Hunyuan, Protocol::HunyuanQueue, Protocol::Meshy];
const JOBS: [Protocol; 2] = [Protocol::HunyuanQueue, Protocol::Meshy];

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
        let transport: Arc<dyn Transport> = Arc::new(Following(ToFake(Arc::clone(&self.fake))));
        let (pace, ledger) = (Arc::clone(&self.pace), Arc::clone(&self.ledger));
        let patience = Patience::default();
        let hunyuan = |manner| Hunyuan { manner, ..Hunyuan::new("http://127.0.0.1:8081/") };
        match self.fake.protocol {
            Protocol::Hunyuan => {
                let generator = hunyuan(Manner::Wait);
                Box::new(Generated { generator, transport, pace, ledger, patience })
            }
            Protocol::HunyuanQueue => {
                let generator = hunyuan(Manner::Queue);
                Box::new(Generated { generator, transport, pace, ledger, patience })
            }
            Protocol::Meshy => {
                let (base, key) =
                    (super::super::meshy::BASE.into(), "canary-key".to_owned().into());
                let generator = Meshy { base, key, model: "meshy-6".into(), faces: 30_000 };
                Box::new(Generated { generator, transport, pace, ledger, patience })
            }
        }
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
        let expected = if protocol == Protocol::Hunyuan { 3 } else { 2 };
        assert_eq!(submits, expected, "{protocol:?}: a job is asked for once per photo and seed");
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
    let bench = Bench::new(Protocol::Meshy, Trouble::SubmitAnswerLost);
    assert!(bench.told().contains("stopped before its end"));
    bench.fake.now(Trouble::None);
    assert!(bench.told().contains("may have been charged"));
    assert_eq!(bench.counts()[0], 1);
}

#[test]
fn a_submit_that_cannot_be_read_or_failed_inside_is_not_repeated_either() {
    for trouble in [Trouble::SubmitBody("<html>ok</html>"), Trouble::SubmitStatus(500, "oh")] {
        let bench = Bench::new(Protocol::Meshy, trouble);
        bench.told();
        bench.fake.now(Trouble::None);
        assert!(bench.told().contains("may have been charged"), "{trouble:?}");
    }
}

#[test]
fn a_submit_that_never_arrived_or_was_refused_may_be_repeated() {
    let refused = Trouble::SubmitStatus(402, "no credits");
    for (trouble, arrived) in [(Trouble::SubmitUnheard, 1), (refused, 2)] {
        let bench = Bench::new(Protocol::Meshy, trouble);
        bench.told();
        bench.fake.now(Trouble::None);
        bench.ask().unwrap();
        assert_eq!(bench.counts()[0], arrived, "{trouble:?}");
    }
    let bench = Bench::new(Protocol::Meshy, refused);
    let error = bench.ask().unwrap_err();
    let expected = "meshy: submit: the answer must be a success, found 402 no credits";
    assert_eq!(error.to_string(), expected);
    assert_eq!(error.hint(), Some("the account at the service is empty"));
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
    for (protocol, trouble, words) in [
        (Protocol::Meshy, Trouble::Dead, "the service gave it up: no object"),
        (Protocol::HunyuanQueue, Trouble::Dead, "the service gave it up: no object"),
        (Protocol::Meshy, Trouble::Forgotten, "the service no longer knows it"),
    ] {
        let bench = Bench::new(protocol, trouble);
        assert!(bench.told().contains(words), "{protocol:?}");
        bench.fake.now(Trouble::None);
        bench.ask().unwrap();
        assert_eq!(bench.counts()[0], 2, "{protocol:?}");
    }
}

#[test]
fn an_expired_address_is_asked_for_again_without_a_new_job() {
    let bench = Bench::new(Protocol::Meshy, Trouble::Expired);
    let told = bench.told();
    assert!(told.contains("download") && told.contains("403 an HTML page"), "{told}");
    bench.fake.now(Trouble::None);
    bench.ask().unwrap();
    assert_eq!(bench.counts()[0], 1);
}

#[test]
fn an_address_inside_the_house_is_not_fetched() {
    let bench = Bench::new(Protocol::Meshy, Trouble::PrivateFile);
    assert!(bench.told().contains("private"));
    assert_eq!(bench.counts()[2], 0);
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
        for body in bodies {
            let told = Bench::new(protocol, Trouble::LookBody(body)).told();
            assert!(told.contains("status"), "{protocol:?} {body}: {told}");
        }
        Bench::new(protocol, Trouble::SubmitBody("{\"result\": \"../x\", \"uid\": \"a/b\"}"))
            .told();
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
