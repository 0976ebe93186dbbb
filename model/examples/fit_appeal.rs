//! Fits the weights that say which part a piece of a skin belongs to.
//!
//! `fit_appeal CASES…`: folders with `mesh.glb`, `condition.json` and `face_labels.u16le`; those
//! that are no skin are passed over. A multinomial logit over the parts of each piece, by Newton's
//! method: the same folders give the same weights. Half the weight of an object goes to its pieces
//! by area, half to its parts alike, so that small parts count.

// Matrices read best by index.
#![allow(clippy::print_stdout, clippy::print_stderr, clippy::needless_range_loop)]

use std::collections::BTreeMap;
use std::path::Path;

use model::geometric::labels::appeal::{NUMBERS, Numbers};
use model::geometric::labels::{Sheet, sheet};
use object::Condition;
use object::weld::Weld;
use rayon::prelude::*;

type Anyhow = Box<dyn std::error::Error + Send + Sync>;

/// Weights of children, weights of the base, the base beforehand.
const SIZE: usize = 2 * NUMBERS + 1;
type Weights = [f64; SIZE];
type Square = [[f64; SIZE]; SIZE];

/// Rounds of Newton's method at most, and the step that is none any more.
const ROUNDS: usize = 20;
const STILL: f64 = 1e-4;
/// Longest step of a weight.
const STRIDE: f64 = 3.0;
/// What a squared weight costs.
const RIDGE: f64 = 0.1;

/// A piece: its weight, its true part, and for each part with a prompt what is known of the two.
struct Piece {
    weight: f64,
    truth: usize,
    parts: Vec<(usize, Weights)>,
}

fn main() -> Result<(), Anyhow> {
    let cases: Vec<String> = std::env::args().skip(1).collect();
    let read = |case: &String| read(Path::new(case)).map_err(|e| format!("{case}: {e}"));
    let objects = cases.par_iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let objects: Vec<Vec<Piece>> = objects.into_iter().flatten().collect();
    eprintln!("{} skins of {} objects", objects.len(), cases.len());
    let weights = fit(&objects);
    let list = |w: &[f64]| w.iter().map(|w| format!("{w:.3}")).collect::<Vec<_>>().join(", ");
    println!("const CHILD: Numbers = [{}];", list(&weights[..NUMBERS]));
    println!("const BASE: Numbers = [{}];", list(&weights[NUMBERS..2 * NUMBERS]));
    println!("const BASE_BIAS: f64 = {:.3};", weights[2 * NUMBERS]);
    Ok(())
}

/// The pieces of an object; nothing if it is no skin.
fn read(dir: &Path) -> Result<Option<Vec<Piece>>, Anyhow> {
    let mesh = object::glb::read(&std::fs::read(dir.join("mesh.glb"))?)?;
    let condition = std::fs::read_to_string(dir.join("condition.json"))?;
    let condition = Condition::from_json(&condition)?;
    let labels = std::fs::read(dir.join("face_labels.u16le"))?;
    let labels = labels.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]]));
    let Some(sheet) = sheet(&mesh, &condition, &Weld::new(&mesh)) else { return Ok(None) };
    let mut votes = vec![BTreeMap::<usize, f64>::new(); sheet.share.len()];
    for (face, label) in labels.enumerate() {
        let piece = sheet.piece_of_face[face] as usize;
        *votes[piece].entry(label.into()).or_default() += mesh.area(face);
    }
    let most = |v: &BTreeMap<usize, f64>| v.iter().max_by(|a, b| a.1.total_cmp(b.1)).map(|m| *m.0);
    let truth: Vec<usize> = votes.iter().map(|v| most(v).unwrap_or(0)).collect();
    Ok(Some(pieces(&sheet, &truth, condition.tree.root())))
}

