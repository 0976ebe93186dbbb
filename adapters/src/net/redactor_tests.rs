//! Every form of a secret that could be read back, and texts that stay as they are.

use base64::engine::general_purpose::URL_SAFE;
use serde_json::json;

use super::*;

const KEY: &str = "sk-CANARY/abc+defgh1234=xyz";

fn redactor() -> Redactor {
    let key = SecretString::from(format!("Bearer {KEY}"));
    Redactor::new([&key])
}

fn escaped(each: impl Fn(u8) -> String) -> String {
    KEY.bytes().map(each).collect()
}

fn wrapped(text: &str, width: usize) -> String {
    text.as_bytes()
        .chunks(width)
        .map(|l| String::from_utf8_lossy(l).into_owned() + "\r\n")
        .collect()
}

/// The key in every form, each with its name.
fn forms() -> Vec<(&'static str, String)> {
    let twice = STANDARD.encode(STANDARD.encode(KEY));
    let long = STANDARD.encode(format!("{}Authorization: Bearer {KEY} and more", "x".repeat(200)));
    let reversed: String = KEY.chars().rev().collect();
    let upper = KEY.to_ascii_uppercase();
    let doubled = KEY.replace('/', "%2F").replace('%', "%25");
    let quoted = json!({ "a": json!({ "b": KEY.replace('/', "\\/") }).to_string() }).to_string();
    vec![
        ("plain", KEY.into()),
        ("slash", KEY.replace('/', "\\/")),
        ("unicode", escaped(|b| format!("\\u{b:04X}"))),
        ("braces", escaped(|b| format!("\\u{{{b:x}}}"))),
        ("percent", escaped(|b| format!("%{b:02x}"))),
        ("percent upper", escaped(|b| format!("%{b:02X}"))),
        ("percent twice", doubled),
        ("named", KEY.replace('/', "&sol;").replace('+', "&plus;").replace('=', "&equals;")),
        ("decimal", escaped(|b| format!("&#{b};"))),
        ("hexadecimal", escaped(|b| format!("&#x{b:x};"))),
        ("hex", escaped(|b| format!("{b:02x}"))),
        ("hex upper", escaped(|b| format!("{b:02X}"))),
        ("hex with colons", escaped(|b| format!("{b:02x}:"))),
        ("hex lines", wrapped(&escaped(|b| format!("{b:02x}")), 16)),
        ("octal", escaped(|b| format!("\\{b:03o}"))),
        ("base32", base32(KEY.as_bytes())),
        ("base64", STANDARD.encode(KEY)),
        ("base64 for addresses", URL_SAFE.encode(KEY)),
        ("base64 twice", STANDARD.encode(STANDARD.encode(KEY))),
        ("base64 of hex", STANDARD.encode(escaped(|b| format!("{b:02x}")))),
        ("base64 three times", STANDARD.encode(&twice)),
        ("base64 wrapped", wrapped(&long, 76)),
        ("base64 wrapped in JSON", json!({ "a": wrapped(&long, 64) }).to_string()),
        ("base64 of a percent text", STANDARD.encode(escaped(|b| format!("%{b:02x}")))),
        ("base64 of a wrong case", STANDARD.encode(&upper)),
        ("reversed", reversed.clone()),
        ("base64 reversed", STANDARD.encode(&reversed)),
        ("upper", upper),
        ("lower", KEY.to_ascii_lowercase()),
        ("all but the last", KEY[..KEY.len() - 1].into()),
        ("all but the first", KEY[1..].into()),
        ("most of it", KEY[..14].into()),
        ("in lines", wrapped(KEY, 5)),
        ("in JSON in JSON", quoted),
    ]
}

fn base32(text: &[u8]) -> String {
    String::from_utf8(inside_base32(text, 0, BASE32[0])).unwrap()
}

/// Whether a form says more than the key.
fn says_more(name: &str) -> bool {
    name.contains("JSON") || name.contains("wrapped")
}

/// Whether a text still says twelve characters of the key, or of one of its forms, in a row.
fn tells(text: &str, form: &str) -> bool {
    let text = text.to_ascii_lowercase();
    let form: Vec<char> = form.to_ascii_lowercase().chars().collect();
    form.windows(12.min(form.len())).any(|w| text.contains(&w.iter().collect::<String>()))
}

#[test]
fn a_key_is_found_in_every_form_and_the_words_around_it_stay() {
    for (name, form) in forms() {
        let told = format!("before ({form}) behind");
        let kept = redactor().text(&told).into_owned();
        assert!(kept.starts_with("before (") && kept.ends_with(") behind"), "{name}: {kept}");
        assert!(kept.contains(HIDDEN) && !tells(&kept, KEY), "{name}: {kept}");
        if !says_more(name) {
            assert!(!tells(&kept, &form), "{name}: {kept}");
        }
    }
}

