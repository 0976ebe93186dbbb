//! Restate as a script of answers: what is asked again, under which key, and what is given up.

use adapters::transport::{Limits, Method};
use runner::FolderDepot;
use trace::Digest;

use super::*;

/// A front door that answers as scripted and remembers under which keys it was asked.
#[derive(Default)]
struct Script {
    answers: Mutex<Vec<Result<Response, TransportError>>>,
    asked: Mutex<Vec<String>>,
}

impl Transport for Script {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        assert_eq!(request.url, "http://restate/kinfold.articulate/make");
        assert!(matches!(request.limits, Limits { deadline: WAIT, .. }));
        let key = request.headers.iter().find(|(name, _)| name == "idempotency-key");
        self.asked.lock().unwrap().push(key.unwrap().1.clone());
        self.answers.lock().unwrap().remove(0)
    }
}

fn status(status: u16, body: &serde_json::Value) -> Result<Response, TransportError> {
    Ok(Response { status, headers: vec![], body: body.to_string().into_bytes() })
}

fn answer(answer: &Answer) -> Result<Response, TransportError> {
    status(200, &serde_json::to_value(answer).unwrap())
}

fn broken(may_have_arrived: bool) -> Result<Response, TransportError> {
    let request = Request::new("restate.status", Method::Get, "http://restate");
    let error = TransportError::refused(&request, "nobody answers there");
    Err(TransportError { transient: true, may_have_arrived, ..error })
}

fn made(bytes: &[u8]) -> Answer {
    Answer::Made { output: Digest::of(bytes), notes: vec![], seconds: 0.5 }
}

/// Asks for a stage whose result is `a lid`; what came of it and the keys that were asked.
fn asked(
    answers: Vec<Result<Response, TransportError>>,
    there: bool,
) -> (Result<Done, StageError>, Vec<String>) {
    asked_for(Duration::from_secs(60), answers, there)
}

/// The same with another patience.
fn asked_for(
    patience: Duration,
    answers: Vec<Result<Response, TransportError>>,
    there: bool,
) -> (Result<Done, StageError>, Vec<String>) {
    let dir = tempfile::tempdir().unwrap();
    let depot = Arc::new(FolderDepot::new(dir.path(), "batch"));
    if there {
        depot.put_blob(&Digest::of(b"a lid"), b"a lid").unwrap();
    }
    let script = Arc::new(Script { answers: Mutex::new(answers), ..Script::default() });
    let transport: Arc<dyn Transport> = Arc::<Script>::clone(&script);
    let mut ingress = Ingress::new("http://restate/", transport, depot);
    ingress.patience = patience;
    let key = Digest::of(b"key");
    let input = (Digest::of(b"a lid"), Arc::new(b"a lid".to_vec()));
    let inputs = vec![input.0.clone()];
    let errand = Errand { stage: "articulate".into(), key, seed: None, inputs };
    let done = ingress.perform(&errand, &[input]);
    let keys = script.asked.lock().unwrap().clone();
    (done, keys)
}

fn key(round: &str) -> String {
    format!("{}{round}", Digest::of(b"key"))
}

#[test]
fn an_answer_is_waited_for_under_one_key_however_often_the_connection_breaks() {
    let busy = status(503, &serde_json::json!({ "message": "starting" }));
    let answers = vec![broken(true), busy, broken(true), broken(false), answer(&made(b"a lid"))];
    let (done, keys) = asked(answers, true);
    assert_eq!(done.unwrap().bytes, b"a lid");
    assert_eq!(keys, vec![key(""); 5]);
}

#[test]
fn nobody_there_is_a_trouble_that_passes_and_is_told_by_address() {
    let silence = (0..9).map(|_| broken(false)).collect();
    let (done, _) = asked_for(Duration::from_millis(1), silence, true);
    let error = done.unwrap_err();
    assert_eq!((error.again, error.blame), (Again::Later(None), Blame::Work));
    assert!(error.message.contains("nobody answers there"), "{error}");
}

#[test]
fn inputs_that_are_missing_are_brought_and_asked_for_under_another_key() {
    let missing = Answer::Missing(vec![Digest::of(b"a lid")]);
    let (done, keys) = asked(vec![answer(&missing), answer(&made(b"a lid"))], false);
    assert_eq!(done.unwrap().result.output, Digest::of(b"a lid"));
    assert_eq!(keys, [key(""), key(".1")]);
}

#[test]
fn a_result_that_stays_lost_stops_the_batch() {
    let (done, keys) = asked((0..3).map(|_| answer(&made(b"gone"))).collect(), true);
    let error = done.unwrap_err();
    assert_eq!(error.blame, Blame::House);
    assert!(error.message.contains("found it missing 3 times"), "{error}");
    assert_eq!(keys, [key(""), key(".1"), key(".2")]);
}

#[test]
fn failures_are_told_apart() {
    let told = |answer| asked(vec![answer], true).0.unwrap_err();
    let failed = Answer::failed(StageError::new("part `lid` got no face"));
    let own = told(answer(&failed));
    assert_eq!((own.message.as_str(), own.again), ("part `lid` got no face", Again::Never));
    let strange = told(answer(&Answer::Strange(Digest::of(b"other"))));
    assert_eq!(strange.blame, Blame::House);
    let killed = told(status(500, &serde_json::json!({ "message": "too\nmany attempts" })));
    assert_eq!(killed.again, Again::Later(None));
    assert!(killed.message.ends_with("status 500: too many attempts"), "{killed}");
    let nobody = told(status(404, &serde_json::json!({ "message": "no such service" })));
    assert!(nobody.message.contains("no service kinfold.articulate"), "{nobody}");
    let noise = told(status(200, &serde_json::json!("noise")));
    assert!(noise.message.contains("expected a worker's answer, found"), "{noise}");
}
