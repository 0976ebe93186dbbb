//! Tiny fits from end to end.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use model::classic::joints::{axis_model, range_model};
use model::classic::learned::pack::Pack;
use model::classic::segment::classify;

use super::*;
use crate::dataset::Specimen;
use crate::procedural::{Id, worded};
use crate::truth::TruthFile;

/// Nobody watches.
pub(super) struct Quiet;

impl Watcher for Quiet {
    fn say(&self, _: &str) {}

    fn go_on(&self, _: usize) -> bool {
        true
    }
}

/// Ends every run after one model.
struct Impatient;

impl Watcher for Impatient {
    fn say(&self, _: &str) {}

    fn go_on(&self, made: usize) -> bool {
        made == 0
    }
}

/// Hears what is said, and counts how often somebody asks whether to go on.
struct Listener(Mutex<Vec<String>>, AtomicUsize);

impl Watcher for Listener {
    fn say(&self, line: &str) {
        self.0.lock().unwrap().push(line.to_owned());
    }

    fn go_on(&self, _: usize) -> bool {
        self.1.fetch_add(1, Ordering::SeqCst);
        true
    }
}

const GROWTH: &str = "{ trees = 3, leaves = 4, rate = 0.3, questions = 0.7, features = 0.5, \
                      curve = 0.1, hold = 1.0, seed = 7 }";

/// All families but these.
fn but(kept: &[&str]) -> String {
    let others = crate::procedural::names().filter(|name| !kept.contains(name));
    let others: Vec<String> = others.map(|name| format!("{name:?}")).collect();
    format!("{{ each = 2, without = [{}] }}", others.join(", "))
}

fn segments() -> String {
    let families = but(&["drawer_unit", "storage_box"]);
    format!(
        "fit = 'segments'\nout = 'run'\npack = 'a.pack'\n[model]\nrounds = 3\n\
         [[model.ensemble]]\ncut = 1\npairwise = true\nfolds = 2\nrounds = 2\n\
         families = {families}\ngrowth = {GROWTH}\n\
         [[model.ensemble]]\nfused = ['32']\npairwise = false\nfolds = 4\nsplit = 2\nrounds = 1\n\
         families = {families}\ngrowth = {GROWTH}\n"
    )
}

fn ranges() -> String {
    let families = but(&["drawer_unit", "storage_box"]);
    format!(
        "fit = 'ranges'\nout = 'run'\npack = 'a.pack'\n[model]\nfused = '32'\n\
         families = {families}\nways = 3\ngrowth = {GROWTH}\n"
    )
}

fn axes() -> String {
    let families = but(&["drawer_unit", "storage_box"]);
    format!(
        "fit = 'axes'\nout = 'run'\npack = 'a.pack'\n[model]\nfused = '32'\n\
         families = {families}\ngrowth = {GROWTH}\n"
    )
}

fn confidence() -> String {
    let families = but(&["drawer_unit", "storage_box"]);
    format!(
        "fit = 'confidence'\nout = 'run'\npack = 'a.pack'\n[model]\ndraws = 1\nfused = ['32']\n\
         families = {families}\ngrowth = {GROWTH}\n"
    )
}

fn prior(fit: &str, more: &str) -> String {
    let families = but(&["drawer_unit", "control_box", "storage_box", "suitcase"]);
    format!("fit = '{fit}'\nout = 'run'\npack = 'a.pack'\n[model]\nfamilies = {families}\n{more}")
}

/// A fit in a folder of its own: recipes stand in packs, so they have the same name and text.
struct Place(tempfile::TempDir);

impl Place {
    fn new(recipe: &str) -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        std::fs::write(place.recipe(), recipe).unwrap();
        place
    }

    fn recipe(&self) -> PathBuf {
        self.0.path().join("recipe.toml")
    }

    fn pack(&self) -> Vec<u8> {
        std::fs::read(self.0.path().join("a.pack")).unwrap()
    }

    fn fit(&self) -> Outcome {
        let outcome = fit(&self.recipe(), &Quiet).unwrap();
        assert!(outcome.finished);
        outcome
    }

    fn refused(&self) -> String {
        fit(&self.recipe(), &Quiet).unwrap_err().to_string()
    }
}

/// Fits twice, once without a break and once ended after every model, and gives the pack.
fn both_ways(recipe: &str) -> (Vec<u8>, Outcome) {
    let whole = Place::new(recipe);
    let outcome = whole.fit();
    let broken = Place::new(recipe);
    let mut runs = 1;
    while !fit(&broken.recipe(), &Impatient).unwrap().finished {
        assert!(!broken.0.path().join("a.pack").exists(), "a pack is there whole or not at all");
        runs += 1;
        assert!(runs < 60, "it never ends");
    }
    assert!(whole.pack() == broken.pack(), "ended {runs} times, other bytes");
    if outcome.made > 1 {
        assert!(runs >= outcome.made, "{runs} runs for {} models", outcome.made);
    }
    (whole.pack(), outcome)
}

