//! Fits the networks that say which part each piece belongs to.
//!
//! `fit_belonging OUT TRAIN VAL EXCLUDED [--objects N] [--draws N] [--epochs N] [--families N]
//! [--cells N] [--drop SHARE] [--decay RATE] [--seed N] [--voices N] [--units N]`: folders of shards
//! (`tar.zst`) and the list of records that must not be trained on, which end the run where they turn
//! up. With cells, objects are seen as one skin over that many cells instead of as they are. One
//! network for each round, of so many hidden units, fitted to what the rounds before believe, and as
//! many such rows as voices; Adam on small batches: the same shards give the same weights. Half the
//! weight of an object goes to its pieces by area, half to its parts alike, so that small parts count.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use model::geometric::labels::belonging::{
    Beliefs, FIRST_UNIT, Layout, NUMBERS, Net, Numbers, ROUNDS, chances,
};
use model::geometric::labels::{Way, label_faces, layout};
use object::condition::Prompt;
use object::origin::Origin;
use object::weld::Weld;
use object::{ArticulatedObject, Condition, DQuat, KinematicTree, Mesh};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use training::dataset::evalcase::specimen;
use training::dataset::library::{check_held_out, held_out};
use training::dataset::shards::{read_shard, shards};
use training::dataset::{Specimen, middle_face};
use training::fuse::fused;
use training::procedural::generate;

type Anyhow = Box<dyn std::error::Error + Send + Sync>;

const BATCH: usize = 8;
const RATE: f32 = 0.003;
const DECAY: f32 = 0.01;
/// A seed that nothing else is made with.
const FAMILY_SEED: u64 = 51;
/// The seeds of one voice are this far from those of the next.
const VOICE_SEEDS: u64 = 1000;
/// How often the loss is told in a round.
const TOLD: usize = 4;

/// What is asked for on the command line.
struct Wanted {
    objects: usize,
    draws: u64,
    epochs: usize,
    cells: Vec<usize>,
    decay: f32,
    drop: f32,
    seed: u64,
    families: usize,
    voices: u64,
    units: usize,
}

/// An object in pieces, with its truth.
struct Case {
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

/// A piece to be asked about: its weight, its true part, numbers of each part.
struct Question {
    weight: f32,
    truth: usize,
    numbers: Vec<Numbers>,
}

fn main() -> Result<(), Anyhow> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [out, train, val, excluded, rest @ ..] = &args[..] else {
        return Err("OUT TRAIN VAL EXCLUDED".into());
    };
    let wanted = wanted(rest)?;
    let excluded = held_out(Path::new(excluded))?;
    let mut train = read(Path::new(train), &wanted, ("train", &excluded))?;
    let all = Wanted { objects: usize::MAX, draws: 1, cells: wanted.cells.clone(), ..wanted };
    train.extend(own(&wanted)?);
    let mut val = read(Path::new(val), &all, ("val", &excluded))?;
    report("as it is, val", &val, |c| c.plain);
    report("with every piece right, val", &val, |c| iou_of(c, &c.truth()));
    let mut bytes = Vec::new();
    for voice in 0..wanted.voices {
        for case in train.iter_mut().chain(&mut val) {
            case.beliefs = case.layout.first();
        }
        for round in 0..ROUNDS {
            let seed = wanted.seed + VOICE_SEEDS * voice + round as u64;
            let net = fit(&train, &val, seed, &wanted).ok_or("no network has so many units")?;
            for case in train.iter_mut().chain(&mut val) {
                case.beliefs = net.answers(&case.layout, &case.beliefs);
            }
            report(&format!("voice {voice}, round {round}, train"), &train, iou);
            report(&format!("voice {voice}, round {round}, val"), &val, iou);
            bytes.extend(net.as_slice().iter().flat_map(|w| w.to_le_bytes()));
        }
        std::fs::write(out, &bytes)?;
    }
    Ok(())
}

