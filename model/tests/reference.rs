//! The network against the paper's formulas, written out once more in plain f64 loops from the
//! weights of a saved file: a golden that needs no data of others.
#![allow(clippy::unwrap_used)]

use std::io::Cursor;

use burn::tensor::Device;
use model::net::{
    Answer, Batch, Config, Example, JointQuestion, MotionType, Network, PartPrompt, Points,
    Positions, Precision,
};
use model::weights::{Header, TensorFile, load_network, save_network};

type Rows = Vec<Vec<f64>>;

fn sizes(positions: Positions) -> Config {
    Config {
        width: 18,
        heads: 3,
        blocks: 2,
        points: 23,
        tokens: 7,
        chunk: 11,
        queries: 17,
        features: 5,
        text: 4,
        max_parts: 6,
        positions,
    }
}

/// Numbers in (−½, ½) that look random and never change.
fn numbers(count: usize, seed: usize) -> Vec<f32> {
    let number =
        |i: usize| ((i + 1) as f64 * 0.754_877_666 + seed as f64 * 0.569_840_291).fract() - 0.5;
    (0..count).map(|i| number(i) as f32).collect()
}

fn points(count: usize, config: &Config, seed: usize) -> Points {
    let triples = |seed| numbers(3 * count, seed).as_chunks::<3>().0.to_vec();
    let features = numbers(count * config.features, seed + 2);
    Points { positions: triples(seed), normals: Some(triples(seed + 1)), features }
}

fn example(config: &Config) -> Example {
    let part = |text: bool, point: bool, seed: usize| PartPrompt {
        text: text.then(|| numbers(config.text, seed)),
        point: point.then(|| points(1, config, seed + 3)),
    };
    let joint = |parent, child, motion, queries: &[u32]| JointQuestion {
        parent,
        child,
        motion,
        queries: queries.to_vec(),
    };
    Example {
        shape: points(config.points, config, 1),
        parts: vec![
            part(true, true, 5),
            part(false, true, 9),
            part(true, false, 13),
            part(true, true, 17),
        ],
        queries: points(config.queries, config, 40),
        joints: vec![
            joint(0, 1, MotionType::Revolute, &[3, 16, 0]),
            joint(1, 3, MotionType::Prismatic, &[5, 3]),
        ],
    }
}

/// The weights of a file, and the paper's formulas over them.
struct Formulas {
    file: TensorFile<Cursor<Vec<u8>>>,
    config: Config,
}

impl Formulas {
    fn tensor(&mut self, name: &str) -> Vec<f64> {
        self.file.values(name).unwrap().into_iter().map(f64::from).collect()
    }

    fn linear(&mut self, name: &str, x: &Rows) -> Rows {
        let weight = self.tensor(&format!("{name}.weight"));
        let bias = format!("{name}.bias");
        let bias = self.file.shape(&bias).is_some().then(|| self.tensor(&bias));
        let row = |x: &Vec<f64>| {
            let out = weight.chunks(x.len()).enumerate();
            out.map(|(o, w)| dot(w, x) + bias.as_ref().map_or(0.0, |b| b[o])).collect()
        };
        x.iter().map(row).collect()
    }

    fn mlp(&mut self, name: &str, x: &Rows) -> Rows {
        let hidden = map(&self.linear(&format!("{name}.0"), x), |v| v / (1.0 + (-v).exp()));
        self.linear(&format!("{name}.2"), &hidden)
    }

    fn norm(&mut self, name: &str, x: &Rows) -> Rows {
        let (gain, bias) =
            (self.tensor(&format!("{name}.weight")), self.tensor(&format!("{name}.bias")));
        let row = |x: &Vec<f64>| {
            let mean = x.iter().sum::<f64>() / x.len() as f64;
            let variance = x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / x.len() as f64;
            let scale = (variance + 1e-5).sqrt();
            x.iter()
                .zip(gain.iter().zip(&bias))
                .map(|(v, (g, b))| (v - mean) / scale * g + b)
                .collect()
        };
        x.iter().map(row).collect()
    }