#[test]
fn segments_in_two_ensembles_of_which_one_is_split_open_in_the_model() {
    let (bytes, outcome) = both_ways(&segments());
    let pack = Pack::open("a", &bytes).unwrap();
    classify::Learned::read(&pack).unwrap();
    let shapes: Vec<_> = pack.head.ensembles.iter().map(|e| (e.folds, e.rounds)).collect();
    assert_eq!(shapes, [(2, 2), (2, 1), (2, 1)]);
    assert_eq!(outcome.made, 2 + 2 * 2 + 4, "a model for every fold and round");
    assert_eq!(pack.setting(classify::ROUNDS), Ok(3.0));
    let name = "ensemble 1, round 0, out of fold: mean IoU";
    let mean = pack.head.origin.metrics[name];
    assert!(mean > 0.1 && mean <= 1.0, "{:?}", pack.head.origin.metrics);
    let origin = &pack.head.origin;
    assert_eq!(origin.recipe.as_deref(), Some(&*segments()));
    assert!(origin.commit.is_some() && origin.data.contains_key("sizes.pack"), "{origin:?}");
    assert!(!origin.data.contains_key("axes.pack"), "axes are not asked");
}

#[test]
fn ranges_open_in_the_model() {
    let (bytes, outcome) = both_ways(&ranges());
    let pack = Pack::open("a", &bytes).unwrap();
    range_model::Learned::read(&pack).unwrap();
    assert_eq!(
        outcome.made,
        4 * range_model::FOLDS,
        "of amounts and of ways, of slides and of turns"
    );
    assert!(outcome.metrics.keys().any(|name| name.starts_with("turn, out of fold, fused")));
}

#[test]
fn axes_open_in_the_model() {
    let (bytes, outcome) = both_ways(&axes());
    let pack = Pack::open("a", &bytes).unwrap();
    axis_model::Learned::read(&pack).unwrap();
    assert_eq!(outcome.made, 2 * (axis_model::FOLDS + 1), "forests and a network for both joints");
    assert!(pack.head.origin.data.contains_key("segments.pack"));
}

#[test]
fn confidence_opens_in_the_model_with_a_calibration_of_every_question() {
    use model::classic::confidence::{FOLDS, Learned, QUESTIONS, settings};
    let (bytes, outcome) = both_ways(&confidence());
    let pack = Pack::open("a", &bytes).unwrap();
    Learned::read(&pack).unwrap();
    assert_eq!(outcome.made, QUESTIONS.len() * FOLDS);
    for (question, _) in QUESTIONS {
        let line = settings(question).map(|name| pack.setting(&name).unwrap());
        assert!(line.iter().all(|n| n.is_finite()), "{question}: {line:?}");
    }
    let name = "labels, out of fold, own families, half open: right";
    assert!((0.0..=1.0).contains(&outcome.metrics[name]), "{:?}", outcome.metrics);
    assert!(pack.head.origin.data.contains_key("ranges.pack"), "{:?}", pack.head.origin.data);
}

#[test]
fn priors_open_as_the_model_reads_them() {
    use model::classic::lexicon::sizes;
    use model::classic::segment::grow::{evidence, fused_unary};
    use model::classic::segment::prompts::roles;
    type Asked = (&'static str, String, Vec<String>, &'static str, Vec<(String, usize)>);
    let own = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
    let all = |names: &[&str], count: usize| {
        names.iter().map(|name| (name.to_string(), count)).collect::<Vec<_>>()
    };
    let cases: [Asked; 4] = [
        (
            "contacts",
            "ridge = 1.0\n".into(),
            own(&evidence::NAMES),
            evidence::TABLE,
            all(&[evidence::SECTION], evidence::NAMES.len()),
        ),
        ("sizes", String::new(), own(&sizes::NAMES), sizes::TABLE, all(&sizes::CLASSES, 2)),
        (
            "roles",
            "ridge = 1.0\ncandidates = 300\n".into(),
            own(&roles::names()),
            roles::TABLE,
            all(&roles::rows(), roles::WEIGHTS),
        ),
        (
            "fused_unary",
            "ridge = 0.1\nfused = '32'\n".into(),
            own(&fused_unary::NAMES),
            fused_unary::TABLE,
            all(&fused_unary::SECTIONS, fused_unary::FEATURES),
        ),
    ];
    for (fit, more, names, table, sections) in cases {
        let recipe = prior(fit, &more);
        let (place, again) = (Place::new(&recipe), Place::new(&recipe));
        place.fit();
        again.fit();
        assert!(place.pack() == again.pack(), "{fit}: same recipe, same bytes");
        let bytes = place.pack();
        let pack = Pack::open(fit, &bytes).unwrap();
        pack.is(fit).unwrap();
        pack.asks(table, &names).unwrap();
        assert_eq!(pack.head.sections.len(), sections.len(), "{fit}");
        for (place, (section, count)) in sections.into_iter().enumerate() {
            // Roles that no object has learn nothing; the first row counts for all.
            let numbers = pack.numbers(&section, count).unwrap();
            let is_learned = numbers.iter().any(|n| n.abs() > 1e-3);
            assert!(is_learned || fit == "roles" && place > 0, "{fit}, {section}: {numbers:?}");
        }
        if fit == "fused_unary" {
            assert!(pack.setting(fused_unary::BASE_BIAS).unwrap().is_finite());
        }
        assert!(!pack.head.origin.metrics.is_empty(), "{fit}");
    }
}

