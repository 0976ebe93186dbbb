//! How the links of an asset look: materials and textures of the file, carried over to surfaces that were
//! repaired, simplified, capped and cut since.

pub(crate) mod look;
mod mean;
mod pack;
mod painted;
mod stored;
mod textures;
mod transfer;

use std::collections::BTreeMap;

use glamx::DVec3;
use object::ArticulatedObject;
use object::appearance::{Appearance, Material, Surfacing};
use rayon::prelude::*;

use crate::asset::{Asset, Link, LinkBody};
use crate::write::appearance::look::{AssetAppearance, Group, LinkAppearance};
use crate::write::appearance::mean::mean;
use crate::write::appearance::painted::painted;
use crate::write::appearance::textures::{Textures, Use};
use crate::write::appearance::transfer::Source;

impl AssetAppearance {
    /// How the links of an asset look that was built of `object`, whose mesh looks like `appearance`.
    ///
    /// Without one, links whose vertices have several colours are split by colour, and others have the
    /// one colour of the link. The same inputs give the same appearance, on any number of threads.
    pub fn of(asset: &Asset, object: &ArticulatedObject, appearance: Option<&Appearance>) -> Self {
        let fits = |a: &&Appearance| a.faces().len() == object.mesh().faces().len();
        let known = appearance.filter(fits);
        let looks = |link: &Link| Some(looks(asset, object, known, link, link.body.as_ref()?));
        let looks: Vec<Option<Vec<Surfacing>>> = asset.links.par_iter().map(looks).collect();
        let mut maker = Maker { names: Names::of(asset), notes: vec![], pending: BTreeMap::new() };
        if appearance.is_some() && known.is_none() {
            maker.notes.push("materials are left out: they are of another mesh".into());
        }
        let mut links: Vec<LinkAppearance> = Vec::new();
        for (index, (link, looks)) in asset.links.iter().zip(looks).enumerate() {
            let of = link.body.as_ref().zip(looks);
            links.push(of.map_or_else(LinkAppearance::default, |(body, looks)| {
                maker.link((index, link, body), known, &looks)
            }));
        }
        let Maker { pending, mut notes, .. } = maker;
        let Some(known) = known else { return Self { links, textures: vec![], notes } };
        let mut textures = Textures::new(known);
        for (material, mut uses) in pending {
            let Some(of) = known.materials().get(material as usize) else { continue };
            let (places, mut of_links): (Vec<_>, Vec<Use>) = uses.drain(..).unzip();
            for (place, of_link) in places.iter().zip(&of_links) {
                let [link, group] = *place;
                let body = asset.links[link].body.as_ref();
                let base = of.base_texture.and_then(|t| Some((t, textures.pixels(t.picture)?)));
                let group = &mut links[link].groups[group];
                group.mean =
                    mean(of, base, body.map(|b| &b.visual), (&group.faces, &of_link.corners));
            }
            let laid = textures.lay(of, &mut of_links);
            for (([link, group], of_link), material) in places.into_iter().zip(of_links).zip(laid) {
                let group = &mut links[link].groups[group];
                group.corners = if material.is_textured() { of_link.corners } else { vec![] };
                group.material = material;
            }
        }
        notes.extend(textures.notes);
        Self { links, textures: textures.files, notes }
    }
}

/// What each face of a link's surface has of the object's.
fn looks(
    asset: &Asset,
    object: &ArticulatedObject,
    appearance: Option<&Appearance>,
    link: &Link,
    body: &LinkBody,
) -> Vec<Surfacing> {
    let faces = 0..body.visual.faces().len();
    let none = || faces.clone().map(|_| Surfacing::default()).collect();
    let Some(appearance) = appearance else { return none() };
    let own: Vec<usize> = object.faces_of(link.part).collect();
    let looks: Vec<Surfacing> = own.iter().map(|&f| appearance.faces()[f]).collect();
    if looks.iter().all(|l| l.material.is_none()) {
        return none();
    }
    let placed = |p: DVec3| asset.turn * (asset.scale.value * p) + asset.offset - link.frame;
    let mesh = object.mesh().submesh(own).and_then(|m| m.map_vertices(placed));
    let Some(source) = mesh.ok().and_then(|m| Source::new(&m, &looks)) else { return none() };
    faces.clone().into_par_iter().map(|f| source.of_face(body.visual.corners(f))).collect()
}

