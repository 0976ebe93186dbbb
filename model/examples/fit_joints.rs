//! Fits the score table of joint axes to dumped candidates and writes it as Rust.
//!
//! `fit_joints TABLE.rs PLAIN.tsv [SKIN.tsv STRETCHED.tsv…]`, dumps made by `dump_joints`. A
//! conditional logit: each joint picks one of its candidates, any within 15° and 5 % of the largest
//! extent is right. Weights are shared by all joints, corrected per role; role corrections are drawn
//! towards what the words mean ([`MEANINGS`]). Full-batch Adam from zero: the same dumps give the
//! same table.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::collections::BTreeMap;
use std::fmt::Write;

use model::geometric::features::{COUNT, NAMES};
use model::geometric::words::{ROLES, Role};

type Anyhow = Box<dyn std::error::Error>;
type Row = [f64; COUNT];

/// Steps of the optimiser and the length of the first.
const STEPS: usize = 700;
const RATE: f64 = 0.05;
/// How strongly shared weights, those of endless turns and role corrections are kept small.
const KEEP: [f64; 3] = [0.05, 0.3, 0.3];
/// Altered copies (skins, stretched) count this much.
const COPY: f64 = 0.5;

/// What words mean before any data: role, slide or turn, number, weight.
const MEANINGS: [(Role, bool, &str, f64); 24] = [
    (Role::Drawer, true, "upright", -4.0),
    (Role::Drawer, true, "outward_one_way", 4.0),
    (Role::Drawer, true, "outward_free", 2.0),
    (Role::Drawer, true, "firm_more", -2.0),
    (Role::Button, true, "outward_free", 4.0),
    (Role::Button, true, "thin", 1.0),
    (Role::Door, true, "upright", -3.0),
    (Role::Lift, true, "upright", 2.0),
    (Role::Door, false, "upright", 4.0),
    (Role::Door, false, "handle", -1.5),
    (Role::Door, false, "twin", -1.0),
    (Role::FallDoor, false, "upright", -5.0),
    (Role::FallDoor, false, "high", -4.0),
    (Role::FallDoor, false, "high_far", 1.0),
    (Role::Lid, false, "upright", -4.0),
    (Role::Lid, false, "handle", -1.5),
    (Role::Lid, false, "high", -0.5),
    (Role::Flap, false, "upright", -1.0),
    (Role::Flap, false, "high_far", 1.5),
    (Role::Knob, false, "outward", 2.0),
    (Role::Knob, false, "round", 1.0),
    (Role::Knob, false, "off_centre_squared", -3.0),
    (Role::Wheel, false, "round", 2.0),
    (Role::Wheel, false, "off_centre_squared", -3.0),
];

/// One joint with its candidates, numbers divided by their spread.
struct Joint {
    group: (String, String, usize),
    slides: bool,
    endless: bool,
    role: usize,
    weight: f64,
    right: Vec<bool>,
    numbers: Vec<Row>,
}

/// Everything fitted, in spreads: shared weights of turns and slides, of endless turns, of roles.
#[derive(Clone)]
struct Weights(Vec<Row>);

const ENDLESS: usize = 2;
const ROLE_ROWS: usize = 3;

impl Weights {
    fn rows(joint: &Joint) -> impl Iterator<Item = usize> {
        let kind = usize::from(joint.slides);
        let role = ROLE_ROWS + kind * ROLES.len() + joint.role;
        [Some(kind), Some(role), joint.endless.then_some(ENDLESS)].into_iter().flatten()
    }

    fn of(&self, joint: &Joint) -> Row {
        let mut sum = [0.0; COUNT];
        for row in Self::rows(joint) {
            sum.iter_mut().zip(&self.0[row]).for_each(|(s, w)| *s += w);
        }
        sum
    }
}

fn main() -> Result<(), Anyhow> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [table, dumps @ ..] = &args[..] else { return Err("TABLE.rs DUMPS.tsv…".into()) };
    let mut joints = Vec::new();
    for (copy, dump) in dumps.iter().enumerate() {
        joints.extend(read(&std::fs::read_to_string(dump)?, copy)?);
    }
    joints.retain(|j| j.right.iter().any(|r| *r));
    weigh(&mut joints);
    let spread = spread(&mut joints);
    let weights = fit(&joints, &spread);
    let text = table_text(&weights, &spread, joints.len())?;
    std::fs::write(table, text)?;
    Ok(())
}

