//! What the program says to somebody who asks how to use it, word for word.

use crate::kinfold::say;

#[test]
fn help_names_every_command() {
    let said = say(&["--help"]);
    assert_eq!((said.code, said.err.as_str()), (Some(0), ""));
    assert_eq!(said.out, include_str!("transcripts/help.txt"));
}

#[test]
fn help_of_make_names_every_argument() {
    let said = say(&["make", "--help"]);
    assert_eq!(said.code, Some(0));
    assert_eq!(said.out, include_str!("transcripts/help_make.txt"));
}

#[test]
fn help_of_batch_says_what_a_manifest_is_and_how_to_go_on() {
    let said = say(&["batch", "--help"]);
    assert_eq!(said.code, Some(0));
    assert_eq!(said.out, include_str!("transcripts/help_batch.txt"));
}

#[test]
fn help_of_check_says_what_the_exit_codes_mean() {
    let said = say(&["check", "--help"]);
    assert_eq!(said.code, Some(0));
    assert_eq!(said.out, include_str!("transcripts/help_check.txt"));
}

#[test]
fn help_of_eval_says_what_the_columns_mean() {
    let said = say(&["eval", "--help"]);
    assert_eq!(said.code, Some(0));
    assert_eq!(said.out, include_str!("transcripts/help_eval.txt"));
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
