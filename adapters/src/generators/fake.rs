//! Services that exist only in tests: each speaks its protocol, keeps its jobs and counts what it is
//! asked, and fails on command.

mod protocol;

use std::sync::Mutex;

use object::{DVec3, Mesh};
use serde_json::json;

use self::protocol::{binary, html, json};
use crate::transport::{Method, Request, Response, Transport, TransportError};

pub(crate) use self::protocol::Protocol;

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
    /// A Gradio server of before version 5: it knows no prefix, and says so.
    NoPrefix,
    /// A Gradio server that says this of itself, and knows no prefix.
    Config(&'static str),
}

pub(crate) struct Fake {
    pub(crate) protocol: Protocol,
    pub(crate) trouble: Mutex<Trouble>,
    /// Submits that arrived, looks, downloads.
    pub(crate) counts: Mutex<[u32; 3]>,
    /// What was posted, in order; a submit that nobody heard too.
    pub(crate) posted: Mutex<Vec<Request>>,
}

impl Fake {
    pub(crate) fn new(protocol: Protocol, trouble: Trouble) -> Self {
        let (counts, posted) = (Mutex::default(), Mutex::default());
        Self { protocol, trouble: Mutex::new(trouble), counts, posted }
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
        match trouble {
            Trouble::SubmitAnswerLost => Err(lost(request)),
            Trouble::SubmitStatus(status, words) => Ok(json(status, json!({ "message": words }))),
            Trouble::SubmitBody(body) => Ok(html(200, body)),
            Trouble::File(file) if self.protocol.at_once() => Ok(binary(file.to_vec())),
            _ => Ok(self.protocol.accepted()),
        }
    }

    /// An upload, or a further function of a Gradio app.
    fn besides(&self, request: &Request) -> Response {
        if !request.step.ends_with(".upload") {
            return json(200, json!({ "event_id": "job-1" }));
        }
        let form = String::from_utf8_lossy(&request.body);
        assert!(form.contains("content-type: image/png"), "{form}");
        json(
            200,
            match self.protocol {
                Protocol::Gradio => json!(["/tmp/a b/photo.png"]),
                Protocol::Comfy => json!({ "name": "photo.png" }),
                _ => json!({ "code": 0, "data": { "file_token": "token-1" } }),
            },
        )
    }

    fn look(&self, request: &Request) -> Result<Response, TransportError> {
        if request.url.contains("/queue/data?session_hash=") {
            assert!(request.url.ends_with("&event_id=job-1"), "{}", request.url);
            self.count(1);
            return Ok(self.protocol.queued());
        }
        let named = request.url.contains("/job-1") || request.body == b"{\"JobId\":\"job-1\"}";
        if !named {
            return Ok(json(404, json!({ "message": "not found" })));
        }
        let (looks, protocol) = (self.count(1), self.protocol);
        let trouble = *self.trouble.lock().unwrap();
        let host = if trouble == Trouble::PrivateFile {
            "https://169.254.169.254"
        } else {
            protocol.files()
        };
        let file = format!("{host}/file.glb?Signature=canary");
        if request.step == "fal.result" {
            let dead = json(422, json!({ "detail": "no object" }));
            let done = json(200, json!({ "model_glb": { "url": file } }));
            return Ok(if trouble == Trouble::Dead { dead } else { done });
        }
        match trouble {
            Trouble::LooksLost if looks.is_multiple_of(2) => Err(lost(request)),
            Trouble::LookBody(body) => Ok(html(200, body)),
            Trouble::Endless => Ok(protocol.running()),
            Trouble::Dead => Ok(protocol.dead()),
            Trouble::Forgotten if protocol == Protocol::Tencent => {
                let error = json!({ "Code": "ResourceNotFound", "Message": "not found" });
                Ok(json(200, json!({ "Response": { "Error": error } })))
            }
            Trouble::Forgotten => Ok(json(404, json!({ "message": "not found" }))),
            _ if looks < 3 && protocol != Protocol::Gradio => Ok(protocol.running()),
            trouble => Ok(protocol.finished(&file, trouble)),
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

impl Transport for Fake {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        let trouble = *self.trouble.lock().unwrap();
        if let (Trouble::NoPrefix | Trouble::Config(_), true) =
            (trouble, request.url.contains("/gradio_api"))
        {
            return Ok(json(404, json!({ "detail": "Not Found" })));
        }
        if request.step == "gradio.config" {
            let functions = ["start_session", "image_to_3d", "extract_glb"];
            let listed = functions.map(|name| json!({ "api_name": name, "inputs": [4, 7] }));
            let kept = json!([{ "id": 4, "type": "state" }, { "id": 7, "type": "image" }]);
            return Ok(match trouble {
                Trouble::Config(body) => html(200, body),
                _ => json(
                    200,
                    json!({ "version": "4.44.1", "dependencies": listed, "components": kept }),
                ),
            });
        }
        if request.method == Method::Post {
            self.posted.lock().unwrap().push(request.clone());
        }
        match request.method {
            Method::Post if request.step.ends_with(".submit") => self.submit(request),
            Method::Post if request.is_look() => self.look(request),
            Method::Post => Ok(self.besides(request)),
            Method::Get if request.step == "download" => Ok(self.download(request)),
            Method::Get => self.look(request),
        }
    }
}

fn lost(request: &Request) -> TransportError {
    let error = TransportError::refused(request, "the answer stopped before its end");
    TransportError { transient: true, may_have_arrived: true, ..error }
}
