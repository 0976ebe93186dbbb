//! What a run promises, on a tiny network and our own objects.

use std::path::Path;

use super::*;
use crate::augment::Augment;
use crate::dataset::sample::Counts;
use crate::loss::LossWeights;
use config::{Every, Sizes, Validation};
use optimiser::Schedule;

fn tiny(folder: &Path) -> TrainConfig {
    let network = Sizes { width: 24, heads: 2, blocks: 1, points: 96, tokens: 12, max_parts: 32 };
    TrainConfig {
        out: folder.join("run"),
        cache: folder.join("cache"),
        from: None,
        seed: 5,
        steps: 6,
        batch: 2,
        queries: 48,
        balanced: 0.5,
        network,
        schedule: Schedule { rate: 3e-3, warmup: 4, ..Schedule::default() },
        loss: LossWeights::default(),
        augment: Augment::default(),
        sample: Counts { even: 300, least: 24 },
        every: Every { curve: 2, checkpoint: 2, validation: 4 },
        sources: vec![SourceConfig::of_families("ours", 4)],
        held_out: vec![],
        validation: Some(Validation { source: SourceConfig::of_families("seen", 2), objects: 2 }),
    }
}

/// Ends a run after some steps, as a kill would: without another word.
struct Patience {
    steps: usize,
    losses: Vec<f64>,
}

impl Watcher for Patience {
    fn notice(&mut self, event: &Event) {
        if let Event::Curve { losses, .. } = event {
            self.losses.push(losses[0]);
        }
    }

    fn measured(&self, _: &str) {}

    fn go_on(&mut self) -> bool {
        self.steps = self.steps.saturating_sub(1);
        self.steps > 0
    }
}

fn run(config: &TrainConfig, steps: usize) -> (Result<Outcome, TrainError>, Vec<f64>) {
    let mut patience = Patience { steps, losses: vec![] };
    (train(config, &mut patience), patience.losses)
}

fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let name = |e: std::io::Result<std::fs::DirEntry>| e.unwrap().path();
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(name).collect();
    paths.sort();
    let name = |p: &PathBuf| p.file_name().unwrap().to_string_lossy().into_owned();
    paths.iter().map(|p| (name(p), std::fs::read(p).unwrap())).collect()
}

#[test]
fn a_run_cut_into_pieces_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let whole = tiny(folder.path());
    let (outcome, losses) = run(&whole, 99);
    assert!(outcome.unwrap().finished);
    assert_eq!(losses.len(), 3);
    let pieces = TrainConfig { out: folder.path().join("pieces"), ..whole.clone() };
    let (outcome, _) = run(&pieces, 3);
    let outcome = outcome.unwrap();
    assert_eq!((outcome.step, outcome.finished), (3, false));
    let (_, rest) = run(&pieces, 99);
    assert_eq!(rest, losses[1..], "a point of the curve is the mean of two steps");
    let [a, b] = [&whole, &pieces].map(|c| files(&c.out));
    assert_eq!(a.len(), 6, "checkpoint, weights, two tables, a plot and a lock");
    assert!(a == b, "the same names and bytes");
}

#[test]
fn one_thread_and_two_give_the_same_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let out = folder.path().join(format!("{threads}"));
        let config = TrainConfig { out, steps: 2, ..tiny(folder.path()) };
        pool.install(|| run(&config, 99)).0.unwrap();
        std::fs::read(config.out.join(CHECKPOINT)).unwrap()
    };
    assert!(on(1) == on(2));
}

#[test]
fn a_checkpoint_of_another_run_is_refused_and_weights_of_other_sizes_too() {
    let folder = tempfile::tempdir().unwrap();
    let config = TrainConfig { steps: 2, ..tiny(folder.path()) };
    run(&config, 99).0.unwrap();
    let other = TrainConfig { seed: 6, ..config.clone() };
    assert!(matches!(run(&other, 1).0, Err(TrainError::OtherRun(_))));
    let from = Some(config.out.join(WEIGHTS));
    let out = folder.path().join("next");
    let next = TrainConfig { from, out, ..config.clone() };
    run(&next, 99).0.unwrap();
    let network = Sizes { tokens: 13, ..config.network };
    let wide = TrainConfig { network, out: folder.path().join("wide"), ..next };
    assert!(matches!(run(&wide, 1).0, Err(TrainError::OtherSizes(_))));
}

#[test]
fn training_on_our_own_objects_lowers_the_loss_to_less_than_half() {
    let folder = tempfile::tempdir().unwrap();
    let tiny = tiny(folder.path());
    let every = Every { curve: 40, checkpoint: 200, validation: 200 };
    let config = TrainConfig { steps: 200, every, augment: Augment::none(), ..tiny };
    let (outcome, losses) = run(&config, usize::MAX);
    assert!(outcome.unwrap().finished);
    let (first, last) = (losses[0], losses[losses.len() - 1]);
    assert!(last < 0.5 * first, "from {first:.3} to {last:.3}");
}

#[test]
fn a_checkpoint_cut_short_is_an_error_that_names_it_and_nothing_is_trained_over_it() {
    let folder = tempfile::tempdir().unwrap();
    let config = TrainConfig { steps: 2, ..tiny(folder.path()) };
    run(&config, 99).0.unwrap();
    let path = config.out.join(CHECKPOINT);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 5]).unwrap();
    let told = run(&TrainConfig { steps: 4, ..config }, 99).0.unwrap_err().to_string();
    assert!(told.contains("checkpoint.safetensors"), "{told}");
    assert_eq!(std::fs::read(&path).unwrap().len(), bytes.len() - 5);
}

#[test]
fn the_weights_of_a_run_are_what_the_articulator_loads() {
    let folder = tempfile::tempdir().unwrap();
    let config = TrainConfig { steps: 1, ..tiny(folder.path()) };
    let outcome = run(&config, 99).0.unwrap();
    let file = File::open(&outcome.weights).unwrap();
    let neural = model::Neural::load(BufReader::new(file), "test").unwrap();
    let made = crate::procedural::FAMILIES[0].make().unwrap();
    let condition = made.condition.resolve().unwrap();
    let answer = model::Articulate::articulate(&neural, made.object.mesh(), &condition, 1);
    // Weights of one step may well give every face to one part, or lose the root.
    use model::ArticulateError::{NothingLabelled, Tree};
    assert!(matches!(answer, Ok(_) | Err(NothingLabelled(_) | Tree(_))), "{answer:?}");
}

#[test]
fn two_runs_in_one_folder_are_one_too_many() {
    let folder = tempfile::tempdir().unwrap();
    let config = TrainConfig { steps: 1, ..tiny(folder.path()) };
    std::fs::create_dir_all(&config.out).unwrap();
    let lock = alone(&config.out).unwrap();
    assert!(matches!(run(&config, 9).0, Err(TrainError::Busy(_))));
    drop(lock);
    assert!(run(&config, 9).0.is_ok());
}
