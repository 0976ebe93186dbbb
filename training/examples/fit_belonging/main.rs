//! Grows the boosted trees that say which neighbouring pieces are of one part, and which part each
//! piece belongs to.
//!
//! `fit_belonging OUT TRAIN VAL EXCLUDED [--objects N] [--draws N] [--cut N] [--families N]
//! [--skin RECIPE]... [--own-draws N] [--opened yes|no] [--kin yes|no] [--voices N] [--rounds N]
//! [--seed N] [--trees N] [--leaves N] [--rate R] [--share S] [--numbers S] [--curve C] [--hold C]`:
//! folders of shards (`tar.zst`) and the list of records that must not be trained on,
//! which end the run where they turn up. Every other draw of an object has its points in the middle of
//! parts, the others anywhere on them; so often more it is drawn cut up ([`cut_up`]), if it is no skin. Our
//! own families are drawn as often as those objects, unless another number is said; three of each, made
//! from another seed and trained on by nothing, are asked about beside validation: what families teach does
//! not show on shards. With skins, as [`Recipe`] writes them, objects are seen as each of these instead of
//! as they are; opened, every part is either at rest or anywhere in its range, and what cannot be posed so
//! is left out and named. Half the weight of an object goes to its pieces by the root of their area, half
//! to its parts alike: small pieces astray make large boxes, and small parts count. The same shards give
//! the same bytes.
//! How trees grow is said in [`training::forest::Growth`].

#![allow(clippy::print_stdout, clippy::print_stderr)]

mod trees;

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use model::geometric::labels::belonging::{Beliefs, KIN, Layout, NUMBERS, Numbers, Tie};
use model::geometric::labels::{Way, label_faces, layout};
use object::condition::Prompt;
use object::mesh::Bounds;
use object::origin::Origin;
use object::weld::Weld;
use object::{ArticulatedObject, Condition, DQuat, DVec3};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use training::dataset::cut::cut_up;
use training::dataset::evalcase::specimen;
use training::dataset::library::{each, held_out};
use training::dataset::pose::opened;
use training::dataset::shards::Bundle;
use training::dataset::{Specimen, any_face, middle_face};
use training::forest::{Growth, Question, blind_voice};
use training::fuse::{Recipe, fused};
use training::procedural::{KINDS, worded};

type Anyhow = Box<dyn std::error::Error + Send + Sync>;

/// A seed that nothing else is made with.
const FAMILY_SEED: u64 = 51;
/// The seed of those that trees are judged by, and how often each family is among them.
const JUDGED: (u64, usize) = (54, 3);

/// The number of the draw that says how objects are opened.
const OPENED: u64 = 1000;
/// The number of the first draw that says how objects are cut up.
const CUT: u64 = 2000;
/// Nothing surprises more than what has this chance.
const UNLIKELY: f64 = 1e-3;
/// Two pieces count at least as much as if the smaller had this share of the surface.
const TINY: f64 = 1e-3;

/// What is asked for on the command line.
#[derive(Clone)]
struct Wanted {
    objects: usize,
    draws: u64,
    skins: Vec<Recipe>,
    /// How often each object is drawn cut up, beside how often it is as it is.
    cut: u64,
    /// Whether skins are of the object as it moves, not of the object at rest.
    opened: bool,
    families: usize,
    /// How often each object of our own families is drawn.
    own_draws: Option<u64>,
    /// Whether anything is learnt of which neighbours are of one part.
    kin: bool,
    voices: usize,
    rounds: usize,
    growth: Growth,
}

/// An object in pieces, with its truth.
struct Case {
    draw: u64,
    /// The voice whose forests are not grown on it.
    voice: usize,
    layout: Layout,
    /// For each piece, the area of each part in it, as a share of the whole surface.
    votes: Vec<BTreeMap<usize, f64>>,
    parts: usize,
    /// Mean IoU over parts of the labels the program gives as it is.
    plain: f64,
    beliefs: Beliefs,
}

impl Case {
    /// All pieces with those they share most with.
    fn truth(&self) -> Beliefs {
        let row = |votes: &BTreeMap<usize, f64>| {
            (0..self.parts).map(|p| votes.get(&p).copied().unwrap_or(0.0) as f32).collect()
        };
        self.votes.iter().map(row).collect()
    }
}

