//! What the network promises, at tiny odd sizes with random parameters.

use burn::module::{Module, ModuleVisitor, Param};
use burn::optim::{AdamWConfig, GradientsParams};
use burn::tensor::{Device, Gradients, Tensor};

use super::batch::{Example, JointQuestion, PartPrompt};
use super::kernel::tests::numbers;
use super::*;

fn sizes() -> Config {
    Config {
        width: 24,
        heads: 3,
        blocks: 2,
        points: 37,
        tokens: 11,
        chunk: 13,
        queries: 29,
        features: 5,
        text: 7,
        max_parts: 5,
        positions: Positions::Offset,
    }
}

fn triples(count: usize, seed: u32) -> Vec<[f32; 3]> {
    numbers(3 * count, seed).as_chunks::<3>().0.iter().map(|p| p.map(|x| x * 0.5)).collect()
}

fn points(count: usize, config: &Config, seed: u32) -> Points {
    let features = numbers(count * config.features, seed + 2);
    Points { positions: triples(count, seed), normals: Some(triples(count, seed + 1)), features }
}

fn part(config: &Config, seed: u32) -> PartPrompt {
    let text = (!seed.is_multiple_of(3)).then(|| numbers(config.text, seed));
    let point = (seed % 3 != 1).then(|| points(1, config, seed + 5));
    PartPrompt { text, point }
}

fn example(config: &Config, parts: usize, seed: u32) -> Example {
    let revolute = JointQuestion {
        parent: 0,
        child: 1,
        motion: MotionType::Revolute,
        queries: vec![2, 28, 3],
    };
    let slide =
        JointQuestion { parent: 1, child: 2, motion: MotionType::Prismatic, queries: vec![0, 2] };
    Example {
        shape: points(config.points, config, seed),
        parts: (0..parts as u32).map(|p| part(config, seed + 10 * p)).collect(),
        queries: points(config.queries, config, seed + 7),
        joints: vec![revolute, slide],
    }
}

fn values<const D: usize>(x: Tensor<D>) -> Vec<f32> {
    x.into_data().try_to_vec().unwrap()
}

fn far(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn answer(network: &Network, examples: &[Example]) -> (Vec<f32>, Vec<f32>) {
    let batch = Batch::new(examples, network.config(), &Device::flex()).unwrap();
    let Answer { logits, joints } = network.forward(&batch);
    (values(logits), values(joints))
}

fn network(seed: u64) -> Network {
    Network::new(&sizes(), seed, &Device::flex()).unwrap()
}

#[test]
fn queries_do_not_know_which_others_are_asked_with_them() {
    let (network, config) = (network(1), sizes());
    let whole = example(&config, 3, 1);
    let all = answer(&network, std::slice::from_ref(&whole)).0;
    for (from, to) in [(0, 13), (13, 26), (26, 29)] {
        let queries = whole.queries.slice(from..to, config.features);
        let part = Example { queries, joints: vec![], ..whole.clone() };
        assert!(far(&answer(&network, &[part]).0, &all[from * 3..to * 3]) <= 1e-6);
    }
}

#[test]
fn an_element_does_not_know_its_batch() {
    let (network, config) = (network(2), sizes());
    let few = example(&config, 3, 4);
    let many = example(&config, 5, 77);
    let (logits, joints) = answer(&network, &[few.clone(), many.clone()]);
    let (alone, joints_alone) = answer(&network, &[few]);
    for (row, alone) in logits[..29 * 5].chunks(5).zip(alone.chunks(3)) {
        assert!(far(&row[..3], alone) < 1e-5);
        assert!(row[3..].iter().all(|&l| l < -1e8), "parts that are not there");
    }
    assert!(far(&joints[..5 * 12], &joints_alone) < 1e-5);
    assert!(far(&joints[5 * 12..], &answer(&network, &[many]).1) < 1e-5);
}

#[test]
fn parts_in_another_order_give_scores_in_that_order() {
    let (network, config) = (network(3), sizes());
    let mut e = example(&config, 4, 8);
    let (before, joints) = answer(&network, std::slice::from_ref(&e));
    let order = [2, 0, 3, 1];
    e.parts = order.iter().map(|&p| e.parts[p].clone()).collect();
    for joint in &mut e.joints {
        let new = |old: usize| order.iter().position(|&p| p == old).unwrap();
        (joint.parent, joint.child) = (new(joint.parent), new(joint.child));
    }
    let (after, joints_after) = answer(&network, &[e]);
    for (before, after) in before.chunks(4).zip(after.chunks(4)) {
        assert!(far(&order.map(|p| before[p]), after) < 1e-5);
    }
    assert!(far(&joints, &joints_after) < 1e-5);
}

#[test]
fn what_is_absent_is_not_looked_at() {
    let (network, config) = (network(4), sizes());
    let with = |normals: bool| {
        let mut e = example(&config, 3, 9);
        e.queries.normals = e.queries.normals.filter(|_| normals);
        answer(&network, &[e]).0
    };
    assert!(far(&with(true), &with(false)) > 1e-4, "normals matter");
    let mut e = example(&config, 3, 9);
    e.parts[1].point = None;
    let without = answer(&network, std::slice::from_ref(&e)).0;
    e.parts[1].point = Some(points(1, &config, 50));
    assert!(far(&answer(&network, &[e]).0, &without) > 1e-4, "a point matters");
}

/// Collects the parameters whose gradient is missing or zero.
struct Untouched<'a>(&'a Gradients, Vec<String>);

impl ModuleVisitor for Untouched<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        let moved = param.val().grad(self.0).is_some_and(|g| {
            let size: f32 = g.abs().max().into_scalar();
            size > 0.0 && size.is_finite()
        });
        if !moved {
            self.1.push(format!("{:?}", param.id));
        }
    }
}

