//! How long each stage of the flow takes, on an object of our own and, where the shared data lies
//! beside the repository (or where `KINFOLD_SHARED` says), on one generator mesh of 40,000 faces.
//!
//! `cargo bench --workspace --bench stages`; each stage works on what the one before it made.

#![allow(missing_docs, reason = "criterion's macros write undocumented functions")]
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a bench stops and says why")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use adapters::{ConditionFile, GeneratedMesh, MeshFile, Photo};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, SamplingMode, criterion_group, criterion_main};
use object::Condition;
use runner::Stage;
use trace::{Digest, Manifest, Recorder};
use workflow::Tools;
use workflow::stages::{
    Articulate, BuildAsset, CheckInSim, Checked, GenerateMesh, ProposeCondition, RenderViews,
    SelectMeasures, SelectPrompts, ShapeParts, TransferAppearance, UrdfPackage, Views, WriteUrdf,
};

/// One photo with the files that answer for the generator and the VLM.
struct Case {
    name: &'static str,
    photo: PathBuf,
    tools: Tools,
    scratch: tempfile::TempDir,
}

impl Case {
    fn new(name: &'static str, folder: &Path, photo: &str) -> Self {
        let scratch = tempfile::tempdir().unwrap();
        let tools = Tools {
            image_to_3d: Box::new(MeshFile { path: folder.join("mesh.glb"), ..Default::default() }),
            vlm: Box::new(ConditionFile {
                path: folder.join("condition.json"),
                ..Default::default()
            }),
            critic: None,
            articulate: Box::new(model::Geometric),
            seed: 0,
            scratch: scratch.path().to_owned(),
        };
        Self { name, photo: folder.join(photo), tools, scratch }
    }

    /// Times a stage and hands on what it makes.
    fn stage<S: Stage<Tools>>(
        &self,
        group: &mut BenchmarkGroup<'_, WallTime>,
        stage: &S,
        input: impl Fn() -> S::Input,
    ) -> Arc<S::Output> {
        group.bench_function(S::NAME, |b| b.iter(|| stage.run(input(), &self.tools).unwrap()));
        Arc::new(stage.run(input(), &self.tools).unwrap())
    }

    fn all_stages(&self, c: &mut Criterion) {
        let mut group = c.benchmark_group(self.name);
        group.sample_size(10).sampling_mode(SamplingMode::Flat);
        group.warm_up_time(Duration::from_millis(100)).measurement_time(Duration::from_secs(1));
        let photo = Arc::new(Photo::open(&self.photo).unwrap());
        let mesh = self.stage(&mut group, &GenerateMesh, || photo.clone());
        let views = self.stage(&mut group, &RenderViews, || mesh.clone());
        let condition = self
            .stage(&mut group, &ProposeCondition, || (photo.clone(), mesh.clone(), views.clone()));
        self.made(&mut group, (&mesh, &views, &condition));
        group.finish();
    }

    fn made(
        &self,
        group: &mut BenchmarkGroup<'_, WallTime>,
        (mesh, views, condition): (&Arc<GeneratedMesh>, &Views, &Arc<Condition>),
    ) {
        let prompts = self.stage(group, &SelectPrompts, || condition.clone());
        let object = self.stage(group, &Articulate, || (mesh.clone(), prompts.clone()));
        let measures = self.stage(group, &SelectMeasures, || condition.clone());
        let shapes = self.stage(group, &ShapeParts, || (object.clone(), measures.clone()));
        let asset = self.stage(group, &BuildAsset, || (shapes.clone(), condition.clone()));
        let of = || (asset.clone(), object.clone(), mesh.clone());
        let looks = self.stage(group, &TransferAppearance, of);
        let urdf = self.stage(group, &WriteUrdf, || (asset.clone(), looks.clone()));
        let checked = self.stage(group, &CheckInSim, || (urdf.clone(), condition.clone()));
        let path = self.scratch.path().join("trace.mcap");
        group.bench_function("trace", |b| b.iter(|| record(&path, views, &urdf, &checked)));
    }
}

/// A trace with what weighs most in one: the pictures, the asset's files, the motion.
fn record(path: &Path, views: &Views, urdf: &UrdfPackage, checked: &Checked) {
    let manifest = Manifest {
        run_id: Digest::of(b"bench").to_string(),
        flow: "bench".into(),
        version: "0".into(),
        seed: 0,
        inputs: BTreeMap::new(),
        parameters: BTreeMap::new(),
    };
    let mut recorder = Recorder::create(path, &manifest, 0).unwrap();
    for (name, png) in &views.0 {
        recorder.image(&format!("/views/{name}"), "png", png, 1).unwrap();
    }
    for (name, bytes) in &urdf.0 {
        recorder.attach(name, "application/octet-stream", bytes, 2).unwrap();
    }
    for (frame, at) in checked.motion.iter().zip(3..) {
        recorder.joints(&frame.joints, at).unwrap();
    }
    recorder.verdict(&serde_json::to_value(&checked.verdict).unwrap(), 4).unwrap();
    recorder.finish().unwrap();
}

fn stages(c: &mut Criterion) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    Case::new("cabinet", &root.join("examples/cabinet"), "photo.png").all_stages(c);
    let shared = std::env::var_os("KINFOLD_SHARED").map(PathBuf::from);
    let shared = shared.unwrap_or_else(|| root.join("../shared"));
    let folder = shared.join("data/cases/dev/paper__hy-eval-024");
    if folder.is_dir() {
        Case::new("paper", &folder, "image.png").all_stages(c);
    } else {
        eprintln!("SKIPPED: the paper case, {} is not there", folder.display());
    }
}

criterion_group!(benches, stages);
criterion_main!(benches);
