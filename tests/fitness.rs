//! How fit made assets are: the tier they reach, how tight their collision pieces are, and whether
//! what moves is closed; from the true labels and joints, and of whatever folders hold assets.
//!
//! `KINFOLD_SHARED` has the cases; `KINFOLD_ASSETS` names a folder of assets made from them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use asset::{BuildOptions, build};
use object::mesh::Bounds;
use object::weld::Weld;
use object::{ArticulatedObject, DVec3, KinematicTree, Mesh, Origin, Part, Range};
use serde_json::Value;
use sim_check::{CheckOptions, Provenance, Tier};
use training::evaluate::case::Case;
use training::truth::TruthFile;
use workflow::stages::repair::repaired;

use crate::{cases, clients, examples};

/// Largest ratio of the pieces' volumes to what a link fills, and most pieces of a link.
const TIGHT: f64 = 1.2;
const PIECES: usize = 32;

/// What was found about the assets of one origin.
#[derive(Default)]
struct Fitness {
    tiers: BTreeMap<Tier, usize>,
    failures: BTreeMap<String, usize>,
    /// Ratio of the space that pieces fill to that of their link, where that is known, and the same
    /// with the pieces' volumes added up.
    ratios: Vec<f64>,
    sums: Vec<f64>,
    /// Links whose pieces fill too much, by how much, and how many pieces they have.
    loose: Vec<String>,
    links: usize,
    most_pieces: usize,
    moving: usize,
    closed: usize,
    /// Parts by what was altered about them.
    changes: BTreeMap<String, usize>,
}

impl Fitness {
    /// Reads a package and checks it.
    fn add(&mut self, folder: &Path) -> Tier {
        let options = CheckOptions {
            up_to: Tier::Dynamic,
            provenance: Provenance::default(),
            ..CheckOptions::default()
        };
        let verdict = sim_check::check(&folder.join("asset.urdf"), &options);
        *self.tiers.entry(verdict.tier).or_default() += 1;
        for check in verdict.failures().filter(|_| verdict.tier < Tier::Dynamic) {
            *self.failures.entry(check.id.clone()).or_default() += 1;
        }
        let about = std::fs::read(folder.join("asset.json")).unwrap();
        let about: Value = serde_json::from_slice(&about).unwrap();
        for change in about["changes"].as_array().into_iter().flatten() {
            *self.changes.entry(change["what"].as_str().unwrap().into()).or_default() += 1;
        }
        let fixed = |l: &&Value| {
            let joints = about["joints"].as_array().unwrap();
            let own = joints.iter().find(|j| j["child"] == l["name"]);
            own.is_none_or(|j| j["type"] == "fixed")
        };
        for link in about["links"].as_array().unwrap().iter().filter(|l| l["visual"].is_string()) {
            self.links += 1;
            self.weigh_pieces(folder, link);
            if !fixed(&link) {
                self.moving += 1;
                let mesh = mesh(&folder.join(link["visual"].as_str().unwrap()));
                self.closed += usize::from(is_closed(&mesh));
            }
        }
        verdict.tier
    }

    fn weigh_pieces(&mut self, folder: &Path, link: &Value) {
        let pieces = link["collision"].as_array().unwrap();
        self.most_pieces = self.most_pieces.max(pieces.len());
        let pieces: Vec<Mesh> =
            pieces.iter().map(|p| mesh(&folder.join(p.as_str().unwrap()))).collect();
        let volume = link["volume"]["value"].as_f64().unwrap();
        let is_known = link["volume"]["how"].as_str().unwrap().contains("closed bodies");
        if is_known && volume > 0.0 {
            let sum: f64 = pieces.iter().map(Mesh::signed_volume).sum();
            self.sums.push(sum / volume);
            // What is in several pieces is filled once, as in several bodies of the surface.
            let all = if sum <= TIGHT * volume { sum } else { filled(&pieces) };
            self.ratios.push(all / volume);
            if all > TIGHT * volume {
                let (asset, name) = (folder.file_name().unwrap().display(), &link["name"]);
                let ratio = all / volume;
                self.loose.push(format!("{ratio:.2} {} pieces: {asset} {name}", pieces.len()));
            }
        }
    }

