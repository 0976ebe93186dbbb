//! Grows the boosted trees that say how far a joint goes.
//!
//! `fit_reaches OUT TRAIN VAL EXCLUDED [--objects N] [--families N] [--skin RECIPE] [--seed N] [--trees N]
//! [--leaves N] [--rate R] [--share S] [--numbers S] [--curve C] [--hold C]`: writes
//! `turns_reach.trees` and `slides_reach.trees` into `OUT`, from folders of shards (`tar.zst`) and
//! objects of our own families; the list of records that must not be trained on ends the run where
//! they turn up. Every joint with limits is asked about with its true axis, on the object as it is
//! and, with a recipe of [`Recipe`], as a skin. The same shards give the same bytes. How trees
//! grow is said in [`training::forest::Growth`].

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use model::geometric::forest::{Forest, mean_chances};
use model::geometric::joints::{Labelled, shared_axis};
use model::geometric::range::usual;
use model::geometric::reach::{NOTHING, NUMBERS, VOICES, amounts, likeliest, likeness};
use model::geometric::scene::Scene;
use model::geometric::setting::Setting;
use model::geometric::sweep::Axis;
use object::weld::Weld;
use object::{ArticulatedObject, JointMotion, Range};
use rayon::prelude::*;
use training::dataset::Specimen;
use training::dataset::evalcase::specimen;
use training::dataset::library::{each, held_out};
use training::dataset::shards::Bundle;
use training::forest::{Bins, Growth, Lessons, Question, blind_voice};
use training::fuse::{Recipe, fused};
use training::procedural::{family_of, worded};
use training::truth::TruthFile;

type Anyhow = Box<dyn std::error::Error + Send + Sync>;

/// The seed of scenes.
const SCENE_SEED: u64 = 1;
/// A seed that nothing else is made with.
const FAMILY_SEED: u64 = 53;
/// Bins are chosen by every so many ends.
const SAMPLED: usize = 4;
/// How often the loss is told while a forest grows.
const TOLD: usize = 4;
/// Ends are right if they are off by at most this, and roughly right by this.
const OFF: [f64; 3] = [0.05, 0.1, 0.3];
/// How a forest grows where the command line says nothing else.
const GROWTH: Growth = Growth {
    trees: 300,
    leaves: 15,
    rate: 0.06,
    questions: 0.6,
    numbers: 0.8,
    curve: 4.0,
    hold: 10.0,
    seed: 7,
};

/// What is asked for on the command line.
struct Wanted {
    objects: usize,
    families: usize,
    skin: Option<Recipe>,
    growth: Growth,
}

/// One end of a range: of a joint first how far it goes along its axis, then how far back.
struct End {
    /// The voice whose forest is not grown on it.
    voice: usize,
    turns: bool,
    is_skin: bool,
    asked: Question<NUMBERS>,
    /// How far it is: radians, or lengths of the part.
    wanted: f64,
    usual: f64,
    free: f64,
    length: f64,
}

fn main() -> Result<(), Anyhow> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [out, train, val, excluded, rest @ ..] = &args[..] else {
        return Err("OUT TRAIN VAL EXCLUDED".into());
    };
    let wanted = wanted(rest)?;
    let excluded = held_out(Path::new(excluded))?;
    let every = Wanted { objects: usize::MAX, ..wanted };
    let val = read(Path::new(val), &every, ("val", &excluded))?;
    let mut train = read(Path::new(train), &wanted, ("train", &excluded))?;
    train.extend(own(&wanted)?);
    let out = Path::new(out);
    std::fs::create_dir_all(out)?;
    for (name, turns) in [("slides", false), ("turns", true)] {
        let own: Vec<&End> = train.iter().filter(|e| e.turns == turns).collect();
        let judged: Vec<&End> = val.iter().filter(|e| e.turns == turns).collect();
        let voices = grown(&own, &wanted.growth);
        let mut bytes = Vec::new();
        voices.iter().for_each(|v| v.write(&mut bytes));
        std::fs::write(out.join(format!("{name}_reach.trees")), bytes)?;
        let said = |voices: &[Forest<NUMBERS>], both: &[&End]| {
            let asked = |way: usize| mean_chances(voices, &both[way].asked.numbers);
            likeliest(turns, &[asked(0), asked(1)])
        };
        let usual = |both: &[&End]| [0, 1].map(|way| both[way].usual.min(both[way].free));
        report(&format!("{name}, train by others"), &own, |both| {
            said(&voices[both[0].voice..=both[0].voice], both)
        });
        report(&format!("{name}, train as is usual"), &own, usual);
        report(&format!("{name}, val"), &judged, |both| said(&voices, both));
        report(&format!("{name}, val as is usual"), &judged, usual);
    }
    Ok(())
}

