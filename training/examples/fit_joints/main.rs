//! Fits what chooses joint axes: boosted trees and a small network, each for turns and for slides.
//!
//! `fit_joints OUT TRAIN VAL EXCLUDED [--objects N] [--families N] [--skin RECIPE] [--keep FOLDER]
//! [--seed N] [--trees N] [--leaves N] [--rate R] [--share S] [--numbers S] [--curve C] [--hold C]`:
//! writes `turns.trees`, `slides.trees`, `turns.f32le` and `slides.f32le` into `OUT`, from folders of shards
//! (`tar.zst`) and objects of our own families; the list of records that must not be trained on ends the
//! run where they turn up. Every object is seen four times: as it is and as one skin, as [`Recipe`] writes
//! it, with its true labels and with those that the forests of parts that ship give it, by the voice that
//! does not know it, for labels are seldom perfect; skins also with hinges that are all of one side. Objects
//! of validation are labelled as the program does. Of the candidates of a joint, those near its true axis
//! are right, to the trees the nearer the more. The same shards and forests of parts give the same bytes.
//! What is read is kept in a folder, if one is named, shard by shard, and taken from there when the same is
//! asked of the same objects again, however trees are to grow: a run that was broken off goes on where it
//! was. Of that the program is no part, so a folder is for one program. How trees grow is said in
//! [`training::forest::Growth`].
//!
//! The networks' files have the size that the count of [`model::geometric::features::NAMES`] asks for,
//! and nothing builds while they have another: after a change there, put zeros of the new size in their
//! place, fit, and take what was fitted.

#![allow(clippy::print_stdout, clippy::print_stderr)]

mod kept;
mod knuckles;
mod net;
mod trees;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use model::geometric::features::{COUNT, NAMES};
use model::geometric::forest::{Forest, mean_chances};
use model::geometric::joints::{Labelled, candidates, endless, shared_axis};
use model::geometric::labels::{Way, belonging, label_faces};
use model::geometric::scene::Scene;
use model::geometric::score::net::Net;
use model::geometric::score::{NUMBERS, Numbers, blended, numbers};
use model::geometric::setting::Setting;
use object::condition::Prompt;
use object::origin::Origin;
use object::weld::Weld;
use object::{ArticulatedObject, Condition, DVec3, JointKind, JointMotion, KinematicTree};
use rayon::prelude::*;
use training::dataset::evalcase::specimen;
use training::dataset::library::{check_held_out, held_out};
use training::dataset::shards::{Bundle, read_shard, shards};
use training::dataset::{Specimen, middle_face};
use training::forest::{Growth, Question, blind_number, blind_voice};
use training::fuse::{Recipe, fused};
use training::procedural::{family_of, worded};
use training::truth::TruthFile;

use self::knuckles::Side;
use self::trees::SHARES;

type Anyhow = Box<dyn std::error::Error + Send + Sync>;

/// Angle and distance, as a share of the largest extent, beyond which an axis is wrong.
const WRONG: (f64, f64) = (15.0, 0.05);
/// Angle and distance that make an axis less right by a factor of e.
const OFF: (f64, f64) = (4.0, 0.008);
/// The seed of scenes.
const SCENE_SEED: u64 = 1;
/// A seed that nothing else is made with.
const FAMILY_SEED: u64 = 52;
/// So many of our own families are kept together.
const FAMILIES: usize = 40;

/// How an object is seen, each time with its true labels and with those that are found; then, as a skin,
/// with hinges that are all of one side.
const SIGHTS: [&str; 6] = [
    "as it is",
    "as it is, labelled",
    "as a skin",
    "as a skin, labelled",
    "as a skin, hinges of the part",
    "as a skin, hinges of its parent",
];
/// Which of them skins are, with their true labels.
const SKINS: usize = 2;
/// Which of them have hinges that are all of one side.
const ONE_SIDED: [(usize, Side); 2] = [(4, Side::Part), (5, Side::Parent)];

