//! Materials and texture coordinates of an OBJ's faces.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::attached::{Attached, library, names};
use super::mtl::{self, Named};
use crate::appearance::{Appearance, MAX_MATERIALS, Picture, Surfacing};
use crate::mesh::{MAX_FACES, MAX_VERTICES, Mesh};
use crate::reading::{Reading, shortened};

/// What the lines so far say of how faces look.
#[derive(Debug, Default)]
pub(super) struct Look<'a> {
    attached: Attached<'a>,
    libraries: Vec<Cow<'a, str>>,
    /// Names of `usemtl` by index, in order of first use.
    names: Vec<Cow<'a, str>>,
    known: BTreeMap<Cow<'a, str>, u32>,
    current: Option<u32>,
    /// Coordinates, v upward.
    places: Vec<[f32; 2]>,
    /// For each triangle its material's name and coordinates.
    faces: Vec<Surfacing>,
}

fn missing(library: &str, why: &str) -> String {
    let name: String = library.chars().take(200).collect();
    format!("the materials of `{name}` are left out: it {why}")
}

/// The name that a line `usemtl NAME` says.
fn used(line: &str) -> Option<&str> {
    line.trim_start().strip_prefix("usemtl").map(str::trim)
}

/// What is found in a line, borrowed where the line is.
fn within<'a>(line: &Cow<'a, str>, find: fn(&str) -> Option<&str>) -> Option<Cow<'a, str>> {
    match line {
        Cow::Borrowed(line) => find(line).map(Cow::Borrowed),
        Cow::Owned(line) => find(line).map(|found| Cow::Owned(found.to_owned())),
    }
}

impl<'a> Look<'a> {
    /// Takes in a line that is neither a vertex nor a face.
    pub(super) fn line(&mut self, line: Cow<'a, str>) {
        if let Cow::Borrowed(line) = line
            && line.starts_with('#')
        {
            return self.attached.comment(line);
        }
        if let Some(library) = within(&line, library) {
            if self.libraries.len() < MAX_MATERIALS {
                self.libraries.push(library);
            }
            return;
        }
        let mut words = line.split_whitespace();
        match words.next() {
            Some("vt") if self.places.len() < MAX_VERTICES => {
                let mut number = || words.next().and_then(|w| w.parse().ok()).unwrap_or(0.0);
                let place: [f32; 2] = [number(), number()];
                self.places.push(place.map(|c| if c.is_finite() { c } else { 0.0 }));
            }
            Some("usemtl") => {
                let name = within(&line, used).unwrap_or_default();
                let next = self.names.len();
                if next < MAX_MATERIALS || self.known.contains_key(&name) {
                    self.current = Some(*self.known.entry(name.clone()).or_insert_with(|| {
                        self.names.push(name);
                        next as u32
                    }));
                }
            }
            _ => {}
        }
    }

