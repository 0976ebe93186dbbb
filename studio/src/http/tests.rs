//! The server as a program asks it, without a socket.

use std::sync::Mutex as Lock;

use axum::body::{Body, to_bytes};
use axum::http::{Method, Request};
use object::mesh::UpAxis;
use object::{DVec3, Mesh};
use serde_json::{Map, Value, json};
use tower::ServiceExt as _;

use super::guard::TOKEN;
use super::*;
use crate::desk::Desk;
use crate::house::{Artefact, Built, Failure, House, Order, Outcome, StageState, Tell};
use crate::paper::Paper;

/// A house that builds nothing, and says so in the way it is told to.
#[derive(Default)]
struct Shed {
    orders: Lock<Vec<Order>>,
    closed: bool,
}

impl House for Shed {
    fn why_not(&self) -> Option<String> {
        self.closed.then(|| "there is no photo".to_owned())
    }

    fn stages(&self, order: &Order) -> usize {
        1 + order.export.len()
    }

    fn build(
        &self,
        order: &Order,
        tell: Tell<'_>,
        stop: &dyn Fn() -> bool,
    ) -> Result<Outcome, Failure> {
        locked(&self.orders).push(order.clone());
        tell("articulate", StageState::Running);
        tell("articulate", StageState::Done);
        if order.export.contains(&"usd".to_owned()) {
            while !stop() {
                std::thread::sleep(Duration::from_millis(2));
            }
            return Err(Failure::new("interrupted"));
        }
        let tier = Some("dynamic".to_owned());
        Ok(Outcome { exit: 0, tier, remarks: vec!["well".into()], out: "a.kinfold".into() })
    }

    fn built(&self) -> Result<Option<Built>, Failure> {
        Ok(None)
    }

    fn artefacts(&self) -> Result<Vec<Artefact>, Failure> {
        Ok(vec![Artefact { name: "asset.urdf".into(), bytes: 3 }])
    }

    fn artefact(&self, name: &str) -> Result<Option<Vec<u8>>, Failure> {
        Ok((name == "meshes/a.obj").then(|| b"abc".to_vec()))
    }

    fn check(&self, path: &str) -> Result<Value, Failure> {
        Err(Failure::new(format!("{path}: no such file")).with_hint("name another"))
    }

    fn can_draft(&self) -> bool {
        false
    }

    fn draft(&self) -> Result<String, Failure> {
        Err(Failure::new("nobody"))
    }
}

