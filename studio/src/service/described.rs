//! The service as an OpenAPI document.

use serde_json::{Value, json};

use super::jobs::JobsAnswer;
use crate::openapi::{About, BYTES, JSON, Question, document, of, schemas};
use crate::works::{self, Job, JobOrder, Kept};

/// The service as an OpenAPI 3.1 document.
pub fn described() -> Value {
    let mut schemas = schemas();
    let bytes = || json!({ "type": "string", "format": "binary" });
    let get = |path, words, kind, schema| Question {
        path,
        method: "get",
        words,
        body: None,
        answers: vec![("200", kind, schema)],
    };
    let job = of::<Job>(&mut schemas);
    let questions = vec![
        get(
            "/v1/about",
            "What can be asked for here, and what this token may still spend",
            JSON,
            of::<works::About>(&mut schemas),
        ),
        Question {
            path: "/v1/files",
            method: "post",
            words: "Take a photo or a mesh in; jobs name it by its digest",
            body: Some((BYTES, bytes())),
            answers: vec![("201", JSON, of::<Kept>(&mut schemas))],
        },
        Question {
            path: "/v1/jobs",
            method: "post",
            words: "Ask for an asset; the same question is the same job, 200 instead of 202 then",
            body: Some((JSON, of::<JobOrder>(&mut schemas))),
            answers: vec![("202", JSON, job.clone()), ("200", JSON, job.clone())],
        },
        get(
            "/v1/jobs",
            "This token's jobs, the newest first; ?before=ID&most=N for those after the first 100",
            JSON,
            of::<JobsAnswer>(&mut schemas),
        ),
        get("/v1/jobs/{id}", "A job, and the files that it left", JSON, job.clone()),
        get(
            "/v1/jobs/{id}/events",
            "Server-sent events `job`: how it stands, now and whenever that changes, until it is over",
            "text/event-stream",
            job,
        ),
        get("/v1/jobs/{id}/artefacts/{digest}", "A file that a job left", BYTES, bytes()),
        get("/v1/openapi.json", "This document", JSON, json!({ "type": "object" })),
    ];
    let about = About {
        title: "kinfold serve",
        description: "Makes articulated assets, many and for several. Every request carries a token, as \
            `Authorization: Bearer TOKEN`. Files are named by their digests, BLAKE3 in hexadecimal digits; a \
            request names no program, no path, no address and no key. What was answered with a status below \
            300 survives whatever happens to the service; what was not answered may be asked again as it is.",
        token: json!({ "type": "http", "scheme": "bearer" }),
    };
    document(about, questions, schemas)
}
