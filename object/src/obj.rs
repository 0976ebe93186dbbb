//! OBJ file ↔ mesh: vertices with optional colours, faces, and materials of an MTL file; groups are skipped.
//!
//! An OBJ names its materials and they their pictures: [`contained`] takes these files into the text, as
//! comments, so that it goes on as one file, and [`read_noted`] finds them there.

mod attached;
mod look;
mod mtl;

use std::borrow::Cow;
use std::fmt::Write as _;

use glamx::DVec3;

use crate::mesh::{FileFrame, MAX_FACES, MAX_VERTICES, Mesh, MeshError, UpAxis, limit};
use crate::normals::{CREASE_ANGLE, corner_normals};
use crate::reading::Reading;

pub use attached::contained;
use look::Look;

/// Why a text is not an OBJ file we can take a surface from.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ObjError {
    /// A line that breaks a rule.
    #[error("OBJ line {line}: {rule}, found `{found}`")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// The rule.
        rule: &'static str,
        /// The line's text, shortened.
        found: String,
    },
    /// The surface is not a mesh: empty, too large, without extent.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// Whether normals are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ObjNormals {
    /// A `vn` per corner, split along creases of more than 40°.
    #[default]
    Smooth,
    /// Positions and faces only.
    None,
}

/// Reads an OBJ text whose `up` axis is known. Faces come out in file order; a polygon becomes a
/// fan from its first corner. Colours (`v x y z r g b`, sRGB 0–1) are kept if every vertex has one.
///
/// # Errors
/// [`ObjError`] with the line, the rule and what was found.
pub fn read(text: &str, up: UpAxis) -> Result<Mesh, ObjError> {
    Ok(read_with(text, up, None)?.mesh)
}

/// Like [`read`], and says how the surface looks, by the materials and pictures that [`contained`] took in,
/// and what was left out. Terms of MTL become those of our materials: see [`crate::appearance`].
///
/// # Errors
/// As [`read`]. What is wrong with a material or a picture is a note.
pub fn read_noted(text: &str, up: UpAxis) -> Result<Reading, ObjError> {
    read_with(text, up, Some(Look::default()))
}

fn read_with<'t>(
    text: &'t str,
    up: UpAxis,
    mut look: Option<Look<'t>>,
) -> Result<Reading, ObjError> {
    let mut reader = Reader { frame: FileFrame { up }, ..Reader::default() };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().enumerate();
    while let Some((number, first)) = lines.next() {
        let whole = whole_line(first, &mut lines);
        let line = &*whole;
        // Half the lines of most files are normals and texture coordinates.
        let start = line.trim_start().as_bytes();
        if !matches!(start, [b'v' | b'f', rest @ ..] if !rest.first().is_some_and(u8::is_ascii_alphanumeric))
        {
            if let Some(look) = &mut look {
                look.line(whole);
            }
            continue;
        }
        let fail = |rule| ObjError::Line {
            line: number + 1,
            rule,
            found: line.chars().take(80).collect(),
        };
        let said = line.bytes().position(|b| b == b'#').map_or(line, |end| &line[..end]);
        let mut words = said.split_whitespace();
        match words.next() {
            Some("v") => reader.vertex(words).map_err(fail)?,
            Some("f") => {
                if let Some(look) = &mut look {
                    look.face(words.clone());
                }
                reader.face(words).map_err(fail)?;
            }
            _ => {}
        }
        // What is too large is refused before the rest of it takes memory.
        limit("vertices", MAX_VERTICES, reader.vertices.len())?;
        limit("triangles", MAX_FACES, reader.faces.len())?;
    }
    let coloured = reader.colours.len() == reader.vertices.len();
    let mesh = Mesh::new(reader.vertices, reader.faces)?.with_frame(reader.frame);
    let mesh = mesh.with_colours(coloured.then_some(reader.colours))?;
    let Some(look) = look else { return Ok(Reading { mesh, appearance: None, notes: vec![] }) };
    Ok(look.finish(mesh))
}