fn main() -> Result<(), Anyhow> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [out, train, val, excluded, rest @ ..] = &args[..] else {
        return Err("OUT TRAIN VAL EXCLUDED".into());
    };
    let wanted = wanted(rest)?;
    let excluded = held_out(Path::new(excluded))?;
    let mut train = read(Path::new(train), &wanted, ("train", &excluded))?;
    let all = Wanted { objects: usize::MAX, draws: 2, cut: 0, ..wanted.clone() };
    train.extend(own(&wanted)?);
    let val = read(Path::new(val), &all, ("val", &excluded))?;
    let mut judged = [("val", val), ("own val", own_judged(&all)?)];
    for (what, cases) in &judged {
        report(&format!("as it is, {what}"), cases, |c| c.plain);
        report(&format!("with every piece right, {what}"), cases, |c| iou_of(c, &c.truth()));
    }
    let kept = |bytes: &[u8]| std::fs::write(out, bytes);
    trees::grown((&mut train[..], &mut judged[..]), &wanted, kept)
}

fn wanted(args: &[String]) -> Result<Wanted, Anyhow> {
    let growth = trees::GROWTH;
    let (objects, skins) = (usize::MAX, Vec::new());
    let (draws, cut, families) = (1, 0, 0);
    let (kin, voices, rounds) = (true, 3, 2);
    let (opened, own_draws) = (false, None);
    let mut wanted = Wanted {
        objects,
        draws,
        cut,
        skins,
        opened,
        families,
        own_draws,
        kin,
        voices,
        rounds,
        growth,
    };
    for pair in args.chunks(2) {
        let [what, value] = pair else { return Err("a value is missing".into()) };
        match what.as_str() {
            "--objects" => wanted.objects = value.parse()?,
            "--draws" => wanted.draws = value.parse()?,
            "--cut" => wanted.cut = value.parse()?,
            "--families" => wanted.families = value.parse()?,
            "--own-draws" => wanted.own_draws = Some(value.parse()?),
            "--kin" => wanted.kin = value == "yes",
            "--voices" => wanted.voices = value.parse()?,
            "--rounds" => wanted.rounds = value.parse()?,
            "--skin" => wanted.skins.push(value.parse()?),
            "--opened" => wanted.opened = value == "yes",
            _ if wanted.growth.take(what, value)? => {}
            _ => return Err(format!("unknown: {what}").into()),
        }
    }
    if wanted.opened && wanted.skins.is_empty() {
        return Err("--opened: what is opened is a --skin".into());
    }
    if wanted.cut > 0 && !wanted.skins.is_empty() {
        return Err("--cut: what is cut up is no --skin".into());
    }
    Ok(wanted)
}

/// Of each object as it was first seen with points in the middle, and anywhere: the mean over all, that of
/// boxes, how surprising the truth is, and on how many the mean is more or less than by merging.
fn report(what: &str, cases: &[Case], iou: impl Fn(&Case) -> f64) {
    for (draw, how) in [(0, ""), (1, ", points anywhere")] {
        let cases: Vec<&Case> = cases.iter().filter(|c| c.draw == draw).collect();
        if !cases.is_empty() {
            report_of(&format!("{what}{how}"), &cases, &iou);
        }
    }
}

fn report_of(what: &str, cases: &[&Case], iou: impl Fn(&Case) -> f64) {
    let mean = cases.iter().map(|c| iou(c)).sum::<f64>() / cases.len().max(1) as f64;
    let better = cases.iter().filter(|c| iou(c) > c.plain + 1e-9).count();
    let worse = cases.iter().filter(|c| iou(c) < c.plain - 1e-9).count();
    let loss = cases.iter().map(|c| surprise(c)).sum::<f64>() / cases.len().max(1) as f64;
    let boxes = cases.iter().map(|c| box_iou(c)).sum::<f64>() / cases.len().max(1) as f64;
    eprintln!(
        "{what}: {mean:.4} boxes {boxes:.4} loss {loss:.4} ({}; {better} better, {worse} worse)",
        cases.len()
    );
}

