//! Who made it: signatures of traces and of a batch's statements, judged by other programs, too.

use std::path::Path;
use std::process::Command;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use crate::batch::Batch;
use crate::kinfold::{Bench, CLOCK, Said, program};

const TRACE: &str = "out/trace.mcap";
const SIGNATURE: &str = "out/trace.mcap.minisig";

fn said(bench: &Bench, args: &[&str]) -> Said {
    program().current_dir(bench.path("")).args(args).output().unwrap().into()
}

fn sign(bench: &Bench, more: &[&str]) -> Said {
    said(bench, &[&["trace", "sign", TRACE, "--key", "own.key"], more].concat())
}

fn verify(bench: &Bench, key: &str) -> Said {
    said(bench, &["trace", "verify", TRACE, "--key", key])
}

/// A finished run, and two keys: `own` and `other`.
fn bench() -> Bench {
    let bench = Bench::done();
    for name in ["own", "other"] {
        let drawn = said(&bench, &["trace", "keygen", name]);
        assert_eq!((drawn.code, drawn.out), (Some(0), format!("{name}.key\n{name}.pub\n")));
    }
    bench
}

fn text(bench: &Bench, name: &str) -> String {
    std::fs::read_to_string(bench.path(name)).unwrap()
}

/// The line of a key's file that says the key.
fn line(bench: &Bench, name: &str) -> String {
    text(bench, name).lines().nth(1).unwrap().to_owned()
}

/// Whether a program is there; said loudly where it is not.
fn there(name: &str, args: &[&str]) -> bool {
    let there = Command::new(name).args(args).output().is_ok();
    if !there {
        eprintln!("SKIPPED: no {name} to judge what kinfold signs");
    }
    there
}

fn run(folder: &Path, program: &str, args: &[&str]) -> bool {
    let said = Command::new(program).current_dir(folder).args(args).output().unwrap();
    eprintln!("{program} {args:?}: {}", String::from_utf8_lossy(&said.stderr));
    said.status.success()
}

#[test]
fn a_trace_that_somebody_else_made_and_sealed_passes_for_nobodys_with_a_key() {
    let bench = bench();
    assert_eq!(sign(&bench, &[]).code, Some(0));
    let holds = verify(&bench, "own.pub");
    assert_eq!(holds.code, Some(0), "{holds:?}");
    assert!(holds.out.contains("signed with key ") && holds.out.contains("file:trace.mcap hashed"));
    // Somebody makes another, with the same program, and lays it in its place.
    let signature = text(&bench, SIGNATURE);
    std::fs::rename(bench.path("out"), bench.path("before")).unwrap();
    let forged = bench.made(&["--seed", "7"]);
    assert_eq!(forged.code, Some(0), "{forged:?}");
    std::fs::write(bench.path(SIGNATURE), signature).unwrap();
    assert_eq!(said(&bench, &["trace", "verify", TRACE]).code, Some(0), "its seal holds");
    let found = verify(&bench, "own.pub");
    assert_eq!((found.code, found.out.as_str()), (Some(1), ""), "{found:?}");
    assert!(found.err.contains("the signature is not of these bytes"), "{}", found.err);
}

#[test]
fn the_same_trace_key_and_clock_give_the_same_signature() {
    let bench = bench();
    sign(&bench, &[]);
    let first = text(&bench, SIGNATURE);
    assert!(!first.contains("timestamp"), "nobody asked for the time: {first}");
    sign(&bench, &[]);
    assert_eq!(first, text(&bench, SIGNATURE));
    let timed = sign(&bench, &["--clock", CLOCK, "--json"]);
    let answer: Value = serde_json::from_str(&timed.out).unwrap();
    assert_eq!(answer["comment"], "timestamp:1769860800\tfile:trace.mcap\thashed");
    assert_eq!(answer["signature"], SIGNATURE);
    let holds = said(&bench, &["trace", "verify", TRACE, "--key", "own.pub", "--json"]);
    let holds: Value = serde_json::from_str(&holds.out).unwrap();
    assert_eq!(holds["signed"]["key"], answer["key"]);
    assert_eq!(holds["signed"]["comment"], "timestamp:1769860800 file:trace.mcap hashed");
}