/// What is asked for on the command line.
#[derive(Clone)]
struct Wanted {
    objects: usize,
    families: usize,
    skin: Recipe,
    growth: Growth,
    /// Where joints' numbers are kept.
    kept: Option<PathBuf>,
}

/// A joint and its candidates.
struct Joint {
    /// Which of [`SHARES`] of the objects it is of: voices that leave that out do not know it.
    share: usize,
    /// Which of [`SIGHTS`].
    sight: usize,
    turns: bool,
    asked: Question<NUMBERS>,
    /// For each candidate, how far it is from the truth: degrees, and a share of the largest extent.
    off: Vec<(f32, f32)>,
}

impl Joint {
    /// Whether any candidate is right.
    fn is_told(&self) -> bool {
        self.asked.truth.iter().any(|t| *t > 0.0)
    }
}

fn main() -> Result<(), Anyhow> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [out, train, val, excluded, rest @ ..] = &args[..] else {
        return Err("OUT TRAIN VAL EXCLUDED".into());
    };
    let wanted = wanted(rest)?;
    let excluded = held_out(Path::new(excluded))?;
    let every = Wanted { objects: usize::MAX, families: 0, ..wanted.clone() };
    let val = read(Path::new(val), &every, ("val", &excluded))?;
    let mut train = read(Path::new(train), &wanted, ("train", &excluded))?;
    train.extend(own(&wanted)?);
    let out = Path::new(out);
    std::fs::create_dir_all(out)?;
    for (name, turns) in [("slides", false), ("turns", true)] {
        let own: Vec<&Joint> = train.iter().filter(|j| j.turns == turns).collect();
        let judged: Vec<&Joint> = val.iter().filter(|j| j.turns == turns).collect();
        let net = net::fitted(&own).ok_or("nothing to fit a network to")?;
        std::fs::write(out.join(format!("{name}.f32le")), net.write())?;
        told(&format!("{name}, val by the network"), &judged, |j| best(&net_scores(&net, j)));
        let voices = trees::grown(&own, &wanted.growth);
        let mut bytes = Vec::new();
        voices.iter().for_each(|v| v.write(&mut bytes));
        std::fs::write(out.join(format!("{name}.trees")), bytes)?;
        told(&format!("{name}, train by others"), &own, |j| {
            likeliest(&voices[j.share..=j.share], j)
        });
        told(&format!("{name}, val by the trees"), &judged, |j| likeliest(&voices, j));
        told(&format!("{name}, val by both"), &judged, |j| {
            let chances = mean_chances(&voices, &j.asked.numbers);
            best(&blended(&chances, &net_scores(&net, j)))
        });
        told(&format!("{name}, val, the nearest there is"), &judged, nearest);
    }
    Ok(())
}

/// Joints as they were kept, when the same was asked of the same objects, or as they are made, and then
/// kept; `what` says in a word, and with `of` in full, which objects those are.
fn kept(
    wanted: &Wanted,
    (what, of): (&str, &[u8]),
    make: impl FnOnce() -> Result<Vec<Joint>, Anyhow>,
) -> Result<Vec<Joint>, Anyhow> {
    let Some(folder) = &wanted.kept else { return make() };
    let path = folder.join(format!("{what}-{}.f32le", asked_of(wanted, (what, of))));
    if path.exists() {
        return kept::read(&path);
    }
    let joints = make()?;
    std::fs::create_dir_all(folder)?;
    kept::write(&path, &joints)?;
    Ok(joints)
}

/// All that the numbers of some objects' joints follow from, but for the program, as a digest: the objects,
/// how they are seen, who labels them, and what is told.
fn asked_of(wanted: &Wanted, (what, of): (&str, &[u8])) -> String {
    let mut hasher = blake3::Hasher::new();
    let (skin, labels) = (&wanted.skin, belonging::digest());
    hasher.update(format!("{what} {skin:?} {labels} {NAMES:?}").as_bytes()).update(of);
    hasher.finalize().to_hex().chars().take(12).collect()
}

