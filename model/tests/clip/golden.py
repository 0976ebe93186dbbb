"""Writes a tiny CLIP text checkpoint of our own making and what `transformers` makes of it.

    pip install torch transformers safetensors
    python golden.py SCRATCH_DIR > golden.json

Weights follow a formula that `checkpoint.rs` repeats, so that only merges, tokens and vectors are
checked in. Recorded with the versions named in the file.
"""

import json
import sys
from pathlib import Path

import numpy as np
import safetensors.numpy
import tokenizers
import torch
import transformers
from transformers import CLIPTextConfig, CLIPTextModelWithProjection, CLIPTokenizer

WIDTH, HIDDEN, LAYERS, HEADS, OUT, PLACES = 32, 56, 2, 4, 20, 77

WORDS = """door drawer left right lid handle wheel top bottom the of cabinet knob the the hinge
upper lower front back shelf oven microwave laptop refrigerator café straße it's don't we're 第 ドア
and with a an its glass window seat chair table leg""".split()

TEXTS = [
    "door",
    "Left Door",
    "the top drawer of the cabinet",
    "  handle \t\n  of   the\u00a0lid  ",
    "",
    " ",
    "café",
    "cafe\u0301",
    "Größe der STRASSE, straße",
    "İstanbul ışık",
    "ΟΔΟΣ ὀδός",
    "naïve façade — “smart” quotes…",
    "it's the door's hinge; don't, we're, I'll, he'd, I've, I'M",
    "'s 's' ''s 'S rock'n'roll o'clock '",
    "drawer2 3rd 10x20 1,234.56 42%",
    "٣ ½ Ⅷ ² 第3扉",
    "door!!! (left)/[right] {a} <b> #c @d $e ^f &g *h",
    "a_b-c.d/e\\f|g~h`i",
    "door 🚪",
    "🚪🚪👨\u200d👩\u200d👧 👍🏽 🇩🇪",
    "ドア 引き出し 左の扉",
    "дверь шкафа",
    "دُرج الخزانة",
    "दराज़ का हैंडल",
    "서랍 한글",
    "ᄒ\u1161ᆫ",
    "x\u0000y\u0007z",
    "a\u200bb\ufeffc\u00add",
    "\u1680ogham\u2003space\u3000wide\u2028line",
    "zero\u0085next",
    "ſtill ﬁne Å Å Ω",
    "upperlowerfrontbackshelf",
    "THE THE THE thethethe",
    "&amp; &lt;b&gt;",
    "lid <|endoftext|> door",
    "<|startoftext|>wheel",
    "𝒟oor 𝟚 ²₂",
    "q̣̇ ṩ",
    "ǅ ǈ Ǳ ﬃ",
    "e" * 30,
    "refrigerator microwave oven laptop window glass seat chair table leg",
]


def letters():
    """The letter of each byte, in the order of bytes."""
    own = [*range(33, 127), *range(0xA1, 0xAD), *range(0xAE, 0x100)]
    others = iter(range(0x100, 0x200))
    return [chr(b) if b in own else chr(next(others)) for b in range(256)]


def learned(words, count):
    """The first merges byte-pair encoding learns from these words, ties by spelling."""
    table = letters()
    spelled = [[table[b] for b in word.lower().encode()] for word in words]
    spelled = [word[:-1] + [word[-1] + "</w>"] for word in spelled]
    merges = []
    while len(merges) < count:
        pairs = {}
        for word in spelled:
            for pair in zip(word, word[1:]):
                pairs[pair] = pairs.get(pair, 0) + 1
        if not pairs:
            break
        best = min(pairs, key=lambda pair: (-pairs[pair], pair))
        merges.append(best)
        spelled = [merged(word, best) for word in spelled]
    return merges


def merged(word, pair):
    out = []
    for symbol in word:
        if out and (out[-1], symbol) == pair:
            out[-1] = "".join(pair)
        else:
            out.append(symbol)
    return out