/// Two cubes side by side.
fn cubes() -> Mesh {
    let cube = |x: f64| {
        let corner = move |i: u32| {
            let bit = |k: u32| f64::from((i >> k) & 1);
            DVec3::new(x + bit(0), bit(1), bit(2))
        };
        (0..8).map(corner).collect::<Vec<_>>()
    };
    let faces = [
        [0u32, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    let both = faces.iter().copied().chain(faces.iter().map(|f| f.map(|v| v + 8)));
    Mesh::new([cube(0.0), cube(1.5)].concat(), both.collect()).unwrap()
}

struct Studio {
    folder: tempfile::TempDir,
    room: Room,
}

impl Studio {
    fn open(house: Shed) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let paper = Paper::open(&folder.path().join("a.json"), UpAxis::Y).unwrap();
        let setup = Setup {
            title: "cubes".into(),
            version: "0".into(),
            page: "<!doctype html>the page".into(),
            mesh_name: "cubes.glb".into(),
            desk: Desk::new(cubes()),
            photo: None,
            paper,
            out: "a.kinfold".into(),
            house: Arc::new(house),
        };
        let token = Token::new().unwrap();
        Self { folder, room: room(setup, token, "127.0.0.1:7411".parse().unwrap()) }
    }

    fn asked(&self, method: Method, path: &str, body: Option<Value>) -> Request<Body> {
        let request = Request::builder()
            .method(method)
            .uri(path)
            .header("host", "127.0.0.1:7411")
            .header(TOKEN, self.room.token.as_str());
        match body {
            Some(body) => request
                .header("content-type", "application/json")
                .body(Body::from(body.to_string())),
            None => request.body(Body::empty()),
        }
        .unwrap()
    }

    async fn answer(&self, request: Request<Body>) -> (u16, Vec<u8>) {
        let answer = router(Arc::clone(&self.room)).oneshot(request).await.unwrap();
        let status = answer.status().as_u16();
        (status, to_bytes(answer.into_body(), usize::MAX).await.unwrap().to_vec())
    }

    async fn ask(&self, method: Method, path: &str, body: Value) -> (u16, Value) {
        let body = (!body.is_null()).then_some(body);
        let (status, bytes) = self.answer(self.asked(method, path, body)).await;
        (status, serde_json::from_slice(&bytes).unwrap_or(Value::Null))
    }

    /// Writes a condition, and returns its revision.
    async fn write(&self, document: &Value) -> String {
        let base = locked(&self.room.paper).revision().to_owned();
        let body = json!({ "text": format!("{document:#}\n"), "base": base });
        let (status, said) = self.ask(Method::PUT, "/api/condition", body).await;
        assert_eq!(status, 200, "{said}");
        said["revision"].as_str().unwrap().to_owned()
    }
}

fn two_parts() -> Value {
    // The file's frame is y up: (x, y, z) of the object is (x, z, -y) of the file.
    json!({
        "schema": "kinfold-condition/2",
        "category": "pair",
        "parts": [
            { "name": "left", "point": [0.2, 0.0, -0.5] },
            { "name": "right", "parent": "left", "joint": "prismatic", "point": [1.7, 0.0, -0.5] },
        ],
    })
}

fn block_on<F: Future>(future: F) -> F::Output {
    tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap().block_on(future)
}

#[test]
fn nobody_is_answered_without_the_token_or_from_another_origin() {
    let studio = Studio::open(Shed::default());
    let token = studio.room.token.as_str().to_owned();
    let with = |headers: &[(&str, &str)], path: &str| {
        let mut request = Request::builder().uri(path);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        request.body(Body::empty()).unwrap()
    };
    let host = ("host", "127.0.0.1:7411");
    let good = format!("/api/state?token={token}");
    let page = format!("/?token={token}");
    block_on(async {
        type Case<'a> = (&'a [(&'a str, &'a str)], &'a str, u16);
        let cases: [Case<'_>; 11] = [
            (&[host], &good, 200),
            (&[("host", "localhost:7411"), ("origin", "http://localhost:7411")], &good, 200),
            (&[host, ("sec-fetch-site", "same-origin")], &good, 200),
            (&[host], "/api/state", 401),
            (&[host], "/", 401),
            (&[host], "/api/state?token=0123", 401),
            (&[("host", "example.com")], &good, 403),
            (&[host, ("origin", "http://example.com")], &good, 403),
            (&[host, ("sec-fetch-site", "cross-site")], &good, 403),
            (&[host, ("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate")], &good, 403),
            (&[host, ("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate")], &page, 200),
        ];
        for (headers, path, expected) in cases {
            let (status, body) = studio.answer(with(headers, path)).await;
            assert_eq!(status, expected, "{headers:?} {path}");
            if status != 200 && path != "/" {
                let body: Value = serde_json::from_slice(&body).unwrap();
                assert!(body["error"]["message"].is_string() && body["error"]["hint"].is_string());
            }
        }
        let (status, body) = studio.answer(with(&[host], &format!("/?token={token}"))).await;
        assert_eq!((status, &body[..]), (200, &b"<!doctype html>the page"[..]));
    });
}

#[test]
fn what_is_asked_for_is_what_is_described_and_nothing_else() {
    let document = crate::openapi();
    let described: Vec<&str> =
        document["paths"].as_object().unwrap().keys().map(String::as_str).collect();
    let mut routed: Vec<String> =
        routes().into_iter().map(|(path, _)| path.replace("{*name}", "{name}")).collect();
    routed.sort_unstable();
    assert_eq!(routed, described);
    let studio = Studio::open(Shed::default());
    block_on(async {
        for (path, methods) in document["paths"].as_object().unwrap() {
            for method in ["get", "post", "put", "delete"] {
                let is_known =
                    methods.as_object().is_some_and(|m: &Map<_, _>| m.contains_key(method));
                if path == "/api/events" && is_known {
                    continue;
                }
                let verb = Method::from_bytes(method.to_uppercase().as_bytes()).unwrap();
                let (status, _) = studio.ask(verb, &path.replace("{name}", "a"), Value::Null).await;
                assert_eq!(status == 405, !is_known, "{method} {path}: {status}");
            }
        }
        assert_eq!(studio.ask(Method::GET, "/api/other", Value::Null).await.0, 404);
    });
}

#[test]
fn a_condition_is_written_labelled_and_articulated() {
    let studio = Studio::open(Shed::default());
    block_on(async {
        let (_, state) = studio.ask(Method::GET, "/api/state", Value::Null).await;
        assert_eq!(state["document"]["parts"], json!([]));
        assert_eq!(state["to_file"], json!([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]));
        let revision = studio.write(&two_parts()).await;
        let on_disk = std::fs::read_to_string(studio.folder.path().join("a.json")).unwrap();
        assert_eq!(on_disk, format!("{:#}\n", two_parts()));
        let asked = json!({ "revision": revision });
        let (status, labels) = studio.ask(Method::POST, "/api/labels", asked.clone()).await;
        assert_eq!((status, &labels["parts"]), (200, &json!(["left", "right"])), "{labels}");
        use base64::Engine as _;
        let faces = base64::engine::general_purpose::STANDARD
            .decode(labels["faces"].as_str().unwrap())
            .unwrap();
        assert_eq!(faces, [[0u8; 12], [1; 12]].concat());
        let (_, joints) = studio.ask(Method::POST, "/api/articulate", asked).await;
        let joint = &joints["joints"][0];
        assert_eq!((&joint["part"], &joint["kind"]), (&json!("right"), &json!("prismatic")));
        assert!(joint["range"][1].as_f64().unwrap() > joint["range"][0].as_f64().unwrap());
        let range = |pivot: [f64; 3]| json!({ "revision": revision, "part": "right", "axis": [1, 0, 0], "pivot": pivot });
        let (status, said) =
            studio.ask(Method::POST, "/api/free-range", range([1e12, 0.0, 0.0])).await;
        assert_eq!(status, 400, "{said}");
        let (status, said) =
            studio.ask(Method::POST, "/api/free-range", range([1.5, 0.0, 0.0])).await;
        assert_eq!(status, 200, "{said}");
        assert!(
            said["range"][0].as_f64().unwrap() < 0.0 && said["range"][1].as_f64().unwrap() > 0.2
        );
        let old = json!({ "revision": "0123456789abcdef" });
        assert_eq!(studio.ask(Method::POST, "/api/labels", old).await.0, 503);
    });
}

#[test]
fn a_draft_with_faults_is_kept_and_its_faults_are_told() {
    let studio = Studio::open(Shed::default());
    block_on(async {
        let mut document = two_parts();
        document["parts"][1]["parent"] = json!("lefd");
        let revision = studio.write(&document).await;
        let (_, state) = studio.ask(Method::GET, "/api/state", Value::Null).await;
        let fault = state["faults"][0]["message"].as_str().unwrap();
        assert!(fault.contains("did you mean `left`"), "{fault}");
        let (status, said) =
            studio.ask(Method::POST, "/api/labels", json!({ "revision": revision })).await;
        assert_eq!((status, said["faults"].as_array().map(Vec::len)), (422, Some(1)), "{said}");
        let (status, _) =
            studio.ask(Method::POST, "/api/build", json!({ "revision": revision })).await;
        assert_eq!(status, 422);
    });
}

#[test]
fn what_was_changed_on_disk_meanwhile_is_answered_and_not_written_over() {
    let studio = Studio::open(Shed::default());
    block_on(async {
        let revision = studio.write(&two_parts()).await;
        let path = studio.folder.path().join("a.json");
        std::fs::write(&path, "{ \"parts\": [], \"notes\": \"theirs\" }").unwrap();
        let body = json!({ "text": "{}", "base": revision });
        let (status, said) = studio.ask(Method::PUT, "/api/condition", body).await;
        assert_eq!((status, &said["document"]["notes"]), (409, &json!("theirs")), "{said}");
        assert!(std::fs::read_to_string(&path).unwrap().contains("theirs"));
        let body = json!({ "text": "{}", "base": said["revision"] });
        assert_eq!(studio.ask(Method::PUT, "/api/condition", body).await.0, 200);
        let body = json!({ "text": "{ not json", "base": locked(&studio.room.paper).revision() });
        assert_eq!(studio.ask(Method::PUT, "/api/condition", body).await.0, 400);
    });
}

#[test]
fn a_build_tells_its_stages_and_its_end_and_one_goes_on_at_a_time() {
    let studio = Studio::open(Shed::default());
    block_on(async {
        let revision = studio.write(&two_parts()).await;
        let mut events = studio.room.events.subscribe();
        let order = |export: &str| json!({ "revision": revision, "export": [export] });
        let (status, said) = studio.ask(Method::POST, "/api/build", order("mjcf")).await;
        assert_eq!((status, &said["build"]), (202, &json!(1)), "{said}");
        let mut told = Vec::new();
        loop {
            let event = events.recv().await.unwrap();
            let is_end = matches!(event, Event::Built { .. });
            told.push(serde_json::to_value(&event).unwrap());
            if is_end {
                break;
            }
        }
        assert_eq!(
            told[1],
            json!({ "build": 1, "stage": "articulate", "state": "done", "done": 1, "of": 2 })
        );
        assert_eq!((&told[2]["tier"], &told[2]["message"]), (&json!("dynamic"), &json!("well")));
        let (_, state) = studio.ask(Method::GET, "/api/state", Value::Null).await;
        assert_eq!((&state["built"]["exit"], &state["building"]), (&json!(0), &Value::Null));

        assert_eq!(studio.ask(Method::POST, "/api/build", order("usd")).await.0, 202);
        assert_eq!(studio.ask(Method::POST, "/api/build", order("mjcf")).await.0, 409);
        assert_eq!(studio.ask(Method::POST, "/api/build/cancel", Value::Null).await.0, 200);
        let end = loop {
            if let Event::Built { exit, message, .. } = events.recv().await.unwrap() {
                break (exit, message);
            }
        };
        assert_eq!(end, (1, "interrupted".into()));
        assert_eq!(studio.ask(Method::POST, "/api/build", order("stl")).await.0, 400);
    });
}

#[test]
fn where_nothing_can_be_built_it_is_said_why() {
    let studio = Studio::open(Shed { closed: true, ..Shed::default() });
    block_on(async {
        let revision = studio.write(&two_parts()).await;
        let (_, state) = studio.ask(Method::GET, "/api/state", Value::Null).await;
        assert_eq!(
            (&state["can_build"], &state["why_not"]),
            (&json!(false), &json!("there is no photo"))
        );
        let (status, said) =
            studio.ask(Method::POST, "/api/build", json!({ "revision": revision })).await;
        assert_eq!((status, &said["error"]["message"]), (422, &json!("there is no photo")));
    });
}

#[test]
fn files_of_an_asset_are_handed_out_by_name_and_run_nowhere() {
    let studio = Studio::open(Shed::default());
    block_on(async {
        let body = Some(json!({ "revision": 7, "more": true }));
        let (status, said) = studio.answer(studio.asked(Method::POST, "/api/labels", body)).await;
        let said: Value = serde_json::from_slice(&said).unwrap();
        assert_eq!(status, 422);
        assert!(said["error"]["message"].as_str().unwrap().starts_with("the question: "), "{said}");
        let (_, all) = studio.ask(Method::GET, "/api/artefacts", Value::Null).await;
        assert_eq!(all["files"][0]["name"], "asset.urdf");
        let request = studio.asked(Method::GET, "/api/artefacts/meshes/a.obj", None);
        let answer = router(Arc::clone(&studio.room)).oneshot(request).await.unwrap();
        assert_eq!(answer.headers()["content-disposition"], "attachment");
        assert_eq!(answer.headers()["x-content-type-options"], "nosniff");
        let (status, said) = studio.ask(Method::GET, "/api/artefacts/other", Value::Null).await;
        assert_eq!(status, 404, "{said}");
        let (status, said) =
            studio.ask(Method::POST, "/api/check", json!({ "path": "b.urdf" })).await;
        assert_eq!((status, &said["error"]["hint"]), (422, &json!("name another")));
    });
}

#[test]
fn a_page_that_comes_or_goes_is_counted() {
    let studio = Studio::open(Shed::default());
    block_on(async {
        let mut events = studio.room.events.subscribe();
        let ask = || {
            router(Arc::clone(&studio.room)).oneshot(studio.asked(Method::GET, "/api/events", None))
        };
        let (one, other) = (ask().await.unwrap(), ask().await.unwrap());
        drop(one);
        drop(other);
        let mut counts = Vec::new();
        for _ in 0..4 {
            if let Event::Tabs { count } = events.recv().await.unwrap() {
                counts.push(count);
            }
        }
        assert_eq!(counts, [1, 2, 1, 0]);
    });
}

#[test]
fn only_this_machine_is_listened_to() {
    let studio = Studio::open(Shed::default());
    let listener = TcpListener::bind("0.0.0.0:0").unwrap();
    let Ok(inner) = Arc::try_unwrap(studio.room) else { panic!("held") };
    let error = serve(listener, inner.token, inner.setup, &Stop::default()).unwrap_err();
    assert!(error.to_string().contains("not of this machine alone"), "{error}");
}
