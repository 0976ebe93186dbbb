//! USD layers read in a process of their own: the program that works apart.

use std::ffi::OsString;
use std::io::{Read as _, Write as _};
use std::process::{Command, ExitCode, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use object::usd::apart;

use super::isolated::bound_memory;
use super::program;

/// The word after which this program reads a layer from its standard input: `kinfold read-usd-layer`.
const VERB: &str = "read-usd-layer";
/// How long reading may take, seconds: at any size, and more for each MiB. It gives up on its own before.
const READING: [f64; 2] = [30.0, 2.5];
/// Most bytes of an answer: twice the largest mesh that is taken, in digits. A guess with room.
const MOST: u64 = 4 << 30;

/// Reads a layer if the arguments say so: then it returns what to end with.
pub(super) fn asked(mut arguments: impl Iterator<Item = OsString>) -> Option<ExitCode> {
    arguments.nth(1).filter(|verb| verb == VERB)?;
    let read = || -> std::io::Result<()> {
        bound_memory()?;
        let mut layer = Vec::new();
        std::io::stdin().lock().read_to_end(&mut layer)?;
        // What breaks down in the library is said by the answer.
        std::panic::set_hook(Box::new(|_| {}));
        let mut out = std::io::stdout().lock();
        out.write_all(&apart::answer(layer))?;
        out.flush()
    };
    // A thread that does not end is left behind.
    std::process::exit(i32::from(read().is_err()))
}

/// From now on layers are read by the program that works apart, started for each.
pub(super) fn read_apart() {
    apart::read_layers_by(read);
}

fn read(layer: &[u8]) -> Result<Vec<u8>, String> {
    let program = program::apart().map_err(|e| format!("this program cannot find itself: {e}"))?;
    let mut command = Command::new(program);
    command.arg(VERB).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let child = command.spawn();
    let mut child = child.map_err(|e| format!("no process could be started to read it: {e}"))?;
    let (stdin, stdout) = (child.stdin.take(), child.stdout.take());
    let (sender, answers) = channel();
    let deadline = READING[0] + READING[1] * layer.len() as f64 / f64::from(1 << 20);
    let answer = std::thread::scope(|scope| {
        scope.spawn(move || {
            // One that does not listen does not answer either.
            let _ = stdin.map(|mut stdin| stdin.write_all(layer));
        });
        scope.spawn(move || {
            let mut answer = Vec::new();
            let read = stdout.map(|out| out.take(MOST).read_to_end(&mut answer));
            // Nobody may be waiting any more.
            let _ = sender.send(read.and_then(Result::ok).map(|_| answer));
        });
        let answer = answers.recv_timeout(Duration::from_secs_f64(deadline));
        // With it end both pipes, and so both threads.
        let _ = child.kill();
        let _ = child.wait();
        answer
    });
    match answer {
        Ok(Some(answer)) if !answer.is_empty() => Ok(answer),
        Ok(_) | Err(RecvTimeoutError::Disconnected) => Err("the reader broke down on it".into()),
        Err(RecvTimeoutError::Timeout) => {
            Err(format!("it takes longer than the {deadline:.0} s it may"))
        }
    }
}
