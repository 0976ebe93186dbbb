//! The header of a PLY file: which numbers follow, and how they are written.

use super::error::PlyError;
use crate::mesh::{MAX_FACES, MAX_VERTICES, limit};

/// Most bytes of a header. Those of scanners have some hundred lines; a guess with room.
const MAX_HEADER: usize = 64 << 10;
/// Most properties of all elements together: Gaussian splats have 62.
const MAX_PROPERTIES: usize = 512;

/// How numbers stand in the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

/// A type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of one.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// What white is in a colour of this type.
    pub(super) fn white(self) -> f64 {
        match self {
            Self::U8 => 255.0,
            Self::U16 => 65535.0,
            _ => 1.0,
        }
    }

    fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// A number of every row, or a list of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// The type of the list's length, where it is a list.
    pub(super) length: Option<Kind>,
}

/// Rows of one kind.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// Whether it is the one with faces.
    pub(super) fn is_face(&self) -> bool {
        self.name == "face"
    }

    /// The list that holds the corners of a face.
    pub(super) fn corners(&self) -> Option<usize> {
        let is_list = |p: &Property| p.length.is_some() && p.kind.is_whole();
        let named = |p: &Property| matches!(p.name.as_str(), "vertex_indices" | "vertex_index");
        self.properties.iter().position(|p| is_list(p) && named(p))
    }
}

/// All that stands before the rows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    has_texture: bool,
}

impl Header {
    /// Reads it; gives the bytes behind it as well.
    pub(super) fn parse(bytes: &[u8]) -> Result<(Self, &[u8]), PlyError> {
        let mut header = Self { encoding: Encoding::Text, elements: vec![], has_texture: false };
        let (mut at, mut encoding, mut properties) = (0, None, 0);
        for number in 1.. {
            let rest = bytes.get(at..MAX_HEADER.min(bytes.len())).unwrap_or_default();
            let fail = |rule, line: &[u8]| PlyError::Header {
                line: number,
                rule,
                found: String::from_utf8_lossy(line).trim().chars().take(80).collect(),
            };
            let Some(end) = rest.iter().position(|b| *b == b'\n' || *b == b'\r') else {
                return Err(fail("a header of at most 64 KiB ends with `end_header`", rest));
            };
            let line = rest.get(..end).unwrap_or_default();
            // Lines may end in one of three ways; in the body a byte 10 may be data.
            let is_pair = rest.get(end..end + 2) == Some(b"\r\n");
            at += end + if is_pair { 2 } else { 1 };
            let text = String::from_utf8_lossy(line);
            let words: Vec<&str> = text.split_whitespace().take(6).collect();
            match words[..] {
                ["ply"] if number == 1 => {}
                _ if number == 1 => return Err(fail("the first line must be `ply`", line)),
                ["format", name, _] => {
                    let known = match name {
                        "ascii" => Encoding::Text,
                        "binary_little_endian" => Encoding::Little,
                        "binary_big_endian" => Encoding::Big,
                        _ => return Err(fail("the format must be ascii or binary", line)),
                    };
                    encoding = Some(known);
                }
                ["comment", "TextureFile", ..] => header.has_texture = true,
                ["comment" | "obj_info", ..] | [] => {}
                ["element", name, count] => {
                    let count = count.parse();
                    let count = count.map_err(|_| fail("an element has a whole count", line))?;
                    let name = name.to_owned();
                    header.elements.push(Element { name, count, properties: vec![] });
                }
                ["property", ref of @ ..] => {
                    properties += 1;
                    let property = property(of).filter(|_| properties <= MAX_PROPERTIES);
                    let property = property.ok_or_else(|| {
                        fail("a property has a type and a name, and there are at most 512", line)
                    })?;
                    match header.elements.last_mut() {
                        Some(element) => element.properties.push(property),
                        None => return Err(fail("a property belongs to an element", line)),
                    }
                }
                ["end_header"] => break,
                _ => return Err(fail("a line must be one that PLY knows", line)),
            }
        }
        let missing = PlyError::Rule { rule: "a format must be said", found: "none".into() };
        header.encoding = encoding.ok_or(missing)?;
        Ok((header, bytes.get(at..).unwrap_or_default()))
    }

    /// Whether a surface can follow: vertices with places, faces with corners, not too many of them.
    pub(super) fn check(&self) -> Result<(), PlyError> {
        let rule = |rule, found: String| Err(PlyError::Rule { rule, found });
        let vertex = self.elements.iter().find(|e| e.name == "vertex");
        let Some(vertex) = vertex else { return rule("a surface has vertices", "none".into()) };
        let has = |name: &str| vertex.properties.iter().any(|p| p.name == name);
        if !["x", "y", "z"].iter().all(|name| has(name)) {
            return rule("vertices have x, y and z", self.listed());
        }
        if !self.elements.iter().any(|e| e.is_face() && e.count > 0) {
            let found = if has("f_dc_0") {
                "a cloud of Gaussian splats, which has no surface: make a mesh of it first"
            } else {
                "points alone: make a mesh of them first, such as by MeshLab's screened Poisson"
            };
            return rule("a surface has faces", found.into());
        }
        if self.elements.iter().any(|e| e.is_face() && e.corners().is_none()) {
            return rule("faces have a list `vertex_indices`", self.listed());
        }
        if self.elements.iter().any(|e| e.count > 0 && e.properties.is_empty()) {
            return rule("an element has properties", self.listed());
        }
        limit("vertices", MAX_VERTICES, vertex.count)?;
        let faces = self.elements.iter().filter(|e| e.is_face()).map(|e| e.count);
        limit("triangles", MAX_FACES, faces.max().unwrap_or(0))?;
        match self.elements.iter().filter(|e| e.name == "vertex" || e.is_face()).count() {
            2 => Ok(()),
            _ => rule("vertices and faces stand in one element each", self.listed()),
        }
    }

    /// What of the file makes no difference to the mesh, in plain words. Normals follow from it.
    pub(super) fn left_out(&self) -> Vec<String> {
        let of = |face: bool, names: &[&str]| {
            let mut elements = self.elements.iter().filter(|e| e.is_face() == face);
            elements.any(|e| e.properties.iter().any(|p| names.contains(&p.name.as_str())))
        };
        let textured = self.has_texture || of(true, &["texcoord"]) || of(false, &["texture_u"]);
        let lost = [
            (textured, "the PLY's texture is left out; OBJ with MTL, glTF or USD bring it"),
            (of(true, &["red", "diffuse_red"]), "the PLY's colours of faces are left out"),
        ];
        lost.into_iter().filter(|(is, _)| *is).map(|(_, what)| what.to_owned()).collect()
    }

    fn listed(&self) -> String {
        let one = |e: &Element| {
            let names: Vec<&str> = e.properties.iter().map(|p| p.name.as_str()).take(12).collect();
            format!("{} ({})", e.name, names.join(", "))
        };
        let all = self.elements.iter().take(8).map(one).collect::<Vec<_>>().join(", ");
        all.chars().take(200).collect()
    }
}

fn property(words: &[&str]) -> Option<Property> {
    match *words {
        ["list", length, kind, name] => {
            let length = Kind::of(length).filter(|k| k.is_whole())?;
            Some(Property { name: name.into(), kind: Kind::of(kind)?, length: Some(length) })
        }
        [kind, name] => Some(Property { name: name.into(), kind: Kind::of(kind)?, length: None }),
        _ => None,
    }
}
