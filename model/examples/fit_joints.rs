//! Fits the networks that choose joint axes to dumped candidates and writes them as Rust.
//!
//! `fit_joints TABLE.rs DUMP.tsv…`, dumps made by `dump_joints`. A conditional logit: each joint
//! picks one of its candidates, any within 15° and 5 % of the largest extent is right. Numbers are
//! weighed linearly, by all joints and by those of the role, and taken together by hidden units
//! that know the role. Adam on small batches, weights decaying: the same dumps give the same table.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::collections::BTreeMap;
use std::fmt::Write;

use model::geometric::features::COUNT;
use model::geometric::words::ROLES;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

type Anyhow = Box<dyn std::error::Error>;
type Row = [f64; COUNT];

/// Hidden units.
const UNITS: usize = 20;
/// What a unit is told beside the numbers: one, whether the turn is endless, the role.
const TOLD: usize = 2 + ROLES.len();
/// A unit's weights: of the numbers, of what it is told, and what it is worth.
const UNIT: usize = COUNT + TOLD + 1;
/// All weights: of every joint, of each role, of the units.
const SIZE: usize = COUNT * (1 + ROLES.len()) + UNITS * UNIT;
const FIRST_UNIT: usize = COUNT * (1 + ROLES.len());
/// Times every joint is seen, joints seen together, the length of the first step.
const EPOCHS: usize = 8;
const BATCH: usize = 16;
const RATE: f64 = 0.003;
/// How fast weights decay; those of roles three times as fast.
const DECAY: f64 = 0.03;

