//! Engines beside the embedded one, as far as they need nobody: what is missing is told, and a batch
//! through a front door that answers as Restate's would gives the same bytes.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use model::Choice;
use runner::{Answer as Told, Errand, FolderDepot};
use serde_json::json;
use workflow::Tools;
use workflow::image_to_urdf::any_image_to_urdf;

use crate::batch::{Batch, number, same};
use crate::kinfold::{Said, say};
use crate::server::{Answer, Asked, Server};

#[test]
fn what_restate_needs_is_told_before_any_work() {
    let batch = Batch::of(1);
    let nobody = ["--engine", "restate", "--store", "s", "--admin", "http://127.0.0.1:1"];
    for (arguments, code, words) in [
        (&["--engine", "restate"][..], 2, "expected a --store that the workers share"),
        (&["--engine", "restate", "--store", "s", "--shard", "0/2"], 2, "found both"),
        (&["--engine", "restate", "--store", "s", "--ingress", "here"], 2, "expected an address"),
        (&["--store", "ftp://here"], 2, "expected a folder, file:///FOLDER, s3://BUCKET/PREFIX"),
        (&nobody, 1, "hint: --admin URL names Restate's administration"),
    ] {
        let said = Said::from(batch.batch(arguments).output().unwrap());
        assert_eq!(said.code, Some(code), "{said:?}");
        assert!(said.err.contains(words), "expected {words} in {}", said.err);
        assert!(!batch.path("out/ledger.sqlite").exists(), "nothing was begun");
    }
    let said = say(&["worker", "--engine", "embedded", "--store", "s"]);
    assert_eq!(said.code, Some(2), "{said:?}");
}

#[test]
fn a_worker_that_others_reach_does_not_start_without_a_key_to_obey() {
    for address in ["0.0.0.0:0", "[::]:0", "10.0.0.1:9080", "[::ffff:10.0.0.1]:9080"] {
        let said = say(&["worker", "--listen", address, "--store", "s"]);
        assert_eq!(said.code, Some(2), "{address}: {said:?}");
        assert!(said.err.contains("expected --identity-key to listen on"), "{}", said.err);
    }
    // A secret one, put there by mistake, is not quoted.
    let secret = "MC4CAQAwBQYDK2VwBCIE";
    let said = say(&["worker", "--store", "s", "--identity-key", secret]);
    assert_eq!(said.code, Some(2), "{said:?}");
    assert!(said.err.contains("found something else") && !said.err.contains(secret), "{said:?}");
}

#[cfg(not(feature = "remote"))]
#[test]
fn a_program_that_knows_no_buckets_says_so() {
    let batch = Batch::of(1);
    let said = Said::from(batch.batch(&["--store", "s3://ours/stages"]).output().unwrap());
    assert_eq!(said.code, Some(2), "{said:?}");
    assert!(
        said.err.contains("shared store s3://ours/stages: expected a kinfold built"),
        "{said:?}"
    );
    assert!(!batch.path("out").exists(), "nothing was begun");
}

#[cfg(not(feature = "restate"))]
#[test]
fn a_program_that_knows_no_restate_says_so() {
    let said = say(&["worker", "--store", "s"]);
    assert_eq!(said.code, Some(2), "{said:?}");
    assert!(said.err.contains("built with its feature `restate`"), "{}", said.err);
}

/// The idempotency keys that were asked for, and how many of those questions were broken off.
#[derive(Default)]
struct Book {
    keys: BTreeSet<String>,
    broken: usize,
}

/// A front door and a back door in one, whose only worker is this process. The first question under
/// every third key is lost on its way.
fn door(store: PathBuf, book: Arc<Mutex<Book>>) -> Server {
    Server::start(move |asked: &Asked| {
        if asked.method == "GET" {
            return Answer::json(200, &json!({}));
        }
        let key = asked.headers.iter().find_map(|h| {
            h.to_ascii_lowercase().strip_prefix("idempotency-key: ").map(String::from)
        });
        {
            let mut book = book.lock().unwrap();
            if book.keys.insert(key.unwrap()) && book.keys.len().is_multiple_of(3) {
                book.broken += 1;
                return Answer::json(503, &json!({ "message": "no leader yet" }));
            }
        }
        let errand: Errand = serde_json::from_slice(&asked.body).unwrap();
        assert_eq!(asked.path, format!("/kinfold.{}/make", errand.stage));
        let told = done(errand, &store);
        Answer::json(200, &serde_json::to_value(told).unwrap())
    })
}

/// Does an errand as a worker would, on a stack as large as its.
fn done(errand: Errand, store: &Path) -> Told {
    let store = store.to_path_buf();
    let perform = move || {
        let scratch = tempfile::tempdir().unwrap();
        let tools = Tools {
            image_to_3d: Box::new(adapters::MeshFile { path: "".into(), ..Default::default() }),
            vlm: Box::new(adapters::ConditionFile { path: "".into(), ..Default::default() }),
            critic: None,
            articulate: model::articulator(Choice::default()),
            seed: errand.seed.unwrap_or_default(),
            scratch: scratch.path().to_path_buf(),
        };
        let name = format!("{:?}", std::thread::current().id());
        any_image_to_urdf().perform(&errand, &tools, &FolderDepot::new(&store, &name)).unwrap()
    };
    std::thread::Builder::new().stack_size(32 << 20).spawn(perform).unwrap().join().unwrap()
}

#[test]
fn a_batch_whose_stages_are_done_elsewhere_gives_the_same_bytes() {
    let (there, here) = (Batch::of(2), Batch::of(2));
    let (_, embedded) = here.ran(&["--export", "mjcf,usd,glb"]);
    let (book, store) = (Arc::<Mutex<Book>>::default(), there.path("shared"));
    let door = door(store.clone(), Arc::clone(&book));
    let url = format!("http://127.0.0.1:{}", door.port);
    let (said, answer) = there.ran(&[
        "--export",
        "mjcf,usd,glb",
        "--engine",
        "restate",
        "--store",
        store.to_str().unwrap(),
        "--ingress",
        &url,
        "--admin",
        &url,
    ]);
    assert_eq!(said.code, Some(0), "{said:?}");
    same(&here.assets(), &there.assets());
    assert_eq!(answer["this_run"]["stages_run"], embedded["this_run"]["stages_run"]);
    assert_eq!([number(&answer, "accepted"), number(&answer, "calls")], [2, 0]);
    let book = book.lock().unwrap();
    // Eleven stages compute for each item; the views of two seeds are the same.
    assert!((12..=22).contains(&book.keys.len()) && book.broken > 2, "{:?}", book.keys);
    assert!(book.keys.iter().all(|key| key.len() == 64), "each asked for once: {:?}", book.keys);
    assert_eq!(there.say(&["audit", "out"]).code, Some(0));
}
