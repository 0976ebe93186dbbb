//! Whether built assets that are wrong are flagged, by the checks of group R as a verdict has them.
//!
//! `cargo run --release -p kinfold-workflow --example measure_verdicts -- (kinds[:SEED] | CASES) [amended | truth]`
//!
//! `kinds` are the forty objects in which a mistake is likely, from the seed of judging unless another is given;
//! `CASES` is a folder of cases. With `amended`, joints are amended by what the verdict finds, as `make` does;
//! without, assets are judged as they are first built. With `truth`, the truth is built, and what else the
//! checks of joints and contact find is told: whether the objects themselves are sound. A line for each object:
//! right or wrong, and what is flagged; then a sum for each kind, or for all: right, flagged where wrong, flagged
//! elsewhere alone, neither, and findings in objects that are right.

#![allow(clippy::print_stdout, reason = "what it measures goes to whoever reads it")]

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use asset::{Asset, Measures, finish, shape};
use model::{Articulation, Prepared};
use object::{ArticulatedObject, Condition, JointMotion, Mesh, Origin, Range};
use sim_check::{CheckOptions, Status, Tier, Verdict, check};
use training::evaluate::case::{Case, folders};
use training::evaluate::doubts::Judged;
use training::evaluate::solver::links;
use training::metrics::Link;
use training::procedural::pitfalls::{DESIGNS, JUDGED, PITFALLS, Question};
use workflow::stages::repair::repaired;

type Failure = Box<dyn Error + Send + Sync>;

/// Right; flagged where wrong; flagged elsewhere alone; neither; findings in objects that are right.
type Sum = [usize; 5];

#[derive(Clone, Copy)]
struct How {
    is_amended: bool,
    is_truth: bool,
}

/// An object, what is asked, and the truth.
struct Subject<'a> {
    name: &'a str,
    mesh: &'a Mesh,
    part_of_face: &'a [u16],
    links: &'a [Link],
    condition: &'a Condition,
    leads_back: bool,
    truth: Option<&'a ArticulatedObject>,
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let root = arguments
        .first()
        .ok_or("usage: measure_verdicts (kinds[:SEED] | CASES) [amended | truth]")?;
    let says = |word: &str| arguments.iter().skip(1).any(|a| a == word);
    let how = How { is_amended: says("amended"), is_truth: says("truth") };
    let mut sums: BTreeMap<String, Sum> = BTreeMap::new();
    if let Some(seed) = root.strip_prefix("kinds") {
        let seed = seed.strip_prefix(':').map_or(Ok(JUDGED), str::parse)?;
        for kind in &PITFALLS {
            for index in 0..DESIGNS {
                let Question { specimen, condition } = kind.make(index, seed)?;
                let object = &specimen.object;
                let subject = Subject {
                    name: &specimen.id,
                    mesh: object.mesh(),
                    part_of_face: object.part_of_face(),
                    links: &links(&whole(object)),
                    condition: &condition,
                    leads_back: kind.leads_back(),
                    truth: Some(object),
                };
                measured(&subject, how, sums.entry(kind.name.into()).or_default())?;
            }
        }
    } else {
        for folder in folders(Path::new(root))? {
            let case = Case::read(&folder)?;
            let subject = Subject {
                name: &case.name,
                mesh: &case.mesh,
                part_of_face: &case.part_of_face,
                links: &case.links,
                condition: &case.condition,
                leads_back: false,
                truth: None,
            };
            if let Err(why) = measured(&subject, how, sums.entry("cases".into()).or_default()) {
                println!("{}: {why}", case.name);
            }
        }
    }
    println!("right, flagged where wrong, flagged elsewhere, neither; findings in right objects");
    sums.iter().for_each(|(name, sum)| println!("{name}: {sum:?}"));
    let total = |at: usize| sums.values().map(|sum| sum[at]).sum::<usize>();
    println!("all: {:?}", [0, 1, 2, 3, 4].map(total));
    Ok(())
}

/// An articulation that is the object itself.
fn whole(object: &ArticulatedObject) -> Articulation {
    Articulation {
        object: object.clone(),
        part_of_condition: (0..object.tree().len()).map(Some).collect(),
        notes: Vec::new(),
        confidence: None,
    }
}