/// The cases of a split's shards; those of validation are judged as the program labels them, too.
fn read(
    folder: &Path,
    wanted: &Wanted,
    from: (&str, &BTreeSet<String>),
) -> Result<Vec<Case>, Anyhow> {
    let judged = from.0 == "val";
    let one = |bundle: &Bundle| {
        let found = specimen(bundle);
        if let Err(e) = &found {
            eprintln!("{}: {e}", bundle.id);
        }
        found.map_or(Vec::new(), |s| seen_as(&s, wanted, judged))
    };
    let told = |shard: &Path, cases| eprintln!("{}: {cases} cases", shard.display());
    Ok(each(folder, wanted.objects, from, one, told)?)
}

/// Objects of our own families, each in one of its wordings.
fn own(wanted: &Wanted) -> Result<Vec<Case>, Anyhow> {
    let wanted = Wanted { draws: wanted.own_draws.unwrap_or(wanted.draws), ..wanted.clone() };
    made(wanted.families, FAMILY_SEED, |s| seen_as(s, &wanted, false))
}

/// Some of every family that nothing is trained on.
fn own_judged(wanted: &Wanted) -> Result<Vec<Case>, Anyhow> {
    let (seed, each) = JUDGED;
    made(each * KINDS, seed, |s| seen_as(s, wanted, true))
}

fn made(
    count: usize,
    seed: u64,
    seen: impl Fn(&Specimen) -> Vec<Case> + Sync,
) -> Result<Vec<Case>, Anyhow> {
    let one = |number| Ok::<_, Anyhow>(seen(&worded(number, seed)?));
    let made = (0..count).into_par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
    Ok(made.into_iter().flatten().collect())
}

/// The object as it is, or as skins if any are asked for, each with points drawn anew.
fn seen_as(specimen: &Specimen, wanted: &Wanted, judged: bool) -> Vec<Case> {
    let voice = blind_voice(&specimen.id, wanted.voices);
    let drawn = |object: &ArticulatedObject, number| {
        case(object, &Draw::of(&specimen.id, number), voice, judged)
    };
    if wanted.skins.is_empty() {
        let whole = (0..wanted.draws).filter_map(|d| drawn(&specimen.object, d));
        let cut = (0..wanted.cut).filter_map(|d| {
            let mut draw = Draw::of(&specimen.id, CUT + d);
            let cut = cut_up(&specimen.object, &mut draw.dice);
            let cut = cut.inspect_err(|e| eprintln!("{} cut up: {e}", specimen.id)).ok()?;
            drawn(&cut, wanted.draws + d)
        });
        return whole.chain(cut).collect();
    }
    let open = match wanted.opened.then(|| Draw::of(&specimen.id, OPENED)) {
        None => None,
        Some(mut draw) => match opened(&specimen.object, &mut draw.dice) {
            Ok(object) => Some(Specimen { object, ..specimen.clone() }),
            Err(e) => {
                eprintln!("{} opened: {e}", specimen.id);
                return Vec::new();
            }
        },
    };
    let specimen = open.as_ref().unwrap_or(specimen);
    // As drawn first every skin has its points in the middle, and every other one is seen from behind.
    let number =
        |skin: u64, draw: u64| 2 * (skin + draw / 2 * wanted.skins.len() as u64) + draw % 2;
    let skin = |(i, recipe): (u64, &Recipe)| match fused(specimen, recipe) {
        Ok(skin) if judged => (0..2).filter_map(|d| drawn(&skin.object, d)).collect(),
        Ok(skin) => (0..wanted.draws).filter_map(|d| drawn(&skin.object, number(i, d))).collect(),
        Err(e) => {
            eprintln!("{} over {} cells: {e}", specimen.id, recipe.cells);
            Vec::new()
        }
    };
    (0..).zip(&wanted.skins).flat_map(skin).collect()
}

/// How an object is seen once.
struct Draw {
    number: u64,
    dice: Pcg64Mcg,
}

impl Draw {
    fn of(id: &str, number: u64) -> Self {
        let own = blake3::hash(id.as_bytes());
        let seed = own
            .as_bytes()
            .iter()
            .take(7)
            .fold(number, |seed, &byte| seed.wrapping_mul(251) + u64::from(byte));
        Self { number, dice: Pcg64Mcg::seed_from_u64(seed) }
    }
}