#[test]
fn json_stays_json_and_its_keys_numbers_and_pieces_are_searched() {
    for (name, form) in forms() {
        let body = json!({ "a": { form.as_str(): [1, form] }, "n": 1 }).to_string();
        let kept = redactor().body(body.into_bytes());
        let value: Value = serde_json::from_slice(&kept).unwrap();
        assert_eq!(value["n"], 1, "{name}");
        assert!(!tells(&value.to_string(), KEY), "{name}");
        assert!(says_more(name) || !tells(&value.to_string(), &form), "{name}");
    }
    let split = json!({ "content": [{ "text": &KEY[..9] }, { "text": &KEY[9..] }] });
    let kept = redactor().body(split.to_string().into_bytes());
    assert!(!String::from_utf8_lossy(&kept).contains("CANARY"));
    let twice = format!(r#"{{"a":"{KEY}","a":"x"}}"#);
    let kept = String::from_utf8(redactor().body(twice.into_bytes())).unwrap();
    assert!(!kept.contains("CANARY"), "{kept}");
    let digits = SecretString::from("904817263540192837".to_owned());
    let kept = Redactor::new([&digits]).body(br#"{"id":904817263540192837}"#.to_vec());
    assert_eq!(kept, br#"{"id":"<redacted>"}"#);
}

#[test]
fn a_mesh_stays_a_mesh() {
    for (name, form) in forms() {
        let mut json = json!({ "asset": { "version": "2.0", "generator": form } }).to_string();
        json.push_str(&"   "[..json.len().wrapping_neg() % 4]);
        let bin = [&[1, 2, 3, 4][..], KEY.as_bytes(), &[0]].concat();
        let chunks = [
            &(json.len() as u32).to_le_bytes()[..],
            b"JSON",
            json.as_bytes(),
            &(bin.len() as u32).to_le_bytes(),
            b"BIN\0",
            &bin,
        ]
        .concat();
        let glb =
            [b"glTF\x02\0\0\0", &(12 + chunks.len() as u32).to_le_bytes()[..], &chunks].concat();
        let kept = redactor().body(glb);
        let word = |at: usize| u32::from_le_bytes(kept[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((word(8), word(12) % 4), (kept.len(), 0), "{name}");
        let end = 20 + word(12);
        let value: Value = serde_json::from_slice(&kept[20..end]).unwrap();
        assert_eq!(value["asset"]["version"], "2.0");
        assert_eq!((word(end), kept.len()), (bin.len(), end + 8 + bin.len()), "{name}");
        assert!(!tells(&String::from_utf8_lossy(&kept), KEY), "{name}");
        assert!(says_more(name) || !tells(&value.to_string(), &form), "{name}");
    }
}

#[test]
fn what_holds_no_secret_keeps_its_bytes() {
    let bodies: [&[u8]; 5] = [
        b"{\"n\": 1,  \"words\": \"Bearer of news \\u00e9 50% &amp; more\"}",
        b"\x89PNG\r\n\x1a\n\xff\xfe binary",
        b"glTF\x02\0\0\0 no glb at all",
        "Kühlschrank 冷蔵庫 and the quick brown fox".as_bytes(),
        b"",
    ];
    for body in bodies {
        assert_eq!(redactor().body(body.to_vec()), body);
        assert_eq!(Redactor::default().body(body.to_vec()), body);
    }
}

#[test]
fn short_and_empty_words_are_not_looked_for() {
    for word in ["", "0", "EMPTY", "000000000000000000", "        "] {
        assert!(Redactor::new([&SecretString::from(word.to_owned())]).is_idle(), "{word}");
    }
}

#[test]
fn who_signed_and_the_signature_are_secrets_and_the_day_is_none() {
    let header = "TC3-HMAC-SHA256 Credential=canary-id/2019-02-25/ai3d/tc3_request, \
                  SignedHeaders=content-type;host, Signature=canary00ff";
    let redactor = Redactor::new([&SecretString::from(header.to_owned())]);
    let told = redactor.text("canary-id signed canary00ff on 2019-02-25/ai3d/tc3_request");
    assert_eq!(told, "<redacted> signed <redacted> on 2019-02-25/ai3d/tc3_request");
}

#[test]
fn letters_outside_ascii_are_not_cut() {
    let key = SecretString::from("schlüsselwörter-überall".to_owned());
    let kept = Redactor::new([&key]).text("é schlüsselwörter-überall é").into_owned();
    assert_eq!(kept, "é <redacted> é");
}

#[test]
fn a_large_body_is_searched_once_and_not_for_ever() {
    let mut body = vec![7_u8; 20 << 20];
    body[10 << 20..][..KEY.len()].copy_from_slice(KEY.as_bytes());
    let kept = redactor().body(body);
    assert_eq!(kept.len(), 20 << 20);
    assert!(!kept.windows(6).any(|w| w == b"CANARY"));
    let many = format!("{KEY} ").repeat(20_000);
    assert!(!redactor().text(&many).contains("CANARY"));
}