fn loss(network: &Network, batch: &Batch) -> Tensor<1> {
    let Answer { logits, joints } = network.forward(batch);
    logits.powi_scalar(2).mean() + joints.powi_scalar(2).mean()
}

#[test]
fn every_parameter_has_a_gradient() {
    let (device, config) = (Device::flex().autodiff(), sizes());
    let network = Network::new(&config, 5, &device).unwrap();
    let batch = Batch::new(&[example(&config, 3, 2), example(&config, 3, 5)], &config, &device);
    let grads = loss(&network, &batch.unwrap()).backward();
    let mut untouched = Untouched(&grads, vec![]);
    network.visit(&mut untouched);
    assert!(untouched.1.is_empty(), "no gradient: {:?}", untouched.1);
    assert_eq!(Network::parameters(&config).unwrap().len(), 135);
}

fn trained_losses(steps: usize) -> Vec<u32> {
    let (device, config) = (Device::flex().autodiff(), sizes());
    let mut network = Network::new(&config, 5, &device).unwrap();
    let mut optimiser = AdamWConfig::new().with_weight_decay(0.01).init();
    let batch = Batch::new(&[example(&config, 3, 2), example(&config, 3, 5)], &config, &device);
    let batch = batch.unwrap();
    let step = |_| {
        let loss = loss(&network, &batch);
        let grads = GradientsParams::from_grads(loss.backward(), &network);
        network = optimiser.step(1e-3, network.clone(), grads);
        loss.into_scalar::<f32>()
    };
    let losses: Vec<f32> = (0..steps).map(step).collect();
    assert!(losses[steps - 1] < 0.8 * losses[0], "training lowers the loss: {losses:?}");
    losses.iter().map(|l| l.to_bits()).collect()
}

#[test]
fn training_gives_the_same_bits_on_one_thread_and_on_two() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| trained_losses(5))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(1));
}

/// Sizes at which most layers fill tiles.
fn wide_sizes() -> Config {
    Config { width: 72, ..sizes() }
}

fn at(precision: Precision, device: &Device) -> Network {
    let random = &mut source::Random { seed: 1 };
    Network::build(&wide_sizes(), random, device, precision).unwrap()
}

#[test]
fn half_precision_is_near_the_full_one_and_does_not_know_its_chunks() {
    let config = wide_sizes();
    let e = example(&config, 3, 1);
    let [(full, _), (half, joints)] = [Precision::Full, Precision::Half]
        .map(|p| answer(&at(p, &Device::flex()), std::slice::from_ref(&e)));
    let (off, size) = (far(&full, &half), full.iter().fold(0f32, |m, l| m.max(l.abs())));
    assert!(0.0 < off && off < 0.02 * size, "off by {off} of {size}");
    assert_eq!(joints.len(), 5 * 12);
    for (from, to) in [(0, 1), (1, 29)] {
        let queries = e.queries.slice(from..to, config.features);
        let part = Example { queries, joints: vec![], ..e.clone() };
        let found = answer(&at(Precision::Half, &Device::flex()), &[part]).0;
        assert!(far(&found, &half[from * 3..to * 3]) <= 1e-6);
    }
}

#[test]
fn what_records_gradients_is_full_in_any_precision() {
    let (device, config) = (Device::flex().autodiff(), wide_sizes());
    let batch = Batch::new(&[example(&config, 3, 2)], &config, &device).unwrap();
    let [full, half] = [Precision::Full, Precision::Half].map(|p| {
        let network = at(p, &device);
        let loss = loss(&network, &batch);
        let grads = GradientsParams::from_grads(loss.backward(), &network);
        let network = AdamWConfig::new().init().step(1e-3, network, grads);
        let Answer { logits, .. } = network.forward(&batch);
        (loss.into_scalar::<f32>().to_bits(), values(logits))
    });
    assert_eq!(full, half);
}

#[test]
fn half_precision_gives_the_same_bits_on_one_thread_and_on_two() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let e = example(&wide_sizes(), 4, 3);
        pool.install(|| answer(&at(Precision::Half, &Device::flex()), &[e]))
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn a_batch_that_does_not_fit_names_the_limit() {
    let config = sizes();
    let told = |e: &Example| {
        Batch::new(std::slice::from_ref(e), &config, &Device::flex()).unwrap_err().to_string()
    };
    let good = example(&config, 3, 1);
    let six = Example { parts: vec![part(&config, 1); 6], ..good.clone() };
    assert_eq!(told(&six), "example 0: parts must be between 1 and 5, found 6");
    let few = Example { shape: points(36, &config, 1), ..good.clone() };
    assert_eq!(told(&few), "example 0: shape points must be 37, found 36");
    let mut long = good.clone();
    long.parts[1].text = Some(vec![0.0; 9]);
    assert_eq!(told(&long), "example 0: numbers of a text must be 7, found 9");
    let mut wrong = good;
    wrong.joints[0].child = 3;
    assert!(told(&wrong).contains("must be between 1 and 3, found 4"));
}

#[test]
fn a_layer_that_overflows_is_named() {
    let (network, config) = (network(6), sizes());
    let mut e = example(&config, 3, 1);
    e.queries.features[3] = f32::INFINITY;
    let batch = Batch::new(&[e], &config, &Device::flex()).unwrap();
    let mut watch = watch::Watch::on();
    let memory = network.remember(&batch.shape, &batch.parts, &mut watch);
    network.decode(&memory, &batch.queries, &mut watch);
    assert_eq!(watch.found().as_deref(), Some("the query embedding"));
}