/// The object with a point on each part, turned by a quarter for each draw: what is front is not
/// known. Every other draw takes the face nearest the middle of the part's surface, as one does who
/// knows the part; the others any place on it, as one does who clicks.
fn case(object: &ArticulatedObject, draw: &Draw, voice: usize, is_judged: bool) -> Option<Case> {
    let turn = DQuat::from_rotation_z(FRAC_PI_2 * draw.number as f64);
    let mesh = &object.mesh().map_vertices(|v| turn * v).ok()?;
    let parts = object.tree().len();
    let mut dice = draw.dice.clone();
    let mut prompts = Vec::new();
    for part in 0..parts {
        let faces: Vec<usize> = object.faces_of(part).collect();
        let face = if draw.number.is_multiple_of(2) {
            middle_face(mesh, &faces)
        } else {
            any_face(mesh, &faces, &mut dice)
        };
        let point = face.map(|f| mesh.centroid(f));
        prompts.push(Prompt { point, ..Prompt::default() });
    }
    let tree = object.tree().clone();
    let condition =
        Condition { category: String::new(), tree, prompts, size: None, origin: Origin::User };
    let weld = Weld::new(mesh);
    let (piece_of_face, layout) = layout(mesh, &condition, &weld);
    let total: f64 = (0..piece_of_face.len()).map(|f| mesh.area(f)).sum();
    let truth = |face: usize| usize::from(object.part_of_face()[face]);
    let mut votes = vec![BTreeMap::new(); layout.len()];
    for (face, &piece) in piece_of_face.iter().enumerate() {
        *votes[piece as usize].entry(truth(face)).or_insert(0.0) += mesh.area(face) / total;
    }
    let mut plain = 0.0;
    if is_judged {
        let found = label_faces(mesh, &condition, &weld, Way::Merging).part_of_face;
        let mut crossed = vec![vec![0.0; parts]; parts];
        for (face, &found) in found.iter().enumerate() {
            crossed[truth(face)][usize::from(found)] += mesh.area(face) / total;
        }
        plain = mean_iou(&crossed);
    }
    let beliefs = layout.first();
    Some(Case { draw: draw.number, voice, layout, votes, parts, plain, beliefs })
}

fn mean_iou(crossed: &[Vec<f64>]) -> f64 {
    let one = |p: usize| {
        let own: f64 = crossed[p].iter().sum();
        let taken: f64 = crossed.iter().map(|row| row[p]).sum();
        crossed[p][p] / (own + taken - crossed[p][p]).max(1e-12)
    };
    (0..crossed.len()).map(one).sum::<f64>() / crossed.len() as f64
}

/// Mean IoU over parts if every piece goes to the likeliest part.
fn iou(case: &Case) -> f64 {
    iou_of(case, &case.beliefs)
}

fn iou_of(case: &Case, beliefs: &Beliefs) -> f64 {
    let mut crossed = vec![vec![0.0; case.parts]; case.parts];
    for (votes, row) in case.votes.iter().zip(beliefs) {
        let best = likeliest(row);
        votes.iter().for_each(|(&truth, area)| crossed[truth][best] += area);
    }
    mean_iou(&crossed)
}

/// Mean IoU over parts of two boxes: that of the pieces of which the part is the likeliest, and that of
/// the pieces most of which are the part's.
fn box_iou(case: &Case) -> f64 {
    let boxes = |part_of: &dyn Fn(usize) -> usize| {
        let mut boxes = vec![Bounds::of([]); case.parts];
        for piece in 0..case.layout.len() {
            let (whole, own) = (&mut boxes[part_of(piece)], case.layout.bounds(piece));
            *whole = Bounds { min: whole.min.min(own.min), max: whole.max.max(own.max) };
        }
        boxes
    };
    let found = boxes(&|piece| likeliest(&case.beliefs[piece]));
    let right = boxes(&|piece| most(&case.votes[piece]));
    let volume = |b: &Bounds| (b.max - b.min).max(DVec3::ZERO).element_product();
    let one = |(a, b): (&Bounds, &Bounds)| {
        let both = volume(&Bounds { min: a.min.max(b.min), max: a.max.min(b.max) });
        both / (volume(a) + volume(b) - both).max(f64::MIN_POSITIVE)
    };
    found.iter().zip(&right).map(one).sum::<f64>() / case.parts as f64
}

