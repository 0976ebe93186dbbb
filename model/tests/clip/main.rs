//! CLIP's text tower against what `transformers` makes of the same checkpoint, a tiny one whose
//! weights follow a formula; `golden.py` recorded it. And what a folder that is no checkpoint is
//! told.
#![allow(clippy::unwrap_used)]

mod checkpoint;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use checkpoint::{Golden, Tensors, Truth, write_weights};
use model::features::{ClipError, ClipText, FeatureError, TextFeatures};
use model::net::clip::ClipSizes;
use model::net::{Config, Network, NetworkError, Precision};
use model::weights::{Header, WeightsError, save_network};
use model::{Neural, NeuralError};
use serde_json::json;

/// Largest error, as a share of the vector's largest value.
const TOLERANCE: f64 = 1e-5;

fn told(folder: &Path) -> String {
    ClipText::open(folder).unwrap_err().to_string()
}

#[test]
fn tokens_and_vectors_are_those_of_transformers() {
    let golden = Golden::read();
    assert!(golden.texts.len() >= 30);
    for activation in ["quick_gelu", "gelu"] {
        let clip = ClipText::open(golden.folder(activation).path()).unwrap();
        assert_eq!(clip.width(), golden.sizes[4]);
        let mut worst: f64 = 0.0;
        for truth in &golden.texts {
            assert_eq!(clip.tokens(&truth.text), truth.ids, "{:?}", truth.text);
            let expected = if activation == "gelu" { &truth.gelu } else { &truth.quick_gelu };
            let found = clip.embed(&truth.text).unwrap();
            assert_eq!(found.len(), expected.len());
            let largest = expected.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
            let off = found.iter().zip(expected).map(|(f, t)| (f64::from(*f) - t).abs());
            let off = off.fold(0.0, f64::max) / largest;
            assert!(off <= TOLERANCE, "{:?}: off by {off:.2e} of its largest value", truth.text);
            worst = worst.max(off);
        }
        eprintln!("{activation}: {worst:.1e}");
    }
}

#[test]
fn a_text_has_one_vector_whatever_was_asked_before_and_on_any_number_of_threads() {
    let golden = Golden::read();
    let folder = golden.folder("quick_gelu");
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let clip = ClipText::open(folder.path()).unwrap();
            let mut texts: Vec<&Truth> = golden.texts.iter().collect();
            if threads > 1 {
                texts.reverse();
            }
            let bits = |text: &Truth| {
                let vector = clip.embed(&text.text).unwrap();
                (text.text.clone(), vector.iter().map(|v| v.to_bits()).collect::<Vec<_>>())
            };
            texts.into_iter().map(bits).collect::<BTreeMap<_, _>>()
        })
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn the_identity_changes_with_weights_vocabulary_and_activation_alone() {
    let golden = Golden::read();
    let folder = golden.folder("quick_gelu");
    let identity = || ClipText::open(folder.path()).unwrap().identity();
    let first = identity();
    assert!(first.starts_with("clip/1 ") && first.len() == 23, "{first}");

    let mut tensors = golden.tensors();
    tensors.reverse();
    tensors.push(("vision_model.embeddings.class_embedding".into(), vec![3], vec![1.0; 3]));
    write_weights(folder.path(), &tensors);
    assert_eq!(identity(), first, "order and image tower");

    tensors[0].2[5] += 1e-3;
    write_weights(folder.path(), &tensors);
    assert_ne!(identity(), first, "a weight");

    golden.write(folder.path(), "gelu");
    assert_ne!(identity(), first, "the activation");

    golden.write(folder.path(), "quick_gelu");
    let fewer = golden.merges[..golden.merges.len() - 1].join("\n");
    fs::write(folder.path().join("merges.txt"), fewer).unwrap();
    assert_ne!(identity(), first, "the merges");
}

#[test]
fn too_long_texts_are_refused_with_the_limit() {
    let clip = ClipText::open(Golden::read().folder("gelu").path()).unwrap();
    assert!(clip.embed(&"?!".repeat(37)).is_ok());
    let told = clip.embed(&"7".repeat(76)).unwrap_err();
    assert_eq!(told, FeatureError::TooManyTokens { limit: 75, found: 76 });
    assert_eq!(told.to_string(), "a text may have at most 75 tokens, found 76");
    assert!(clip.embed(&"7".repeat(75)).is_ok());
    let told = clip.embed(&" ".repeat(121)).unwrap_err();
    assert_eq!(told, FeatureError::TextTooLong { limit: 120, found: 121 });
}

#[test]
fn tensors_that_are_missing_or_of_another_shape_are_listed_together() {
    let golden = Golden::read();
    let folder = golden.folder("gelu");
    let mut tensors = golden.tensors();
    tensors.retain(|(name, ..)| name != "text_projection.weight");
    let bias = tensors.iter_mut().find(|(name, ..)| name.ends_with("layers.1.mlp.fc1.bias"));
    let (_, shape, values) = bias.unwrap();
    (*shape, *values) = (vec![3], vec![0.0; 3]);
    write_weights(folder.path(), &tensors);
    let error = ClipText::open(folder.path()).unwrap_err();
    let told = error.to_string();
    assert!(
        matches!(&error, ClipError::Weights { source: WeightsError::Mismatch(all), .. } if all.len() == 2)
    );
    assert!(told.contains("model.safetensors: 2 of the weights do not fit"), "{told}");
    let missing = "`text_projection.weight` expected [20, 32], found none";
    let wrong = "`text_model.encoder.layers.1.mlp.fc1.bias` expected [56], found [3]";
    assert!(told.contains(missing) && told.contains(wrong), "{told}");
}