#[test]
fn minisign_judges_our_signatures_and_we_judge_its() {
    if !there("minisign", &["-v"]) {
        return;
    }
    let bench = bench();
    let root = bench.path("");
    sign(&bench, &["--clock", CLOCK]);
    assert!(run(&root, "minisign", &["-V", "-H", "-p", "own.pub", "-m", TRACE]));
    assert!(!run(&root, "minisign", &["-V", "-p", "other.pub", "-m", TRACE]));
    // It signs with our key, and we with its.
    std::fs::remove_file(bench.path(SIGNATURE)).unwrap();
    assert!(run(&root, "minisign", &["-S", "-W", "-s", "own.key", "-m", TRACE, "-t", "by hand"]));
    let holds = verify(&bench, "own.pub");
    assert!(holds.code == Some(0) && holds.out.contains(": by hand\n"), "{holds:?}");
    assert!(run(&root, "minisign", &["-G", "-W", "-s", "its.key", "-p", "its.pub"]));
    std::fs::remove_file(bench.path(SIGNATURE)).unwrap();
    assert_eq!(said(&bench, &["trace", "sign", TRACE, "--key", "its.key"]).code, Some(0));
    assert!(run(&root, "minisign", &["-V", "-p", "its.pub", "-m", TRACE]));
    assert_eq!(verify(&bench, "its.pub").code, Some(0));
    assert!(run(&root, "minisign", &["-S", "-l", "-W", "-s", "its.key", "-m", TRACE]));
    let old = verify(&bench, "its.pub");
    assert!(old.code == Some(1) && old.err.contains("in the old form"), "{old:?}");
}

#[test]
fn a_missing_or_foreign_signature_never_passes() {
    let bench = bench();
    let none = verify(&bench, "own.pub");
    assert_eq!(none.code, Some(1), "{none:?}");
    assert!(
        none.err.contains("it is not signed: trace.mcap.minisig cannot be opened"),
        "{}",
        none.err
    );
    sign(&bench, &[]);
    let good = text(&bench, SIGNATURE);
    let wrong = verify(&bench, "other.pub");
    assert!(wrong.code == Some(1) && wrong.err.contains("signed with key "), "{wrong:?}");
    let lines: Vec<_> = good.lines().collect();
    let long = "x".repeat(20_000);
    for (bad, found) in [
        (good[..good.len() / 2].to_owned(), "fewer than four lines"),
        (good[..good.len() - 9].to_owned(), "60 bytes in a line instead of 64"),
        (good[..good.len() - 10].to_owned(), "no base64"),
        (lines[..3].join("\n") + "\nAAAA\n", "3 bytes in a line instead of 64"),
        (good.replace("file:trace.mcap", "file:other.mcap"), "the trusted comment was changed"),
        (good.replace("\thashed", "\u{1b}[2J"), "the trusted comment was changed"),
        (String::new(), "fewer than four lines"),
        ("\u{0}\u{1}".into(), "fewer than four lines"),
        (long, "has more than 16384 bytes"),
        (text(&bench, "own.pub"), "fewer than four lines"),
    ] {
        std::fs::write(bench.path(SIGNATURE), bad).unwrap();
        let said = verify(&bench, "own.pub");
        assert_eq!((said.code, said.out.as_str()), (Some(1), ""), "{said:?}");
        assert!(said.err.contains(found) && !said.err.contains('\u{1b}'), "{found}: {}", said.err);
    }
    std::fs::remove_file(bench.path(SIGNATURE)).unwrap();
    std::fs::create_dir(bench.path(SIGNATURE)).unwrap();
    assert!(verify(&bench, "own.pub").err.contains("is no regular file"));
    let json = said(&bench, &["trace", "verify", TRACE, "--key", "own.pub", "--json"]);
    assert_eq!(serde_json::from_str::<Value>(&json.out).unwrap()["holds"], false);
}

