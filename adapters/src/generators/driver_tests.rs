//! The driver against fakes of every protocol, well and in every trouble.

use serde_json::json;

use super::*;
use crate::contract::check_image_to_3d;
use crate::generators::bench::{ALL, Bench, photo};
use crate::generators::fake::{Protocol, Trouble, glb_file};

/// Services that are looked at again and again.
const JOBS: [Protocol; 7] = [
    Protocol::HunyuanQueue,
    Protocol::Meshy,
    Protocol::Fal,
    Protocol::Tripo,
    Protocol::Replicate,
    Protocol::Comfy,
    Protocol::Tencent,
];
/// Services with a bill, whose jobs have numbers.
const PAID: [Protocol; 5] =
    [Protocol::Meshy, Protocol::Fal, Protocol::Tripo, Protocol::Replicate, Protocol::Tencent];
/// Services that give the mesh in answer to the submit.
const AT_ONCE: [Protocol; 2] = [Protocol::Hunyuan, Protocol::Stability];

/// Services with jobs.
fn with_jobs() -> impl Iterator<Item = Protocol> {
    ALL.into_iter().filter(|p| !AT_ONCE.contains(p))
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
        for request in bench.fake.posted.lock().unwrap().iter() {
            let body = String::from_utf8_lossy(&request.body);
            assert!(!body.contains("canary"), "no key stands in a body");
        }
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
fn a_gradio_server_of_before_version_5_is_asked_where_it_listens() {
    let bench = Bench::new(Protocol::Gradio, Trouble::NoPrefix);
    bench.ask().unwrap();
    assert_eq!(bench.counts(), [1, 3, 1], "three functions, one file");
    let posted = bench.posted();
    let joined: Vec<_> = posted.iter().filter(|r| r.url.ends_with("/queue/join")).collect();
    assert_eq!(joined.len(), 3, "the queue keeps what one function leaves for the next");
    let body: serde_json::Value = serde_json::from_slice(&joined[1].body).unwrap();
    assert_eq!((&body["data"][0], &body["fn_index"]), (&json!(null), &json!(1)), "a state's place");
    assert_eq!(body["data"][1]["path"], "/tmp/a b/photo.png");
}

#[test]
fn a_gradio_server_cannot_send_its_client_elsewhere() {
    for (config, told) in [
        (r#"{"dependencies": [], "api_prefix": "//elsewhere.example"}"#, "api_prefix"),
        (r#"{"dependencies": [], "api_prefix": "/a?b=c"}"#, "api_prefix"),
        (r#"{"dependencies": [], "api_prefix": "elsewhere"}"#, "api_prefix"),
        (r#"{"dependencies": [], "api_prefix": "/.."}"#, "api_prefix"),
        ("{}", "dependencies"),
        ("<html>", "JSON"),
    ] {
        let bench = Bench::new(Protocol::Gradio, Trouble::Config(config));
        let found = bench.told();
        assert!(found.contains(told), "{config}: {found}");
        assert_eq!(bench.counts()[0], 0, "nothing is asked of it");
    }
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
        "data": {"task_id": "a b"}, "id": "%2e", "prompt_id": ".", "Response": {"JobId": "a/b"}}"#;
    for protocol in with_jobs() {
        let told = Bench::new(protocol, Trouble::SubmitBody(hostile)).told();
        assert!(told.contains("must be letters, digits"), "{protocol:?}: {told}");
    }
    for body in ["event: complete\ndata: [", "event: heartbeat\n", "<html>", "data: x", ""] {
        let told = Bench::new(Protocol::Gradio, Trouble::LookBody(body)).told();
        assert!(told.contains("stream") || told.contains("must be JSON"), "{body}: {told}");
    }
}
