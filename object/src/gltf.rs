//! glTF in several files → one GLB: buffers and pictures that lie beside the `.gltf` are taken in, and nothing
//! else of it changes.

use serde_json::{Value, json};

use crate::appearance::media_type;
use crate::beside::{Beside, Found};
use crate::glb::{GlbError, LEFT_OUT, check_json, chunks, of_chunks};

/// A glTF text and the files beside it as one GLB, which is read by [`crate::glb::read`].
///
/// A picture that is not there, or no picture, is left out, and the GLB says so; a buffer has to be there.
///
/// # Errors
/// [`GlbError`] where the text is no glTF, or a buffer cannot be had.
pub fn to_glb(text: &[u8], beside: Beside<'_>) -> Result<Vec<u8>, GlbError> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    check_json(text)?;
    let document = serde_json::from_slice(text).map_err(|e| GlbError::Json(e.to_string()))?;
    let mut packer = Packer { document, bin: Vec::new(), left_out: Vec::new() };
    packer.buffers(beside)?;
    packer.images(beside);
    Ok(packer.finish())
}

/// A document whose data move into one binary chunk.
struct Packer {
    document: Value,
    bin: Vec<u8>,
    left_out: Vec<String>,
}

impl Packer {
    fn list(&mut self, name: &str) -> Option<&mut Vec<Value>> {
        self.document.get_mut(name).and_then(Value::as_array_mut)
    }

    /// Puts bytes into the chunk; where they begin.
    fn put(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let start = self.bin.len();
        self.bin.extend_from_slice(bytes);
        start
    }

    /// All buffers that lie beside become parts of the first.
    fn buffers(&mut self, beside: Beside<'_>) -> Result<(), GlbError> {
        let buffers = self.list("buffers").map(std::mem::take).unwrap_or_default();
        let (mut kept, mut places) = (vec![Value::Null], Vec::new());
        for (index, buffer) in buffers.into_iter().enumerate() {
            let uri = buffer.get("uri").and_then(Value::as_str);
            let Some(uri) = uri.filter(|uri| !uri.starts_with("data:")) else {
                // Data of its own, or the place of what was packed and is never read.
                places.push((kept.len(), 0));
                kept.push(buffer);
                continue;
            };
            let place = || format!("buffer {index}");
            let Found { bytes, .. } = beside(&plain(uri)).map_err(|why| {
                let found = format!("`{}`, which {why}", uri.chars().take(200).collect::<String>());
                GlbError::rule(place(), "its file lies beside the .gltf", found)
            })?;
            let declared = buffer.get("byteLength").and_then(Value::as_u64).unwrap_or(u64::MAX);
            let present = bytes.get(..usize::try_from(declared).unwrap_or(usize::MAX));
            let Some(bytes) = present else {
                let found = format!("{declared} declared, {} in `{uri}`", bytes.len());
                return Err(GlbError::rule(place(), "the declared bytes must be there", found));
            };
            let start = self.put(bytes);
            places.push((0, start));
        }
        self.move_views(&places);
        self.document["buffers"] = kept.into();
        Ok(())
    }

    /// Lets every view look where its buffer went; one of no buffer stays so, for the reader to refuse.
    fn move_views(&mut self, places: &[(usize, usize)]) {
        let moved = |of: &mut Value| {
            let buffer = of.get("buffer").and_then(Value::as_u64);
            let place = buffer.and_then(|b| places.get(usize::try_from(b).ok()?));
            let Some(&(buffer, start)) = place else {
                if of.get("buffer").is_some() {
                    of["buffer"] = (places.len() + 1).into();
                }
                return;
            };
            of["buffer"] = buffer.into();
            let offset = of.get("byteOffset").and_then(Value::as_u64).unwrap_or(0);
            if start > 0 {
                of["byteOffset"] = offset.saturating_add(start as u64).into();
            }
        };
        for view in self.list("bufferViews").into_iter().flatten().filter(|v| v.is_object()) {
            moved(view);
            for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
                let packed = view.get_mut("extensions").and_then(|e| e.get_mut(name));
                if let Some(packed) = packed.filter(|p| p.is_object()) {
                    moved(packed);
                }
            }
        }
    }

    fn images(&mut self, beside: Beside<'_>) {
        let mut images = self.list("images").map(std::mem::take).unwrap_or_default();
        for (index, image) in images.iter_mut().enumerate() {
            let uri = image.get("uri").and_then(Value::as_str);
            let Some(uri) = uri.filter(|uri| !uri.starts_with("data:")) else { continue };
            let name: String = uri.chars().take(200).collect();
            match beside(&plain(uri)) {
                Ok(Found { bytes, .. }) => {
                    let view = self.list("bufferViews").map_or(0, |views| views.len());
                    let start = self.put(&bytes);
                    let of = json!({"buffer": 0, "byteOffset": start, "byteLength": bytes.len()});
                    match self.list("bufferViews") {
                        Some(views) => views.push(of),
                        None => self.document["bufferViews"] = json!([of]),
                    }
                    *image = json!({"bufferView": view, "mimeType": media_type(&bytes)});
                }
                Err(why) => {
                    self.left_out.push(format!("image {index} is left out: `{name}` {why}"));
                    *image = json!({});
                }
            }
        }
        if !images.is_empty() {
            self.document["images"] = images.into();
        }
    }

    fn finish(mut self) -> Vec<u8> {
        if self.bin.is_empty() {
            // A buffer has at least a byte; what other buffers hold stands in themselves.
            self.bin.resize(4, 0);
        }
        let whole = json!({"byteLength": self.bin.len()});
        if let Some(first) = self.list("buffers").and_then(|all| all.first_mut()) {
            *first = whole;
        }
        note(&mut self.document, &self.left_out);
        of_chunks(self.document.to_string().into_bytes(), Some(self.bin))
    }
}

