//! The whole articulator with random weights: nonsense, but nonsense that keeps every promise.
#![allow(clippy::unwrap_used)]

use burn::tensor::Device;
use model::net::{Config, Network, Precision, source::Random};
use model::weights::{Header, save_network};
use model::{Articulate, ArticulateError, Neural, NeuralError};
use object::articulated::Range;
use object::kinematics::JointKind;
use object::{Condition, DVec3, Mesh};

/// Seeds whose random networks give the cubes to more than one part; most give them all to one.
const LIVELY: [u64; 6] = [17, 18, 34, 45, 59, 60];

fn sizes() -> Config {
    Config {
        width: 32,
        heads: 2,
        blocks: 1,
        points: 256,
        tokens: 16,
        chunk: 77,
        queries: 512,
        ..Config::small()
    }
}

/// Three unit cubes side by side, apart, far from the origin and not of unit size.
fn cubes() -> Mesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for cube in 0..3u32 {
        let corner =
            |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        vertices.extend((0..8).map(|i| (corner(i) + DVec3::X * 1.5 * f64::from(cube)) * 0.2 + 3.0));
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        for q in quads.map(|q: [u32; 4]| q.map(|v| v + 8 * cube)) {
            faces.extend([[q[0], q[1], q[2]], [q[0], q[2], q[3]]]);
        }
    }
    Mesh::new(vertices, faces).unwrap()
}

fn condition() -> Condition {
    let text = r#"{"schema":"kinfold-condition/1","parts":[
        {"name":"body"},
        {"name":"door","parent":"body","joint":"revolute"},
        {"name":"knob","parent":"door","joint":["prismatic","continuous"]}]}"#;
    Condition::from_json(text).unwrap()
}

fn neural(seed: u64) -> Neural {
    Neural::new(Network::new(&sizes(), seed, &Device::flex()).unwrap(), "random")
}

#[test]
fn the_result_keeps_the_promise_of_an_articulator() {
    let mut made = 0;
    for seed in LIVELY {
        let answer = neural(seed).articulate(&cubes(), &condition(), 5);
        let found = match answer {
            Ok(found) => found,
            Err(ArticulateError::NothingLabelled(_) | ArticulateError::Tree(_)) => continue,
            Err(other) => panic!("{other}"),
        };
        made += 1;
        assert_eq!(found.object.part_of_face().len(), cubes().faces().len());
        for (old, new) in found.part_of_condition.iter().enumerate() {
            let name = condition().tree.parts()[old].name.clone();
            let lost = found.notes.iter().any(|n| n.part == name && n.loss);
            assert!(new.is_some() || lost, "{name} is gone without a word");
            for joint in new.iter().flat_map(|&p| found.object.joints(p)) {
                let continuous = joint.range == Range::Continuous;
                assert_eq!(continuous, joint.kind == JointKind::Continuous);
            }
        }
    }
    assert!(made >= 3, "only {made} of {} networks labelled more than one part", LIVELY.len());
}

#[test]
fn one_thread_and_two_give_the_same_object() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let answers = pool.install(|| {
            let one = |seed| neural(seed).articulate(&cubes(), &condition(), 5);
            LIVELY.into_iter().map(|seed| one(seed).map_err(|e| e.to_string())).collect::<Vec<_>>()
        });
        assert!(answers.iter().any(Result::is_ok));
        answers
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn an_identity_says_in_which_precision_it_answers() {
    let told = [Precision::Full, Precision::Half].map(|precision| {
        let random = &mut Random { seed: 1 };
        let network = Network::build(&sizes(), random, &Device::flex(), precision).unwrap();
        Neural::new(network, "abc").identity()
    });
    assert_eq!(told, ["neural/1 abc", "neural/1 abc half"]);
}

#[test]
fn weights_for_other_encoders_are_refused() {
    let network = Network::new(&sizes(), 1, &Device::flex()).unwrap();
    let mut bytes = Vec::new();
    save_network(&network, &Header::new(&sizes(), "clip/1", "geometric-features/1"), &mut bytes)
        .unwrap();
    let told = Neural::load(std::io::Cursor::new(bytes), "x").unwrap_err();
    assert!(matches!(told, NeuralError::Encoder { what: "text", .. }));
    assert_eq!(told.to_string(), "the weights want the text encoder `clip/1`, here is `ngram/1`");
}
