//! A Chromium without a window, spoken to over two pipes in the DevTools protocol.
//!
//! `KINFOLD_CHROMIUM` names one where it is not called `chromium`. It draws with the processor, obeys
//! `prefers-reduced-motion`, so that what is asked for is there at the next frame, and notes whatever a
//! page complains of or asks for.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use base64::Engine as _;
use image::RgbImage;
use serde_json::{Value, json};

/// After so long a browser hangs; it ends a test and measures nothing.
const HANGS: Duration = Duration::from_secs(120);

/// What it is started with: it asks nobody on its own account.
const QUIET: &[&str] = &[
    "--headless",
    "--no-sandbox",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--remote-debugging-pipe",
];

/// Keys that are held.
pub const ALT: u8 = 1;
/// Control.
pub const CTRL: u8 = 2;
/// Shift.
pub const SHIFT: u8 = 8;

/// The name of a browser, if there is one; said loudly where there is none.
pub fn chromium() -> Option<String> {
    let name = std::env::var("KINFOLD_CHROMIUM").unwrap_or_else(|_| "chromium".into());
    if Command::new(&name).arg("--version").output().is_ok_and(|o| o.status.success()) {
        return Some(name);
    }
    eprintln!("SKIPPED: no {name}");
    None
}

/// A browser with one page.
pub struct Browser {
    child: Child,
    input: ChildStdin,
    output: Receiver<Value>,
    calls: u64,
    session: Option<String>,
    events: Vec<Value>,
    /// What a page may ask, besides itself.
    pub origin: Option<String>,
    _home: tempfile::TempDir,
}