fn measured(subject: &Subject, how: How, sum: &mut Sum) -> Result<(), Failure> {
    let made = match subject.truth.filter(|_| how.is_truth) {
        Some(object) => whole(object),
        None => Prepared::new(subject.mesh)?.articulate(subject.condition, 0)?.0,
    };
    let shapes = shape(&made.object, &Measures::of(subject.condition), &made.part_of_condition, 0)?;
    let shapes = shapes.with_confidence(made.confidence.clone());
    let mut asset = finish(shapes, subject.condition, Origin::Model)?;
    let scratch = tempfile::tempdir()?;
    if how.is_amended {
        asset = repaired(asset, 0, scratch.path())?;
    }
    let made = Articulation { object: as_built(&made.object, &asset)?, ..made };
    let truth = (subject.mesh, subject.part_of_face, subject.links);
    let judged = Judged::of(truth, &made, subject.leads_back);
    let up_to = if how.is_truth { Tier::Kinematic } else { Tier::Static };
    let verdict = verdict(&asset, scratch.path(), up_to)?;
    let is_ours = |id: &str| {
        let groups: &[char] = if how.is_truth { &['J', 'C', 'R'] } else { &['R'] };
        id.starts_with(groups)
    };
    let failed = verdict.checks.iter().filter(|c| is_ours(&c.id) && c.status == Status::Fail);
    let found: Vec<String> =
        failed.flat_map(|c| c.evidence.iter().map(|told| format!("{} {told}", c.id))).collect();
    let wrong = made.part_of_condition.iter().zip(&judged.parts);
    let wrong: Vec<usize> =
        wrong.filter(|(_, part)| part.is_wrong).filter_map(|(part, _)| *part).collect();
    let links = asset.links.iter().filter(|link| wrong.contains(&link.part)).map(|l| &l.name);
    let joints = asset.joints.iter().filter(|j| wrong.contains(&asset.links[j.child].part));
    let mut wrong = links.chain(joints.map(|j| &j.name)).map(|name| format!("`{name}`"));
    let (place, word) = if judged.is_right() {
        sum[4] += found.len();
        (0, "right")
    } else if wrong.any(|name| found.iter().any(|told| told.contains(&name))) {
        (1, "wrong, flagged")
    } else if found.is_empty() {
        (3, "wrong, not flagged")
    } else {
        (2, "wrong, flagged elsewhere")
    };
    sum[place] += 1;
    println!("{}: {word} {found:?}", subject.name);
    Ok(())
}

/// What the checks say of an asset.
fn verdict(asset: &Asset, scratch: &Path, up_to: Tier) -> Result<Verdict, Failure> {
    let folder = scratch.join("asset");
    for (name, bytes) in &asset.to_urdf().files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap_or(&folder))?;
        std::fs::write(path, bytes)?;
    }
    let options = CheckOptions { up_to, ..CheckOptions::default() };
    Ok(check(&folder.join("asset.urdf"), &options))
}

/// The object with the axes and ranges of the asset that was built of it.
fn as_built(object: &ArticulatedObject, asset: &Asset) -> Result<ArticulatedObject, Failure> {
    let part = |part: usize| {
        let of_part = asset.joints.iter().filter(|j| asset.links[j.child].part == part);
        let built = of_part.filter_map(|joint| joint.motion.as_ref());
        let one = |(motion, built): (&JointMotion, &asset::Motion)| {
            let unit = if motion.kind.turns() { 1.0 } else { 1.0 / asset.scale.value };
            let range = match &built.limits {
                Some([lower, upper]) => {
                    Range::Limits { lower: lower.value * unit, upper: upper.value * unit }
                }
                None => Range::Continuous,
            };
            let axis = (asset.turn.inverse() * built.axis.value).normalize();
            JointMotion { axis, range, ..*motion }
        };
        object.joints(part).iter().zip(built).map(one).collect::<Vec<_>>()
    };
    let joints = (0..object.tree().len()).map(part).collect();
    let (mesh, labels) = (object.mesh().clone(), object.part_of_face().to_vec());
    Ok(ArticulatedObject::new(mesh, object.tree().clone(), labels, joints)?)
}
