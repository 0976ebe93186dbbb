#!/usr/bin/env bash
# An opaque frame of a lossless animated WebP comes back darker from the `image` crate than from libwebp.
#
# Guess: a pixel with alpha 255 that is laid over another replaces it, so lossless in is the same bytes out.
# Versions: image 0.25.10 with image-webp 0.2.4 (Rust); Pillow 12.0.0 with libwebp.
# Behaviour: in a frame whose blending method is "alpha-blend" (the default of most writers), image-webp
#   mixes opaque pixels in integers, too, and loses a level of many values; with "do not blend" none is lost.
# Seen, 256 frames of one grey each, 0 to 255, all opaque:
#   image blend: 255 of 256 greys differ, by -1 to 0
#   image replace: 0 of 256 greys differ, by 0 to 0
#   pillow blend: 0 of 256 greys differ, by 0 to 0
#   pillow replace: 0 of 256 greys differ, by 0 to 0
# Why it matters: a test that compares frames byte for byte fails on files that are right. A writer that
#   sets "do not blend" for frames without transparent pixels is read exactly by both.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
cd "$d"
python3 -m venv a && a/bin/pip install -q --disable-pip-version-check pillow==12.0.0
mkdir src
cat > Cargo.toml <<'T'
[package]
name = "webp"
version = "0.0.0"
edition = "2021"
[dependencies]
image = { version = "=0.25.10", default-features = false, features = ["webp"] }
image-webp = "=0.2.4"
T
cat > src/main.rs <<'R'
use image::codecs::webp::{WebPDecoder, WebPEncoder};
use image::{AnimationDecoder, ExtendedColorType, ImageEncoder};
// A picture of one grey, as the chunk of a still file without its head.
fn still(v: u8) -> Vec<u8> {
    let pixels: Vec<u8> = (0..16).flat_map(|_| [v, v, v, 255]).collect();
    let mut file = Vec::new();
    WebPEncoder::new_lossless(&mut file).write_image(&pixels, 4, 4, ExtendedColorType::Rgba8).unwrap();
    file.split_off(12)
}
fn chunk(file: &mut Vec<u8>, name: &[u8; 4], bytes: &[u8]) {
    file.extend(name); file.extend((bytes.len() as u32).to_le_bytes()); file.extend(bytes);
    if bytes.len() % 2 == 1 { file.push(0) }
}
fn film(values: &[u8], blend: u8) -> Vec<u8> {
    let mut body = b"WEBP".to_vec();
    chunk(&mut body, b"VP8X", &[0x12, 0, 0, 0, 3, 0, 0, 3, 0, 0]);
    chunk(&mut body, b"ANIM", &[255, 255, 255, 255, 0, 0]);
    for v in values {
        let mut frame = vec![0, 0, 0, 0, 0, 0, 3, 0, 0, 3, 0, 0, 100, 0, 0, blend];
        frame.extend(still(*v));
        chunk(&mut body, b"ANMF", &frame);
    }
    let mut file = Vec::new();
    chunk(&mut file, b"RIFF", &body);
    file
}
fn main() {
    let values: Vec<u8> = (0..=255).collect();
    for (name, blend) in [("blend", 0u8), ("replace", 2)] {
        let file = film(&values, blend);
        std::fs::write(format!("{name}.webp"), &file).unwrap();
        let frames = WebPDecoder::new(std::io::Cursor::new(file)).unwrap().into_frames().collect_frames().unwrap();
        let off: Vec<i32> = frames.iter().zip(&values).map(|(f, v)| i32::from(f.buffer().as_raw()[0]) - i32::from(*v)).collect();
        println!("image {name}: {} of 256 greys differ, by {} to {}", off.iter().filter(|o| **o != 0).count(), off.iter().min().unwrap(), off.iter().max().unwrap());
    }
}
R
CARGO_TARGET_DIR="$d/t" cargo run -q --release > out.txt
a/bin/python - >> out.txt <<'P'
from PIL import Image, ImageSequence
for name in ("blend", "replace"):
    off = [f.convert("RGBA").getpixel((0, 0))[0] - i for i, f in enumerate(ImageSequence.Iterator(Image.open(name + ".webp")))]
    print(f"pillow {name}: {sum(o != 0 for o in off)} of {len(off)} greys differ, by {min(off)} to {max(off)}")
P
cat out.txt
diff - out.txt <<'E'
image blend: 255 of 256 greys differ, by -1 to 0
image replace: 0 of 256 greys differ, by 0 to 0
pillow blend: 0 of 256 greys differ, by 0 to 0
pillow replace: 0 of 256 greys differ, by 0 to 0
E
