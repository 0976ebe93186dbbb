//! A tiny checkpoint of our own making: merges from the recording, weights by a formula.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use model::weights::TensorWriter;
use safetensors::Dtype;
use serde::Deserialize;
use serde_json::json;

#[derive(Deserialize)]
pub(crate) struct Golden {
    /// Width, hidden width, layers, heads, width out, positions.
    pub(crate) sizes: [usize; 6],
    pub(crate) merges: Vec<String>,
    pub(crate) texts: Vec<Truth>,
}

#[derive(Deserialize)]
pub(crate) struct Truth {
    pub(crate) text: String,
    pub(crate) ids: Vec<u32>,
    pub(crate) quick_gelu: Vec<f64>,
    pub(crate) gelu: Vec<f64>,
}

/// Name, shape and values of each.
pub(crate) type Tensors = Vec<(String, Vec<usize>, Vec<f32>)>;

impl Golden {
    pub(crate) fn read() -> Self {
        serde_json::from_str(include_str!("golden.json")).unwrap()
    }

    /// Letters of bytes, letters that end a word, merges, and what opens and ends a text.
    pub(crate) fn vocabulary(&self) -> BTreeMap<String, usize> {
        let printed = |b: u32| matches!(b, 33..=126 | 0xa1..=0xac | 0xae..=0xff);
        let mut others = 0x100u32..;
        let letter = |b| if printed(b) { b } else { others.next().unwrap() };
        let letters = (0..256).map(letter).map(|c| char::from_u32(c).unwrap().to_string());
        let mut names: Vec<String> = letters.collect();
        names.extend(names.clone().iter().map(|l| format!("{l}</w>")));
        names.extend(self.merges.iter().map(|m| m.replace(' ', "")));
        names.extend(["<|startoftext|>", "<|endoftext|>"].map(String::from));
        names.into_iter().zip(0..).collect()
    }

    pub(crate) fn tensors(&self) -> Tensors {
        let [d, f, layers, _, out, places] = self.sizes;
        let mut shapes = vec![
            (
                "text_model.embeddings.token_embedding.weight".into(),
                vec![self.vocabulary().len(), d],
            ),
            ("text_model.embeddings.position_embedding.weight".into(), vec![places, d]),
        ];
        for i in 0..layers {
            let layer = |name: &str| format!("text_model.encoder.layers.{i}.{name}");
            let square = ["q", "k", "v", "out"].map(|x| (format!("self_attn.{x}_proj"), d, d));
            let wide = [("mlp.fc1".into(), f, d), ("mlp.fc2".into(), d, f)];
            for (name, o, n) in square.into_iter().chain(wide) {
                shapes.push((layer(&format!("{name}.weight")), vec![o, n]));
                shapes.push((layer(&format!("{name}.bias")), vec![o]));
            }
            for name in ["layer_norm1", "layer_norm2"] {
                shapes.push((layer(&format!("{name}.weight")), vec![d]));
                shapes.push((layer(&format!("{name}.bias")), vec![d]));
            }
        }
        shapes.push(("text_model.final_layer_norm.weight".into(), vec![d]));
        shapes.push(("text_model.final_layer_norm.bias".into(), vec![d]));
        shapes.push(("text_projection.weight".into(), vec![out, d]));
        let values = |(seed, (name, shape)): (usize, (String, Vec<usize>))| {
            let values = numbers(shape.iter().product(), seed);
            (name, shape, values)
        };
        shapes.into_iter().enumerate().map(values).collect()
    }

    /// The configuration of both towers, as OpenAI's are.
    pub(crate) fn config(&self, activation: &str) -> serde_json::Value {
        let [d, f, layers, heads, out, places] = self.sizes;
        let size = self.vocabulary().len();
        json!({
            "model_type": "clip", "projection_dim": out, "vision_config": {"hidden_size": 7},
            "text_config": {
                "hidden_size": d, "intermediate_size": f, "num_hidden_layers": layers,
                "num_attention_heads": heads, "max_position_embeddings": places,
                "vocab_size": size, "hidden_act": activation, "eos_token_id": 2,
            },
        })
    }

    /// Writes the checkpoint.
    pub(crate) fn write(&self, folder: &Path, activation: &str) {
        let put = |name: &str, text: String| fs::write(folder.join(name), text).unwrap();
        put("config.json", self.config(activation).to_string());
        put("vocab.json", serde_json::to_string(&self.vocabulary()).unwrap());
        put("merges.txt", format!("#version: 0.2\n{}\n", self.merges.join("\n")));
        write_weights(folder, &self.tensors());
    }

    /// A folder with the checkpoint, for as long as it is held.
    pub(crate) fn folder(&self, activation: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        self.write(folder.path(), activation);
        folder
    }
}

/// Numbers in (−½, ½) that look random and never change.
fn numbers(count: usize, seed: usize) -> Vec<f32> {
    let number = |i: usize| i as f64 * 0.754_877_666 + seed as f64 * 0.569_840_291;
    (1..=count).map(|i| (number(i) - number(i).floor() - 0.5) as f32).collect()
}

pub(crate) fn write_weights(folder: &Path, tensors: &Tensors) {
    let header: Vec<_> =
        tensors.iter().map(|(n, s, _)| (n.clone(), Dtype::F32, s.clone())).collect();
    let file = fs::File::create(folder.join("model.safetensors")).unwrap();
    let mut writer = TensorWriter::new(file, &header, None).unwrap();
    for (_, _, values) in tensors {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        writer.write(&bytes).unwrap();
    }
    writer.finish().unwrap();
}
