//! What is computed on the way to labels, by name.

use crate::classic::lexicon::sizes;
use crate::classic::segment::classify;
use crate::classic::segment::grow::{distance, fused_unary};
use crate::classic::segment::prompts::{placed, repeats, seeds};
use object::{Condition, Mesh};

use crate::classic::golden::record::{Record, few, runs};
use crate::classic::lexicon::places::Place;
use crate::classic::lexicon::sizes::SizePrior;
use crate::classic::lexicon::words::meaning;
use crate::classic::segment::classify::{Asked, Probabilities};
use crate::classic::segment::classify::{pairwise_names, unary_names};
use crate::classic::segment::grow::merge::Link;
use crate::classic::segment::oversegment::patches::Cutting;
use crate::classic::segment::prompts::seeds::Seed;
use crate::classic::segment::prompts::shape;
use crate::classic::segment::prompts::shape::shape;
use crate::classic::segment::skin::Skin;
use crate::classic::segment::start::{Start, View};
use crate::classic::segment::*;

/// How many rows of a table are recorded of the usual cut, and of each other cut of a fused mesh.
const ROWS: usize = 12;
const ROWS_OF_OTHERS: usize = 4;
/// How many candidates are recorded of what is placed by its words.
const CANDIDATES: usize = 24;
/// Shares of a surface at which sizes are asked about.
const SHARES: [f64; 6] = [0.0005, 0.004, 0.03, 0.12, 0.4, 0.95];

/// Records how an object is labelled.
pub(crate) fn record(record: &mut Record, (mesh, weld): (&Mesh, &Weld), condition: &Condition) {
    let skin = Skin::of(mesh, weld);
    let start = Start::of(&skin, condition);
    let root = condition.tree.root() as u16;
    let is_fused = start.is_fused(root);
    record.section("start");
    record.numbers("components", &[skin.bodies.len() as f64]);
    record.numbers("fused share", &[start.fused]);
    record.exact("is fused", is_fused.to_string());
    let seed = |s: &Seed| format!("{}>{}", s.face, s.part);
    record.exact("prompts", start.seeds.iter().map(seed).collect::<Vec<_>>().join(" "));
    of_parts(record, condition);
    of_placed(record, condition, &skin);
    let features = |p: &SizePrior| SHARES.map(|share| p.score(share));
    record.section("sizes");
    for (part, prior) in condition.tree.parts().iter().zip(&start.priors) {
        record.numbers(&part.name, &features(prior));
    }
    of_view(record, (&start, &start.view), condition, ("usual cut", 0, is_fused));
    if is_fused {
        let others = start.asked_of_others(condition);
        for (i, (&cutting, told)) in Cutting::OTHERS.iter().zip(&others).enumerate() {
            let view = View::of(&skin, (&start.seeds, root), cutting);
            let title = format!("cut {}", i + 1);
            of_view(record, (&start, &view), condition, (&title, i + 1, true));
            record.section(format!("class probabilities as fused, {title}"));
            of_probabilities(record, condition, &told.1);
        }
    }
}

fn of_parts(record: &mut Record, condition: &Condition) {
    record.section("parts");
    for (part, facts) in condition.tree.parts().iter().enumerate() {
        let role = meaning(&facts.text, &condition.category);
        let traits = placed::traits(condition, part);
        record.exact(&facts.name, format!("{role:?} {traits:?} {:?}", Place::of(&facts.text)));
    }
}

/// What could be a part that has no prompt, what it looks like, and which is taken.
fn of_placed(record: &mut Record, condition: &Condition, skin: &Skin) {
    let Skin { mesh, component, bodies, .. } = skin;
    let thing_of = |face: usize| (component[face], bodies[component[face] as usize].area);
    let (mut seeds, _) = seeds::seeds(mesh, condition, thing_of);
    seeds.extend(repeats::place(condition, component, bodies, &seeds).0);
    let open = placed::open(condition, &seeds);
    if open.is_empty() {
        return;
    }
    let (units, candidates) = skin.placeable();
    let shape = shape(candidates, units);
    let row = |c: usize| (c.to_string(), shape[c].to_vec());
    let rows: Vec<_> = few(shape.len(), CANDIDATES).into_iter().map(row).collect();
    record.table("descriptor, candidates", &shape::NAMES, &rows);
    let puzzle = placed::puzzle(condition, (units, candidates), (&open, &seeds));
    record.section("fits");
    for (part, fits) in condition.tree.parts().iter().zip(&puzzle.fits) {
        record.numbers(&part.name, fits);
    }
    let choice = placed::choose(condition, (units, candidates), (&open, &seeds));
    let members = |c: &usize| format!("{:?}", candidates.units(*c));
    for (part, chosen) in condition.tree.parts().iter().zip(&choice) {
        let chosen = chosen.as_ref().map_or("none".into(), members);
        record.exact(format!("{} is placed on", part.name), chosen);
    }
}

