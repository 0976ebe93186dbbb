//! Stages done elsewhere, with toys: by a worker in this process that knows nothing but the store.

use std::path::Path;
use std::sync::{Arc, Mutex};

use trace::Digest;

use super::super::artefact::Text;
use super::super::toy::{Toys, flow, options};
use super::super::{Artefact, Ending, FolderDepot, Outcome, Quiet, StateDir, run};
use super::*;

/// A worker that loses what it should have on some of its errands.
struct Bench {
    depot: Arc<dyn Depot>,
    answers: Mutex<Vec<Answer>>,
}

impl Bench {
    fn at(root: &Path) -> Arc<Self> {
        let depot = Arc::new(FolderDepot::new(root, "worker"));
        Arc::new(Self { depot, answers: Mutex::default() })
    }
}

impl Workers for Bench {
    fn perform(&self, errand: &Errand, inputs: &[Input]) -> Result<Done, StageError> {
        let nothing_in_particular = flow("");
        let perform = || nothing_in_particular.perform(errand, &Toys::default(), &*self.depot);
        let mut answer = perform().unwrap();
        self.answers.lock().unwrap().push(answer.clone());
        if matches!(answer, Answer::Missing(_)) {
            inputs.iter().for_each(|(digest, bytes)| self.depot.put_blob(digest, bytes).unwrap());
            answer = perform().unwrap();
        }
        match answer {
            Answer::Made { output, notes, .. } => {
                let Found::Whole(bytes) = self.depot.blob(&output).unwrap() else {
                    panic!("{output} is not there")
                };
                Ok(Done { result: Committed { output, notes }, bytes, took: Duration::ZERO })
            }
            Answer::Failed { message, .. } => Err(StageError::new(message)),
            other => panic!("{other:?}"),
        }
    }
}

fn played(state: &Path, workers: Option<Arc<dyn Workers>>, shared: &Path) -> Outcome {
    let depot = Arc::new(FolderDepot::new(shared, "batch"));
    let state = StateDir::open(state).unwrap().sharing(depot);
    let options = super::super::RunOptions { workers, ..options(Default::default()) };
    run(&flow("abc"), &Arc::new(Toys::default()), &state, &options, &mut Quiet).unwrap()
}

#[test]
fn stages_done_elsewhere_give_the_same_digests_and_are_recalled_afterwards() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    let here = played(&path("here"), None, &path("own"));
    let bench = Bench::at(&path("shared"));
    let there = played(&path("there"), Some(bench.clone()), &path("shared"));
    assert!(matches!(there.ending, Ending::Done), "{:?}", there.ending);
    let digests = |o: &Outcome| -> Vec<Digest> {
        o.nodes.iter().map(|n| n.output.clone().unwrap().0).collect()
    };
    assert_eq!(digests(&here), digests(&there));
    // The text that was given was not in the shared store until it was asked for.
    let answers = std::mem::take(&mut *bench.answers.lock().unwrap());
    assert!(answers.iter().any(|a| matches!(a, Answer::Missing(_))), "{answers:?}");
    let again = played(&path("other"), Some(bench.clone()), &path("shared"));
    assert!(again.nodes.iter().all(|n| n.recalled), "{again:?}");
    assert!(bench.answers.lock().unwrap().is_empty());
}

fn errand(stage: &str, inputs: &[&str]) -> Errand {
    let inputs = inputs.iter().map(|t| Digest::of(t.as_bytes())).collect();
    Errand { stage: stage.into(), key: Digest::of(b"another version"), seed: None, inputs }
}

#[test]
fn an_errand_of_another_version_is_not_done() {
    let dir = tempfile::tempdir().unwrap();
    let depot = FolderDepot::new(dir.path(), "worker");
    for errand in [errand("reverse", &["abc"]), errand("reverse", &[]), errand("fly", &["abc"])] {
        let answer = flow("").perform(&errand, &Toys::default(), &depot).unwrap();
        assert!(matches!(answer, Answer::Strange(_)), "{errand:?}: {answer:?}");
    }
}

#[test]
fn an_errand_done_twice_is_done_once() {
    let dir = tempfile::tempdir().unwrap();
    let depot = FolderDepot::new(dir.path(), "worker");
    let bytes = Artefact::<Toys>::encode(&Text("abc".into())).unwrap();
    depot.put_blob(&Digest::of(&bytes), &bytes).unwrap();
    let toys = Toys::default();
    let Answer::Strange(key) =
        flow("").perform(&errand("reverse", &["abc"]), &toys, &depot).unwrap()
    else {
        panic!("it knew the key")
    };
    let errand = Errand { key, ..errand("reverse", &["abc"]) };
    let twice = [0, 1].map(|_| flow("").perform(&errand, &toys, &depot).unwrap());
    let output = |answer: &Answer| match answer {
        Answer::Made { output, .. } => output.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!(output(&twice[0]), Digest::of(b"cba"));
    assert_eq!(output(&twice[0]), output(&twice[1]));
    assert_eq!(toys.times("reverse"), 1);
}