    /// Each head divided by its root mean square.
    fn heads(&mut self, name: &str, x: Rows) -> Vec<Vec<Vec<f64>>> {
        let gain = self.tensor(&format!("{name}.weight"));
        let head = |h: &[f64]| {
            let scale = (dot(h, h) / h.len() as f64 + 1e-6).sqrt();
            h.iter().zip(&gain).map(|(v, g)| v / scale * g).collect()
        };
        x.iter().map(|row| row.chunks(gain.len()).map(head).collect()).collect()
    }

    fn attention(&mut self, name: &str, x: &Rows, context: &Rows) -> Rows {
        let q = self.linear(&format!("{name}.to_q"), x);
        let q = self.heads(&format!("{name}.norm_q"), q);
        let k = self.linear(&format!("{name}.to_k"), context);
        let k = self.heads(&format!("{name}.norm_k"), k);
        let v = self.linear(&format!("{name}.to_v"), context);
        let width = self.config.width / self.config.heads;
        let one = |q: &Vec<f64>, h: usize| {
            let scores = k.iter().map(|k| (dot(q, &k[h]) / (width as f64).sqrt()).exp());
            let weights: Vec<f64> = scores.collect();
            let total: f64 = weights.iter().sum();
            let column = |c: usize| {
                v.iter().zip(&weights).map(|(v, w)| w * v[h * width + c]).sum::<f64>() / total
            };
            (0..width).map(column).collect::<Vec<_>>()
        };
        let rows = q.iter().map(|q| q.iter().enumerate().flat_map(|(h, q)| one(q, h)).collect());
        let rows: Rows = rows.collect();
        self.linear(&format!("{name}.to_out.0"), &rows)
    }

    fn look(&mut self, name: &str, x: Rows, context: Option<&Rows>) -> Rows {
        let y = self.norm(&format!("{name}.norm"), &x);
        let found = self.attention(name, &y, context.unwrap_or(&y));
        add(x, &found)
    }

    fn think(&mut self, name: &str, x: Rows) -> Rows {
        let y = self.norm(&format!("{name}.norm"), &x);
        let both = self.linear(&format!("{name}.net.0.proj"), &y);
        let gated = |row: &Vec<f64>| {
            let (value, gate) = row.split_at(row.len() / 2);
            value.iter().zip(gate).map(|(v, g)| v * g * normal(*g)).collect()
        };
        let out = self.linear(&format!("{name}.net.2"), &both.iter().map(gated).collect());
        add(x, &out)
    }

    fn embed(&mut self, points: &Points) -> Rows {
        let normals = points.normals.clone().unwrap();
        let position = self.mlp("pos_embed.mlp", &codes(&points.positions));
        let normal = self.mlp("normal_embed.mlp", &codes(&normals));
        let features = points.features.chunks(self.config.features);
        let features = features.map(|f| f.iter().map(|&v| v.into()).collect()).collect();
        add(add(position, &normal), &self.linear("feat_proj", &features))
    }

    fn part(&mut self, part: &PartPrompt) -> Vec<f64> {
        let mut token = vec![0.0; self.config.width];
        if let Some(text) = &part.text {
            let text = vec![text.iter().map(|&v| v.into()).collect()];
            token = add(vec![token], &self.mlp("text_embed", &text)).remove(0);
        }
        if let Some(point) = &part.point {
            token = add(vec![token], &self.embed(point)).remove(0);
        }
        token
    }

    /// Logits [Q, P] and joints [R, 12].
    fn answer(&mut self, e: &Example) -> (Rows, Rows) {
        let points = self.embed(&e.shape);
        let latents =
            self.tensor("latents").chunks(self.config.width).map(<[f64]>::to_vec).collect();
        let shape = self.look("gather", latents, Some(&points));
        let shape = self.think("digest", shape);
        let mut parts: Rows = e.parts.iter().map(|p| self.part(p)).collect();
        let mut queries = self.embed(&e.queries);
        for i in 0..self.config.blocks {
            parts = self.look(&format!("blocks.{i}.part.shape"), parts, Some(&shape));
            parts = self.look(&format!("blocks.{i}.part.parts"), parts, None);
            parts = self.think(&format!("blocks.{i}.part.mlp"), parts);
            queries = self.look(&format!("blocks.{i}.query.shape"), queries, Some(&shape));
            queries = self.look(&format!("blocks.{i}.query.parts"), queries, Some(&parts));
            queries = self.think(&format!("blocks.{i}.query.mlp"), queries);
        }
        let pairs =
            queries.iter().map(|q| parts.iter().map(|p| [&q[..], p].concat()).collect::<Rows>());
        let pairs: Vec<Rows> = pairs.collect();
        let logits = pairs.iter().map(|row| self.mlp("part_head", row).concat()).collect();
        (logits, self.joints(e, &queries, &parts))
    }

