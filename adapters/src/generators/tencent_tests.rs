//! Tencent's own ways: what is sent and how it is signed, errors behind a 200, limits of a photo.

use std::sync::Mutex;

use trace::FixedClock;

use super::*;
use crate::TransportError;
use crate::budget::{Account, Accounted, Book, MemoryBook};
use crate::net::tape::{MemoryTape, Recorded, Replayed};
use crate::photo::tests::png;

/// 2023-11-14T22:13:20Z.
const MOMENT: u64 = 1_700_000_000;

fn tencent(seconds: u64) -> Tencent {
    Tencent {
        base: BASE.into(),
        id: "canary-id-0".to_owned().into(),
        key: "canary-key-0".to_owned().into(),
        region: Some("ap-guangzhou".into()),
        model: "3.1".into(),
        faces: 30_000,
        clock: Arc::new(FixedClock(seconds * 1_000_000_000)),
    }
}

/// Says one thing and keeps what it was asked.
struct Says(Value, Mutex<Vec<Request>>);

impl Says {
    fn new(answer: Value) -> Self {
        Self(answer, Mutex::default())
    }
}

impl Transport for Says {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        self.1.lock().unwrap().push(request.clone());
        Ok(Response { status: 200, headers: vec![], body: self.0.to_string().into_bytes() })
    }
}

fn submit(transport: &dyn Transport, size: [u32; 2]) -> Result<Submitted, AdapterError> {
    let photo = Photo::read(png(size[0], size[1]), "photo").unwrap();
    tencent(MOMENT).submit(transport, &Ask { photo: &photo, seed: 7 })
}

fn look(answer: &Value) -> Result<JobState, AdapterError> {
    tencent(MOMENT).poll(&Says::new(answer.clone()), &JobHandle::new("job-1"))
}

fn error(code: &str) -> Value {
    json!({ "Response": { "Error": { "Code": code, "Message": "no" }, "RequestId": "r" } })
}

#[test]
fn what_is_sent_is_signed_for_its_host_and_its_second() {
    let says = Says::new(json!({ "Response": { "JobId": "135" } }));
    assert_eq!(submit(&says, [200, 150]).unwrap(), Submitted::Job(JobHandle::new("135")));
    let request = says.1.lock().unwrap().remove(0);
    let header = |name: &str| request.headers.iter().find(|(n, _)| n == name).unwrap().1.clone();
    assert_eq!(header("x-tc-action"), "SubmitHunyuanTo3DProJob");
    assert_eq!(header("x-tc-version"), "2025-05-13");
    assert_eq!(header("x-tc-timestamp"), MOMENT.to_string());
    assert_eq!(header("x-tc-region"), "ap-guangzhou");
    assert_eq!(request.url, "https://ai3d.tencentcloudapi.com/");
    let signing = Signing {
        service: "ai3d",
        host: "ai3d.tencentcloudapi.com",
        action: "SubmitHunyuanTo3DProJob",
        body: &request.body,
        seconds: MOMENT,
    };
    let expected = signing.authorization("canary-id-0", "canary-key-0");
    assert_eq!(request.secrets[0].1.expose_secret(), expected);
    let body = String::from_utf8(request.body.clone()).unwrap();
    assert!(!format!("{request:?} {body} {:?}", request.headers).contains("canary"));
}

#[test]
fn a_photo_out_of_the_limits_is_told_before_anything_is_sent() {
    let says = Says::new(json!({}));
    let told = submit(&says, [127, 300]).unwrap_err().to_string();
    let rule = "photo: Tencent takes a photo of 128 to 5000 pixels a side";
    assert_eq!(told, format!("{rule}, found 127 x 300 as it would be sent"));
    let photo = |bytes| Photo { bytes, media_type: "image/png".into(), size: [5000, 128] };
    assert_eq!(picture(&photo(vec![0; MAX_PHOTO / 4 * 3])).unwrap().len(), MAX_PHOTO);
    let told = picture(&photo(vec![0; MAX_PHOTO / 4 * 3 + 1])).unwrap_err().to_string();
    assert!(told.ends_with("6000000 bytes in base64, found 6000004 as it would be sent"), "{told}");
    assert!(says.1.lock().unwrap().is_empty());
}

