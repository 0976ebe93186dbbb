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
pub(crate) struct Question {
    pub(crate) path: &'static str,
    pub(crate) method: &'static str,
    pub(crate) words: &'static str,
    /// What is sent: its media type and its schema.
    pub(crate) body: Option<(&'static str, Value)>,
    pub(crate) answers: Vec<(&'static str, &'static str, Value)>,
}

/// What an API is about, and who may ask.
pub(crate) struct About {
    pub(crate) title: &'static str,
    pub(crate) description: &'static str,
    /// The scheme of the token.
    pub(crate) token: Value,
}

/// Schemas as an OpenAPI document has them.
pub(crate) fn schemas() -> SchemaGenerator {
    let settings = SchemaSettings::draft2020_12().with(|s| {
        s.definitions_path = "/components/schemas".into();
    });
    settings.into_generator()
}

/// An API as an OpenAPI 3.1 document.
pub(crate) fn document(
    about: About,
    questions: Vec<Question>,
    mut schemas: SchemaGenerator,
) -> Value {
    let mut paths: Map<String, Value> = Map::new();
    for question in questions {
        let path = paths.entry(question.path).or_insert_with(|| json!({}));
        path[question.method] = operation(&question);
    }
    let _ = schemas.subschema_for::<Failure>();
    let About { title, description, token } = about;
    json!({
        "openapi": "3.1.0",
        "info": { "title": title, "version": "1", "description": description },
        "security": [{ "token": [] }],
        "paths": paths,
        "components": {
            "schemas": schemas.take_definitions(true),
            "securitySchemes": { "token": token },
        },
    })
}

/// The API as an OpenAPI 3.1 document.
pub fn openapi() -> Value {
    let mut schemas = schemas();
    let questions = questions(&mut schemas);
    let about = About {
        title: "kinfold studio",
        description: "Sees, steers, corrects and builds one object. Positions are in the object \
            frame: right-handed, z up, front towards -y, in the mesh's unit. Every question carries \
            the token of the page's address, in the header `x-kinfold-token` or as `?token=`.",
        token: json!({ "type": "apiKey", "in": "header", "name": TOKEN }),
    };
    document(about, questions, schemas)
}

fn operation(question: &Question) -> Value {
    let mut operation = json!({ "summary": question.words, "responses": {} });
    if let Some((kind, schema)) = &question.body {
        operation["requestBody"] =
            json!({ "required": true, "content": { *kind: { "schema": schema } } });
    }
    let named = question.path.split('{').skip(1).filter_map(|rest| rest.split('}').next());
    let named = named.map(
        |name| json!({ "name": name, "in": "path", "required": true, "schema": { "type": "string" } }),
    );
    let named: Vec<_> = named.collect();
    if !named.is_empty() {
        operation["parameters"] = json!(named);
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

pub(crate) const JSON: &str = "application/json";
pub(crate) const BYTES: &str = "application/octet-stream";

pub(crate) fn of<T: JsonSchema>(schemas: &mut SchemaGenerator) -> Value {
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
    let ask = |path, words, body: Option<Value>, schema| Question {
        path,
        method: "post",
        words,
        body: body.map(|schema| (JSON, schema)),
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
            body: Some((JSON, of::<editing::WriteBody>(schemas))),
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
            body: Some((JSON, of::<working::BuildBody>(schemas))),
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