#[test]
fn a_layer_that_overflows_is_named() {
    let golden = Golden::read();
    let folder = golden.folder("gelu");
    let mut tensors = golden.tensors();
    weight_of(&mut tensors, "layers.1.mlp.fc2.weight").fill(f32::MAX);
    write_weights(folder.path(), &tensors);
    let told = ClipText::open(folder.path()).unwrap().embed("door").unwrap_err();
    let layer = NetworkError::NotFinite("text block 1".into());
    assert_eq!(told, FeatureError::Encoder(layer));
    let message = "the text encoder: text block 1 gave a value that is not finite";
    assert_eq!(told.to_string(), message);

    weight_of(&mut tensors, "final_layer_norm.bias")[0] = f32::NAN;
    write_weights(folder.path(), &tensors);
    let told = self::told(folder.path());
    assert!(told.ends_with("`text_model.final_layer_norm.bias` holds a value that is not finite"));
}

fn weight_of<'a>(tensors: &'a mut Tensors, name: &str) -> &'a mut Vec<f32> {
    &mut tensors.iter_mut().find(|(n, ..)| n.ends_with(name)).unwrap().2
}

#[test]
fn a_missing_file_is_named_with_the_rule() {
    let golden = Golden::read();
    for name in ["config.json", "vocab.json", "merges.txt", "model.safetensors"] {
        let folder = golden.folder("gelu");
        fs::remove_file(folder.path().join(name)).unwrap();
        let told = told(folder.path());
        let rule = "a CLIP folder holds config.json, vocab.json, merges.txt and model.safetensors";
        assert!(told.contains(&format!("{name}: {rule}")), "{told}");
    }
}

#[test]
fn files_that_contradict_each_other_or_themselves_are_told_how() {
    let golden = Golden::read();
    let merges = format!("#version: 0.2\n{}\n", golden.merges.join("\n"));
    let vocabulary = |change: &dyn Fn(&mut BTreeMap<String, usize>)| {
        let mut all = golden.vocabulary();
        change(&mut all);
        serde_json::to_string(&all).unwrap()
    };
    let config = |key: &str, value: serde_json::Value| {
        let mut all = golden.config("gelu");
        all["text_config"][key] = value;
        all.to_string()
    };
    let broken = [
        ("config.json", "[".into(), "expected a CLIP configuration: "),
        ("config.json", "7".into(), "expected a CLIP configuration: "),
        ("config.json", config("hidden_act", json!("relu")), "is quick_gelu or gelu, found relu"),
        ("config.json", config("layer_norm_eps", json!(-1)), "`layer_norm_eps` is above zero"),
        ("config.json", config("num_attention_heads", json!(7)), "`num_attention_heads` (7)"),
        (
            "config.json",
            config("num_hidden_layers", json!(0)),
            "`num_hidden_layers` must be between",
        ),
        ("config.json", config("eos_token_id", json!(9)), "texts end with token 9, but"),
        ("config.json", config("vocab_size", json!(99)), "lie below `vocab_size` (99)"),
        ("vocab.json", "{}".into(), "every byte, merge and special symbol has a number, `"),
        (
            "vocab.json",
            vocabulary(&|v| v.retain(|k, _| k != "<|startoftext|>")),
            "`<|startoftext|>` none",
        ),
        ("vocab.json", vocabulary(&|v| v.retain(|k, _| k != "Ā</w>")), "`Ā</w>` none"),
        ("vocab.json", vocabulary(&|v| v.extend([("x".into(), 1 << 20)])), "`x` has 1048576"),
        ("merges.txt", format!("{merges}a\n"), "expected two symbols, found `a`"),
        ("merges.txt", format!("{merges}a b c\n"), "expected two symbols, found `a b c`"),
        ("merges.txt", format!("{merges}q q\n"), "`qq` none"),
        ("model.safetensors", "short".into(), "not a safetensors file: shorter than 8 bytes"),
    ];
    for (name, text, rule) in broken {
        let folder = golden.folder("gelu");
        fs::write(folder.path().join(name), &text).unwrap();
        let told = told(folder.path());
        assert!(told.contains(rule), "{name}: {told}");
    }
    let folder = golden.folder("gelu");
    fs::write(folder.path().join("merges.txt"), [0xff, 0xfe]).unwrap();
    assert!(told(folder.path()).contains("merges.txt: expected UTF-8"));
}

#[test]
fn published_sizes_are_sound() {
    assert_eq!(ClipSizes::base().check(), Ok(()));
    assert_eq!(ClipSizes::large().check(), Ok(()));
    assert_eq!(ClipSizes::large().out, Config::paper().text);
}

#[test]
fn a_network_is_read_with_the_encoder_it_was_trained_with() {
    let clip = || Box::new(ClipText::open(Golden::read().folder("gelu").path()).unwrap());
    let sizes =
        |text| Config { width: 16, heads: 2, blocks: 1, tokens: 8, text, ..Config::small() };
    let load = |text: usize, identity: &str| {
        let header = Header::new(&sizes(text), identity, "geometric-features/1");
        let network = Network::new(&sizes(text), 1, &burn::tensor::Device::flex()).unwrap();
        let mut bytes = Vec::new();
        save_network(&network, &header, &mut bytes).unwrap();
        Neural::load_with(std::io::Cursor::new(bytes), clip(), "x", Precision::Full)
    };
    let identity = clip().identity();
    assert!(load(20, &identity).is_ok());
    let told = load(20, "ngram/1").unwrap_err().to_string();
    let here = format!("the weights want the text encoder `ngram/1`, here is `{identity}`");
    assert_eq!(told, here);
    let told = load(256, &identity).unwrap_err();
    assert!(matches!(told, NeuralError::TextWidth { wanted: 256, found: 20, .. }), "{told}");
}