/// Reports on joints, each two ends one after the other.
fn report(what: &str, ends: &[&End], said: impl Fn(&[&End]) -> [f64; 2]) {
    for (skin, sight) in [(false, "as it is"), (true, "as a skin")] {
        let joints: Vec<&[&End]> = ends.chunks_exact(2).filter(|e| e[0].is_skin == skin).collect();
        if joints.is_empty() {
            continue;
        }
        let said: Vec<[f64; 2]> = joints.iter().map(|both| said(both)).collect();
        for (way, name) in [(0, "ahead"), (1, "back")] {
            let off = |(both, said): (&&[&End], &[f64; 2])| {
                (said[way] - both[way].wanted).abs() * both[way].length
            };
            let off: Vec<f64> = joints.iter().zip(&said).map(off).collect();
            let count = off.len() as f64;
            let share =
                |most: f64| 100.0 * off.iter().filter(|o| **o <= most).count() as f64 / count;
            let [a, b, c] = OFF.map(share);
            let mean = off.iter().map(|o| o.min(1.0)).sum::<f64>() / count;
            let still = joints.iter().zip(&said);
            let still = still.filter(|(b, s)| s[way] == 0.0 && b[way].wanted > 0.1).count();
            eprintln!(
                "{what}, {sight}, {name}: {count} joints, {a:.1} {b:.1} {c:.1} %, off by {mean:.3}, \
                 {still} that move do not"
            );
        }
    }
}

/// A forest for each voice.
fn grown(ends: &[&End], growth: &Growth) -> Vec<Forest<NUMBERS>> {
    let bins = Bins::of(ends.iter().step_by(SAMPLED).flat_map(|e| &e.asked.numbers));
    let mut lessons = Lessons::new(&bins);
    ends.iter().for_each(|e| lessons.add(std::slice::from_ref(&e.asked)));
    let grow = |voice: usize| {
        let growth = Growth { seed: growth.seed + voice as u64, ..*growth };
        let knows = |end: usize| ends[end].voice != voice;
        lessons.grow(&growth, knows, |trees, loss| {
            if trees % (growth.trees / TOLD).max(1) == 0 {
                eprintln!("  {trees} trees: loss {loss:.4}");
            }
        })
    };
    (0..VOICES).into_par_iter().map(grow).collect()
}

fn wanted(args: &[String]) -> Result<Wanted, Anyhow> {
    let mut wanted = Wanted { objects: usize::MAX, families: 0, skin: None, growth: GROWTH };
    for pair in args.chunks(2) {
        let [what, value] = pair else { return Err("a value is missing".into()) };
        match what.as_str() {
            "--objects" => wanted.objects = value.parse()?,
            "--families" => wanted.families = value.parse()?,
            "--skin" => wanted.skin = Some(value.parse()?),
            _ if wanted.growth.take(what, value)? => {}
            _ => return Err(format!("unknown: {what}").into()),
        }
    }
    Ok(wanted)
}

fn read(
    folder: &Path,
    wanted: &Wanted,
    from: (&str, &BTreeSet<String>),
) -> Result<Vec<End>, Anyhow> {
    let one = |bundle: &Bundle| {
        let truth = TruthFile::from_json(&bundle.truth).map(|t| t.category);
        let found = specimen(bundle).and_then(|s| Ok((s, truth.map_err(|e| e.to_string())?)));
        match found {
            Ok((specimen, category)) => seen(&specimen, &category, wanted.skin.as_ref()),
            Err(e) => {
                eprintln!("{}: {e}", bundle.id);
                Vec::new()
            }
        }
    };
    let told = |shard: &Path, ends| eprintln!("{}: {ends} ends", shard.display());
    Ok(each(folder, wanted.objects, from, one, told)?)
}

