//! The rows of a PLY file.

use glamx::DVec3;

use super::error::PlyError;
use super::header::{Element, Encoding, Header, Kind, Property};
use crate::mesh::{MAX_FACES, limit};

/// What the rows hold, in the file's frame.
#[derive(Debug, Default)]
pub(super) struct PlyMesh {
    pub(super) vertices: Vec<DVec3>,
    pub(super) colours: Option<Vec<[u8; 4]>>,
    pub(super) faces: Vec<[u32; 3]>,
}

/// Rows, read from their first byte to their last.
pub(super) struct Body<'a> {
    header: &'a Header,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Body<'a> {
    pub(super) fn new(header: &'a Header, bytes: &'a [u8]) -> Self {
        Self { header, bytes, at: 0 }
    }

    pub(super) fn read(mut self) -> Result<PlyMesh, PlyError> {
        let mut mesh = PlyMesh::default();
        for element in &self.header.elements {
            match element.name.as_str() {
                "vertex" => self.vertices(element, &mut mesh)?,
                "face" => self.faces(element, &mut mesh)?,
                // Behind the faces nothing is of use.
                _ if !mesh.faces.is_empty() && !mesh.vertices.is_empty() => break,
                _ => self.skip(element)?,
            }
        }
        // Faces may stand before the vertices they name: Mesh::new judges them.
        Ok(mesh)
    }

    fn vertices(&mut self, element: &Element, mesh: &mut PlyMesh) -> Result<(), PlyError> {
        let place = |name: &str| element.properties.iter().position(|p| p.name == name);
        let places = ["x", "y", "z"].map(place);
        let shades = ["red", "green", "blue", "alpha"];
        let either = |n: &str| place(n).or_else(|| place(&format!("diffuse_{n}")));
        let shades = shades.map(|n| either(n).or_else(|| place(n.get(..1).unwrap_or(n))));
        let coloured = shades[..3].iter().all(Option::is_some);
        let mut colours = Vec::new();
        let mut row = vec![0.0; element.properties.len()];
        for number in 0..element.count {
            for (value, property) in row.iter_mut().zip(&element.properties) {
                *value = self.value((element, number), property)?;
            }
            let of = |index: Option<usize>| index.and_then(|i| row.get(i).copied());
            let [x, y, z] = places.map(|i| of(i).unwrap_or(f64::NAN));
            mesh.vertices.push(DVec3::new(x, y, z));
            if coloured {
                colours.push(shades.map(|index| {
                    let kind = index.and_then(|i| element.properties.get(i)).map(|p| p.kind);
                    let share = of(index).zip(kind).map_or(1.0, |(v, kind)| v / kind.white());
                    (share.clamp(0.0, 1.0) * 255.0).round() as u8
                }));
            }
        }
        mesh.colours = coloured.then_some(colours);
        Ok(())
    }

    fn faces(&mut self, element: &Element, mesh: &mut PlyMesh) -> Result<(), PlyError> {
        let corners = element.corners();
        for number in 0..element.count {
            for (index, property) in element.properties.iter().enumerate() {
                if Some(index) == corners {
                    self.fan((element, number), property, &mut mesh.faces)?;
                } else {
                    self.value((element, number), property)?;
                }
            }
            limit("triangles", MAX_FACES, mesh.faces.len())?;
        }
        Ok(())
    }

    /// A polygon as triangles that share its first corner.
    fn fan(
        &mut self,
        (element, row): (&Element, usize),
        property: &Property,
        faces: &mut Vec<[u32; 3]>,
    ) -> Result<(), PlyError> {
        let length = self.length((element, row), property)?;
        let fail =
            |rule, found: String| PlyError::Row { element: element.name.clone(), row, rule, found };
        if length < 3 {
            return Err(fail("a face has at least 3 corners", length.to_string()));
        }
        let corner = |this: &mut Self| {
            let value = this.number((element, row), property.kind)?;
            let is_index = value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0;
            if is_index {
                Ok(value as u32)
            } else {
                Err(fail("a corner is a vertex's number", value.to_string()))
            }
        };
        let (hub, mut last) = (corner(self)?, corner(self)?);
        for _ in 2..length {
            let next = corner(self)?;
            faces.push([hub, last, next]);
            last = next;
            limit("triangles", MAX_FACES, faces.len())?;
        }
        Ok(())
    }

    fn skip(&mut self, element: &Element) -> Result<(), PlyError> {
        for number in 0..element.count {
            for property in &element.properties {
                self.value((element, number), property)?;
            }
        }
        Ok(())
    }

    /// A number; of a list, which is passed over, nothing.
    fn value(&mut self, at: (&Element, usize), property: &Property) -> Result<f64, PlyError> {
        if property.length.is_none() {
            return self.number(at, property.kind);
        }
        for _ in 0..self.length(at, property)? {
            self.number(at, property.kind)?;
        }
        Ok(0.0)
    }

    fn length(&mut self, at: (&Element, usize), property: &Property) -> Result<usize, PlyError> {
        let value = self.number(at, property.length.unwrap_or(Kind::U8))?;
        if value >= 0.0 && value.fract() == 0.0 {
            return Ok(value as usize);
        }
        let rule = "a list's length is a whole number";
        Err(PlyError::Row { element: at.0.name.clone(), row: at.1, rule, found: value.to_string() })
    }

    fn number(&mut self, (element, row): (&Element, usize), kind: Kind) -> Result<f64, PlyError> {
        let found = match self.header.encoding {
            Encoding::Text => self.word(),
            Encoding::Little | Encoding::Big => self.binary(kind),
        };
        found.map_err(|found| PlyError::Row {
            element: element.name.clone(),
            row,
            rule: "a row has a number for each property",
            found,
        })
    }

    fn word(&mut self) -> Result<f64, String> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let start = rest.iter().position(|b| !b.is_ascii_whitespace());
        let rest = start.and_then(|s| rest.get(s..)).ok_or("the end of the file")?;
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += start.unwrap_or(0) + length;
        let word = String::from_utf8_lossy(rest.get(..length.min(80)).unwrap_or_default());
        word.parse().map_err(|_| format!("`{word}`"))
    }

    fn binary(&mut self, kind: Kind) -> Result<f64, String> {
        let end = self.at + kind.size();
        let bytes = self.bytes.get(self.at..end).ok_or("the end of the file")?;
        self.at = end;
        let mut word = [0; 8];
        for (n, byte) in bytes.iter().enumerate() {
            let place = if self.header.encoding == Encoding::Big { bytes.len() - 1 - n } else { n };
            if let Some(slot) = word.get_mut(place) {
                *slot = *byte;
            }
        }
        let [a, b, c, d, ..] = word;
        Ok(match kind {
            Kind::I8 => f64::from(a as i8),
            Kind::U8 => f64::from(a),
            Kind::I16 => f64::from(i16::from_le_bytes([a, b])),
            Kind::U16 => f64::from(u16::from_le_bytes([a, b])),
            Kind::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Kind::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Kind::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Kind::F64 => f64::from_le_bytes(word),
        })
    }
}