    /// Adds the triangles of a face, as the mesh gets them; what is wrong with it is said by who reads that.
    pub(super) fn face<'t>(&mut self, words: impl Iterator<Item = &'t str>) {
        let mut corners = words.map(|word| self.place(word));
        let (Some(hub), Some(mut last)) = (corners.next(), corners.next()) else { return };
        let material = self.current;
        let rest: Vec<_> = corners.collect();
        for next in rest.into_iter().take(MAX_FACES) {
            self.faces.push(Surfacing { material, corners: [hub, last, next] });
            last = next;
        }
    }

    /// Where a corner `v/t` or `v/t/n` lies on the texture; zeros where it does not say.
    fn place(&self, word: &str) -> [f32; 2] {
        let number = word.split('/').nth(1).and_then(|t| t.parse::<i64>().ok()).unwrap_or(0);
        let count = self.places.len() as i64;
        let index = if number < 0 { number.saturating_add(count) } else { number - 1 };
        usize::try_from(index).ok().and_then(|i| self.places.get(i)).copied().unwrap_or_default()
    }

    /// The mesh with how it looks, unless the file has no materials.
    pub(super) fn finish(self, mesh: Mesh) -> Reading {
        let mut notes = Vec::new();
        let materials = self.materials(&mut notes);
        if self.names.is_empty() {
            // Of a library that no face uses only its absence is of interest.
            let libraries = self.libraries.iter().flat_map(|line| names(line));
            let missing = libraries.filter_map(|n| Some(missing(n, &self.attached.file(n).err()?)));
            return Reading { mesh, appearance: None, notes: shortened(missing.collect()) };
        }
        if self.libraries.is_empty() {
            return Reading { mesh, appearance: None, notes: vec![] };
        }
        let (materials, pictures) = self.pictures(materials, &mut notes);
        // Of names that no library explains, faces have no material.
        let mut place_of = vec![None; self.names.len()];
        for (place, name) in place_of.iter_mut().zip(&self.names) {
            *place = materials.iter().position(|m| m.name == *name);
            if place.is_none() && !name.is_empty() {
                let name: String = name.chars().take(80).collect();
                notes.push(format!("material `{name}` is left out: no file defines it"));
            }
        }
        let dress = |face: &Surfacing| {
            let index = face.material.and_then(|n| place_of.get(n as usize).copied().flatten());
            let Some(of) = index.and_then(|i| materials.get(i)) else {
                return Surfacing::default();
            };
            let [scale, shift] = of.moved;
            let corners = face.corners.map(|[u, v]| {
                let u = f64::from(u) * scale[0] + shift[0];
                let v = 1.0 - (f64::from(v) * scale[1] + shift[1]);
                [u as f32, v as f32].map(|c| if c.is_finite() { c } else { 0.0 })
            });
            let corners = if of.material.is_textured() { corners } else { [[0.0; 2]; 3] };
            Surfacing { material: index.map(|i| i as u32), corners }
        };
        let faces: Vec<_> = self.faces.iter().map(dress).collect();
        let materials = materials.iter().map(|m| m.material.clone()).collect();
        let appearance = Appearance::or_noted((pictures, materials, faces), &mut notes);
        Reading { mesh, appearance, notes: shortened(notes) }
    }

    /// Materials of all libraries that could be had.
    fn materials(&self, notes: &mut Vec<String>) -> Vec<Named> {
        let mut all = Vec::new();
        for name in self.libraries.iter().flat_map(|line| names(line)) {
            match self.attached.file(name) {
                Ok(bytes) => {
                    let text = String::from_utf8_lossy(&bytes);
                    all.extend(mtl::parse(&text, MAX_MATERIALS - all.len(), notes));
                }
                Err(why) => notes.push(missing(name, &why)),
            }
        }
        all
    }

    /// Materials with their pictures laid on.
    fn pictures(
        &self,
        mut materials: Vec<Named>,
        notes: &mut Vec<String>,
    ) -> (Vec<Named>, Vec<Picture>) {
        let mut places: BTreeMap<String, Option<usize>> = BTreeMap::new();
        let mut pictures = Vec::new();
        let used = |m: &&mut Named| self.known.contains_key(m.name.as_str());
        for material in materials.iter_mut().filter(used) {
            for which in 0..material.pictures.len() {
                let Some(name) = material.pictures.get_mut(which).and_then(Option::take) else {
                    continue;
                };
                let place = places.entry(name.clone()).or_insert_with(|| {
                    match self
                        .attached
                        .file(&name)
                        .map_err(|why| format!("it {why}"))
                        .and_then(Picture::new)
                    {
                        Ok(picture) => {
                            pictures.push(picture);
                            Some(pictures.len() - 1)
                        }
                        Err(why) => {
                            let name: String = name.chars().take(200).collect();
                            notes.push(format!("picture `{name}` is left out: {why}"));
                            None
                        }
                    }
                });
                if let Some(place) = *place {
                    material.lay(which, place);
                }
            }
        }
        (materials, pictures)
    }
}