#[test]
fn forests_are_taken_over_only_where_the_recipe_asks_for_the_same() {
    let place = Place::new(&ranges());
    let first = place.fit();
    let (bytes, second) = (place.pack(), place.fit());
    assert_eq!((first.found, second.made, second.found), (0, 0, 0), "taken over whole");
    assert_eq!((place.pack() == bytes, &second.metrics), (true, &first.metrics));
    let other = |from: &str, to: &str| {
        std::fs::write(place.recipe(), ranges().replace(from, to)).unwrap();
        let outcome = place.fit();
        (outcome.made, outcome.found)
    };
    assert_eq!(other("fit =", "# Said otherwise.\nfit ="), (0, first.made));
    assert_eq!(other("seed = 7", "seed = 107"), (first.made, 0));
    assert_eq!(other("each = 2", "each = 3"), (first.made, 0));
}

#[test]
fn finished_ensembles_are_not_read_again() {
    let place = Place::new(&segments());
    assert!(place.fit().made > 0);
    std::fs::write(place.recipe(), segments().replace("rounds = 3", "rounds = 1")).unwrap();
    let listener = Listener(Mutex::new(Vec::new()), AtomicUsize::new(0));
    assert!(fit(&place.recipe(), &listener).unwrap().finished);
    let said = listener.0.into_inner().unwrap();
    assert_eq!(said.iter().filter(|l| l.contains("taken over whole")).count(), 2, "{said:?}");
    assert_eq!(listener.1.into_inner(), 0, "nobody asks whether to go on");
    let bytes = place.pack();
    assert_eq!(Pack::open("a", &bytes).unwrap().setting(classify::ROUNDS), Ok(1.0));
}

#[test]
fn a_recipe_that_will_not_do_is_refused_by_file_field_and_finding() {
    let told = |recipe: &str| Place::new(recipe).refused();
    let unknown = told(&ranges().replace("fused", "skin"));
    assert!(
        unknown.contains("recipe.toml: ") && unknown.contains("unknown field `skin`"),
        "{unknown}"
    );
    let unknown = told(&ranges().replace("trees = 3", "tree = 3"));
    assert!(unknown.contains("unknown field `tree`"), "{unknown}");
    let missing = told(&format!("{}[data]\ntrain = 'nowhere'\n", ranges()));
    let rule = "`data.train` must be a folder of shards, found none at ";
    assert!(missing.contains(rule) && missing.ends_with("nowhere"), "{missing}");
    let fit = told(&ranges().replace("'ranges'", "'range'"));
    assert!(fit.contains("`fit` must be one of segments, axes") && fit.contains("range"), "{fit}");
    let family = told(&ranges().replace("\"globe\"", "\"sofa\""));
    assert!(family.contains("there is no family `sofa`"), "{family}");
    let growth = told(&ranges().replace("leaves = 4", "leaves = 1"));
    assert!(growth.contains("model.growth: `leaves` must be from 2"), "{growth}");
    let split = told(&segments().replace("split = 2", "split = 3"));
    assert!(split.contains("model.ensemble, number 2: `folds` must be a multiple"), "{split}");
    let cut = told(&segments().replace("fused = ['32']", "fused = ['32']\ncut = 1"));
    assert!(cut.contains("`cut` must be 0 where `fused` is given"), "{cut}");
    let none = told(&ranges().replace("each = 2", "each = 0"));
    assert!(none.contains("there is nothing to learn from"), "{none}");
    let cells = told(&ranges().replace("'32'", "'4'"));
    assert!(cells.contains("between 8 and 256 cells"), "{cells}");
    assert_eq!(
        FitError::Nothing("ranges").to_string(),
        "there is nothing to learn ranges from: no object of the recipe shows any"
    );
}

