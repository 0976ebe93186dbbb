//! Colour on a terminal, by how our own lines begin: a stranger's words begin none of them.

use std::fmt::Write as _;
use std::io::IsTerminal as _;

use anstream::ColorChoice;
use anstyle::{AnsiColor, Style};

use super::args::{Command, When};

const RED: Style = AnsiColor::Red.on_default().bold();
const YELLOW: Style = AnsiColor::Yellow.on_default().bold();
const GREEN: Style = AnsiColor::Green.on_default();
const CYAN: Style = AnsiColor::Cyan.on_default();
const DIM: Style = Style::new().dimmed();
const BOLD: Style = Style::new().bold();

/// How our lines begin, and how the beginning is shown.
const BEGINNINGS: [(&str, Style); 13] = [
    ("tier none", RED),
    ("tier", BOLD),
    ("FAIL", RED),
    ("OPEN", YELLOW),
    ("WARN", YELLOW),
    ("WAIVED", CYAN),
    ("pass ", GREEN),
    ("           mend:", CYAN),
    ("           expected", DIM),
    ("           found", DIM),
    ("Why it matters", BOLD),
    ("How it is measured", BOLD),
    ("How to mend it", BOLD),
];

/// Whether the result of a command is shown in colour.
pub(super) fn wanted(command: &Command) -> bool {
    let (when, json) = match command {
        Command::Check(args) => (args.color, args.json || args.here),
        Command::Explain(args) => (args.color, args.json),
        _ => return false,
    };
    let stdout = std::io::stdout();
    !json
        && match when {
            When::Always => true,
            When::Never => false,
            // NO_COLOR, CLICOLOR_FORCE and a terminal that can do nothing are known to it.
            When::Auto => match anstream::AutoStream::choice(&stdout) {
                ColorChoice::Auto => stdout.is_terminal(),
                choice => choice != ColorChoice::Never,
            },
        }
}

/// An inert text of ours, its lines' beginnings in colour.
pub(super) fn painted(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 256);
    for line in text.split_inclusive('\n') {
        let begins = |(word, _): &&(&str, Style)| line.starts_with(word);
        match BEGINNINGS.iter().find(begins) {
            Some((word, style)) => {
                // Writing to a string cannot fail.
                let _ = write!(out, "{style}{word}{style:#}{}", &line[word.len()..]);
            }
            None => out.push_str(line),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beginnings_are_in_colour_and_all_words_stay() {
        let text = "tier none of x\n\nFAIL   C1  FAIL\n           mend: OPEN\n39 passed\n";
        let shown = painted(text);
        assert!(shown.contains("\u{1b}[1m\u{1b}[31mFAIL\u{1b}[0m   C1  FAIL\n"), "{shown:?}");
        assert_eq!(anstream::adapter::strip_str(&shown).to_string(), text);
    }
}