/// A line with those it is continued on: a backslash at its end joins the next one to it.
fn whole_line<'t>(
    first: &'t str,
    rest: &mut impl Iterator<Item = (usize, &'t str)>,
) -> Cow<'t, str> {
    let Some(start) = first.trim_end().strip_suffix('\\') else { return Cow::Borrowed(first) };
    // A remark that ends so is one line still: names of folders do.
    if first.trim_start().starts_with('#') {
        return Cow::Borrowed(first);
    }
    let mut whole = start.to_owned();
    for (_, next) in rest.by_ref() {
        whole.push(' ');
        match next.trim_end().strip_suffix('\\') {
            Some(more) => whole.push_str(more),
            None => {
                whole.push_str(next);
                break;
            }
        }
    }
    Cow::Owned(whole)
}

#[derive(Default)]
struct Reader {
    frame: FileFrame,
    vertices: Vec<DVec3>,
    colours: Vec<[u8; 4]>,
    faces: Vec<[u32; 3]>,
    /// The numbers of a line.
    numbers: Vec<f64>,
}

impl Reader {
    fn vertex<'t>(&mut self, words: impl Iterator<Item = &'t str>) -> Result<(), &'static str> {
        self.numbers.clear();
        for word in words {
            self.numbers.push(word.parse().map_err(|_| "a vertex is made of numbers")?);
        }
        match self.numbers[..] {
            [x, y, z] | [x, y, z, _] => self.push(x, y, z),
            [x, y, z, r, g, b] | [x, y, z, _, r, g, b] => {
                let byte = |c: f64| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
                self.push(x, y, z);
                self.colours.push([byte(r), byte(g), byte(b), 255]);
            }
            _ => return Err("a vertex has 3 coordinates, then perhaps a weight and a colour"),
        }
        Ok(())
    }

    fn push(&mut self, x: f64, y: f64, z: f64) {
        self.vertices.push(self.frame.point_to_object(DVec3::new(x, y, z)));
    }

    fn face<'t>(&mut self, words: impl Iterator<Item = &'t str>) -> Result<(), &'static str> {
        let count = self.vertices.len();
        let mut corners = words.map(|word| corner(word, count));
        let mut next = || corners.next().transpose();
        let [Some(hub), Some(mut last), Some(third)] = [next()?, next()?, next()?] else {
            return Err("a face has at least 3 corners");
        };
        let mut ahead = Some(third);
        while let Some(corner) = ahead {
            self.faces.push([hub, last, corner]);
            (last, ahead) = (corner, next()?);
        }
        Ok(())
    }
}

/// The vertex of `v`, `v/t`, `v//n` or `v/t/n`, counted from 1, or back from the end; `count` are
/// known.
fn corner(word: &str, count: usize) -> Result<u32, &'static str> {
    let end = word.bytes().position(|b| b == b'/').unwrap_or(word.len());
    let number = word[..end].parse::<i64>();
    let number = number.map_err(|_| "a corner starts with a whole number")?;
    let count = count as i64;
    let index = if number < 0 { number.saturating_add(count) } else { number - 1 };
    let known = u32::try_from(index).ok().filter(|&i| i64::from(i) < count);
    known.ok_or("a corner must name a vertex above it")
}

/// Writes a mesh as OBJ text in the object frame (z up, metres), the same text for the same mesh.
///
/// Coordinates are printed so that they read back to the same bits; the vertices are the mesh's,
/// normals are shared by corners that have the same one.
pub fn write(mesh: &Mesh, normals: ObjNormals) -> String {
    let mut text = String::from("# kinfold, metres, z up\n");
    for (v, p) in mesh.vertices().iter().enumerate() {
        row(&mut text, "v", *p);
        if let Some(&[r, g, b, _]) = mesh.colours().and_then(|c| c.get(v)) {
            text.pop();
            let [r, g, b] = [r, g, b].map(|c| f64::from(c) / 255.0);
            put(&mut text, format_args!(" {r:.4} {g:.4} {b:.4}\n"));
        }
    }
    match normals {
        ObjNormals::None => {
            for [a, b, c] in mesh.faces().iter().map(|f| f.map(|v| v + 1)) {
                put(&mut text, format_args!("f {a} {b} {c}\n"));
            }
        }
        ObjNormals::Smooth => write_shaded_faces(&mut text, mesh),
    }
    text
}