/// The ends of objects of our own families, each in one of its wordings.
fn own(wanted: &Wanted) -> Result<Vec<End>, Anyhow> {
    let one = |number: usize| {
        let specimen = worded(number, FAMILY_SEED)?;
        Ok::<_, Anyhow>(seen(&specimen, &family_of(number).replace('_', " "), wanted.skin.as_ref()))
    };
    let made = (0..wanted.families).into_par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
    Ok(made.into_iter().flatten().collect())
}

fn seen(specimen: &Specimen, category: &str, skin: Option<&Recipe>) -> Vec<End> {
    let voice = blind_voice(&specimen.id, VOICES);
    let skin = skin.and_then(|recipe| fused(specimen, recipe).ok()).map(|s| s.object);
    let sights = [Some(specimen.object.clone()), skin].into_iter().enumerate();
    sights
        .flat_map(|(i, o)| o.map(|o| (i == 1, o)))
        .flat_map(|(s, o)| ends(&o, category, (s, voice)))
        .collect()
}

fn ends(object: &ArticulatedObject, category: &str, (is_skin, voice): (bool, usize)) -> Vec<End> {
    let mesh = object.mesh();
    let weld = Weld::new(mesh);
    let tree = object.tree();
    let from = Labelled { mesh, weld: &weld, tree, part_of_face: object.part_of_face(), category };
    let scene = Scene::new(&from, SCENE_SEED);
    let mut ends: Vec<End> = Vec::new();
    let mut alike: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for &part in tree.root_first() {
        let up = tree.parent(part).and_then(|p| shared_axis(object.joints(p)));
        let Some(setting) = Setting::new(&scene, &from, part, up, SCENE_SEED) else { continue };
        let stem: String =
            tree.parts()[part].text.chars().filter(|c| !c.is_ascii_digit()).collect();
        for wanted in object.joints(part) {
            let first = ends.len();
            ends.extend(of_joint(&setting, wanted, (is_skin, voice)));
            alike.entry(stem.clone()).or_default().extend(first..ends.len());
        }
    }
    for group in alike.values() {
        group.iter().for_each(|&e| ends[e].asked.weight = (group.len() as f32).sqrt().recip());
    }
    ends
}

fn of_joint(setting: &Setting, wanted: &JointMotion, seen: (bool, usize)) -> Vec<End> {
    let Range::Limits { lower, upper } = wanted.range else { return Vec::new() };
    let (scene, role) = (setting.scene, setting.meaning.role);
    let turns = wanted.kind.turns();
    let pivot = (wanted.pivot - scene.origin) / scene.unit;
    let axis = setting.opening(&Axis { direction: wanted.axis, pivot, turns }, role);
    let is_along = axis.direction.dot(wanted.axis) > 0.0;
    let length = setting.length(&axis);
    let unit = if turns { 1.0 } else { length * scene.unit };
    let far = if is_along { [upper, -lower] } else { [-lower, upper] };
    let usual = usual(role, turns);
    let amounts = amounts(turns);
    let free = setting.freedom_of(&axis, role);
    let rows = setting.asked(&axis, role).into_iter().enumerate();
    let one = |(way, numbers): (usize, Vec<[f32; NUMBERS]>)| {
        let wanted = (far[way] / unit).min(amounts.last().copied().unwrap_or(0.0));
        let wanted = if wanted < NOTHING { 0.0 } else { wanted };
        let right: Vec<f64> = amounts.iter().map(|&a| likeness(a, wanted)).collect();
        let all: f64 = right.iter().sum();
        let truth = right.into_iter().map(|r| (r / all) as f32).collect();
        End {
            voice: seen.1,
            turns,
            is_skin: seen.0,
            asked: Question { weight: 1.0, truth, numbers },
            wanted,
            usual: if way == 0 { usual.open } else { usual.close },
            free: (if way == 0 { free.ahead } else { free.back })[0] / length,
            length,
        }
    };
    rows.map(one).collect()
}
