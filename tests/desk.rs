//! A studio that runs and a page of it in a browser, for tests.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::path::PathBuf;
use std::process::{Child, Stdio};

use object::mesh::Bounds;
use object::{DVec3, Mesh};
use serde_json::Value;

use crate::browser::Browser;
use crate::examples;
use crate::kinfold::{Said, program};

/// Pixels of the page.
pub const SIZE: [u32; 2] = [1280, 800];

/// A studio that runs, and the folder it works in.
pub struct Studio {
    child: Child,
    /// Its address, with the token.
    pub url: String,
    /// Where it works.
    pub folder: tempfile::TempDir,
}

impl Studio {
    /// Opens an example with a condition that may not be there yet.
    pub fn open(example: &str, more: &[&str]) -> Self {
        Self::begin(example, &["photo.png", "--mesh", "mesh.glb"], more)
    }

    /// The same of what is named.
    pub fn begin(example: &str, named: &[&str], more: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let case = examples::folder(example);
        for file in ["photo.png", "mesh.glb"] {
            std::fs::copy(case.join(file), folder.path().join(file)).unwrap();
        }
        let files = ["--condition", "mine.json", "--state", "state"];
        Self::start(folder, &[named, &files, more].concat())
    }

    /// Starts one in a folder.
    pub fn start(folder: tempfile::TempDir, words: &[&str]) -> Self {
        let mut command = program();
        command
            .current_dir(folder.path())
            .arg("studio")
            .args(words)
            .args(["--port", "0", "--json"]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
        let told: Value = serde_json::from_str(&line).unwrap_or_else(|e| {
            panic!("{e}: {line} {:?}", Said::from(child.wait_with_output_of()))
        });
        Self { child, url: told["url"].as_str().unwrap().to_owned(), folder }
    }

    /// What the server says of its state.
    pub fn state(&self) -> Value {
        let (host, token) = self.url.trim_start_matches("http://").split_once("/?").unwrap();
        let mut stream = std::net::TcpStream::connect(host).unwrap();
        let asked =
            format!("GET /api/state?{token} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        stream.write_all(asked.as_bytes()).unwrap();
        let mut said = String::new();
        stream.read_to_string(&mut said).unwrap();
        serde_json::from_str(said.split_once("\r\n\r\n").unwrap().1).unwrap()
    }

    /// Ends it and gives back the folder.
    pub fn end(mut self) -> tempfile::TempDir {
        let _ = self.child.kill();
        std::mem::replace(&mut self.folder, tempfile::tempdir().unwrap())
    }

    pub fn origin(&self) -> String {
        self.url.split("/?").next().unwrap().to_owned()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn mesh(&self) -> Mesh {
        object::glb::read(&std::fs::read(self.path("mesh.glb")).unwrap()).unwrap()
    }

    /// The condition as it lies on disk.
    pub fn condition(&self) -> Value {
        serde_json::from_str(&std::fs::read_to_string(self.path("mine.json")).unwrap()).unwrap()
    }

    pub fn part(&self, name: &str) -> Value {
        let condition = self.condition();
        let all = condition["parts"].as_array().unwrap();
        all.iter().find(|p| p["name"] == name).unwrap_or_else(|| panic!("no {name}")).clone()
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

trait Ended {
    fn wait_with_output_of(&mut self) -> std::process::Output;
}

impl Ended for Child {
    /// What it said, once it is ended.
    fn wait_with_output_of(&mut self) -> std::process::Output {
        let _ = self.kill();
        let mut err = Vec::new();
        if let Some(stderr) = self.stderr.as_mut() {
            std::io::Read::read_to_end(stderr, &mut err).unwrap();
        }
        std::process::Output { status: self.wait().unwrap(), stdout: vec![], stderr: err }
    }
}

/// A page of the studio in a browser.
pub struct Page {
    pub browser: Browser,
}

impl Page {
    pub fn open(studio: &Studio) -> Option<Self> {
        let mut browser = Browser::start(SIZE, &[])?;
        browser.origin = Some(studio.origin());
        browser.open_at(&studio.url);
        let mut page = Self { browser };
        page.rest();
        Some(page)
    }

    /// Waits until what was done is saved, labelled and articulated.
    pub fn rest(&mut self) {
        self.browser.settle();
        self.browser.wait_for("it does not come to rest", |state| state == "ready");
        self.browser.settle();
    }

    /// The middle of an element on the screen.
    pub fn middle(&mut self, selector: &str) -> [f64; 2] {
        let script = format!(
            "(() => {{ const e = document.querySelector({selector:?}); if (!e) return null;
            e.scrollIntoView({{ block: 'nearest' }}); const b = e.getBoundingClientRect();
            return [b.left + b.width / 2, b.top + b.height / 2]; }})()"
        );
        let at = self.browser.run(&script);
        let at = at.as_array().unwrap_or_else(|| panic!("no {selector} on the page"));
        [at[0].as_f64().unwrap(), at[1].as_f64().unwrap()]
    }

    pub fn click(&mut self, selector: &str) {
        let at = self.middle(selector);
        self.browser.click_with(at, 0);
    }

    pub fn text(&mut self, selector: &str) -> String {
        let script = format!("document.querySelector({selector:?})?.innerText ?? ''");
        self.browser.run(&script).as_str().unwrap_or_default().to_owned()
    }

    /// Adds a part by keyboard, and leaves the focus in the picture.
    pub fn add(&mut self, name: &str) {
        self.browser.key("a");
        self.browser.write(name);
        self.browser.enter();
        self.browser.settle();
    }

    /// Writes a number into a field, as a person does.
    pub fn fill(&mut self, selector: &str, value: &str) {
        self.click(selector);
        self.browser.run(&format!("document.querySelector({selector:?}).select()"));
        self.browser.write(value);
        self.browser.enter();
    }

    /// Where a point of the object is on the screen when it is looked at from a side, by the rules of the
    /// page's camera: the whole box fits the view.
    pub fn place(&mut self, object: &Mesh, side: Side, point: [f64; 3]) -> [f64; 2] {
        let [width, height, left, top] = self.canvas();
        let slope = (16f64).to_radians().tan();
        let (aspect, tall) = (width / height, (1.0 - 150.0 / height).clamp(0.5, 0.86));
        let (yaw, pitch) = side.angles();
        let z = DVec3::new(pitch.cos() * yaw.sin(), -pitch.cos() * yaw.cos(), pitch.sin());
        let x = DVec3::Z.cross(z).normalize();
        let y = z.cross(x);
        let Bounds { min, max } = object.bounds();
        let middle = (min + max) / 2.0;
        let corner = |i: u32| {
            let side = |k: u32| if (i >> k) & 1 == 1 { max } else { min };
            DVec3::new(side(0).x, side(1).y, side(2).z) - middle
        };
        let needed = |p: DVec3| {
            (p.dot(x).abs() / (0.9 * aspect)).max(p.dot(y).abs() / tall) / slope + p.dot(z)
        };
        let distance = (0..8).map(|i| needed(corner(i))).fold(0.0, f64::max);
        let p = DVec3::from_array(point) - middle;
        let scale = height / 2.0 / ((distance - p.dot(z)) * slope);
        [left + width / 2.0 + p.dot(x) * scale, top + height / 2.0 - p.dot(y) * scale]
    }

    pub fn canvas(&mut self) -> [f64; 4] {
        let script = "(() => { const b = document.getElementById('canvas').getBoundingClientRect();
            return [b.width, b.height, b.left, b.top]; })()";
        let found = self.browser.run(script);
        let number = |i: usize| found[i].as_f64().unwrap();
        [number(0), number(1), number(2), number(3)]
    }
}

/// A side that the object is looked at from, each with its key.
#[derive(Clone, Copy)]
pub enum Side {
    Corner,
    Front,
    Right,
}

impl Side {
    pub fn key(self) -> &'static str {
        match self {
            Self::Corner => "0",
            Self::Front => "1",
            Self::Right => "2",
        }
    }

    /// Turn about z from the front, and height, radians.
    pub fn angles(self) -> (f64, f64) {
        match self {
            Self::Corner => (0.62, 0.42),
            Self::Front => (0.0, 0.0),
            Self::Right => (std::f64::consts::FRAC_PI_2, 0.0),
        }
    }
}