fn wanted(args: &[String]) -> Result<Wanted, Anyhow> {
    let mut wanted = Wanted {
        objects: usize::MAX,
        draws: 1,
        epochs: 12,
        cells: Vec::new(),
        decay: DECAY,
        drop: 0.0,
        seed: 7,
        families: 0,
        voices: 1,
        units: 32,
    };
    for pair in args.chunks(2) {
        let [what, value] = pair else { return Err("a value is missing".into()) };
        match what.as_str() {
            "--objects" => wanted.objects = value.parse()?,
            "--draws" => wanted.draws = value.parse()?,
            "--epochs" => wanted.epochs = value.parse()?,
            "--decay" => wanted.decay = value.parse()?,
            "--drop" => wanted.drop = value.parse()?,
            "--families" => wanted.families = value.parse()?,
            "--seed" => wanted.seed = value.parse()?,
            "--voices" => wanted.voices = value.parse()?,
            "--units" => wanted.units = value.parse()?,
            "--cells" => wanted.cells.push(value.parse()?),
            _ => return Err(format!("unknown: {what}").into()),
        }
    }
    Ok(wanted)
}

/// The mean over all, and on how many it is more or less than by merging.
fn report(what: &str, cases: &[Case], iou: impl Fn(&Case) -> f64) {
    let mean = cases.iter().map(&iou).sum::<f64>() / cases.len().max(1) as f64;
    let better = cases.iter().filter(|c| iou(c) > c.plain + 1e-9).count();
    let worse = cases.iter().filter(|c| iou(c) < c.plain - 1e-9).count();
    eprintln!("{what}: {mean:.4} ({}; {better} better, {worse} worse)", cases.len());
}

/// The cases of a split's shards; those of validation are judged as the program labels them, too.
fn read(
    folder: &Path,
    wanted: &Wanted,
    from: (&str, &BTreeSet<String>),
) -> Result<Vec<Case>, Anyhow> {
    let judged = from.0 == "val";
    let mut cases = Vec::new();
    let mut seen = 0;
    for shard in shards(folder)? {
        if seen >= wanted.objects {
            break;
        }
        let bundles = read_shard(&shard)?;
        bundles.iter().try_for_each(|bundle| check_held_out(bundle, &shard, from))?;
        seen += bundles.len();
        let made = bundles.par_iter().flat_map_iter(|bundle| {
            let found = specimen(bundle);
            if let Err(e) = &found {
                eprintln!("{}: {e}", bundle.id);
            }
            found.map_or(Vec::new(), |s| seen_as(&s, wanted, judged))
        });
        cases.extend(made.collect::<Vec<_>>());
        eprintln!("{}: {} cases", shard.display(), cases.len());
    }
    Ok(cases)
}

/// Objects of our own families, each in one of its wordings.
fn own(wanted: &Wanted) -> Result<Vec<Case>, Anyhow> {
    let one = |number: usize| {
        let mut specimen = generate(number, FAMILY_SEED)?;
        let mut parts = specimen.object.tree().parts().to_vec();
        for (part, wordings) in parts.iter_mut().zip(&specimen.wordings) {
            part.text.clone_from(&wordings[number % wordings.len().max(1)]);
        }
        let joints = (0..parts.len()).map(|p| specimen.object.joints(p).to_vec()).collect();
        let (mesh, labels) = (specimen.object.mesh().clone(), specimen.object.part_of_face());
        let tree = KinematicTree::new(parts)?;
        specimen.object = ArticulatedObject::new(mesh, tree, labels.to_vec(), joints)?;
        Ok::<_, Anyhow>(seen_as(&specimen, wanted, false))
    };
    let made = (0..wanted.families).into_par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
    Ok(made.into_iter().flatten().collect())
}

/// The object as it is, or as skins if any are asked for, each with points drawn anew.
fn seen_as(specimen: &Specimen, wanted: &Wanted, judged: bool) -> Vec<Case> {
    let skin = |&cells: &usize| match fused(specimen, cells) {
        Ok(skin) => Some(skin.object),
        Err(e) => {
            eprintln!("{} over {cells} cells: {e}", specimen.id);
            None
        }
    };
    let drawn = |object: &ArticulatedObject| -> Vec<Case> {
        (0..wanted.draws).filter_map(|d| case(object, d, judged)).collect()
    };
    if wanted.cells.is_empty() {
        return drawn(&specimen.object);
    }
    wanted.cells.iter().filter_map(skin).flat_map(|skin| drawn(&skin)).collect()
}