#[test]
fn what_is_no_key_is_refused_and_no_secret_is_shown() {
    let bench = bench();
    let secret = line(&bench, "own.key");
    let mut bytes = STANDARD.decode(&secret).unwrap();
    bytes[2..4].copy_from_slice(b"Sc");
    let file = |name: &str, bytes: &[u8]| std::fs::write(bench.path(name), bytes).unwrap();
    file(
        "protected.key",
        format!("untrusted comment: x\n{}\n", STANDARD.encode(&bytes)).as_bytes(),
    );
    file("cut.key", &text(&bench, "own.key").as_bytes()[..200]);
    file("ssh.key", b"-----BEGIN OPENSSH PRIVATE KEY-----\nb3BlbnNzaC1rZXktdjE\n");
    file("binary.key", &[0xff; 100]);
    file("long.key", &[b'x'; 5000]);
    for (key, found) in [
        ("own.pub", "expected a minisign secret key, found a public key"),
        ("protected.key", "protected by a password"),
        ("cut.key", "expected a minisign secret key"),
        ("ssh.key", "a key of OpenSSH"),
        ("binary.key", "found no text"),
        ("long.key", "has more than 4096 bytes"),
        ("gone.key", "cannot be opened"),
        ("out", "is no regular file"),
        ("/dev/zero", "is no regular file"),
    ] {
        let said = said(&bench, &["trace", "sign", TRACE, "--key", key]);
        assert_eq!((said.code, said.out.as_str()), (Some(1), ""), "{key}: {said:?}");
        assert!(said.err.contains(found) && said.err.contains(key), "{found}: {}", said.err);
        assert!(
            !said.err.contains(&secret[20..60]) && !said.err.contains("b3Blbn"),
            "{}",
            said.err
        );
        assert!(!bench.path(SIGNATURE).exists());
    }
    sign(&bench, &[]);
    for (key, found) in [
        ("own.key", "expected a minisign public key, found a secret key"),
        ("binary.key", "found no text"),
        ("gone.pub", "cannot be opened"),
        (TRACE, "has more than 4096 bytes"),
    ] {
        let said = verify(&bench, key);
        assert_eq!((said.code, said.out.as_str()), (Some(1), ""), "{key}: {said:?}");
        assert!(said.err.contains(found), "{found}: {}", said.err);
        assert!(!said.err.contains(&secret[20..60]), "{}", said.err);
    }
}

#[test]
fn a_key_is_never_written_over_and_lies_open_to_nobody_else() {
    let bench = bench();
    let before = text(&bench, "own.key");
    for taken in ["own.key", "own.pub"] {
        let said = said(&bench, &["trace", "keygen", "own"]);
        assert!(said.code == Some(1) && said.err.contains("stands there already"), "{said:?}");
        std::fs::rename(bench.path(taken), bench.path("kept")).unwrap();
        std::fs::rename(bench.path("kept"), bench.path(taken)).unwrap();
    }
    std::fs::remove_file(bench.path("own.pub")).unwrap();
    assert_eq!(said(&bench, &["trace", "keygen", "own"]).code, Some(1));
    assert_eq!(text(&bench, "own.key"), before);
    let nowhere = said(&bench, &["trace", "keygen", "nowhere/own"]);
    assert!(nowhere.code == Some(1) && nowhere.err.contains("cannot be written"), "{nowhere:?}");
    let drawn = said(&bench, &["trace", "keygen", "new", "--json"]);
    let drawn: Value = serde_json::from_str(&drawn.out).unwrap();
    assert_eq!(drawn["key"].as_str().unwrap().len(), 16);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let key = bench.path("new.key");
        let about = std::fs::metadata(&key).unwrap().permissions();
        assert_eq!(about.mode() & 0o777, 0o600);
        assert_eq!(said(&bench, &["trace", "sign", TRACE, "--key", "new.key"]).err, "");
        std::fs::set_permissions(&key, std::fs::Permissions::from_mode(0o644)).unwrap();
        let open = said(&bench, &["trace", "sign", TRACE, "--key", "new.key"]);
        assert_eq!(open.code, Some(0));
        assert!(open.err.contains("others may read this secret key"), "{}", open.err);
    }
}

