//! The three codecs against the vendors' schemas, good answers, bad ones and torn ones.

use rand::SeedableRng as _;
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};

use super::openai::LengthKey;
use super::*;
use crate::damage::{misshapen, torn};
use crate::vendor::vendor;

fn codecs() -> Vec<Box<dyn Codec>> {
    let key = || "canary-key-123".to_owned().into();
    let openai = |length, temperature| OpenAi {
        base: "http://127.0.0.1:8000/v1".into(),
        key: Some(key()),
        model: "some-vlm".into(),
        temperature,
        length,
    };
    vec![
        Box::new(openai(LengthKey::Completion, None)),
        Box::new(openai(LengthKey::Plain, Some(0.0))),
        Box::new(Anthropic { base: "https://a.example".into(), key: key(), model: "m".into() }),
        Box::new(Gemini { base: "https://g.example/".into(), key: key(), model: "g".into() }),
    ]
}

fn question() -> Question<'static> {
    let picture = Piece::picture("image/png", b"not looked at here");
    Question {
        step: "vlm.test/0".into(),
        system: "You look at objects.",
        turns: vec![
            Turn::Ours(vec![Piece::text("which parts?"), picture]),
            Turn::Theirs("{}".into()),
            Turn::Ours(vec![Piece::text("again, please")]),
        ],
        schema_name: "parts",
        schema: json!({ "type": "object", "additionalProperties": false, "required": ["parts"],
            "properties": { "parts": { "type": "array", "items": { "type": "string" } } } }),
        max_tokens: 4096,
    }
}

/// A whole answer of each service with some words in it.
fn answers(text: &str) -> [Value; 4] {
    let openai = json!({ "choices": [{ "finish_reason": "stop", "message":
        { "role": "assistant", "content": text, "refusal": null } }],
        "usage": { "prompt_tokens": 7, "completion_tokens": 5 } });
    let anthropic = json!({ "stop_reason": "end_turn", "content": [{ "type": "text", "text": text }],
        "usage": { "input_tokens": 7, "output_tokens": 5 } });
    let gemini = json!({ "candidates": [{ "finishReason": "STOP", "content": { "parts":
        [{ "text": "thinking", "thought": true }, { "text": text }] } }],
        "usageMetadata": { "promptTokenCount": 7, "candidatesTokenCount": 5 } });
    [openai.clone(), openai, anthropic, gemini]
}

fn response(status: u16, body: impl Into<Vec<u8>>) -> Response {
    let headers = vec![("content-type".into(), "application/json".into())];
    Response { status, headers, body: body.into() }
}

#[test]
fn whole_answers_are_read_with_what_they_used() {
    for (codec, answer) in codecs().iter().zip(answers("{\"parts\":[]}")) {
        let reply = codec.reply("s", &response(200, answer.to_string())).unwrap();
        assert_eq!(reply.text, "{\"parts\":[]}", "{}", codec.identity());
        assert_eq!(reply.usage, Usage { input: Some(7), output: Some(5) });
    }
}

#[test]
fn cut_refused_blocked_and_empty_answers_are_errors() {
    let broken = [
        json!({ "choices": [{ "finish_reason": "length", "message": { "content": "{" } }] }),
        json!({ "choices": [{ "finish_reason": "stop", "message": { "content": null } }] }),
        json!({ "choices": [{ "finish_reason": "stop", "message": { "refusal": "no" } }] }),
        json!({ "choices": [] }),
    ];
    let codecs = codecs();
    for answer in &broken {
        codecs[0].reply("s", &response(200, answer.to_string())).unwrap_err();
    }
    let told = |codec: usize, answer: Value| {
        codecs[codec].reply("s", &response(200, answer.to_string())).unwrap_err().to_string()
    };
    assert!(told(2, json!({"stop_reason": "refusal", "content": []})).contains("`refusal`"));
    assert!(told(2, json!({"stop_reason": "max_tokens"})).contains("`max_tokens`"));
    assert!(told(3, json!({"promptFeedback": {"blockReason": "SAFETY"}})).contains("SAFETY"));
    assert!(told(3, json!({"candidates": [{"finishReason": "SAFETY"}]})).contains("`SAFETY`"));
    for (codec, answer) in codecs.iter().zip(answers(" \n")) {
        codec.reply("s", &response(200, answer.to_string())).unwrap_err();
        let busy = codec.reply("s", &response(529, "overloaded")).unwrap_err();
        assert!(busy.is_transient(), "{busy}");
        let page = codec.reply("s", &response(200, "<html>")).unwrap_err();
        assert!(!page.is_transient(), "{page}");
    }
}

/// Reads every service's answer many times through damage; gives what was told where nothing came
/// of it.
fn told_of(damage: fn(&[u8], &mut Pcg64Mcg) -> Vec<u8>) -> Vec<String> {
    let (mut rng, mut told) = (Pcg64Mcg::seed_from_u64(5), vec![]);
    for (codec, answer) in codecs().iter().zip(answers("{\"parts\": [\"a\"]}")) {
        let whole = answer.to_string().into_bytes();
        for round in 0..2000 {
            let status = if round % 10 == 0 { 400 } else { 200 };
            let response = response(status, damage(&whole, &mut rng));
            // Whoever else reads an answer reads this one.
            let _ = crate::usage::Usage::reported(&response);
            match codec.reply("vlm.test/0", &response) {
                Ok(reply) => assert!(!reply.text.trim().is_empty(), "{}", codec.identity()),
                Err(error) => told.push(format!("{error} {error:?}")),
            }
        }
    }
    told
}

#[test]
fn no_damaged_answer_makes_a_reader_panic_or_tell_what_a_terminal_obeys() {
    for damage in [misshapen, torn] {
        let told = told_of(damage);
        assert!(told.len() > 800, "the damage must be felt, found {} errors", told.len());
        for told in told {
            assert!(!told.contains('\u{1b}'), "a terminal would obey: {told}");
            assert!(told.len() < 2000, "{} bytes: {}", told.len(), &told[..200]);
        }
    }
}

#[test]
fn the_key_is_in_no_body_address_or_debug_print() {
    for codec in codecs() {
        let request = codec.request(&question());
        let body = String::from_utf8(request.body.clone()).unwrap();
        assert!(!format!("{request:?} {body} {}", request.url).contains("canary"));
        assert_eq!(request.secrets.len(), 1);
        assert_eq!(request.body, codec.request(&question()).body, "the same bytes each time");
    }
}

#[test]
fn request_bodies_are_what_the_vendors_schemas_ask_for() {
    let specs = [
        ("openai.chat.json", "CreateChatCompletionRequest"),
        ("openai.chat.json", "CreateChatCompletionRequest"),
        ("anthropic.messages.json", "CreateMessageParams"),
        ("gemini.generate-content.json", "GenerateContentRequest"),
    ];
    for (codec, (file, root)) in codecs().iter().zip(specs) {
        let Some(validator) = vendor(file, root) else { continue };
        let body: Value = serde_json::from_slice(&codec.request(&question()).body).unwrap();
        let faults: Vec<_> = validator.iter_errors(&body).map(|e| e.to_string()).collect();
        assert!(faults.is_empty(), "{}: {faults:?}", codec.identity());
        let list = if file.starts_with("gemini") { "contents" } else { "messages" };
        let mut wrong = body.clone();
        wrong[list] = json!("a text where a list belongs");
        assert!(!validator.is_valid(&wrong), "{file}: the schema judges nothing");
    }
}