/// A shard of some of our own objects as records of a split.
fn shard(folder: &Path, ids: &[&str], split: &str) {
    std::fs::create_dir_all(folder).unwrap();
    let mut archive = tar::Builder::new(Vec::new());
    for (i, family) in ids.iter().enumerate() {
        let Specimen { id, object, .. } = worded(Id::new(family, i).unwrap(), 5).unwrap();
        let mut truth = TruthFile::of(&object);
        (truth.record_id, truth.split) = (format!("rec_{i}"), split.into());
        (truth.category, truth.source) = ((*family).into(), "test".into());
        for (part, said) in truth.parts.iter_mut().zip(object.tree().parts()) {
            part.name.clone_from(&said.text);
        }
        let labels: Vec<u8> = object.part_of_face().iter().flat_map(|l| l.to_le_bytes()).collect();
        let files = [
            ("mesh.glb", object::glb::write(object.mesh())),
            ("face_labels.u16le", labels),
            ("truth.json", serde_json::to_vec(&truth).unwrap()),
        ];
        for (name, bytes) in files {
            let mut header = tar::Header::new_gnu();
            header.set_size(bytes.len() as u64);
            header.set_mode(0o644);
            archive.append_data(&mut header, format!("{id}/{name}"), &*bytes).unwrap();
        }
    }
    let plain = archive.into_inner().unwrap();
    std::fs::write(folder.join("shard-000.tar.zst"), zstd::encode_all(&plain[..], 1).unwrap())
        .unwrap();
}

#[test]
fn shards_are_learned_from_by_name_and_an_excluded_record_ends_the_run() {
    let recipe =
        prior("sizes", "[data]\ntrain = 'train'\nvalidation = 'val'\nheld_out = ['held.csv']\n");
    let place = Place::new(&recipe);
    let at = |name: &str| place.0.path().join(name);
    shard(&at("train"), &["desk", "keypad"], "train");
    shard(&at("val"), &["door"], "val");
    std::fs::write(at("held.csv"), "record_id\nrec_9\n").unwrap();
    place.fit();
    let bytes = place.pack();
    let origin = Pack::open("a", &bytes).unwrap().head.origin;
    let files: Vec<&str> = origin.data.keys().map(String::as_str).collect();
    assert_eq!(files, ["held.csv", "train/shard-000.tar.zst", "val/shard-000.tar.zst"]);
    let shard_bytes = std::fs::read(at("train/shard-000.tar.zst")).unwrap();
    let digest = blake3::hash(&shard_bytes).to_hex().to_string();
    assert_eq!(origin.data["train/shard-000.tar.zst"], digest);
    assert!(origin.metrics.contains_key("validation, base: mean"), "{:?}", origin.metrics);

    std::fs::write(at("held.csv"), "record_id\nrec_1\n").unwrap();
    let told = place.refused();
    assert!(told.contains("keypad-1") && told.contains("record `rec_1` is held out"), "{told}");
    std::fs::remove_dir_all(at("val")).unwrap();
    shard(&at("val"), &["door"], "train");
    std::fs::write(at("held.csv"), "record_id\nrec_9\n").unwrap();
    assert!(place.refused().contains("it belongs to split `train`, expected `val`"));
    let listless = Place::new(&recipe.replace("held_out = ['held.csv']\n", ""));
    shard(&listless.0.path().join("train"), &["desk"], "train");
    shard(&listless.0.path().join("val"), &["door"], "val");
    assert!(listless.refused().contains("`data.held_out` must name a list"));
}

#[test]
fn two_runs_do_not_work_in_one_folder() {
    let place = Place::new(&prior("sizes", ""));
    std::fs::create_dir_all(place.0.path().join("run")).unwrap();
    let _lock = alone(&place.0.path().join("run")).unwrap();
    assert!(place.refused().contains("is in use by another run"));
}

#[test]
fn every_recipe_that_ships_is_sound() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes");
    let mut packs = std::collections::BTreeSet::new();
    for recipe in std::fs::read_dir(folder).unwrap() {
        let path = recipe.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        if fit_of(&path).unwrap().is_none() {
            continue;
        }
        let table: toml::Table = toml::from_str(&text).unwrap();
        let pack = Path::new(table["pack"].as_str().unwrap());
        packs.insert(pack.file_stem().unwrap().to_string_lossy().into_owned());
        match check(&path) {
            Ok(()) => {}
            // Shards lie beside the repository, or not at all.
            Err(error) => {
                assert!(error.to_string().contains("must be a folder of shards"), "{error}")
            }
        }
    }
    let shipped: Vec<String> = classic::digests().into_keys().map(String::from).collect();
    assert_eq!(packs.into_iter().collect::<Vec<_>>(), shipped, "a recipe for every pack");
}