#[test]
fn nothing_of_others_is_written_over_by_a_signature() {
    let bench = bench();
    std::fs::write(bench.path("mine"), "precious").unwrap();
    let place = bench.path(SIGNATURE);
    std::fs::write(&place, "precious").unwrap();
    let foreign = sign(&bench, &[]);
    assert!(foreign.code == Some(1) && foreign.err.contains("is no signature"), "{foreign:?}");
    assert_eq!(text(&bench, SIGNATURE), "precious");
    #[cfg(unix)]
    {
        std::fs::remove_file(&place).unwrap();
        std::os::unix::fs::symlink(bench.path("mine"), &place).unwrap();
        assert_eq!(sign(&bench, &[]).code, Some(1));
        assert_eq!(text(&bench, "mine"), "precious");
    }
    std::fs::remove_file(&place).unwrap();
    assert_eq!(said(&bench, &["trace", "sign", TRACE, "--key", "other.key"]).code, Some(0));
    let others = sign(&bench, &[]);
    assert!(others.code == Some(1) && others.err.contains("stands there, by key"), "{others:?}");
    assert_eq!(verify(&bench, "other.pub").code, Some(0));
    // A trace that was torn is not vouched for.
    std::fs::remove_file(&place).unwrap();
    let whole = std::fs::read(bench.path(TRACE)).unwrap();
    std::fs::write(bench.path(TRACE), &whole[..whole.len() / 2]).unwrap();
    let torn = sign(&bench, &[]);
    assert!(torn.code == Some(1) && torn.err.contains("ends before its seal"), "{torn:?}");
    assert!(!place.exists());
}

/// A second run that changed nothing took the signature away without a word.
#[test]
fn a_signature_stays_with_what_it_is_of_and_is_told_where_it_goes() {
    let bench = bench();
    assert_eq!(sign(&bench, &[]).code, Some(0));
    let signed = std::fs::read(bench.path(SIGNATURE)).unwrap();
    let same = bench.made(&[]);
    assert_eq!(same.code, Some(0), "{same:?}");
    assert_eq!(std::fs::read(bench.path(SIGNATURE)).unwrap(), signed);
    assert_eq!(verify(&bench, "own.pub").code, Some(0));
    let other = bench.made(&["--seed", "8"]);
    assert_eq!(other.code, Some(0), "{other:?}");
    assert!(other.err.contains("trace.mcap.minisig was of what stood there before"), "{other:?}");
    assert!(!bench.path(SIGNATURE).exists());
}

#[test]
fn a_signed_trace_in_a_batch_is_no_stranger_to_its_audit() {
    let batch = signed_batch();
    let trace = "out/assets/k000/trace.mcap";
    assert_eq!(batch.say(&["trace", "sign", trace, "--key", "own.key"]).code, Some(0));
    for key in [&[][..], &["--key", "own.pub"]] {
        let said = batch.say(&[&["audit", "out"], key].concat());
        assert_eq!(said.code, Some(0), "{said:?}");
    }
}

/// A batch of two with signed statements, and a key that is not theirs.
fn signed_batch() -> Batch {
    let batch = Batch::of(2);
    assert_eq!(batch.ran(&[]).0.code, Some(0));
    for name in ["own", "other"] {
        assert_eq!(batch.say(&["trace", "keygen", name]).code, Some(0));
    }
    let unsigned = batch.say(&["audit", "out", "--key", "own.pub"]);
    assert_eq!(unsigned.code, Some(1), "{unsigned:?}");
    assert!(unsigned.err.contains("k000: attestation.dsse.json cannot be opened"), "{unsigned:?}");
    let signed = batch.say(&["audit", "sign", "out", "--key", "own.key"]);
    assert_eq!(signed.code, Some(0), "{signed:?}");
    assert!(signed.out.starts_with("2 statements signed with key "), "{signed:?}");
    batch
}

const ENVELOPE: &str = "out/assets/k000/attestation.dsse.json";