fn pieces(sheet: &Sheet, truth: &[usize], root: usize) -> Vec<Piece> {
    let mut area = BTreeMap::<usize, f64>::new();
    truth.iter().zip(&sheet.share).for_each(|(&t, s)| *area.entry(t).or_default() += s);
    let parts = sheet.numbers.first().map_or(1, Vec::len) as f64;
    let known = |row: &[Option<Numbers>]| {
        let asked =
            |(part, x): (usize, &Option<Numbers>)| Some((part, spread(x.as_ref()?, part == root)));
        row.iter().enumerate().filter_map(asked).collect()
    };
    let piece = |i: usize| {
        let each = 0.5 / (area[&truth[i]].max(1e-9) * parts);
        let weight = sheet.share[i] * (0.5 + each);
        Piece { weight, truth: truth[i], parts: known(&sheet.numbers[i]) }
    };
    let whole = (0..truth.len()).map(piece);
    whole.filter(|p| p.parts.iter().any(|(part, _)| *part == p.truth)).collect()
}

/// Numbers in the places of their weights.
fn spread(x: &Numbers, base: bool) -> Weights {
    let mut wide = [0.0; SIZE];
    let from = if base { NUMBERS } else { 0 };
    wide[from..from + NUMBERS].copy_from_slice(x);
    wide[2 * NUMBERS] = f64::from(u8::from(base));
    wide
}

fn fit(objects: &[Vec<Piece>]) -> Weights {
    let mut weights = [0.0; SIZE];
    for round in 0..ROUNDS {
        let slope = |pieces: &Vec<Piece>| {
            let mut slope = Slope::default();
            pieces.iter().for_each(|p| slope.add(p, &weights));
            slope
        };
        let slopes: Vec<Slope> = objects.par_iter().map(slope).collect();
        let mut all = Slope::default();
        slopes.iter().for_each(|s| all.merge(s));
        for i in 0..SIZE {
            all.down[i] -= RIDGE * weights[i];
            all.bend[i][i] += RIDGE;
        }
        let step = solve(all.bend, all.down);
        let longest = step.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
        let stride = (STRIDE / longest).min(1.0);
        weights.iter_mut().zip(step).for_each(|(w, s)| *w += stride * s);
        eprintln!("round {round}: loss {:.4} per object", all.loss / objects.len() as f64);
        if longest < STILL {
            break;
        }
    }
    weights
}

/// The loss, its negative gradient and its Hessian.
#[derive(Default)]
struct Slope {
    loss: f64,
    down: Weights,
    bend: Square,
}

impl Slope {
    fn add(&mut self, piece: &Piece, weights: &Weights) {
        let score = |x: &Weights| x.iter().zip(weights).map(|(a, b)| a * b).sum::<f64>();
        let scores: Vec<f64> = piece.parts.iter().map(|(_, x)| score(x)).collect();
        let most = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let whole: f64 = scores.iter().map(|s| (s - most).exp()).sum();
        let mut mean = [0.0; SIZE];
        for ((part, x), score) in piece.parts.iter().zip(&scores) {
            let chance = (score - most).exp() / whole;
            let right = f64::from(u8::from(*part == piece.truth));
            self.loss -= piece.weight * right * chance.max(1e-12).ln();
            for i in 0..SIZE {
                mean[i] += chance * x[i];
                self.down[i] += piece.weight * (right - chance) * x[i];
                for j in 0..SIZE {
                    self.bend[i][j] += piece.weight * chance * x[i] * x[j];
                }
            }
        }
        for i in 0..SIZE {
            for j in 0..SIZE {
                self.bend[i][j] -= piece.weight * mean[i] * mean[j];
            }
        }
    }

    fn merge(&mut self, other: &Self) {
        self.loss += other.loss;
        for i in 0..SIZE {
            self.down[i] += other.down[i];
            for j in 0..SIZE {
                self.bend[i][j] += other.bend[i][j];
            }
        }
    }
}

/// Solves a x = b by elimination; `a` is positive definite.
fn solve(mut a: Square, mut b: Weights) -> Weights {
    for i in 0..SIZE {
        for row in i + 1..SIZE {
            let share = a[row][i] / a[i][i];
            for column in i..SIZE {
                a[row][column] -= share * a[i][column];
            }
            b[row] -= share * b[i];
        }
    }
    for i in (0..SIZE).rev() {
        let known: f64 = (i + 1..SIZE).map(|j| a[i][j] * b[j]).sum();
        b[i] = (b[i] - known) / a[i][i];
    }
    b
}
