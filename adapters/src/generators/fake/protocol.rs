//! What services that exist only in tests say, each in the words of its protocol.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;

use super::{Trouble, glb_file};
use crate::Response;

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
    pub(super) fn files(self) -> &'static str {
        if self == Self::Gradio {
            "http://127.0.0.1:7860/gradio_api"
        } else {
            "https://cdn.example"
        }
    }

    /// Whether the mesh comes in the answer to the submit.
    pub(super) fn at_once(self) -> bool {
        matches!(self, Self::Hunyuan | Self::Stability)
    }

    /// The answer to a submit.
    pub(super) fn accepted(self) -> Response {
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

    pub(super) fn running(self) -> Response {
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

    /// A queue of before version 5 with the ends of another's event and of ours.
    pub(super) fn queued(self) -> Response {
        let of = |event: &str, file: &str| {
            let output = json!({ "data": [null, { "path": file }] });
            let said = json!({ "msg": "process_completed", "event_id": event, "success": true,
                "output": output });
            format!("data: {said}\n\n")
        };
        let (other, own) = (of("job-0", "/tmp/other.glb"), of("job-1", "/tmp/a b/file.glb"));
        let waits = json!({ "msg": "estimation", "event_id": "job-1" });
        stream(&format!("data: {waits}\n\n{other}{own}"))
    }

    pub(super) fn dead(self) -> Response {
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
    pub(super) fn finished(self, file: &str, trouble: Trouble) -> Response {
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

/// A job of Tripo's.
fn tripo(mut data: serde_json::Value) -> serde_json::Value {
    data["task_id"] = "job-1".into();
    json!({ "code": 0, "data": data })
}

pub(super) fn json(status: u16, body: serde_json::Value) -> Response {
    let headers = vec![("content-type".into(), "application/json".into())];
    Response { status, headers, body: body.to_string().into_bytes() }
}

pub(super) fn html(status: u16, body: &str) -> Response {
    let headers = vec![("content-type".into(), "text/html".into())];
    Response { status, headers, body: body.into() }
}

pub(super) fn binary(body: Vec<u8>) -> Response {
    let headers = vec![("content-type".into(), "model/gltf-binary".into())];
    Response { status: 200, headers, body }
}

fn stream(body: &str) -> Response {
    let headers = vec![("content-type".into(), "text/event-stream".into())];
    Response { status: 200, headers, body: body.into() }
}