fn read(dump: &str, copy: usize) -> Result<Vec<Joint>, Anyhow> {
    let mut joints: Vec<Joint> = Vec::new();
    for line in dump.lines() {
        let cells: Vec<&str> = line.split('\t').collect();
        match cells[..] {
            ["J", case, _, _, kind, role, text, ..] => {
                let stem = text.chars().filter(|c| !c.is_ascii_digit()).collect();
                joints.push(Joint {
                    group: (case.to_string(), stem, copy),
                    slides: kind == "Prismatic",
                    endless: kind == "Continuous",
                    role: role.parse()?,
                    weight: if copy > 0 { COPY } else { 1.0 },
                    right: Vec::new(),
                    numbers: Vec::new(),
                });
            }
            ["C", angle, line, ref numbers @ ..] if numbers.len() >= COUNT => {
                let Some(joint) = joints.last_mut() else { continue };
                let right = angle.parse::<f64>()? < 15.0 && line.parse::<f64>()? < 0.05;
                let mut row = [0.0; COUNT];
                for (r, n) in row.iter_mut().zip(numbers) {
                    *r = n.parse()?;
                }
                joint.right.push(right);
                joint.numbers.push(row);
            }
            _ => {}
        }
    }
    Ok(joints)
}

/// Twelve equal buttons of one object count as the root of twelve.
fn weigh(joints: &mut [Joint]) {
    let mut count: BTreeMap<_, f64> = BTreeMap::new();
    joints.iter().for_each(|j| *count.entry(j.group.clone()).or_default() += 1.0);
    joints.iter_mut().for_each(|j| j.weight /= count[&j.group].sqrt());
}

/// Standard deviation of each number; divides all numbers by it.
fn spread(joints: &mut [Joint]) -> Row {
    let (mut sum, mut square, mut count) = ([0.0; COUNT], [0.0; COUNT], 0.0);
    for row in joints.iter().flat_map(|j| &j.numbers) {
        count += 1.0;
        for (i, v) in row.iter().enumerate() {
            sum[i] += v;
            square[i] += v * v;
        }
    }
    let mut out = [0.0; COUNT];
    for (i, o) in out.iter_mut().enumerate() {
        *o = (square[i] / count - (sum[i] / count).powi(2)).max(0.0).sqrt().max(0.05);
    }
    for row in joints.iter_mut().flat_map(|j| &mut j.numbers) {
        row.iter_mut().zip(&out).for_each(|(v, s)| *v /= s);
    }
    out
}

/// The words' meaning as role rows, in spreads.
fn prior(spread: &Row) -> Weights {
    let mut rows = vec![[0.0; COUNT]; ROLE_ROWS + 2 * ROLES.len()];
    for (role, slides, name, weight) in MEANINGS {
        let row = ROLES.iter().position(|r| *r == role).unwrap_or(0);
        let column = NAMES.iter().position(|n| *n == name).unwrap_or(0);
        rows[ROLE_ROWS + usize::from(slides) * ROLES.len() + row][column] = weight * spread[column];
    }
    Weights(rows)
}

fn fit(joints: &[Joint], spread: &Row) -> Weights {
    let start = prior(spread);
    let mut weights = start.clone();
    let zero = vec![[0.0; COUNT]; weights.0.len()];
    let (mut mean, mut square) = (zero.clone(), zero);
    for step in 1..=STEPS {
        let (loss, slope) = slope(joints, &weights, &start);
        if step % 100 == 0 {
            eprintln!("step {step}: loss {loss:.2}");
        }
        let rate = RATE * (1.0 - (step as f64 - 1.0) / STEPS as f64);
        let warm = |decay: f64| 1.0 - decay.powi(step as i32);
        for (r, row) in weights.0.iter_mut().enumerate() {
            for (c, w) in row.iter_mut().enumerate() {
                let g = slope[r][c];
                mean[r][c] = 0.9 * mean[r][c] + 0.1 * g;
                square[r][c] = 0.999 * square[r][c] + 0.001 * g * g;
                let scale = (square[r][c] / warm(0.999)).sqrt() + 1e-8;
                *w -= rate * mean[r][c] / warm(0.9) / scale;
            }
        }
    }
    weights
}

