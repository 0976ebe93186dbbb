//! A small server of prepared answers on this machine, for tests of the real client.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// What one connection gets.
pub(crate) enum Serve {
    /// These bytes, and the end.
    Bytes(Vec<u8>),
    /// Silence for so long, and the end.
    Nothing(Duration),
}

impl Serve {
    pub(crate) fn text(answer: &str) -> Self {
        Self::Bytes(answer.into())
    }
}

/// A running server; it ends when its answers are used up.
pub(crate) struct Loopback {
    port: u16,
    seen: Arc<Mutex<Vec<String>>>,
}

impl Loopback {
    pub(crate) fn url(&self, path: &str) -> String {
        format!("http://127.0.0.1:{}{path}", self.port)
    }

    /// What was asked so far.
    pub(crate) fn requests(&self) -> Vec<String> {
        self.seen.lock().unwrap().clone()
    }
}

/// Serves one answer per connection, in order.
pub(crate) fn serve(answers: Vec<Serve>) -> Loopback {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let seen = Arc::new(Mutex::new(vec![]));
    let heard = Arc::clone(&seen);
    if answers.is_empty() {
        return Loopback { port, seen };
    }
    std::thread::spawn(move || {
        for answer in answers {
            let Ok((mut stream, _)) = listener.accept() else { return };
            let request = read_request(&mut stream);
            heard.lock().unwrap().push(request);
            match answer {
                Serve::Bytes(bytes) => drop(stream.write_all(&bytes)),
                Serve::Nothing(time) => std::thread::sleep(time),
            }
        }
    });
    Loopback { port, seen }
}

/// Head and as much of the body as its length says.
fn read_request(stream: &mut TcpStream) -> String {
    let mut bytes = vec![];
    let mut chunk = [0; 4096];
    loop {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        if let Some((head, body)) = text.split_once("\r\n\r\n") {
            let length = head.lines().find_map(|l| {
                l.to_ascii_lowercase().strip_prefix("content-length:")?.trim().parse().ok()
            });
            if body.len() >= length.unwrap_or(0_usize) {
                return text;
            }
        }
        match stream.read(&mut chunk) {
            Ok(0) | Err(_) => return text,
            Ok(n) => bytes.extend_from_slice(&chunk[..n]),
        }
    }
}
