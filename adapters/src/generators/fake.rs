//! Services that exist only in tests: each speaks its protocol, keeps its jobs and counts what it is
//! asked, and fails on command.

use std::sync::Mutex;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use object::{DVec3, Mesh};
use serde_json::json;

use crate::transport::{Method, Request, Response, Transport, TransportError};

/// A mesh as services send one.
pub(crate) fn glb_file() -> Vec<u8> {
    let v = [(0., 0., 0.), (1., 0., 0.), (0., 1., 0.), (0., 0., 1.)];
    let v = v.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec();
    object::glb::write(&Mesh::new(v, vec![[0, 1, 2], [0, 3, 1]]).unwrap())
}

/// What goes wrong at a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    None,
    /// The answer to the submit is lost on its way back.
    SubmitAnswerLost,
    /// Nobody hears the submit.
    SubmitUnheard,
    /// The submit is refused with this status and these words.
    SubmitStatus(u16, &'static str),
    /// The submit is answered with this.
    SubmitBody(&'static str),
    /// Every second look gets no answer.
    LooksLost,
    /// Looks are answered with this.
    LookBody(&'static str),
    /// The job never ends.
    Endless,
    /// The job fails.
    Dead,
    /// The service forgets the job.
    Forgotten,
    /// The file's address has expired.
    Expired,
    /// The file is this.
    File(&'static [u8]),
    /// The file's address lies in the user's own net.
    PrivateFile,
}

/// Either service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Protocol {
    Hunyuan,
    HunyuanQueue,
    Meshy,
}

pub(crate) struct Fake {
    pub(crate) protocol: Protocol,
    pub(crate) trouble: Mutex<Trouble>,
    /// Submits that arrived, looks, downloads.
    pub(crate) counts: Mutex<[u32; 3]>,
    pub(crate) bodies: Mutex<Vec<serde_json::Value>>,
}

impl Fake {
    pub(crate) fn new(protocol: Protocol, trouble: Trouble) -> Self {
        let (counts, bodies) = (Mutex::default(), Mutex::default());
        Self { protocol, trouble: Mutex::new(trouble), counts, bodies }
    }

    pub(crate) fn now(&self, trouble: Trouble) {
        *self.trouble.lock().unwrap() = trouble;
    }

    fn count(&self, what: usize) -> u32 {
        let mut counts = self.counts.lock().unwrap();
        counts[what] += 1;
        counts[what]
    }

    fn submit(&self, request: &Request) -> Result<Response, TransportError> {
        let trouble = *self.trouble.lock().unwrap();
        if trouble == Trouble::SubmitUnheard {
            let unheard = TransportError::refused(request, "nobody answers there");
            return Err(TransportError { transient: true, ..unheard });
        }
        self.count(0);
        self.bodies.lock().unwrap().push(serde_json::from_slice(&request.body).unwrap());
        match trouble {
            Trouble::SubmitAnswerLost => Err(lost(request)),
            Trouble::SubmitStatus(status, words) => Ok(json(status, json!({ "message": words }))),
            Trouble::SubmitBody(body) => Ok(html(200, body)),
            Trouble::File(file) if self.protocol == Protocol::Hunyuan => Ok(binary(file.to_vec())),
            _ => Ok(match self.protocol {
                Protocol::Hunyuan => binary(glb_file()),
                Protocol::HunyuanQueue => json(200, json!({ "uid": "job-1" })),
                Protocol::Meshy => json(202, json!({ "result": "job-1" })),
            }),
        }
    }

    fn look(&self, request: &Request) -> Result<Response, TransportError> {
        assert!(request.url.ends_with("/job-1"), "{}", request.url);
        let looks = self.count(1);
        let meshy = self.protocol == Protocol::Meshy;
        let running = if meshy { "IN_PROGRESS" } else { "processing" };
        match *self.trouble.lock().unwrap() {
            Trouble::LooksLost if looks.is_multiple_of(2) => Err(lost(request)),
            Trouble::LookBody(body) => Ok(html(200, body)),
            Trouble::Endless => Ok(json(200, json!({ "status": running }))),
            Trouble::Dead if meshy => Ok(json(
                200,
                json!({ "status": "FAILED", "task_error": { "message": "no object" } }),
            )),
            Trouble::Dead => Ok(json(500, json!({ "status": "error", "message": "no object" }))),
            Trouble::Forgotten if meshy => Ok(json(404, json!({ "message": "not found" }))),
            _ if looks < 3 => Ok(json(200, json!({ "status": running }))),
            trouble if meshy => Ok(json(200, finished(trouble))),
            trouble => {
                let file = if let Trouble::File(f) = trouble { f.to_vec() } else { glb_file() };
                let file = STANDARD.encode(file);
                Ok(json(200, json!({ "status": "completed", "model_base64": file })))
            }
        }
    }

    fn download(&self, request: &Request) -> Response {
        self.count(2);
        assert!(request.secrets.is_empty(), "no key goes to a download");
        match *self.trouble.lock().unwrap() {
            Trouble::Expired => html(403, "<html>Request has expired</html>"),
            Trouble::File(file) => binary(file.to_vec()),
            _ => binary(glb_file()),
        }
    }
}

fn finished(trouble: Trouble) -> serde_json::Value {
    let host = if trouble == Trouble::PrivateFile { "169.254.169.254" } else { "cdn.example" };
    let address = format!("https://{host}/file.glb?Signature=canary");
    json!({ "status": "SUCCEEDED", "model_urls": { "glb": address } })
}

impl Transport for Fake {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        match request.method {
            Method::Post => self.submit(request),
            Method::Get if request.url.contains("/file.glb") => Ok(self.download(request)),
            Method::Get => self.look(request),
        }
    }
}

fn lost(request: &Request) -> TransportError {
    let error = TransportError::refused(request, "the answer stopped before its end");
    TransportError { transient: true, may_have_arrived: true, ..error }
}

fn json(status: u16, body: serde_json::Value) -> Response {
    let headers = vec![("content-type".into(), "application/json".into())];
    Response { status, headers, body: body.to_string().into_bytes() }
}

fn html(status: u16, body: &str) -> Response {
    let headers = vec![("content-type".into(), "text/html".into())];
    Response { status, headers, body: body.into() }
}

fn binary(body: Vec<u8>) -> Response {
    let headers = vec![("content-type".into(), "model/gltf-binary".into())];
    Response { status: 200, headers, body }
}