/// Loss and its slope: negative log-likelihood of a right pick, and the pull towards the start.
fn slope(joints: &[Joint], weights: &Weights, start: &Weights) -> (f64, Vec<Row>) {
    let mut slope = vec![[0.0; COUNT]; weights.0.len()];
    let mut loss = 0.0;
    for joint in joints {
        let own = weights.of(joint);
        let score = |row: &Row| row.iter().zip(&own).map(|(v, w)| v * w).sum::<f64>();
        let scores: Vec<f64> = joint.numbers.iter().map(score).collect();
        let best = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let likely: Vec<f64> = scores.iter().map(|s| (s - best).exp()).collect();
        let all: f64 = likely.iter().sum();
        let picked = likely.iter().zip(&joint.right).filter(|(_, r)| **r).map(|(l, _)| l);
        let right = picked.sum::<f64>() + 1e-9 * all;
        loss += joint.weight * (all / right).ln();
        let mut pull = [0.0; COUNT];
        for ((row, l), r) in joint.numbers.iter().zip(&likely).zip(&joint.right) {
            let share = l / all - if *r { l / right } else { 0.0 };
            pull.iter_mut().zip(row).for_each(|(p, v)| *p += joint.weight * share * v);
        }
        for row in Weights::rows(joint) {
            slope[row].iter_mut().zip(&pull).for_each(|(s, p)| *s += p);
        }
    }
    for (r, row) in slope.iter_mut().enumerate() {
        let keep = if r >= ROLE_ROWS { KEEP[2] } else { KEEP[usize::from(r == ENDLESS)] };
        for (c, s) in row.iter_mut().enumerate() {
            let away = weights.0[r][c] - start.0[r][c];
            loss += keep * away * away;
            *s += 2.0 * keep * away;
        }
    }
    (loss, slope)
}

fn table_text(weights: &Weights, spread: &Row, joints: usize) -> Result<String, Anyhow> {
    let row = |r: &Row| {
        let cells: Vec<String> = r.iter().zip(spread).map(|(w, s)| tenth(w / s)).collect();
        format!("[{}]", cells.join(", "))
    };
    let mut out = String::new();
    writeln!(
        out,
        "//! Weights of the choice among candidate axes, one per number of `features::NAMES`.
//!
//! A conditional logit fitted by `examples/fit_joints.rs` on {joints} joints of Articraft training
//! objects (CC BY 4.0, by the Articraft project) with true part labels: as they are, as outer skins,
//! and stretched. Not to be edited by hand.

use super::features::COUNT;
use super::words::ROLES;

/// One weight per number.
type Row = [f64; COUNT];
"
    )?;
    let shared = [
        ("TURNS", "Weights of every turn."),
        ("SLIDES", "Weights of every slide."),
        ("ENDLESS", "What a turn without limits adds."),
    ];
    for ((name, doc), r) in shared.iter().zip(&weights.0) {
        writeln!(out, "/// {doc}\npub const {name}: Row =\n    {};\n", row(r))?;
    }
    let roles = [
        ("ROLE_TURNS", "What each role adds to a turn, in the order of `ROLES`."),
        ("ROLE_SLIDES", "What each role adds to a slide, in the order of `ROLES`."),
    ];
    for ((name, doc), rows) in roles.iter().zip(weights.0[ROLE_ROWS..].chunks(ROLES.len())) {
        writeln!(out, "/// {doc}\npub const {name}: [Row; ROLES.len()] = [")?;
        rows.iter().try_for_each(|r| writeln!(out, "{},", row(r)))?;
        writeln!(out, "];\n")?;
    }
    Ok(out)
}

fn tenth(w: f64) -> String {
    let w = (w * 10.0).round() / 10.0;
    format!("{:.1}", if w == 0.0 { 0.0 } else { w })
}