impl Browser {
    /// A browser whose page has that many pixels; none where there is no Chromium.
    pub fn start(size: [u32; 2], more: &[&str]) -> Option<Self> {
        let name = chromium()?;
        let home = tempfile::tempdir().unwrap();
        // It reads from file 3 and writes to file 4.
        let script = r#"exec "$0" "$@" 3<&0 4>&1 </dev/null >/dev/null 2>/dev/null"#;
        let mut command = Command::new("sh");
        command.args(["-c", script, &name]).args(QUIET).args(more);
        command.arg(format!("--user-data-dir={}", home.path().display()));
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let (input, stdout) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let (sender, output) = channel();
        std::thread::spawn(move || {
            for message in BufReader::new(stdout).split(0).map_while(Result::ok) {
                let message = serde_json::from_slice(&message).unwrap_or_default();
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        let (calls, session, events) = (0, None, Vec::new());
        let origin = None;
        let mut this = Self { child, input, output, calls, session, events, origin, _home: home };
        let target = this.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session = this.call("Target.attachToTarget", attach)["sessionId"].clone();
        this.session = session.as_str().map(str::to_owned);
        for domain in ["Runtime", "Log", "Network", "Page"] {
            this.call(&format!("{domain}.enable"), json!({}));
        }
        let [width, height] = size;
        let metrics =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        this.call("Emulation.setDeviceMetricsOverride", metrics);
        this.scheme("light");
        Some(this)
    }

    /// What colours a page is asked for: `light` or `dark`.
    pub fn scheme(&mut self, scheme: &str) {
        let features = json!([
            { "name": "prefers-reduced-motion", "value": "reduce" },
            { "name": "prefers-color-scheme", "value": scheme },
        ]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": features }));
    }

    fn call(&mut self, method: &str, params: Value) -> Value {
        self.calls += 1;
        let id = self.calls;
        let mut message = json!({ "id": id, "method": method, "params": params });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.input.write_all(format!("{message}\0").as_bytes()).unwrap();
        self.input.flush().unwrap();
        loop {
            let message = self.output.recv_timeout(HANGS).expect("the browser hangs or is gone");
            if message["id"] == json!(id) {
                assert!(message["error"].is_null(), "{method}: {message}");
                return message["result"].clone();
            }
            self.events.push(message);
        }
    }

    /// Opens a page and waits until it says that it is `ready`, or `still` where it cannot draw.
    pub fn open(&mut self, page: &Path) -> String {
        let page = std::fs::canonicalize(page).unwrap();
        self.open_at(&format!("file://{}", page.display()))
    }

    /// Opens an address, whatever its page is.
    pub fn go(&mut self, address: &str) {
        self.events.clear();
        self.call("Page.navigate", json!({ "url": address }));
        self.settle();
    }

    /// Opens an address and waits until its page is another than `loading`.
    pub fn open_at(&mut self, address: &str) -> String {
        self.events.clear();
        self.call("Page.navigate", json!({ "url": address }));
        self.wait_for("the page does not open", |state| !["", "loading"].contains(&state))
    }

    /// Waits until the page is in a state that will do; returns it.
    pub fn wait_for(&mut self, what: &str, is: impl Fn(&str) -> bool) -> String {
        let begun = Instant::now();
        loop {
            let state = self.run("document.getElementById('app')?.dataset.state ?? ''");
            let state = state.as_str().unwrap_or_default();
            if is(state) {
                return state.to_owned();
            }
            assert!(begun.elapsed() < HANGS, "{what}, it is {state}: {:?}", self.complaints());
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// What a line of JavaScript comes to.
    pub fn run(&mut self, script: &str) -> Value {
        let asked = json!({ "expression": script, "awaitPromise": true, "returnByValue": true });
        let said = self.call("Runtime.evaluate", asked);
        assert!(said["exceptionDetails"].is_null(), "{script}: {said}");
        said["result"]["value"].clone()
    }

    /// Waits for the frame that shows what was asked for.
    pub fn settle(&mut self) {
        self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 30))))");
    }

    /// Presses a key, by its name; only one that writes a character writes it.
    pub fn key(&mut self, key: &str) {
        let text = if key.chars().count() == 1 { key } else { "" };
        for kind in ["keyDown", "keyUp"] {
            let event = json!({ "type": kind, "key": key, "text": text });
            self.call("Input.dispatchKeyEvent", event);
        }
        self.settle();
    }

    /// Presses a key while others are held ([`ALT`], [`CTRL`], [`SHIFT`]).
    pub fn key_with(&mut self, key: &str, held: u8) {
        for kind in ["rawKeyDown", "keyUp"] {
            let event = json!({ "type": kind, "key": key, "modifiers": held });
            self.call("Input.dispatchKeyEvent", event);
        }
        self.settle();
    }

    /// Types a text, key by key, where the focus is.
    pub fn write(&mut self, text: &str) {
        for c in text.chars() {
            let c = c.to_string();
            self.call("Input.dispatchKeyEvent", json!({ "type": "keyDown", "key": c, "text": c }));
            self.call("Input.dispatchKeyEvent", json!({ "type": "keyUp", "key": c }));
        }
    }

    /// Presses Enter, as one that ends a form.
    pub fn enter(&mut self) {
        let key = |kind: &str| json!({ "type": kind, "key": "Enter", "code": "Enter", "windowsVirtualKeyCode": 13, "text": "\r" });
        self.call("Input.dispatchKeyEvent", key("keyDown"));
        self.call("Input.dispatchKeyEvent", key("keyUp"));
        self.settle();
    }

    /// Presses, moves or lets go of the left button.
    pub fn mouse(&mut self, kind: &str, at: [f64; 2]) {
        self.mouse_with(kind, at, 0);
    }

    /// The same while keys are held.
    pub fn mouse_with(&mut self, kind: &str, [x, y]: [f64; 2], held: u8) {
        let down = u8::from(kind != "mouseReleased");
        let event = json!({
            "type": kind, "x": x, "y": y, "button": "left", "buttons": down, "clickCount": 1, "modifiers": held,
        });
        self.call("Input.dispatchMouseEvent", event);
    }

    /// Clicks while keys are held.
    pub fn click_with(&mut self, at: [f64; 2], held: u8) {
        self.mouse_with("mousePressed", at, held);
        self.mouse_with("mouseReleased", at, held);
        self.settle();
    }

    /// Drags from one place to another in some steps while keys are held.
    pub fn drag_with(&mut self, from: [f64; 2], to: [f64; 2], held: u8) {
        self.mouse_with("mousePressed", from, held);
        for step in 1..=8 {
            let k = f64::from(step) / 8.0;
            let at = [from[0] + k * (to[0] - from[0]), from[1] + k * (to[1] - from[1])];
            self.mouse_with("mouseMoved", at, held);
        }
        self.mouse_with("mouseReleased", to, held);
        self.settle();
    }

    /// What is on the screen.
    pub fn picture(&mut self) -> RgbImage {
        self.settle();
        let shot = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        let bytes =
            base64::engine::general_purpose::STANDARD.decode(shot["data"].as_str().unwrap());
        let picture = image::load_from_memory(&bytes.unwrap()).unwrap().to_rgb8();
        if let Some(folder) = std::env::var_os("KINFOLD_PICTURES") {
            let name = format!("{}-{}.png", std::process::id(), self.calls);
            picture.save(Path::new(&folder).join(name)).unwrap();
        }
        picture
    }

    /// Errors and words on the console, and requests for anything but the page itself.
    pub fn complaints(&mut self) -> Vec<String> {
        self.settle();
        let told = |event: &Value| {
            let params = &event["params"];
            match event["method"].as_str().unwrap_or_default() {
                "Network.requestWillBeSent" => {
                    let (url, kind) = (&params["request"]["url"], &params["type"]);
                    let own = self.origin.as_ref().zip(url.as_str());
                    let is_own = own.is_some_and(|(own, url)| url.starts_with(own.as_str()));
                    let is_data = url.as_str().is_some_and(|url| url.starts_with("data:"));
                    (kind != "Document" && !is_own && !is_data).then(|| format!("asked for {url}"))
                }
                "Runtime.exceptionThrown" | "Runtime.consoleAPICalled" | "Log.entryAdded" => {
                    Some(params.to_string())
                }
                _ => None,
            }
        };
        self.events.iter().filter_map(told).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// How many pixels of a part of two pictures differ: of columns and rows from the first corner to before
/// the second.
pub fn differing(a: &RgbImage, b: &RgbImage, [from, to]: [[u32; 2]; 2]) -> usize {
    let columns = |y: u32| (from[0]..to[0]).map(move |x| (x, y));
    let all = (from[1]..to[1]).flat_map(columns);
    let far =
        |p: image::Rgb<u8>, q: image::Rgb<u8>| p.0.iter().zip(q.0).any(|(p, q)| p.abs_diff(q) > 12);
    all.filter(|&(x, y)| far(*a.get_pixel(x, y), *b.get_pixel(x, y))).count()
}
