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

/// One of the services.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Protocol {
    Hunyuan,
    HunyuanQueue,
    Gradio,
    Meshy,
    Fal,
    Tripo,
    Replicate,
    Stability,
    Comfy,
    Tencent,
}

impl Protocol {
    /// Where its services lie that are not the user's own.
    fn files(self) -> &'static str {
        if self == Self::Gradio {
            "http://127.0.0.1:7860/gradio_api"
        } else {
            "https://cdn.example"
        }
    }

    /// The answer to a submit.
    fn accepted(self) -> Response {
        match self {
            Self::Hunyuan | Self::Stability => binary(glb_file()),
            Self::Comfy => json(200, json!({ "prompt_id": "job-1", "node_errors": {} })),
            Self::HunyuanQueue => json(200, json!({ "uid": "job-1" })),
            Self::Gradio => json(200, json!({ "event_id": "job-1" })),
            Self::Meshy => json(202, json!({ "result": "job-1" })),
            Self::Fal => json(200, json!({ "request_id": "job-1", "status": "IN_QUEUE" })),
            Self::Tripo => json(200, json!({ "code": 0, "data": { "task_id": "job-1" } })),
            Self::Tencent => json(200, json!({ "Response": { "JobId": "job-1" } })),
            Self::Replicate => json(201, json!({ "id": "job-1", "status": "starting" })),
        }
    }

    fn running(self) -> Response {
        json(
            200,
            match self {
                Self::Hunyuan | Self::HunyuanQueue => json!({ "status": "processing" }),
                Self::Stability | Self::Comfy => json!({}),
                Self::Gradio => return stream("event: heartbeat\ndata: null\n\n"),
                Self::Meshy => json!({ "status": "IN_PROGRESS" }),
                Self::Fal => json!({ "status": "IN_PROGRESS" }),
                Self::Tripo => tripo(json!({ "status": "running", "progress": 7 })),
                Self::Tencent => json!({ "Response": { "Status": "RUN" } }),
                Self::Replicate => json!({ "status": "processing" }),
            },
        )
    }

    fn dead(self) -> Response {
        match self {
            Self::Hunyuan | Self::HunyuanQueue => {
                json(500, json!({ "status": "error", "message": "no object" }))
            }
            Self::Stability => json(500, json!({})),
            Self::Comfy => json(
                200,
                json!({ "job-1": { "status": { "status_str": "error", "messages": [["execution_error",
                    { "exception_message": "no object" }]] } } }),
            ),
            Self::Gradio => stream("event: error\ndata: {\"error\": \"no object\"}\n\n"),
            Self::Meshy => {
                json(200, json!({ "status": "FAILED", "task_error": { "message": "no object" } }))
            }
            Self::Fal => json(200, json!({ "status": "COMPLETED" })),
            Self::Tripo => {
                json(200, tripo(json!({ "status": "failed", "error_message": "no object" })))
            }
            Self::Tencent => {
                json(200, json!({ "Response": { "Status": "FAIL", "ErrorMessage": "no object" } }))
            }
            Self::Replicate => json(200, json!({ "status": "failed", "error": "no object" })),
        }
    }

    /// A finished job; `file` is the address of its mesh.
    fn finished(self, file: &str, trouble: Trouble) -> Response {
        json(
            200,
            match self {
                Self::Hunyuan | Self::HunyuanQueue => {
                    let file = if let Trouble::File(f) = trouble { f.to_vec() } else { glb_file() };
                    json!({ "status": "completed", "model_base64": STANDARD.encode(file) })
                }
                Self::Gradio => {
                    let data =
                        json!([{ "path": "/tmp/a b/file.glb", "url": "http://elsewhere/x.glb" }]);
                    return stream(&format!("event: complete\ndata: {data}\n\n"));
                }
                Self::Stability => json!({}),
                Self::Comfy => json!({ "job-1": { "outputs": { "7": { "3d": [
                    { "filename": "a b.glb", "subfolder": "", "type": "output" }] } },
                    "status": { "status_str": "success" } } }),
                Self::Meshy => json!({ "status": "SUCCEEDED", "model_urls": { "glb": file } }),
                Self::Fal => json!({ "status": "COMPLETED" }),
                Self::Tripo => {
                    tripo(json!({ "status": "success", "output": { "model_url": file } }))
                }
                Self::Tencent => json!({ "Response": { "Status": "DONE", "ResultFile3Ds": [
                    { "Type": "OBJ", "Url": "https://cdn.example/other" },
                    { "Type": "GLB", "Url": file }], "ResultCreditConsumed": 20 } }),
                Self::Replicate => {
                    json!({ "status": "succeeded", "output": { "model_file": file } })
                }
            },
        )
    }
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
            Trouble::File(file) if at_once(self.protocol) => Ok(binary(file.to_vec())),
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

/// A job of Tripo's.
fn tripo(mut data: serde_json::Value) -> serde_json::Value {
    data["task_id"] = "job-1".into();
    json!({ "code": 0, "data": data })
}

/// Whether the mesh comes in the answer to the submit.
fn at_once(protocol: Protocol) -> bool {
    matches!(protocol, Protocol::Hunyuan | Protocol::Stability)
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

fn stream(body: &str) -> Response {
    let headers = vec![("content-type".into(), "text/event-stream".into())];
    Response { status: 200, headers, body: body.into() }
}
