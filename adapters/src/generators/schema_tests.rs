//! What every service is sent, against the vendors' schemas where there are some, and against closed
//! ones of our own for everything that is posted.

use jsonschema::Validator;
use serde_json::{Map, Value, json};

use super::bench::{ALL, Bench};
use super::fake::{Protocol, Trouble};
use crate::Request;
use crate::vendor::vendor;

/// Our own, by the step they are for.
const OWN: &str = include_str!("request_schemas.json");

/// Everything a service is sent for one mesh, by step.
fn posted(protocol: Protocol) -> Vec<(String, Value)> {
    let bench = Bench::new(protocol, Trouble::None);
    bench.ask().unwrap();
    let posted = bench.fake.posted.lock().unwrap();
    posted.iter().map(|request| (request.step.clone(), body(request))).collect()
}

/// A body as JSON, forms by their fields.
fn body(request: &Request) -> Value {
    let media_type = &request.headers.iter().find(|(n, _)| n == "content-type").unwrap().1;
    let Some((_, line)) = media_type.split_once("multipart/form-data; boundary=") else {
        assert_eq!(media_type, "application/json");
        return serde_json::from_slice(&request.body).unwrap();
    };
    // One letter a byte, so that nothing is lost.
    let text: String = request.body.iter().copied().map(char::from).collect();
    let end = format!("--{line}--\r\n");
    let fields = text.strip_suffix(&end).expect("a form must end with its line");
    let between = format!("--{line}\r\n");
    let fields = fields.split(&between).skip(1);
    Value::Object(fields.map(field).collect::<Map<_, _>>())
}

fn field(text: &str) -> (String, Value) {
    let (head, value) = text.split_once("\r\n\r\n").expect("a field must have a head");
    let value = value.strip_suffix("\r\n").expect("a field must end its line");
    let name = head.strip_prefix("content-disposition: form-data; name=\"").unwrap();
    let (name, rest) = name.split_once('"').unwrap();
    let file = "; filename=\"photo.png\"\r\ncontent-type: image/png";
    let is_png = value.starts_with("\u{89}PNG\r\n\u{1a}\n");
    let value =
        if rest.is_empty() { json!(value) } else { json!({ "png": is_png && rest == file }) };
    (name.to_owned(), value)
}

fn faults(schema: &Validator, body: &Value) -> Vec<String> {
    schema.iter_errors(body).map(|e| format!("{}: {e}", e.instance_path())).collect()
}

#[test]
fn whatever_is_posted_is_what_the_services_ask_for_and_nothing_else() {
    let schemas: Value = serde_json::from_str(OWN).unwrap();
    let mut seen = std::collections::BTreeSet::new();
    for (step, body) in ALL.into_iter().flat_map(posted) {
        let schema = schemas.get(&step).unwrap_or_else(|| panic!("{step} has no schema"));
        let required = schema["required"].as_array().unwrap().clone();
        let schema = jsonschema::draft202012::new(schema).unwrap();
        assert_eq!(faults(&schema, &body), [""; 0], "{step}");
        let mut more = body.clone();
        more["a key nobody knows"] = json!(1);
        assert!(!schema.is_valid(&more), "{step}: a service may be sent anything");
        for key in required {
            let mut less = body.clone();
            less.as_object_mut().unwrap().remove(key.as_str().unwrap());
            assert!(!schema.is_valid(&less), "{step}: {key} may be left out");
        }
        seen.insert(step);
    }
    let all: std::collections::BTreeSet<_> = schemas.as_object().unwrap().keys().cloned().collect();
    assert_eq!(seen, all, "every schema is used");
}

#[test]
fn what_is_asked_for_is_what_the_vendors_schemas_ask_for() {
    let specs = [
        (Protocol::Tripo, "tripo.upload", "tripo.v3.json", "UploadFileRequest"),
        (Protocol::Tripo, "tripo.submit", "tripo.v3.json", "ImageToModelRequest"),
        (
            Protocol::Replicate,
            "replicate.submit",
            "replicate.predictions.json",
            "schemas_prediction_request",
        ),
    ];
    for (protocol, step, file, root) in specs {
        let Some(schema) = vendor(file, root) else { continue };
        let mut body = posted(protocol).into_iter().find(|(s, _)| s == step).unwrap().1;
        if let Some(file) = body.get_mut("file") {
            // A file's bytes are a string to the vendor.
            *file = json!("bytes");
        }
        assert_eq!(faults(&schema, &body), [""; 0], "{step}");
        let mut wrong = body.clone();
        wrong.as_object_mut().unwrap().values_mut().for_each(|v| *v = json!([[]]));
        assert!(!schema.is_valid(&wrong), "{step}: the schema judges nothing");
    }
}