#[test]
fn an_audit_with_a_key_believes_what_is_signed_alone() {
    let batch = signed_batch();
    let audit = |key: &str| batch.say(&["audit", "out", "--key", key]);
    let holds = audit("own.pub");
    assert_eq!(holds.code, Some(0), "{holds:?}");
    assert!(holds.out.contains("0 findings, signed with key "), "{holds:?}");
    assert_eq!(batch.say(&["audit", "out"]).code, Some(0), "envelopes are no strangers");
    let wrong = audit("other.pub");
    assert!(
        wrong.code == Some(1) && wrong.err.contains("k001: attestation.dsse.json: signed with key")
    );
    let good = std::fs::read(batch.path(ENVELOPE)).unwrap();
    batch.say(&["audit", "sign", "out", "--key", "own.key"]);
    assert_eq!(good, std::fs::read(batch.path(ENVELOPE)).unwrap(), "same bytes");

    let other = std::fs::read(batch.path("out/assets/k001/attestation.dsse.json")).unwrap();
    let mut value: Value = serde_json::from_slice(&good).unwrap();
    let statement = STANDARD.decode(value["payload"].as_str().unwrap()).unwrap();
    let cheaper = String::from_utf8(statement).unwrap().replace("CC0-1.0", "CC-BY-4.0");
    value["payload"] = STANDARD.encode(cheaper).into();
    for (bytes, found) in [
        (other, "k000: the ledger's id is not the signed statement's"),
        (value.to_string().into_bytes(), "the signature is not of these bytes"),
        (good[..good.len() / 2].to_vec(), "expected a DSSE envelope"),
        (b"{}".to_vec(), "expected a DSSE envelope"),
    ] {
        batch.write(ENVELOPE, bytes);
        let said = audit("own.pub");
        assert_eq!(said.code, Some(1), "{said:?}");
        assert!(said.err.contains(found), "{found}: {}", said.err);
    }
    batch.write(ENVELOPE, good);
    // A row, forged with its whole chain, is not vouched for by the key.
    batch.write("out/assets/k000/asset.urdf", "<robot name='another'/>");
    let changed = audit("own.pub");
    assert!(
        changed.err.contains("k000: asset.urdf is not the one of the signed statement"),
        "{changed:?}"
    );
    let refused = batch.say(&["audit", "sign", "out", "--key", "other.key"]);
    assert!(refused.code == Some(1) && refused.err.contains("nothing was signed"), "{refused:?}");
}

#[test]
fn openssl_judges_the_envelopes_of_statements() {
    if !there("openssl", &["version"]) {
        return;
    }
    let batch = signed_batch();
    let envelope: Value =
        serde_json::from_slice(&std::fs::read(batch.path(ENVELOPE)).unwrap()).unwrap();
    assert_eq!(envelope["payloadType"], "application/vnd.in-toto+json");
    let decoded = |value: &Value| STANDARD.decode(value.as_str().unwrap()).unwrap();
    let payload = decoded(&envelope["payload"]);
    assert_eq!(payload, std::fs::read(batch.path("out/assets/k000/attestation.json")).unwrap());
    let statement: Value = serde_json::from_slice(&payload).unwrap();
    assert_eq!(statement["_type"], "https://in-toto.io/Statement/v1");
    let head = format!("DSSEv1 28 application/vnd.in-toto+json {} ", payload.len());
    batch.write("pae", [head.as_bytes(), &payload].concat());
    batch.write("sig", decoded(&envelope["signatures"][0]["sig"]));
    // A public key in DER, as RFC 8410 has it.
    let key = std::fs::read_to_string(batch.path("own.pub")).unwrap();
    let key = STANDARD.decode(key.lines().nth(1).unwrap()).unwrap();
    let head = [0x30, 0x2a, 0x30, 0x05, 0x06, 0x03, 0x2b, 0x65, 0x70, 0x03, 0x21, 0x00];
    batch.write("own.der", [&head[..], &key[10..]].concat());
    let args = ["pkeyutl", "-verify", "-pubin", "-inkey", "own.der", "-keyform", "DER"];
    let judged = |file: &str| {
        let args = [&args[..], &["-rawin", "-in", file, "-sigfile", "sig"]].concat();
        run(&batch.path(""), "openssl", &args)
    };
    assert!(judged("pae"));
    batch.write("other", [b"DSSEv1 2 {} ", &payload[..]].concat());
    assert!(!judged("other"));
}