    fn say(&self, of: &str) {
        let all: usize = self.tiers.values().sum();
        let share = |n: usize, of: usize| 100.0 * n as f64 / of.max(1) as f64;
        let dynamic = self.tiers.get(&Tier::Dynamic).copied().unwrap_or_default();
        let tight = |ratios: &[f64]| ratios.iter().filter(|r| **r <= TIGHT).count();
        println!("{of}: {dynamic} of {all} reach dynamic; {:?}", self.tiers);
        println!("  checks that keep the others: {:?}", self.failures);
        println!(
            "  pieces to volume <= {TIGHT} on {:.1} % (added up {:.1} %) of {} links (of {} in all); at most {} pieces",
            share(tight(&self.ratios), self.ratios.len()),
            share(tight(&self.sums), self.sums.len()),
            self.ratios.len(),
            self.links,
            self.most_pieces
        );
        self.loose.iter().for_each(|link| println!("    {link}"));
        let closed = share(self.closed, self.moving);
        println!("  closed: {closed:.1} % of {} moving links", self.moving);
        println!("  altered: {:?}", self.changes);
    }
}

/// A convex body: its box, and its sides as outward normals with their distance from the origin.
type Sides = (Bounds, Vec<(DVec3, f64)>);

/// The space that convex pieces fill together, m³, to about half a percent: of points spread through
/// each, every one counts by how many pieces hold it.
fn filled(pieces: &[Mesh]) -> f64 {
    const SPREAD: u32 = 24;
    let sides = |m: &Mesh| -> Vec<(DVec3, f64)> {
        (0..m.faces().len()).map(|f| (m.normal(f), m.normal(f).dot(m.corners(f)[0]))).collect()
    };
    let all: Vec<Sides> = pieces.iter().map(|m| (m.bounds(), sides(m))).collect();
    let holds = |(bounds, sides): &Sides, p: DVec3| {
        let near = bounds.min.cmple(p).all() && bounds.max.cmpge(p).all();
        near && sides.iter().all(|(normal, offset)| normal.dot(p) <= *offset)
    };
    let of_piece = |(piece, mesh): (&Sides, &Mesh)| {
        let (min, size) = (piece.0.min, piece.0.size());
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(SPREAD);
        let (mut inside, mut shares) = (0.0, 0.0);
        for n in 0..SPREAD.pow(3) {
            let place = [n % SPREAD, n / SPREAD % SPREAD, n / SPREAD.pow(2)].map(at);
            let p = min + size * DVec3::from(place);
            if holds(piece, p) {
                inside += 1.0;
                shares += 1.0 / all.iter().filter(|other| holds(other, p)).count() as f64;
            }
        }
        if inside > 0.0 { mesh.signed_volume() * shares / inside } else { mesh.signed_volume() }
    };
    all.iter().zip(pieces).map(of_piece).sum()
}

fn mesh(path: &Path) -> Mesh {
    let text = std::fs::read_to_string(path).unwrap();
    object::obj::read(&text, object::mesh::UpAxis::Z).unwrap()
}

/// Whether every edge is walked as often one way as the other.
fn is_closed(mesh: &Mesh) -> bool {
    let mut walks: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for [a, b, c] in Weld::new(mesh).faces {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            *walks.entry([p.min(q), p.max(q)]).or_default() += if p < q { 1 } else { -1 };
        }
    }
    walks.into_iter().all(|([p, q], sum)| p == q || sum == 0)
}

/// The object of a case as its truth has it.
fn true_object(folder: &Path, case: &Case) -> ArticulatedObject {
    let truth = TruthFile::from_json(&std::fs::read(folder.join("truth.json")).unwrap()).unwrap();
    let mut motions = truth.motions(case.mesh.frame()).unwrap();
    for motion in motions.iter_mut().flatten() {
        // What another model predicted may leave out the pose it is shown in.
        if let Range::Limits { lower, upper } = motion.range {
            motion.range = Range::Limits { lower: lower.min(0.0), upper: upper.max(0.0) };
        }
    }
    let named = case.condition.tree.parts().iter().zip(&motions);
    let part = |(part, motions): (&Part, &Vec<object::JointMotion>)| Part {
        joints: motions.iter().map(|m| m.kind).collect(),
        ..part.clone()
    };
    let tree = KinematicTree::new(named.map(part).collect()).unwrap();
    ArticulatedObject::new(case.mesh.clone(), tree, case.part_of_face.clone(), motions).unwrap()
}

