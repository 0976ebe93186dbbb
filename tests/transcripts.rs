//! What the program says to somebody who asks how to use it, word for word.
//!
//! `KINFOLD_TRANSCRIPTS=write` writes anew what is due; the difference is part of the change.

use std::path::Path;

use crate::kinfold::say;

/// Compares what was said with the transcript of that name.
#[track_caller]
pub fn is_word_for_word(name: &str, said: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/transcripts");
    let path = folder.join(format!("{name}.txt"));
    if std::env::var("KINFOLD_TRANSCRIPTS").is_ok_and(|word| word == "write") {
        std::fs::write(&path, said).unwrap();
    }
    assert_eq!(said, std::fs::read_to_string(&path).unwrap(), "{name}");
}

#[test]
fn help_names_every_command() {
    let said = say(&["--help"]);
    assert_eq!((said.code, said.err.as_str()), (Some(0), ""));
    is_word_for_word("help", &said.out);
}

#[test]
fn help_of_make_names_every_argument() {
    let said = say(&["make", "--help"]);
    assert_eq!(said.code, Some(0));
    is_word_for_word("help_make", &said.out);
}

#[test]
fn help_of_batch_says_what_a_manifest_is_and_how_to_go_on() {
    let said = say(&["batch", "--help"]);
    assert_eq!(said.code, Some(0));
    is_word_for_word("help_batch", &said.out);
}

#[test]
fn help_of_check_says_what_the_exit_codes_mean() {
    let said = say(&["check", "--help"]);
    assert_eq!(said.code, Some(0));
    is_word_for_word("help_check", &said.out);
}

#[test]
fn help_of_eval_says_what_the_columns_mean() {
    let said = say(&["eval", "--help"]);
    assert_eq!(said.code, Some(0));
    is_word_for_word("help_eval", &said.out);
}

#[test]
fn the_version_is_one_line() {
    let said = say(&["--version"]);
    assert_eq!(said.out, format!("kinfold {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn misuse_exits_2_and_says_how_it_goes() {
    for args in [&["mak"][..], &["make"], &[], &["check", "x.urdf", "--tier", "great"]] {
        let said = say(args);
        assert_eq!((said.code, said.out.as_str()), (Some(2), ""), "{args:?}");
        assert!(!said.err.is_empty());
    }
    let said = say(&["make", "p.png", "--clock", "yesterday"]);
    assert!(said.err.contains("expected a moment like 2026-01-31T12:00:00Z"), "{}", said.err);
}

#[test]
fn completions_know_every_command_in_every_shell() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let said = say(&["completions", shell]);
        assert_eq!(said.code, Some(0));
        for word in
            ["make", "batch", "audit", "store", "check", "eval", "trace", "schema", "dry-run"]
        {
            assert!(said.out.contains(word), "{shell} does not know {word}");
        }
    }
}