/// Groups in the making.
struct Maker {
    names: Names,
    notes: Vec<String>,
    /// For each material with textures, the link and group of each use.
    pending: BTreeMap<u32, Vec<([usize; 2], Use)>>,
}

impl Maker {
    fn link(
        &mut self,
        (index, link, body): (usize, &Link, &LinkBody),
        appearance: Option<&Appearance>,
        looks: &[Surfacing],
    ) -> LinkAppearance {
        let mut by_material: BTreeMap<Option<u32>, Vec<u32>> = BTreeMap::new();
        for (face, look) in (0u32..).zip(looks) {
            by_material.entry(look.material).or_default().push(face);
        }
        let of_vertices = by_material.keys().all(Option::is_none);
        let mut groups = Vec::new();
        for (material, faces) in by_material {
            let of = material
                .zip(appearance)
                .and_then(|(m, a)| Some((m, a.materials().get(m as usize)?)));
            let Some((number, of)) = of else {
                groups.extend(self.painted(link, body, faces));
                continue;
            };
            let name = self.names.fresh(&link.name, &of.name);
            if of.is_textured() {
                let corners = faces.iter().map(|&f| looks[f as usize].corners).collect();
                let of_link = Use { name: name.clone(), corners };
                self.pending.entry(number).or_default().push(([index, groups.len()], of_link));
            }
            groups.push(Group {
                name,
                material: of.clone(),
                mean: mean(of, None, None, (&[], &[])),
                faces,
                corners: vec![],
            });
        }
        if of_vertices && groups.len() < 2 {
            groups.clear();
        }
        LinkAppearance { groups, of_vertices }
    }

    /// Faces without a material, by the colours of their vertices.
    fn painted(&mut self, link: &Link, body: &LinkBody, faces: Vec<u32>) -> Vec<Group> {
        let (by_colour, is_mixed) = painted(&body.visual, &faces, body.colour.value);
        if is_mixed {
            let name = &link.name;
            self.notes.push(format!(
                "link `{name}`: the colours of its vertices are too many, or do not come apart, for URDF and MJCF, which \
                 show their mean"
            ));
        }
        let group = |(mean, faces): ([f64; 4], Vec<u32>)| {
            let [r, g, b, alpha] = mean;
            let light = [r, g, b].map(object::glb::linear_of_srgb);
            let base_colour = [light[0], light[1], light[2], alpha];
            let material = Material { base_colour, ..Material::default() };
            let name = self.names.fresh(&link.name, "colour");
            Group { name, material, mean, faces, corners: vec![] }
        };
        by_colour.into_iter().map(group).collect()
    }
}

/// Names in use, lower case.
struct Names(std::collections::BTreeSet<String>);

impl Names {
    /// Those of the links are taken.
    fn of(asset: &Asset) -> Self {
        Self(asset.links.iter().map(|l| l.name.to_lowercase()).collect())
    }

    /// A name of a link's and a material's that nobody else has: ASCII letters, digits and underscores.
    fn fresh(&mut self, link: &str, material: &str) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let tail: String = material.chars().take(40).map(plain).collect();
        let tail = tail.trim_matches('_');
        let tail = if tail.is_empty() { "material" } else { tail };
        let name = format!("{link}_{tail}");
        let numbered = (2..).map(|n| format!("{name}_{n}"));
        let mut candidates = std::iter::once(name.clone()).chain(numbered);
        let found = candidates.find(|n| self.0.insert(n.to_lowercase()));
        found.unwrap_or(name)
    }
}