/// The likeliest part.
fn likeliest(row: &[f32]) -> usize {
    row.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |b| b.0)
}

/// The part that each piece shares most with, and how much the piece counts: by the root of its area,
/// half an object's weight going to all pieces together, half to its parts alike.
fn counted(case: &Case) -> Vec<(usize, f64)> {
    let truth: Vec<usize> = case.votes.iter().map(most).collect();
    let size = |piece: usize| case.layout.share(piece).sqrt();
    let all = (0..truth.len()).map(size).sum::<f64>().max(f64::MIN_POSITIVE);
    let mut sizes = vec![1e-9; case.parts];
    truth.iter().enumerate().for_each(|(i, &t)| sizes[t] += size(i));
    let weight = |(piece, &t): (usize, &usize)| {
        (t, size(piece) * (0.5 / all + 0.5 / (sizes[t] * case.parts as f64)))
    };
    truth.iter().enumerate().map(weight).collect()
}

/// The part that most of a piece is of.
fn most(votes: &BTreeMap<usize, f64>) -> usize {
    votes.iter().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |m| *m.0)
}

fn questions(case: &Case) -> Vec<Question<NUMBERS>> {
    let counted = counted(case);
    let clusters = case.layout.clusters(&case.beliefs);
    let one = |piece: usize| {
        if case.layout.seed(piece).is_some() {
            return None;
        }
        let rows = case.layout.numbers(piece, &clusters);
        let (parts, numbers): (Vec<usize>, Vec<Numbers>) =
            rows.into_iter().enumerate().filter_map(|(p, r)| Some((p, r?))).unzip();
        let (truth, weight) = counted[piece];
        let right = |p: &usize| f32::from(u8::from(*p == truth));
        parts.contains(&truth).then(|| Question {
            weight: weight as f32,
            truth: parts.iter().map(right).collect(),
            numbers,
        })
    };
    (0..case.layout.len()).filter_map(one).collect()
}

/// Of each two pieces side by side: are they of one part? Those of much surface count more.
fn pairs(case: &Case) -> Vec<Question<KIN>> {
    let whole = |v: &BTreeMap<usize, f64>| v.values().sum::<f64>().max(f64::MIN_POSITIVE);
    let one = |tie: &Tie| {
        let [a, b] = [tie.small, tie.large].map(|i| &case.votes[i as usize]);
        let both = a.iter().map(|(part, x)| x * b.get(part).copied().unwrap_or(0.0)).sum::<f64>();
        let alike = (both / (whole(a) * whole(b))) as f32;
        let weight = (case.layout.share(tie.small as usize) + TINY).sqrt() as f32;
        Question { weight, truth: vec![alike, 1.0 - alike], numbers: vec![tie.numbers] }
    };
    let mut asked: Vec<Question<KIN>> = case.layout.ties().iter().map(one).collect();
    let all: f32 = asked.iter().map(|q| q.weight).sum();
    asked.iter_mut().for_each(|q| q.weight /= all.max(f32::MIN_POSITIVE));
    asked
}

/// Mean surprise at the truth, by how much pieces count.
fn surprise(case: &Case) -> f64 {
    let (mut sum, mut all) = (0.0, 0.0);
    for ((truth, weight), row) in counted(case).into_iter().zip(&case.beliefs) {
        sum -= weight * f64::from(row[truth]).max(UNLIKELY).ln();
        all += weight;
    }
    sum / all.max(f64::MIN_POSITIVE)
}

/// Mean surprise at which pieces are of one part.
fn kin_surprise(case: &Case) -> f64 {
    let asked = pairs(case);
    let said = case.layout.kin_chances();
    let one = |(q, &c): (&Question<KIN>, &f32)| {
        let c = c.clamp(UNLIKELY as f32, 1.0 - UNLIKELY as f32);
        f64::from(-q.weight * (q.truth[0] * c.ln() + q.truth[1] * (1.0 - c).ln()))
    };
    asked.iter().zip(said).map(one).sum()
}