def numbers(count, seed):
    """Numbers in (-1/2, 1/2) that look random and never change."""
    i = np.arange(1, count + 1, dtype=np.float64)
    x = i * 0.754877666 + seed * 0.569840291
    return ((x - np.floor(x)) - 0.5).astype(np.float32)


def tensors(vocabulary):
    """Name and shape of each tensor, in the order of their seeds."""
    d, f = WIDTH, HIDDEN
    yield "text_model.embeddings.token_embedding.weight", (vocabulary, d)
    yield "text_model.embeddings.position_embedding.weight", (PLACES, d)
    for i in range(LAYERS):
        layer = f"text_model.encoder.layers.{i}"
        linear = [(f"self_attn.{x}_proj", d, d) for x in ("q", "k", "v", "out")]
        linear += [("mlp.fc1", f, d), ("mlp.fc2", d, f)]
        for name, o, n in linear:
            yield f"{layer}.{name}.weight", (o, n)
            yield f"{layer}.{name}.bias", (o,)
        for name in ("layer_norm1", "layer_norm2"):
            yield f"{layer}.{name}.weight", (d,)
            yield f"{layer}.{name}.bias", (d,)
    yield "text_model.final_layer_norm.weight", (d,)
    yield "text_model.final_layer_norm.bias", (d,)
    yield "text_projection.weight", (OUT, d)


def write(folder, merges, activation):
    folder.mkdir(parents=True, exist_ok=True)
    names = letters() + [letter + "</w>" for letter in letters()]
    names += ["".join(pair) for pair in merges] + ["<|startoftext|>", "<|endoftext|>"]
    vocabulary = {name: number for number, name in enumerate(names)}
    assert len(vocabulary) == len(names)
    (folder / "vocab.json").write_text(json.dumps(vocabulary), encoding="utf-8")
    lines = ["#version: 0.2", *(" ".join(pair) for pair in merges)]
    (folder / "merges.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    config = CLIPTextConfig(
        vocab_size=len(names), hidden_size=WIDTH, intermediate_size=HIDDEN,
        num_hidden_layers=LAYERS, num_attention_heads=HEADS, projection_dim=OUT,
        max_position_embeddings=PLACES, hidden_act=activation,
        bos_token_id=len(names) - 2, eos_token_id=len(names) - 1, pad_token_id=len(names) - 1,
    )
    config.architectures = ["CLIPTextModelWithProjection"]
    config.save_pretrained(folder)
    weights = {}
    for seed, (name, shape) in enumerate(tensors(len(names))):
        weights[name] = numbers(int(np.prod(shape)), seed).reshape(shape)
    safetensors.numpy.save_file(weights, folder / "model.safetensors", {"format": "pt"})


def main():
    scratch = Path(sys.argv[1])
    merges = learned(WORDS, 120)
    golden = {
        "transformers": transformers.__version__,
        "tokenizers": tokenizers.__version__,
        "torch": torch.__version__,
        "sizes": [WIDTH, HIDDEN, LAYERS, HEADS, OUT, PLACES],
        "merges": [" ".join(pair) for pair in merges],
        "texts": [{"text": text} for text in TEXTS],
    }
    for activation in ("quick_gelu", "gelu"):
        folder = scratch / activation
        write(folder, merges, activation)
        tokens = CLIPTokenizer.from_pretrained(folder)
        model, report = CLIPTextModelWithProjection.from_pretrained(
            folder, output_loading_info=True, dtype=torch.float64, attn_implementation="eager"
        )
        assert not any(report[key] for key in ("missing_keys", "unexpected_keys")), report
        model.eval()
        for entry in golden["texts"]:
            ids = tokens(entry["text"])["input_ids"]
            with torch.no_grad():
                out = model(torch.tensor([ids])).text_embeds[0]
            assert entry.setdefault("ids", ids) == ids
            entry[activation] = [float(f"{x:.9g}") for x in out.tolist()]
    json.dump(golden, sys.stdout, ensure_ascii=True, indent=None, separators=(",", ":"))
    print()


main()