    fn joints(&mut self, e: &Example, queries: &Rows, parts: &Rows) -> Rows {
        let width = self.config.width;
        let types = self.tensor("joint_head.motion_type");
        let mut inputs = Vec::new();
        let mut at = Vec::new();
        for joint in &e.joints {
            let kind = usize::from(joint.motion == MotionType::Prismatic);
            for &q in &joint.queries {
                let kind = &types[kind * width..][..width];
                inputs.push(
                    [&queries[q as usize][..], &parts[joint.parent], &parts[joint.child], kind]
                        .concat(),
                );
                at.push(e.queries.positions[q as usize]);
            }
        }
        let mut out = self.mlp("joint_head", &inputs);
        if self.config.positions == Positions::Offset {
            for (row, at) in out.iter_mut().zip(&at) {
                (3..12).for_each(|i| row[i] += f64::from(at[i % 3]));
            }
        }
        out
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn map(x: &Rows, f: impl Fn(f64) -> f64) -> Rows {
    x.iter().map(|row| row.iter().map(|&v| f(v)).collect()).collect()
}

fn add(mut a: Rows, b: &Rows) -> Rows {
    a.iter_mut().flatten().zip(b.iter().flatten()).for_each(|(a, b)| *a += b);
    a
}

/// Φ by Simpson's rule over the density.
fn normal(x: f64) -> f64 {
    let density = |t: f64| (-t * t / 2.0).exp() / std::f64::consts::TAU.sqrt();
    let steps = 400;
    let h = x / f64::from(steps);
    let weight = |i: i32| if i == 0 || i == steps { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    0.5 + (0..=steps).map(|i| weight(i) * density(h * f64::from(i))).sum::<f64>() * h / 3.0
}

/// Waves of each coordinate, then the coordinates. The angle is rounded to single precision, as any
/// network that computes in it must: at 500 radians that shows.
fn codes(vectors: &[[f32; 3]]) -> Rows {
    let code = |v: &[f32; 3]| {
        let angle = |x: f32, i: i32| {
            let frequency = (-(10_000f32.ln()) * i as f32 / 32.0).exp();
            f64::from(1000.0 * x * frequency)
        };
        let waves = v.iter().flat_map(|&x| {
            let sines = (0..32).map(move |i| angle(x, i).sin());
            sines.chain((0..32).map(move |i| angle(x, i).cos()))
        });
        waves.chain(v.iter().map(|&x| x.into())).collect()
    };
    vectors.iter().map(code).collect()
}

fn agree(what: &str, found: &[f32], truth: &Rows) {
    let truth = truth.concat();
    assert_eq!(found.len(), truth.len(), "{what}");
    let largest = truth.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
    let off = found.iter().zip(&truth).map(|(f, t)| (f64::from(*f) - t).abs()).fold(0.0, f64::max);
    assert!(off <= 1e-5 * largest, "{what}: off by {off:.2e} of {largest:.2e}");
}

#[test]
fn the_network_is_the_papers_formulas() {
    for positions in [Positions::Absolute, Positions::Offset] {
        let config = sizes(positions);
        let network = Network::new(&config, 21, &Device::flex()).unwrap();
        let mut bytes = Vec::new();
        save_network(&network, &Header::new(&config, "", ""), &mut bytes).unwrap();
        let (network, _) =
            load_network(Cursor::new(&bytes), &Device::flex(), Precision::Full).unwrap();
        let example = example(&config);
        let batch = Batch::new(std::slice::from_ref(&example), &config, &Device::flex()).unwrap();
        let Answer { logits, joints } = network.forward(&batch);
        let file = TensorFile::open(Cursor::new(bytes)).unwrap();
        let truth = Formulas { file, config }.answer(&example);
        agree("logits", &logits.into_data().try_to_vec().unwrap(), &truth.0);
        agree("joints", &joints.into_data().try_to_vec().unwrap(), &truth.1);
    }
}
