//! The API as an OpenAPI document.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value, json};

use crate::house::{Built, Failure};
use crate::http::building::BuildAnswer;
use crate::http::guard::TOKEN;
use crate::http::told::Event;
use crate::http::{edit as editing, work as working};

/// What is asked and answered in one way.
struct Question {
    path: &'static str,
    method: &'static str,
    words: &'static str,
    body: Option<Value>,
    answers: Vec<(&'static str, &'static str, Value)>,
}

/// The API as an OpenAPI 3.1 document.
pub fn openapi() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|s| {
        s.definitions_path = "/components/schemas".into();
    });
    let mut schemas = settings.into_generator();
    let questions = questions(&mut schemas);
    let mut paths: Map<String, Value> = Map::new();
    for question in questions {
        let path = paths.entry(question.path).or_insert_with(|| json!({}));
        path[question.method] = operation(&question);
    }
    let _ = schemas.subschema_for::<Failure>();
    json!({
        "openapi": "3.1.0",
        "info": {
            "title": "kinfold studio",
            "version": "1",
            "description": "Sees, steers, corrects and builds one object. Positions are in the object \
                frame: right-handed, z up, front towards -y, in the mesh's unit. Every question carries \
                the token of the page's address, in the header `x-kinfold-token` or as `?token=`.",
        },
        "security": [{ "token": [] }],
        "paths": paths,
        "components": {
            "schemas": schemas.take_definitions(true),
            "securitySchemes": {
                "token": { "type": "apiKey", "in": "header", "name": TOKEN },
            },
        },
    })
}

fn operation(question: &Question) -> Value {
    let mut operation = json!({ "summary": question.words, "responses": {} });
    if let Some(body) = &question.body {
        operation["requestBody"] =
            json!({ "required": true, "content": { "application/json": { "schema": body } } });
    }
    if question.path.contains('{') {
        let name = json!({ "name": "name", "in": "path", "required": true, "schema": { "type": "string" } });
        operation["parameters"] = json!([name]);
    }
    for (status, kind, schema) in &question.answers {
        operation["responses"][status] = json!({ "description": "What was asked for", "content": { *kind: { "schema": schema } } });
    }
    operation["responses"]["default"] = json!({
        "description": "Why not, and what to do",
        "content": { "application/json": { "schema": {
            "type": "object",
            "required": ["error"],
            "properties": { "error": { "$ref": "#/components/schemas/Failure" } },
        } } },
    });
    operation
}

const JSON: &str = "application/json";
const BYTES: &str = "application/octet-stream";

fn of<T: JsonSchema>(schemas: &mut SchemaGenerator) -> Value {
    schemas.subschema_for::<T>().to_value()
}

fn questions(schemas: &mut SchemaGenerator) -> Vec<Question> {
    let bytes = || json!({ "type": "string", "format": "binary" });
    let any = || json!({ "type": "object" });
    let get = |path, words, kind, schema| Question {
        path,
        method: "get",
        words,
        body: None,
        answers: vec![("200", kind, schema)],
    };
    let ask = |path, words, body, schema| Question {
        path,
        method: "post",
        words,
        body,
        answers: vec![("200", JSON, schema)],
    };
    let labels = of::<editing::LabelsAnswer>(schemas);
    let asked = Some(of::<editing::AskBody>(schemas));
    let build = of::<BuildAnswer>(schemas);
    vec![
        get(
            "/api/state",
            "What the studio is about, and how far it is",
            JSON,
            of::<editing::StateAnswer>(schemas),
        ),
        get(
            "/api/mesh",
            "The mesh as it is drawn: u32 vertices, drawn faces, faces, 0; f32 positions; RGBA bytes; u32 corners; where fewer are drawn, u32 for each face the drawn one; little endian",
            BYTES,
            bytes(),
        ),
        get("/api/photo", "The photo", "image/*", bytes()),
        get("/api/condition", "The condition file as it lies on disk", JSON, any()),
        Question {
            path: "/api/condition",
            method: "put",
            words: "Write another text into the condition file, if it still is of the revision `base`: 409 with what stands there otherwise",
            body: Some(of::<editing::WriteBody>(schemas)),
            answers: vec![("200", JSON, of::<editing::ConditionAnswer>(schemas))],
        },
        ask(
            "/api/labels",
            "The part of every drawn face, as `make` labels them; 503 where a newer question came",
            asked.clone(),
            labels.clone(),
        ),
        ask("/api/articulate", "The same and the joints", asked, labels),
        ask(
            "/api/free-range",
            "How far a joint goes before its part meets another",
            Some(of::<editing::RangeBody>(schemas)),
            of::<editing::RangeAnswer>(schemas),
        ),
        ask(
            "/api/draft",
            "Ask whom kinfold.toml names for a condition",
            None,
            of::<working::DraftAnswer>(schemas),
        ),
        Question {
            path: "/api/build",
            method: "post",
            words: "Build an asset, as `kinfold make` does; /api/events tells how it goes",
            body: Some(of::<working::BuildBody>(schemas)),
            answers: vec![("202", JSON, build.clone())],
        },
        ask(
            "/api/build/cancel",
            "Stop what is being built",
            None,
            json!({ "anyOf": [build, { "type": "null" }] }),
        ),
        get(
            "/api/events",
            "Server-sent events: stage, built, condition, tabs, lost",
            "text/event-stream",
            of::<Event>(schemas),
        ),
        get(
            "/api/built",
            "What was built last, as a page shows it, and remedies",
            JSON,
            of::<Built>(schemas),
        ),
        get(
            "/api/artefacts",
            "The files of the asset",
            JSON,
            of::<working::ArtefactsAnswer>(schemas),
        ),
        get("/api/artefacts/{name}", "One of them", BYTES, bytes()),
        ask(
            "/api/check",
            "Check any URDF or MJCF model of this machine",
            Some(of::<working::CheckBody>(schemas)),
            any(),
        ),
        get("/api/openapi.json", "This document", JSON, any()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reference_leads_somewhere() {
        let document = openapi();
        let text = document.to_string();
        for (at, _) in text.match_indices("\"$ref\":\"#") {
            let rest = &text[at + 9..];
            let path = rest.split('"').next().unwrap_or_default();
            assert!(document.pointer(path).is_some(), "{path}");
        }
    }
}