/// Reports on each sight of the joints.
fn told(what: &str, joints: &[&Joint], chosen: impl Fn(&Joint) -> usize) {
    for (sight, seen) in SIGHTS.iter().enumerate() {
        let joints: Vec<&Joint> = joints.iter().copied().filter(|j| j.sight == sight).collect();
        report(&format!("{what}, {seen}"), &joints, &chosen);
    }
}

fn likeliest(voices: &[Forest<NUMBERS>], joint: &Joint) -> usize {
    let chances = mean_chances(voices, &joint.asked.numbers);
    best(&chances.into_iter().map(f64::from).collect::<Vec<_>>())
}

/// What the network says of each candidate.
fn net_scores(net: &Net, joint: &Joint) -> Vec<f64> {
    let Some((role, is_endless)) = net::told(joint) else { return Vec::new() };
    let numbers = joint.asked.numbers.iter().map(net::own);
    numbers.map(|row| net.score(&row, role, is_endless)).collect()
}

/// The first of the largest.
fn best(scores: &[f64]) -> usize {
    (0..scores.len()).reduce(|a, b| if scores[b] > scores[a] { b } else { a }).unwrap_or(0)
}

fn nearest(joint: &Joint) -> usize {
    let far =
        |k: &usize| f64::from(joint.off[*k].0) / WRONG.0 + f64::from(joint.off[*k].1) / WRONG.1;
    (0..joint.off.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0)
}

fn report(what: &str, joints: &[&Joint], chosen: impl Fn(&Joint) -> usize) {
    let count = joints.len().max(1) as f64;
    let (mut near, mut found, mut angle, mut line) = (0.0, 0.0, 0.0, 0.0);
    for joint in joints {
        let Some(&(a, l)) = joint.off.get(chosen(joint)) else { continue };
        let (a, l) = (f64::from(a), f64::from(l));
        near += f64::from(u8::from(a < WRONG.0));
        found += f64::from(u8::from(a < WRONG.0 && l < WRONG.1));
        angle += a;
        line += l;
    }
    let (near, found) = (100.0 * near / count, 100.0 * found / count);
    let (angle, line) = (angle / count, line / count);
    eprintln!(
        "{what}: {count} joints, {near:.1} % near, {found:.1} % found, {angle:.1}°, {line:.4}"
    );
}

