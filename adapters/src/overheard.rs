//! What a program says while it runs, line by line, for whoever wants to see it.
//!
//! Who looks on never holds the program up: what he does not take in time is not shown to him. What is
//! kept of a program's words is no business of this file.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::time::{Duration, Instant};

use crate::net::redactor::Redactor;

/// Who looks on: he is given a program's name and a line of what it says, which is anybody's words.
pub type Onlooker = Arc<dyn Fn(&str, &str) + Send + Sync>;

/// Longest line that is shown, bytes; the rest of it is left out.
const LONGEST: usize = 2000;
/// Lines that may wait to be shown.
const WAITING: usize = 1000;
/// A line that is written over again and again, as progress is, is shown this often.
const OFTEN: Duration = Duration::from_secs(2);
/// Lines in which a secret may lie split.
const SPLIT: usize = 8;

/// The same onlooker, who is shown no secret, not even one that is spread over a few lines.
pub(crate) fn discreet(onlooker: Onlooker, redactor: Redactor) -> Onlooker {
    let before = std::sync::Mutex::new(VecDeque::new());
    Arc::new(move |program: &str, line: &str| {
        let mut before = before.lock().unwrap_or_else(|e| e.into_inner());
        let alone = redactor.text(line);
        before.push_back(alone.trim().to_owned());
        if before.len() > SPLIT {
            before.pop_front();
        }
        let all: String = before.iter().map(String::as_str).collect();
        if redactor.finds(&all) {
            before.clear();
            return;
        }
        onlooker(program, &alone);
    })
}

/// Puts what is heard into lines, and has them shown.
pub(crate) struct Overheard {
    lines: SyncSender<String>,
    line: Vec<u8>,
    /// Whether the line was ended by a return, so that the next one may be written over it.
    returned: bool,
    passing: Option<Instant>,
}

impl Overheard {
    /// Somebody looks on; what comes back says when he has seen everything.
    pub(crate) fn by(onlooker: Onlooker, program: &str) -> (Self, Receiver<()>) {
        let (lines, waiting) = sync_channel::<String>(WAITING);
        let (done, seen) = channel();
        let program = program.to_owned();
        std::thread::spawn(move || {
            waiting.iter().for_each(|line| onlooker(&program, &line));
            // Nobody may be waiting for it.
            let _ = done.send(());
        });
        (Self { lines, line: Vec::new(), returned: false, passing: None }, seen)
    }

    /// Some more was said.
    pub(crate) fn hear(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            match byte {
                b'\n' => self.end_line(),
                b'\r' => self.returned = true,
                byte => {
                    if std::mem::take(&mut self.returned) {
                        self.pass();
                    }
                    if self.line.len() < LONGEST {
                        self.line.push(byte);
                    }
                }
            }
        }
    }

    /// Nothing more is said.
    pub(crate) fn end(mut self) {
        self.end_line();
    }

    fn end_line(&mut self) {
        self.returned = false;
        let line = std::mem::take(&mut self.line);
        let text = String::from_utf8_lossy(&line);
        if !text.trim().is_empty() {
            // One that has no room is not shown: the program does not wait for it.
            let _ = self.lines.try_send(text.into_owned());
        }
    }

    /// A line that another is written over.
    fn pass(&mut self) {
        if self.passing.is_none_or(|last| last.elapsed() >= OFTEN) {
            self.passing = Some(Instant::now());
            self.end_line();
        } else {
            self.line.clear();
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use std::sync::Mutex;

    use super::*;

    fn listening() -> (Onlooker, Arc<Mutex<Vec<String>>>) {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&seen);
        let look = move |program: &str, line: &str| {
            kept.lock().unwrap().push(format!("{program}: {line}"))
        };
        (Arc::new(look), seen)
    }

    fn heard(pieces: &[&[u8]]) -> Vec<String> {
        let (onlooker, seen) = listening();
        let (mut heard, done) = Overheard::by(onlooker, "p");
        pieces.iter().for_each(|piece| heard.hear(piece));
        heard.end();
        done.recv().unwrap();
        Arc::try_unwrap(seen)
            .map_or_else(|s| s.lock().unwrap().clone(), |s| s.into_inner().unwrap())
    }

    #[test]
    fn lines_are_shown_whole_wherever_they_are_cut_and_the_last_one_too() {
        assert_eq!(heard(&[b"lo", b"ading\r\nso\n\n", b"on"]), ["p: loading", "p: so", "p: on"]);
        assert_eq!(heard(&[&[b'x'; 5000]])[0].len(), LONGEST + 3);
    }

    #[test]
    fn progress_that_is_written_over_is_shown_now_and_then_and_at_its_end() {
        let bars = b"1 %\r2 %\r3 %\r4 %\rdone\n";
        assert_eq!(heard(&[bars]), ["p: 1 %", "p: done"]);
    }

    #[test]
    fn who_is_slow_holds_nobody_up() {
        let slow: Onlooker = Arc::new(|_, _| std::thread::sleep(Duration::from_secs(5)));
        let (mut heard, _) = Overheard::by(slow, "p");
        let began = Instant::now();
        (0..5000).for_each(|_| heard.hear(b"a line\n"));
        assert!(began.elapsed() < Duration::from_secs(4), "{:?}", began.elapsed());
    }

    #[test]
    fn no_secret_is_shown_not_even_in_pieces() {
        let key = secrecy::SecretString::from("sk-abc123def456ghi789".to_owned());
        let (onlooker, seen) = listening();
        let look = discreet(onlooker, Redactor::new([&key]));
        for line in
            ["hello", "the key is sk-abc123def456ghi789", "sk-abc123", "def456gh", "i789", "bye"]
        {
            look("p", line);
        }
        let seen = seen.lock().unwrap().join("\n");
        assert!(seen.contains("p: hello") && seen.ends_with("p: bye"), "{seen}");
        assert!(!seen.contains("def456"), "{seen}");
    }
}