#[test]
fn an_error_behind_a_success_is_an_error_by_its_family() {
    let told = |code| submit(&Says::new(error(code)), [200, 200]).unwrap_err();
    let signature = told("AuthFailure.SignatureFailure");
    let words = "tencent: submit: the answer must be without an error, found \
                 AuthFailure.SignatureFailure no";
    assert_eq!(signature.to_string(), words);
    assert!(signature.hint().unwrap().contains("does not accept the key"));
    assert!(told("RequestLimitExceeded.JobNumExceed").is_transient());
    assert!(!told("InvalidParameterValue").is_transient());
    for unsure in ["FailedOperation.InnerError", "", "Something.New"] {
        assert!(matches!(told(unsure), AdapterError::Service { status: None, .. }), "{unsure}");
    }
    assert!(look(&error("InternalError")).unwrap_err().is_transient());
    assert_eq!(look(&error("ResourceNotFound")).unwrap(), JobState::Gone);
    // An account that was never opened says so too; the job's number is kept.
    look(&error("ResourceUnavailable.NotExist")).unwrap_err();
}

#[test]
fn the_glb_among_the_files_is_the_mesh() {
    let files = json!([{ "Type": "OBJ", "Url": "https://c.example/m.zip" }, { "Type": "GLB" }, 7,
        { "Type": "glb", "Url": "https://c.example/m.glb" }]);
    let done = json!({ "Response": { "Status": "DONE", "ResultFile3Ds": files } });
    let at = JobState::At(FileAddress("https://c.example/m.glb".into()));
    assert_eq!(look(&done).unwrap(), at);
    let none = json!({ "Response": { "Status": "DONE", "ResultFile3Ds": [files[0]] } });
    assert!(look(&none).unwrap_err().to_string().contains("a file of the type GLB"));
    let failed = json!({ "Response": { "Status": "FAIL", "ErrorCode": "X", "ErrorMessage": "y" } });
    assert_eq!(look(&failed).unwrap(), JobState::Failed("X y".into()));
}

#[test]
fn a_run_is_replayed_at_another_time_with_other_keys() {
    let answer = json!({ "Response": { "Status": "RUN", "Echo": "canary-id-0" } });
    let tape = Arc::new(MemoryTape::default());
    let recorded = Recorded { inner: Says::new(answer), tape: tape.clone() };
    let job = JobHandle::new("job-1");
    tencent(MOMENT).poll(&recorded, &job).unwrap();
    let (exchanges, bodies) = tape.contents();
    let written = serde_json::to_string(&exchanges).unwrap();
    assert!(!written.contains("canary") && !written.contains("x-tc-timestamp"), "{written}");
    assert!(bodies.values().all(|b| !String::from_utf8_lossy(b).contains("canary")));
    let later = Tencent { key: "0".to_owned().into(), ..tencent(0) };
    assert_eq!(later.poll(&Replayed::new(exchanges, bodies), &job).unwrap(), JobState::Running);
}

#[test]
fn the_credits_of_a_job_are_those_it_reports_and_a_look_is_no_call() {
    let file = json!([{ "Type": "GLB", "Url": "https://c.example/m.glb" }]);
    let done = json!({ "Response": { "Status": "DONE", "ResultFile3Ds": file,
        "ResultCreditConsumed": 25 } });
    let book = Arc::new(MemoryBook::default());
    let account = Account { book: book.clone(), ..Account::free() };
    let question = trace::Digest::of(b"q");
    let accounted = Accounted { inner: Says::new(done), account, question };
    for _ in 0..2 {
        tencent(MOMENT).poll(&accounted, &JobHandle::new("job-1")).unwrap();
    }
    let entries = book.entries().unwrap();
    let told: Vec<_> = entries.iter().map(|e| (e.work, e.usage.credits)).collect();
    assert_eq!(told, [(false, Some(25.0))], "paid for once, however often it is looked at");
}