/// Builds the asset of a case from its truth; `Err` says why there is none.
fn build_truth(folder: &Path, out: &Path) -> Result<(), String> {
    let case = Case::read(folder).map_err(|e| e.to_string())?;
    let object = true_object(folder, &case);
    let map: Vec<_> = (0..object.tree().len()).map(Some).collect();
    let options = BuildOptions { joints: Origin::User, ..BuildOptions::default() };
    let asset = build(&object, &case.condition, &map, &options).map_err(|e| e.to_string())?;
    let scratch = tempfile::tempdir().unwrap();
    let asset = repaired(asset, options.seed, scratch.path()).map_err(|e| e.to_string())?;
    for (name, bytes) in &asset.to_urdf().files {
        let path = out.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    Ok(())
}

/// Every unfused development case, or those whose name holds `KINFOLD_CASES`.
fn chosen() -> Vec<PathBuf> {
    let only = std::env::var("KINFOLD_CASES").unwrap_or_default();
    let name = |c: &PathBuf| c.file_name().unwrap().to_string_lossy().into_owned();
    let mut all = cases::dev_cases().unwrap_or_default();
    all.retain(|c| !name(c).ends_with("-fused") && name(c).contains(&only));
    all
}

#[test]
fn examples_are_tight_closed_and_of_few_pieces() {
    let out = tempfile::tempdir().unwrap();
    let mut fitness = Fitness::default();
    for urdf in examples::made(out.path()) {
        fitness.add(urdf.parent().unwrap());
    }
    fitness.say("examples");
    assert!(fitness.sums.iter().all(|r| *r <= TIGHT), "{:?}", fitness.sums);
    assert!(fitness.most_pieces <= PIECES && fitness.closed == fitness.moving);
}

#[test]
#[ignore = "ten minutes: builds every unfused development case from its truth and checks it"]
fn how_fit_are_assets_of_true_parts_and_joints() {
    let keep = std::env::var_os("KINFOLD_KEEP").map(PathBuf::from);
    let temporary = tempfile::tempdir().unwrap();
    let out = keep.unwrap_or_else(|| temporary.path().to_path_buf());
    let (fitness, queue) = (Mutex::new(Fitness::default()), Mutex::new(chosen().into_iter()));
    let work = || loop {
        let next = queue.lock().unwrap().next();
        let Some(case) = next else { return };
        let folder = out.join(case.file_name().unwrap());
        match build_truth(&case, &folder) {
            Ok(()) => {
                let mut own = Fitness::default();
                let tier = own.add(&folder);
                println!("{:9} {} {:?}", tier.name(), case.display(), own.failures);
                fitness.lock().unwrap().merge(own);
            }
            Err(reason) => {
                println!("none      {} {reason}", case.display());
                *fitness.lock().unwrap().tiers.entry(Tier::None).or_default() += 1;
            }
        }
    };
    std::thread::scope(|s| {
        s.spawn(work);
        s.spawn(work);
    });
    fitness.into_inner().unwrap().say("true labels and joints");
}

#[test]
#[ignore = "minutes: checks every asset in the folder KINFOLD_ASSETS names"]
fn how_fit_are_made_assets() {
    let mut fitness = Fitness::default();
    for folder in clients::more_assets() {
        let mut own = Fitness::default();
        let tier = own.add(&folder);
        println!("{:9} {} {:?}", tier.name(), folder.display(), own.failures);
        fitness.merge(own);
    }
    fitness.say("made assets");
}

impl Fitness {
    fn merge(&mut self, other: Self) {
        let add = |to: &mut BTreeMap<String, usize>, from: BTreeMap<String, usize>| {
            from.into_iter().for_each(|(key, n)| *to.entry(key).or_default() += n);
        };
        other.tiers.into_iter().for_each(|(t, n)| *self.tiers.entry(t).or_default() += n);
        add(&mut self.failures, other.failures);
        add(&mut self.changes, other.changes);
        self.ratios.extend(other.ratios);
        self.sums.extend(other.sums);
        self.loose.extend(other.loose);
        self.links += other.links;
        self.most_pieces = self.most_pieces.max(other.most_pieces);
        self.moving += other.moving;
        self.closed += other.closed;
    }
}