/// The object with a point on each part, turned by a quarter for each draw: what is front is not
/// known. Every other draw takes the face nearest the middle of the part's surface, as one does who
/// knows the part; the others any place on it, as one does who clicks.
fn case(object: &ArticulatedObject, draw: u64, is_judged: bool) -> Option<Case> {
    let turn = DQuat::from_rotation_z(FRAC_PI_2 * draw as f64);
    let mesh = &object.mesh().map_vertices(|v| turn * v).ok()?;
    let parts = object.tree().len();
    let mut rng = Pcg64Mcg::seed_from_u64(draw);
    let mut prompts = Vec::new();
    for part in 0..parts {
        let faces: Vec<usize> = object.faces_of(part).collect();
        let face = if draw.is_multiple_of(2) {
            middle_face(mesh, &faces)
        } else {
            any(mesh, &faces, &mut rng)
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
    Some(Case { layout, votes, parts, plain, beliefs })
}

/// Any of some faces, by area.
fn any(mesh: &Mesh, faces: &[usize], rng: &mut Pcg64Mcg) -> Option<usize> {
    let all: f64 = faces.iter().map(|&f| mesh.area(f)).sum();
    let mut left = all * rng.random::<f64>();
    let found = faces.iter().copied().find(|&f| {
        left -= mesh.area(f);
        left <= 0.0
    });
    found.or(faces.last().copied())
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
        let best = row.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |b| b.0);
        votes.iter().for_each(|(&truth, area)| crossed[truth][best] += area);
    }
    mean_iou(&crossed)
}

fn questions(case: &Case) -> Vec<Question> {
    let most = |v: &BTreeMap<usize, f64>| v.iter().max_by(|a, b| a.1.total_cmp(b.1)).map(|m| *m.0);
    let truth: Vec<usize> = case.votes.iter().map(|v| most(v).unwrap_or(0)).collect();
    let mut area = vec![1e-9; case.parts];
    truth.iter().enumerate().for_each(|(i, &t)| area[t] += case.layout.share(i));
    let clusters = case.layout.clusters(&case.beliefs);
    let one = |piece: usize| {
        if case.layout.seed(piece).is_some() {
            return None;
        }
        let rows = case.layout.numbers(piece, &clusters);
        let (parts, numbers): (Vec<usize>, Vec<Numbers>) =
            rows.into_iter().enumerate().filter_map(|(p, r)| Some((p, r?))).unzip();
        let share = case.layout.share(piece);
        let weight = share * (0.5 + 0.5 / (area[truth[piece]] * case.parts as f64));
        let truth = parts.iter().position(|p| *p == truth[piece])?;
        Some(Question { weight: weight as f32, truth, numbers })
    };
    (0..case.layout.len()).filter_map(one).collect()
}

/// Means of all numbers, then their spreads.
fn scale(questions: &[Vec<Question>]) -> Vec<f32> {
    let (mut sum, mut square, mut count) = ([0.0; NUMBERS], [0.0; NUMBERS], 0.0);
    for row in questions.iter().flatten().flat_map(|q| &q.numbers) {
        count += 1.0;
        for (i, &v) in row.iter().enumerate() {
            sum[i] += f64::from(v);
            square[i] += f64::from(v) * f64::from(v);
        }
    }
    let mean = sum.map(|s: f64| s / count);
    let spread = |i: usize| (square[i] / count - mean[i].powi(2)).max(0.0).sqrt().max(0.05);
    let spread: Vec<f64> = (0..NUMBERS).map(spread).collect();
    mean.into_iter().chain(spread).map(|x| x as f32).collect()
}