fn wanted(args: &[String]) -> Result<Wanted, Anyhow> {
    let (objects, families, skin) = (usize::MAX, 0, Recipe::plain(96));
    let mut wanted = Wanted { objects, families, skin, growth: trees::GROWTH, kept: None };
    for pair in args.chunks(2) {
        let [what, value] = pair else { return Err("a value is missing".into()) };
        match what.as_str() {
            "--objects" => wanted.objects = value.parse()?,
            "--families" => wanted.families = value.parse()?,
            "--keep" => wanted.kept = Some(value.into()),
            "--skin" => wanted.skin = value.parse()?,
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
) -> Result<Vec<Joint>, Anyhow> {
    let one = |bundle: &Bundle| {
        let truth = TruthFile::from_json(&bundle.truth).map(|t| t.category);
        let found = specimen(bundle).and_then(|s| Ok((s, truth.map_err(|e| e.to_string())?)));
        let (specimen, category) = match found {
            Ok(found) => found,
            Err(e) => {
                eprintln!("{}: {e}", bundle.id);
                return Vec::new();
            }
        };
        let share = blind_voice(&bundle.id, SHARES);
        let way = if from.0 == "val" { Way::Fitted } else { blind(&bundle.id) };
        seen(&specimen, &category, wanted, (share, way))
    };
    let (mut joints, mut objects) = (Vec::new(), 0);
    for shard in shards(folder)? {
        if objects >= wanted.objects {
            break;
        }
        let bundles = read_shard(&shard)?;
        bundles.iter().try_for_each(|bundle| check_held_out(bundle, &shard, from))?;
        objects += bundles.len();
        let made = || Ok(bundles.par_iter().flat_map_iter(one).collect());
        joints.extend(kept(wanted, (from.0, &std::fs::read(&shard)?), made)?);
        eprintln!("{}: {} joints", shard.display(), joints.len());
    }
    Ok(joints)
}

/// The joints of objects of our own families, each in one of its wordings.
fn own(wanted: &Wanted) -> Result<Vec<Joint>, Anyhow> {
    let one = |number: usize| {
        let specimen = worded(number, FAMILY_SEED)?;
        let (category, share) =
            (family_of(number).replace('_', " "), blind_voice(&specimen.id, SHARES));
        let way = blind(&specimen.id);
        Ok::<_, Anyhow>(seen(&specimen, &category, wanted, (share, way)))
    };
    let mut joints = Vec::new();
    for first in (0..wanted.families).step_by(FAMILIES) {
        let numbers = first..wanted.families.min(first + FAMILIES);
        let of = format!("{FAMILY_SEED} {numbers:?}");
        let made = || {
            let made = numbers.into_par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
            Ok(made.into_iter().flatten().collect())
        };
        joints.extend(kept(wanted, ("families", of.as_bytes()), made)?);
        eprintln!("families from {first}: {} joints", joints.len());
    }
    Ok(joints)
}

/// Labels by who does not know the object.
fn blind(id: &str) -> Way {
    Way::Blind(blind_number(id))
}

/// The joints of an object in all of [`SIGHTS`].
fn seen(
    specimen: &Specimen,
    category: &str,
    wanted: &Wanted,
    (share, way): (usize, Way),
) -> Vec<Joint> {
    let skin = fused(specimen, &wanted.skin).map(|s| s.object);
    let sights = [Some(specimen.object.clone()), skin.ok()].into_iter().enumerate();
    let seen = sights.flat_map(|(i, o)| o.map(|o| (i, o)));
    seen.flat_map(|(i, o)| seen_as(&o, category, (2 * i, share, way))).collect()
}

/// The joints of an object by its true labels and by those that are found.
fn seen_as(
    object: &ArticulatedObject,
    category: &str,
    (sight, share, way): (usize, usize, Way),
) -> Vec<Joint> {
    let mesh = object.mesh();
    let weld = Weld::new(mesh);
    let truth: Vec<&[JointMotion]> = (0..object.tree().len()).map(|p| object.joints(p)).collect();
    let from = Labelled {
        mesh,
        weld: &weld,
        tree: object.tree(),
        part_of_face: object.part_of_face(),
        category,
    };
    let scene = Scene::new(&from, SCENE_SEED);
    let all = vec![true; truth.len()];
    let mut joints = joints((&from, &scene), (&truth, &all), (sight, share));
    let is_skin = sight == SKINS;
    let hinges = if is_skin { knuckles::hinges((&from, &scene), &truth) } else { Vec::new() };
    for (sight, side) in ONE_SIDED {
        let (labels, is_changed) = knuckles::given(&from, &hinges, side);
        if is_changed.contains(&true) {
            let from = Labelled { part_of_face: &labels, ..from };
            let scene = Scene::new(&from, SCENE_SEED);
            let asked = (&truth[..], &is_changed[..]);
            joints.extend(self::joints((&from, &scene), asked, (sight, share)));
        }
    }
    let labels = label_faces(mesh, &pointed(object, category), &weld, way).part_of_face;
    let mut lost = vec![true; truth.len()];
    labels.iter().for_each(|&l| lost[usize::from(l)] = false);
    let Ok((tree, now)) = object.tree().without(&lost) else { return joints };
    if tree.len() < 2 {
        return joints;
    }
    let labels: Vec<u16> =
        labels.iter().map(|&l| now[usize::from(l)].unwrap_or_default() as u16).collect();
    let kept = (0..truth.len()).filter(|&p| now[p].is_some()).map(|p| truth[p]).collect::<Vec<_>>();
    let from = Labelled { mesh, weld: &weld, tree: &tree, part_of_face: &labels, category };
    let (scene, all) = (Scene::new(&from, SCENE_SEED), vec![true; kept.len()]);
    joints.extend(self::joints((&from, &scene), (&kept, &all), (sight + 1, share)));
    joints
}

/// The object's condition with a point in the middle of each part.
fn pointed(object: &ArticulatedObject, category: &str) -> Condition {
    let mesh = object.mesh();
    let prompt = |part: usize| {
        let faces: Vec<usize> = object.faces_of(part).collect();
        let point = middle_face(mesh, &faces).map(|f| mesh.centroid(f));
        Prompt { point, ..Prompt::default() }
    };
    let tree: KinematicTree = object.tree().clone();
    let prompts = (0..tree.len()).map(prompt).collect();
    Condition { category: category.into(), tree, prompts, size: None, origin: Origin::User }
}

/// The joints of those parts that are asked about.
fn joints(
    (from, scene): (&Labelled, &Scene),
    (truth, is_asked): (&[&[JointMotion]], &[bool]),
    (sight, share): (usize, usize),
) -> Vec<Joint> {
    let tree = from.tree;
    let mut joints = Vec::new();
    let mut alike: BTreeMap<(String, usize), Vec<usize>> = BTreeMap::new();
    for &part in tree.root_first().iter().filter(|&&p| is_asked[p]) {
        let up = tree.parent(part).and_then(|p| shared_axis(truth[p]));
        let Some(setting) = Setting::new(scene, from, part, up, SCENE_SEED) else { continue };
        for (k, (&kind, wanted)) in tree.parts()[part].joints.iter().zip(truth[part]).enumerate() {
            let role = setting.meaning.role;
            let role = if kind == JointKind::Continuous { endless(role) } else { role };
            let found = candidates(&setting, kind);
            let features: Vec<&[f64; COUNT]> = found.iter().map(|c| &c.features).collect();
            let asked: Vec<Numbers> = numbers(&features, kind, role);
            let extent = from.mesh.bounds().size().max_element();
            let off: Vec<(f32, f32)> = found
                .iter()
                .map(|c| {
                    let pivot = c.axis.pivot * scene.unit + scene.origin;
                    let (angle, line) = off(c.axis.direction, pivot, wanted);
                    (angle as f32, (line / extent) as f32)
                })
                .collect();
            let right = |&(angle, line): &(f32, f32)| {
                let (angle, line) = (f64::from(angle), f64::from(line));
                let is_wrong = angle >= WRONG.0 || line >= WRONG.1;
                if is_wrong { 0.0 } else { (-angle / OFF.0 - line / OFF.1).exp() }
            };
            let right: Vec<f64> = off.iter().map(right).collect();
            let sum: f64 = right.iter().sum();
            let told = |r: f64| if sum > 0.0 { (r / sum) as f32 } else { 0.0 };
            let truth = right.into_iter().map(told).collect();
            let text = tree.parts()[part].text.chars().filter(|c| !c.is_ascii_digit()).collect();
            alike.entry((text, k)).or_default().push(joints.len());
            joints.push(Joint {
                share,
                sight,
                turns: kind.turns(),
                asked: Question { weight: 1.0, truth, numbers: asked },
                off,
            });
        }
    }
    for group in alike.values() {
        for &j in group {
            joints[j].asked.weight = (group.len() as f32).sqrt().recip();
        }
    }
    joints
}

/// Angle of an axis to the true one, degrees, and for turns the distance of both lines.
fn off(direction: DVec3, pivot: DVec3, wanted: &JointMotion) -> (f64, f64) {
    let angle = wanted.axis.dot(direction).abs().min(1.0).acos().to_degrees();
    let (across, apart) = (wanted.axis.cross(direction), pivot - wanted.pivot);
    let line = if !wanted.kind.turns() {
        0.0
    } else if across.length() < 1e-3 {
        apart.reject_from_normalized(wanted.axis).length()
    } else {
        apart.dot(across.normalize()).abs()
    };
    (angle, line)
}