/// One joint with its candidates.
struct Joint {
    group: (String, String, usize),
    slides: bool,
    endless: bool,
    role: usize,
    weight: f64,
    right: Vec<bool>,
    numbers: Vec<Row>,
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
    let mut text = String::new();
    for (name, slides) in [("TURNS", false), ("SLIDES", true)] {
        let mut own: Vec<&mut Joint> = joints.iter_mut().filter(|j| j.slides == slides).collect();
        let scale = standardise(&mut own);
        let weights = fit(&own);
        writeln!(text, "{}", net_text(name, &weights, &scale)?)?;
    }
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
                    weight: 1.0,
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

/// Mean and spread of each number.
struct Scale {
    mean: Row,
    spread: Row,
}

/// Brings all numbers to mean 0 and spread 1.
fn standardise(joints: &mut [&mut Joint]) -> Scale {
    let (mut sum, mut square, mut count) = ([0.0; COUNT], [0.0; COUNT], 0.0);
    for row in joints.iter().flat_map(|j| &j.numbers) {
        count += 1.0;
        for (i, v) in row.iter().enumerate() {
            sum[i] += v;
            square[i] += v * v;
        }
    }
    let mean = sum.map(|s| s / count);
    let mut spread = [0.0; COUNT];
    for (i, s) in spread.iter_mut().enumerate() {
        *s = (square[i] / count - mean[i].powi(2)).max(0.0).sqrt().max(0.05);
    }
    for row in joints.iter_mut().flat_map(|j| &mut j.numbers) {
        for (i, v) in row.iter_mut().enumerate() {
            *v = (*v - mean[i]) / spread[i];
        }
    }
    Scale { mean, spread }
}

fn fit(joints: &[&mut Joint]) -> Vec<f64> {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let mut weights = vec![0.0; SIZE];
    for unit in weights[FIRST_UNIT..].chunks_mut(UNIT) {
        let reach = (3.0 / (COUNT + TOLD) as f64).sqrt();
        unit.iter_mut().for_each(|w| *w = (2.0 * rng.random::<f64>() - 1.0) * reach);
        unit[UNIT - 1] *= 0.1 / reach;
    }
    let (mut mean, mut square) = (vec![0.0; SIZE], vec![0.0; SIZE]);
    let steps = EPOCHS * joints.len() / BATCH;
    for step in 1..=steps {
        let mut slope = vec![0.0; SIZE];
        for _ in 0..BATCH {
            add_slope(joints[rng.random_range(0..joints.len())], &weights, &mut slope);
        }
        let rate = RATE * (1.0 - (step as f64 - 1.0) / steps as f64);
        let warm = |decay: f64| 1.0 - decay.powi(step as i32);
        for (i, w) in weights.iter_mut().enumerate() {
            mean[i] = 0.9 * mean[i] + 0.1 * slope[i];
            square[i] = 0.999 * square[i] + 0.001 * slope[i] * slope[i];
            let way = mean[i] / warm(0.9) / ((square[i] / warm(0.999)).sqrt() + 1e-8);
            let of_role = (COUNT..FIRST_UNIT).contains(&i);
            *w -= rate * (way + if of_role { 3.0 * DECAY } else { DECAY } * *w);
        }
    }
    weights
}

/// A unit's sum before its bend.
fn lean(joint: &Joint, row: &Row, unit: &[f64]) -> f64 {
    let endless = if joint.endless { unit[COUNT + 1] } else { 0.0 };
    dot(row, unit) + unit[COUNT] + endless + unit[COUNT + 2 + joint.role]
}

fn dot(row: &Row, weights: &[f64]) -> f64 {
    row.iter().zip(weights).map(|(r, w)| r * w).sum()
}

fn score(joint: &Joint, row: &Row, weights: &[f64]) -> f64 {
    let units = weights[FIRST_UNIT..].chunks(UNIT);
    let bent = units.map(|unit| unit[UNIT - 1] * lean(joint, row, unit).tanh());
    dot(row, weights) + dot(row, &weights[COUNT * (1 + joint.role)..]) + bent.sum::<f64>()
}

/// Adds the slope of the negative log-likelihood of a right pick.
fn add_slope(joint: &Joint, weights: &[f64], slope: &mut [f64]) {
    let scores: Vec<f64> = joint.numbers.iter().map(|row| score(joint, row, weights)).collect();
    let best = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let likely: Vec<f64> = scores.iter().map(|s| (s - best).exp()).collect();
    let all: f64 = likely.iter().sum();
    let picked = likely.iter().zip(&joint.right).filter(|(_, r)| **r).map(|(l, _)| l);
    let right = picked.sum::<f64>() + 1e-9 * all;
    for ((row, l), r) in joint.numbers.iter().zip(&likely).zip(&joint.right) {
        let pull = (l / all - if *r { l / right } else { 0.0 }) * joint.weight / BATCH as f64;
        let add = |slope: &mut [f64], by: f64| {
            slope.iter_mut().zip(row).for_each(|(s, v)| *s += by * v);
        };
        add(slope, pull);
        add(&mut slope[COUNT * (1 + joint.role)..], pull);
        let units = weights[FIRST_UNIT..].chunks(UNIT);
        for (unit, slope) in units.zip(slope[FIRST_UNIT..].chunks_mut(UNIT)) {
            let bent = lean(joint, row, unit).tanh();
            slope[UNIT - 1] += pull * bent;
            let by = pull * unit[UNIT - 1] * (1.0 - bent * bent);
            add(slope, by);
            slope[COUNT] += by;
            slope[COUNT + 1] += if joint.endless { by } else { 0.0 };
            slope[COUNT + 2 + joint.role] += by;
        }
    }
}

/// A network for numbers as they are measured: their scale goes into the weights.
fn net_text(name: &str, weights: &[f64], scale: &Scale) -> Result<String, Anyhow> {
    let raw = |w: &[f64]| -> Vec<f64> { w.iter().zip(&scale.spread).map(|(w, s)| w / s).collect() };
    let shift = |w: &[f64]| raw(w).iter().zip(&scale.mean).map(|(w, m)| w * m).sum::<f64>();
    let list = |w: &[f64]| {
        let cells: Vec<String> = w.iter().map(|w| format!("{w:.3}")).collect();
        format!("[{}]", cells.join(", "))
    };
    let mut out = String::new();
    writeln!(out, "pub static {name}: Net<{UNITS}> = Net {{")?;
    writeln!(out, "linear: {}, roles: [", list(&raw(&weights[..COUNT])))?;
    for role in weights[COUNT..FIRST_UNIT].chunks(COUNT) {
        writeln!(out, "{},", list(&raw(role)))?;
    }
    writeln!(out, "], units: [")?;
    for unit in weights[FIRST_UNIT..].chunks(UNIT) {
        let (numbers, told) = (&unit[..COUNT], &unit[COUNT..]);
        let (gain, bias) = (unit[UNIT - 1], told[0] - shift(numbers));
        let roles = list(&told[2..TOLD]);
        let (endless, numbers) = (told[1], list(&raw(numbers)));
        write!(out, "Unit {{ gain: {gain:.3}, bias: {bias:.3}, endless: {endless:.3}, ")?;
        writeln!(out, "roles: {roles}, weights: {numbers} }},")?;
    }
    writeln!(out, "] }};")?;
    Ok(out)
}