/// A surface cut in one way: its segments, the links between them, what is asked and what is answered.
fn of_view(
    record: &mut Record,
    (start, view): (&Start, &View),
    condition: &Condition,
    (title, ensemble, is_fused): (&str, usize, bool),
) {
    let cut = &view.cut;
    record.section(format!("segments, {title}"));
    record.exact("of faces", runs(&cut.of_face));
    record.numbers("share", &cut.segments.iter().map(|p| p.share).collect::<Vec<_>>());
    let groups = start.groups(view, condition);
    let labels: Vec<i32> = groups.iter().map(|g| g.label.map_or(-1, i32::from)).collect();
    record.exact("merged", runs(&labels));
    of_links(record, view, title);
    of_growth(record, (start, view), condition, (title, is_fused));
    let mut layout = start.layout(view, condition);
    let most = if ensemble == 0 { ROWS } else { ROWS_OF_OTHERS };
    let segment_pairs = layout.segment_pairs();
    let row = |i: usize| {
        let segment_pair = &segment_pairs[i];
        (
            format!("{}-{}", segment_pair.small, segment_pair.large),
            segment_pair.features.map(f64::from).to_vec(),
        )
    };
    let rows: Vec<_> = few(segment_pairs.len(), most).into_iter().map(row).collect();
    record.table(format!("pairwise, {title}"), &pairwise_names(), &rows);
    let rounds = classify::rounds(&mut layout, is_fused, Asked::Ensemble(ensemble));
    record.section(format!("affinity, {title}"));
    record.numbers(
        "probability",
        &layout.pair_chances().iter().map(|&c| f64::from(c)).collect::<Vec<_>>(),
    );
    for (round, told) in rounds.iter().enumerate() {
        if round + 1 < rounds.len() {
            of_unary(record, &layout, told, (&format!("{title} before round {round}"), most));
        }
        record.section(format!("class probabilities, {title} before round {round}"));
        of_probabilities(record, condition, told);
    }
}

fn of_links(record: &mut Record, view: &View, title: &str) {
    let row = |l: &Link| (format!("{}-{}", l.a, l.b), vec![l.evidence, l.weight, l.barrier]);
    let rows: Vec<_> = view.links.iter().map(row).collect();
    record.table(format!("evidence, {title}"), &["evidence", "weight", "barrier"], &rows);
}

/// What merging weighs beside evidence.
fn of_growth(
    record: &mut Record,
    (start, view): (&Start, &View),
    condition: &Condition,
    (title, is_fused): (&str, bool),
) {
    if !is_fused {
        record.section(format!("ways, {title}"));
        let far = distance::far(&view.cut.segments, &view.links, start.priors.len());
        for (i, row) in far.iter().enumerate() {
            record.numbers(i.to_string(), row);
        }
        return;
    }
    let fused_surface = start.fused_surface(view, condition);
    let mut rows = Vec::new();
    for (segment, parts) in fused_unary::features(&fused_surface).iter().enumerate() {
        let told = parts.iter().enumerate().filter_map(|(p, n)| n.map(|n| (p, n)));
        rows.extend(told.map(|(part, n)| (format!("{segment}>{part}"), n.to_vec())));
    }
    let rows: Vec<_> = few(rows.len(), ROWS).into_iter().map(|i| rows[i].clone()).collect();
    record.table(format!("fused unary, {title}"), &fused_unary::NAMES, &rows);
    record.section(format!("fused unary term, {title}"));
    for (i, row) in fused_unary::against(&fused_surface).iter().enumerate() {
        record.numbers(i.to_string(), row);
    }
}

fn of_unary(
    record: &mut Record,
    layout: &Layout,
    told: &Probabilities,
    (title, most): (&str, usize),
) {
    let clusters = layout.clusters(told);
    let mut rows = Vec::new();
    for segment in (0..layout.len()).filter(|&s| layout.seed(s).is_none()) {
        let parts = layout.features(segment, &clusters).into_iter().enumerate();
        let told = parts.filter_map(|(p, n)| n.map(|n| (p, n)));
        rows.extend(told.map(|(part, n)| (format!("{segment}>{part}"), n.map(f64::from).to_vec())));
    }
    let rows: Vec<_> = few(rows.len(), most).into_iter().map(|i| rows[i].clone()).collect();
    record.table(format!("unary, {title}"), &unary_names(), &rows);
}

fn of_probabilities(record: &mut Record, condition: &Condition, told: &Probabilities) {
    for (i, part) in condition.tree.parts().iter().enumerate() {
        let column: Vec<f64> = told.iter().map(|row| f64::from(row[i])).collect();
        record.numbers(&part.name, &column);
    }
}

/// Texts of parts, of which some say more than one thing.
const TEXTS: [&str; 16] = [
    "second control knob from left",
    "door with handle",
    "lid release button",
    "handwheels",
    "lightswitchroot",
    "upper left drawer",
    "rear right caster wheel 3",
    "inner ring",
    "glove box lid",
    "tilting screen",
    "pan head",
    "folding leg",
    "body of the lamp",
    "third pedal",
    "spout with knob",
    "thing 7",
];

/// Records what words mean, whatever the object.
pub(crate) fn tables(record: &mut Record) {
    for category in ["", "oven"] {
        record.section(format!("words, category {category:?}"));
        for text in TEXTS {
            record.exact(text, format!("{:?}", meaning(text, category)));
        }
    }
    record.section("places");
    for text in TEXTS {
        let kind = (sizes::family(text), sizes::noun(text), sizes::named(text));
        record.exact(text, format!("{:?} {kind:?}", Place::of(text)));
    }
    record.section("size by words");
    for text in TEXTS {
        for is_base in [false, true] {
            let prior = SizePrior::of(text, is_base);
            let name = format!("{text}{}", if is_base { ", the base" } else { "" });
            record.numbers(&name, &SHARES.map(|share| prior.score(share)));
            let allowed = SHARES.map(|share| prior.allows(share));
            record.exact(format!("{name}, allowed"), format!("{allowed:?}"));
        }
    }
}