/// A GLB that says what did not come along when it was made.
///
/// # Errors
/// [`GlbError`] where it is none.
pub(crate) fn noted(glb: Vec<u8>, left_out: &[String]) -> Result<Vec<u8>, GlbError> {
    if left_out.is_empty() {
        return Ok(glb);
    }
    let (json, bin) = chunks(&glb)?;
    let mut document = serde_json::from_slice(json).map_err(|e| GlbError::Json(e.to_string()))?;
    note(&mut document, left_out);
    Ok(of_chunks(document.to_string().into_bytes(), bin.map(<[u8]>::to_vec)))
}

/// Writes down what did not come along, in `asset.extras`.
fn note(document: &mut Value, left_out: &[String]) {
    if left_out.is_empty() {
        return;
    }
    let Some(asset) = document.get_mut("asset").filter(|asset| asset.is_object()) else { return };
    if !asset.get("extras").is_some_and(Value::is_object) {
        asset["extras"] = json!({});
    }
    asset["extras"][LEFT_OUT] = json!(left_out);
}

/// A URI without its escapes: `my%20tex.png` is `my tex.png`.
fn plain(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let digit = |b: Option<&u8>| b.and_then(|b| char::from(*b).to_digit(16));
    let (mut text, mut at) = (Vec::with_capacity(bytes.len()), 0);
    while let Some(&byte) = bytes.get(at) {
        match (byte, digit(bytes.get(at + 1)), digit(bytes.get(at + 2))) {
            (b'%', Some(high), Some(low)) => {
                text.push((16 * high + low) as u8);
                at += 3;
            }
            _ => {
                text.push(byte);
                at += 1;
            }
        }
    }
    String::from_utf8_lossy(&text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glb;

    fn document() -> Value {
        json!({
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [
                {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            "textures": [{"source": 0}],
            "images": [{"uri": "my%20tex.png"}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}],
            "bufferViews": [
                {"buffer": 0, "byteOffset": 4, "byteLength": 36}, {"buffer": 1, "byteLength": 24}],
            "buffers": [{"uri": "a.bin", "byteLength": 40}, {"uri": "b.bin", "byteLength": 24}],
        })
    }

    fn file(name: &str) -> Result<Found, String> {
        let floats = |all: &[f32]| all.iter().flat_map(|f| f.to_le_bytes()).collect::<Vec<u8>>();
        let bytes = match name {
            "a.bin" => floats(&[7.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0, 0.0]),
            "b.bin" => floats(&[0.25, 0.25, 0.75, 0.25, 0.25, 0.75]),
            "my tex.png" => {
                let mut pixels = crate::appearance::Pixels::filled(2, 2, [255, 0, 0, 255]);
                pixels.set(1, 0, [0, 0, 255, 255]);
                pixels.png().unwrap()
            }
            _ => return Err("is not there".into()),
        };
        Ok(Found { name: name.into(), bytes })
    }

    #[test]
    fn buffers_and_pictures_beside_a_gltf_are_taken_in() {
        let glb = to_glb(document().to_string().as_bytes(), &mut file).unwrap();
        let reading = glb::read_noted(&glb).unwrap();
        assert_eq!(reading.mesh.area(0), 3.0);
        let colours = reading.mesh.colours().unwrap();
        assert_eq!((colours[0], colours[1]), ([255, 0, 0, 255], [0, 0, 255, 255]));
        let appearance = reading.appearance.unwrap();
        assert_eq!(appearance.pictures()[0].size(), [2, 2]);
        assert_eq!(appearance.of_face(0).unwrap().1[1], [0.75, 0.25]);
        assert!(reading.notes.is_empty(), "{:?}", reading.notes);
    }

    #[test]
    fn a_picture_that_is_missing_is_said_and_a_buffer_that_is_missing_refused() {
        let mut without = |name: &str| {
            if name.ends_with("png") { Err("is not there".into()) } else { file(name) }
        };
        let glb = to_glb(document().to_string().as_bytes(), &mut without).unwrap();
        let notes = glb::read_noted(&glb).unwrap().notes;
        assert!(
            notes.contains(&"image 0 is left out: `my%20tex.png` is not there".to_owned()),
            "{notes:?}"
        );
        let error = to_glb(document().to_string().as_bytes(), &mut |_| Err("is not there".into()));
        let said = error.unwrap_err().to_string();
        assert_eq!(
            said,
            "GLB: buffer 0: its file lies beside the .gltf, found `a.bin`, which is not there"
        );
        let short = document().to_string().replace("\"byteLength\":40", "\"byteLength\":44");
        let said = to_glb(short.as_bytes(), &mut file).unwrap_err().to_string();
        assert!(said.contains("44 declared, 40 in `a.bin`"), "{said}");
        assert!(to_glb(b"{", &mut file).is_err());
    }

    #[test]
    fn data_in_the_text_itself_and_broken_references_come_to_what_a_glb_says() {
        let text = json!({"asset": {"version": "2.0"},
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "buffers": [{"byteLength": 36, "uri":
                "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]});
        let glb = to_glb(text.to_string().as_bytes(), &mut file).unwrap();
        assert_eq!(glb::read(&glb).unwrap().area(0), 0.5);
        let lost = text.to_string().replace("\"buffer\":0", "\"buffer\":7");
        assert!(glb::read(&to_glb(lost.as_bytes(), &mut file).unwrap()).is_err());
    }
}