fn fit(train: &[Case], val: &[Case], seed: u64, wanted: &Wanted) -> Option<Net> {
    let epochs = wanted.epochs;
    let mut questions: Vec<Vec<Question>> = train.par_iter().map(questions).collect();
    let mut numbers = scale(&questions);
    numbers.resize(Net::size(wanted.units), 0.0);
    let mut net = Net::new(&numbers)?;
    questions
        .par_iter_mut()
        .flatten()
        .for_each(|q| q.numbers.iter_mut().for_each(|row| net.scale(row)));
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let worth = net.worth();
    begin(net.weights_mut(), worth, &mut rng);
    let count = net.weights().len();
    let (mut mean, mut square) = (vec![0.0f32; count], vec![0.0f32; count]);
    let per_epoch = questions.len() / BATCH;
    let (steps, mut loss) = (epochs * per_epoch, 0.0);
    for step in 1..=steps {
        let batch: Vec<(usize, u64)> =
            (0..BATCH).map(|_| (rng.random_range(0..questions.len()), rng.random())).collect();
        let slopes: Vec<(f64, Vec<f32>)> = batch
            .par_iter()
            .map(|&(i, dice)| {
                let mut dice = Pcg64Mcg::seed_from_u64(dice);
                let mut slope = vec![0.0; count];
                let loss = questions[i]
                    .iter()
                    .map(|q| add_slope(&dropped(q, wanted.drop, &mut dice), &net, &mut slope))
                    .sum();
                (loss, slope)
            })
            .collect();
        let mut slope = vec![0.0f32; count];
        for (l, s) in &slopes {
            loss += l;
            slope.iter_mut().zip(s).for_each(|(a, b)| *a += b / BATCH as f32);
        }
        let progress = (step as f32 - 1.0) / steps as f32;
        let rate = RATE * (1.0 - progress) * (step as f32 / 100.0).min(1.0);
        let warm = |decay: f32| 1.0 - decay.powi(step as i32);
        for (i, w) in net.weights_mut().iter_mut().enumerate() {
            mean[i] = 0.9 * mean[i] + 0.1 * slope[i];
            square[i] = 0.999 * square[i] + 0.001 * slope[i] * slope[i];
            let way = mean[i] / warm(0.9) / ((square[i] / warm(0.999)).sqrt() + 1e-8);
            *w -= rate * (way + wanted.decay * *w);
        }
        let told = (steps / TOLD).max(1);
        if step % told == 0 {
            let shown = val.iter().map(|c| iou_of(c, &net.answers(&c.layout, &c.beliefs)));
            let shown = shown.sum::<f64>() / val.len() as f64;
            eprintln!("  {step}: loss {:.4}, val {shown:.4}", loss / (told * BATCH) as f64);
            loss = 0.0;
        }
    }
    Some(net)
}

/// The question without some of its numbers, the same for every part.
fn dropped(q: &Question, share: f32, dice: &mut Pcg64Mcg) -> Question {
    let mut numbers = q.numbers.clone();
    for i in 0..NUMBERS {
        if dice.random::<f32>() < share {
            numbers.iter_mut().for_each(|row| row[i] = 0.0);
        }
    }
    Question { numbers, ..*q }
}

fn begin(weights: &mut [f32], worth: usize, rng: &mut Pcg64Mcg) {
    let reach = (3.0 / NUMBERS as f32).sqrt();
    for unit in weights[FIRST_UNIT..worth].chunks_mut(NUMBERS + 1) {
        unit[..NUMBERS].iter_mut().for_each(|w| *w = (2.0 * rng.random::<f32>() - 1.0) * reach);
    }
    weights[worth..].iter_mut().for_each(|w| *w = (2.0 * rng.random::<f32>() - 1.0) * 0.1);
}

/// Adds the slope of the negative log-likelihood of the true part; returns that.
fn add_slope(q: &Question, net: &Net, slope: &mut [f32]) -> f64 {
    let mut bent = vec![vec![0.0; net.units()]; q.numbers.len()];
    let scores = q.numbers.iter().zip(&mut bent).map(|(row, bent)| net.score(row, bent));
    let chances = chances(&scores.collect::<Vec<f32>>());
    let first = net.worth();
    let worth = &net.weights()[first..];
    for (k, (row, bent)) in q.numbers.iter().zip(&bent).enumerate() {
        let pull = (chances[k] - f32::from(u8::from(k == q.truth))) * q.weight;
        slope[..NUMBERS].iter_mut().zip(row).for_each(|(s, v)| *s += pull * v);
        for (u, b) in bent.iter().enumerate() {
            slope[first + u] += pull * b;
            let by = pull * worth[u] * (1.0 - b * b);
            let from = FIRST_UNIT + u * (NUMBERS + 1);
            let unit = &mut slope[from..from + NUMBERS + 1];
            unit[..NUMBERS].iter_mut().zip(row).for_each(|(s, v)| *s += by * v);
            unit[NUMBERS] += by;
        }
    }
    -f64::from(q.weight) * f64::from(chances[q.truth].max(1e-9)).ln()
}
