//! Files whose surface lies on its back, set upright: the same file with z up turned to y up.
//!
//! Nothing is rounded: in OBJ two columns trade places and one changes its sign, in GLB one node more holds
//! what stood at the top.

use serde_json::{Value, json};

use crate::glb::{GlbError, chunks, of_chunks};

/// An OBJ text with z up as the same with y up: (x, y, z) becomes (x, z, −y), normals alike.
pub fn obj(text: &str) -> String {
    let mut upright = String::with_capacity(text.len() + 64);
    for line in text.split_inclusive('\n') {
        match turned(line) {
            Some(turned) => upright.push_str(&turned),
            None => upright.push_str(line),
        }
    }
    upright
}

/// A vertex or a normal, turned; `None` for any other line.
fn turned(line: &str) -> Option<String> {
    let said = line.split('#').next()?;
    let mut words = said.split_whitespace();
    let kind = words.next().filter(|kind| matches!(*kind, "v" | "vn"))?;
    let [x, y, z] = [words.next()?, words.next()?, words.next()?];
    let against = match y.strip_prefix('-') {
        Some(positive) => positive.to_owned(),
        None => format!("-{}", y.strip_prefix('+').unwrap_or(y)),
    };
    let rest: Vec<&str> = words.collect();
    let rest = if rest.is_empty() { String::new() } else { format!(" {}", rest.join(" ")) };
    Some(format!("{kind} {x} {z} {against}{rest}\n"))
}

/// A GLB file with z up as the same with y up: a node above all roots of every scene turns them.
///
/// # Errors
/// [`GlbError`] where it is none.
pub fn glb(bytes: &[u8]) -> Result<Vec<u8>, GlbError> {
    let (json, bin) = chunks(bytes)?;
    let broken = |e: serde_json::Error| GlbError::Json(e.to_string());
    let mut document: Value = serde_json::from_slice(json).map_err(broken)?;
    let first = document.get("nodes").and_then(Value::as_array).map_or(0, Vec::len);
    let mut tops = Vec::new();
    let scenes = document.get_mut("scenes").and_then(Value::as_array_mut);
    for scene in scenes.into_iter().flatten() {
        let Some(roots) = scene.get_mut("nodes").filter(|roots| roots.is_array()) else { continue };
        // Columns: x stays, y becomes −z, z becomes y.
        let turn = [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1];
        let top = json!({ "name": "upright", "matrix": turn, "children": roots.take() });
        *roots = json!([first + tops.len()]);
        tops.push(top);
    }
    if let Some(nodes) = document.get_mut("nodes").and_then(Value::as_array_mut) {
        nodes.extend(tops);
    }
    Ok(of_chunks(document.to_string().into_bytes(), bin.map(<[u8]>::to_vec)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, UpAxis};
    use glamx::DVec3;

    #[test]
    fn an_obj_with_z_up_reads_the_same_as_with_its_axis_known() {
        let text = "# v 1 2 3\nv 0.1 0.2 -0.3 1 0 0\nv 1 0 +0.5 0 1 0\nv 0 -1e-3 2 0 0 1 # c\nvn 0 0 1\nf 1 2 3\n";
        let known = crate::obj::read(text, UpAxis::Z).unwrap();
        let turned = crate::obj::read(&obj(text), UpAxis::Y).unwrap();
        assert_eq!(turned.vertices(), known.vertices());
        assert_eq!((turned.faces(), turned.colours()), (known.faces(), known.colours()));
        assert!(obj(text).starts_with("# v 1 2 3\n") && obj(text).contains("vn 0 1 -0\n"));
    }

    #[test]
    fn a_glb_with_z_up_is_turned_by_one_node_and_to_the_last_bit() {
        let v = vec![DVec3::new(0.1, 0.2, -0.3), DVec3::X, DVec3::Y, DVec3::new(0.0, 0.5, 2.0)];
        let mesh = Mesh::new(v, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let file = crate::glb::write(&mesh);
        let read = crate::glb::read(&file).unwrap();
        let turned = crate::glb::read(&glb(&file).unwrap()).unwrap();
        let expected: Vec<DVec3> =
            read.vertices().iter().map(|&p| read.frame().point_to_file(p)).collect();
        assert_eq!(turned.vertices(), expected, "what was z in the file is up");
        assert!(glb(b"glTF").is_err());
    }
}