fn write_shaded_faces(text: &mut String, mesh: &Mesh) {
    let corners = corner_normals(mesh, CREASE_ANGLE);
    let mut known = std::collections::BTreeMap::new();
    let mut lines = String::new();
    for (face, normals) in mesh.faces().iter().zip(&corners) {
        lines.push('f');
        for (v, n) in face.iter().zip(normals) {
            let rounded = n.to_array().map(|c| (c * 1e6).round() as i64);
            let next = known.len() + 1;
            let number = *known.entry(rounded).or_insert_with(|| {
                let [x, y, z] = rounded.map(|c| c as f64 / 1e6);
                put(text, format_args!("vn {x} {y} {z}\n"));
                next
            });
            put(&mut lines, format_args!(" {}//{number}", v + 1));
        }
        lines.push('\n');
    }
    text.push_str(&lines);
}

fn row(text: &mut String, word: &str, p: DVec3) {
    put(text, format_args!("{word} {} {} {}\n", p.x, p.y, p.z));
}

/// Writing to a string cannot fail.
fn put(text: &mut String, line: std::fmt::Arguments<'_>) {
    let _ = text.write_fmt(line);
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: &str = "# a comment\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0\nv 1 1 0 # here\n\
                        v 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl m\nf 1/1/1 2//1 3/1 -1\n";

    #[test]
    fn a_space_that_is_no_ascii_loses_neither_vertex_nor_face() {
        let text = "v 0 0 0\nv\u{a0}1 0 0\nv 0 1 0\nf\u{a0}1 2 3\nf 3 2 1\n";
        let mesh = read(text, UpAxis::Z).unwrap();
        assert_eq!((mesh.vertices().len(), mesh.faces().len()), (3, 2));
    }

    #[test]
    fn a_polygon_becomes_a_fan_and_negative_indices_count_back() {
        let mesh = read(QUAD, UpAxis::Z).unwrap();
        assert_eq!(mesh.faces(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.frame().up, UpAxis::Z);
        let turned = read(QUAD, UpAxis::Y).unwrap();
        assert_eq!(turned.vertices()[2], DVec3::new(1.0, 0.0, 1.0));
    }

    #[test]
    fn a_broken_line_is_named_with_its_number() {
        let error = |text: &str| read(text, UpAxis::Z).unwrap_err().to_string();
        assert_eq!(
            error("v 0 0 0\nv 1 0 0\nf 1 2 3\n"),
            "OBJ line 3: a corner must name a vertex above it, found `f 1 2 3`"
        );
        assert!(error("v 0 zero 0").starts_with("OBJ line 1: a vertex is made of numbers"));
        assert!(error("v 0 0 0\nf 1 1").contains("at least 3 corners"));
        assert!(error("v 1 2\n").contains("3 coordinates"));
        assert!(error("f 0 0 0").contains("above it"));
        assert!(error("f -9223372036854775808 1 1").contains("above it"));
        assert_eq!(error(""), MeshError::Empty.to_string());
        assert!(error("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").contains("not finite"));
    }

    #[test]
    fn what_is_written_reads_back_bit_for_bit() {
        let third = |i: i32| DVec3::new(1.0 / f64::from(i), -0.1 * f64::from(i), 1e-7);
        let colours = vec![[1, 2, 3, 255], [0, 128, 255, 255], [9, 9, 9, 255], [254, 0, 7, 255]];
        let mesh = Mesh::new((1..5).map(third).collect(), vec![[0, 1, 2], [3, 1, 0]]).unwrap();
        let mesh =
            mesh.with_frame(FileFrame { up: UpAxis::Z }).with_colours(Some(colours)).unwrap();
        for normals in [ObjNormals::Smooth, ObjNormals::None] {
            assert_eq!(read(&write(&mesh, normals), UpAxis::Z).unwrap(), mesh);
        }
    }

    #[test]
    fn a_flat_square_needs_one_normal() {
        let text = write(&read(QUAD, UpAxis::Z).unwrap(), ObjNormals::Smooth);
        let normals: Vec<_> = text.lines().filter(|l| l.starts_with("vn")).collect();
        assert_eq!(normals, ["vn 0 0 1"]);
        assert!(text.ends_with("f 1//1 2//1 3//1\nf 1//1 3//1 4//1\n"), "{text}");
    }
}
