//! The nodes of a COLLADA scene: which surfaces stand where.

use std::collections::BTreeMap;

use glamx::{DMat3, DVec3};
use object::mesh::{MAX_FACES, MAX_VERTICES, MeshError};
use roxmltree::Node;

use super::surface::{Surface, surface};
use super::xml::{DaeError, child, children, numbers};

/// Deepest nesting of nodes, and most nodes that are visited: a node may stand in several places.
const DEEPEST: usize = 64;
const MOST_VISITED: usize = 100_000;

/// Points in metres and triangles between them.
#[derive(Default)]
pub(super) struct Soup {
    pub points: Vec<DVec3>,
    pub faces: Vec<[u32; 3]>,
}

/// A linear map and a shift.
#[derive(Clone, Copy)]
struct Affine {
    linear: DMat3,
    shift: DVec3,
}

impl Affine {
    const IDENTITY: Self = Self { linear: DMat3::IDENTITY, shift: DVec3::ZERO };

    fn then(self, inner: Self) -> Self {
        let shift = self.linear * inner.shift + self.shift;
        Self { linear: self.linear * inner.linear, shift }
    }
}

struct Walk<'d> {
    by_id: BTreeMap<&'d str, Node<'d, 'd>>,
    surfaces: BTreeMap<&'d str, Surface>,
    metre: f64,
    visited: usize,
    soup: Soup,
}

/// All surfaces of a file's scene; of a file without one, all its geometries as they are.
pub(super) fn gather<'d>(root: Node<'d, 'd>, metre: f64) -> Result<Soup, DaeError> {
    let named = root.descendants().filter_map(|n| Some((n.attribute("id")?, n)));
    let (by_id, surfaces) = (named.collect(), BTreeMap::new());
    let mut walk = Walk { by_id, surfaces, metre, visited: 0, soup: Soup::default() };
    let scene = child(root, "scene").and_then(|s| child(s, "instance_visual_scene"));
    match scene.and_then(|scene| walk.target(scene)) {
        Some(scene) => walk.nodes(scene, Affine::IDENTITY, 0)?,
        None => {
            let is_geometry = |n: &Node| n.tag_name().name() == "geometry";
            for node in root.descendants().filter(is_geometry) {
                walk.place(node, Affine::IDENTITY)?;
            }
        }
    }
    Ok(walk.soup)
}

impl<'d> Walk<'d> {
    /// What an instance names.
    fn target(&self, instance: Node<'d, 'd>) -> Option<Node<'d, 'd>> {
        let id = instance.attribute("url")?.trim().strip_prefix('#')?;
        self.by_id.get(id).copied()
    }

    fn nodes(&mut self, parent: Node<'d, 'd>, at: Affine, depth: usize) -> Result<(), DaeError> {
        self.visited += 1;
        if depth > DEEPEST || self.visited > MOST_VISITED {
            let rule = format!("nodes nest at most {DEEPEST} deep, {MOST_VISITED} in all");
            return Err(DaeError::at(parent, rule));
        }
        let mut at = at;
        for node in children(parent) {
            let step = match node.tag_name().name() {
                "matrix" => Some(matrix(node)?),
                "translate" => Some(Affine { shift: three(node)?, ..Affine::IDENTITY }),
                "scale" => {
                    let linear = DMat3::from_diagonal(three(node)?);
                    Some(Affine { linear, ..Affine::IDENTITY })
                }
                "rotate" => Some(rotate(node)?),
                "skew" | "lookat" => {
                    return Err(DaeError::at(node, "this kind of transform is not read"));
                }
                _ => None,
            };
            at = step.map_or(at, |step| at.then(step));
        }
        for node in children(parent) {
            match node.tag_name().name() {
                "node" => self.nodes(node, at, depth + 1)?,
                "instance_node" => {
                    let Some(of) = self.target(node) else {
                        return Err(DaeError::at(node, "names no node"));
                    };
                    self.nodes(of, at, depth + 1)?;
                }
                "instance_geometry" => {
                    let Some(of) = self.target(node) else {
                        return Err(DaeError::at(node, "names no geometry"));
                    };
                    self.place(of, at)?;
                }
                "instance_controller" => self.controller(node, at)?,
                _ => {}
            }
        }
        Ok(())
    }

    /// A skinned surface in the pose it was modelled in.
    fn controller(&mut self, node: Node<'d, 'd>, at: Affine) -> Result<(), DaeError> {
        let skin = self.target(node).and_then(|c| child(c, "skin"));
        let source = skin.and_then(|s| s.attribute("source")?.trim().strip_prefix('#'));
        match source.and_then(|id| self.by_id.get(id).copied()) {
            Some(geometry) => self.place(geometry, at),
            None => Err(DaeError::at(node, "names no skinned geometry")),
        }
    }

    fn place(&mut self, geometry: Node<'d, 'd>, at: Affine) -> Result<(), DaeError> {
        self.visited += 1;
        let id = geometry.attribute("id").unwrap_or_default();
        if !self.surfaces.contains_key(id) {
            self.surfaces.insert(id, surface(geometry)?);
        }
        let Some(surface) = self.surfaces.get(id) else { return Ok(()) };
        let first = self.soup.points.len();
        check("vertices", MAX_VERTICES, first + surface.points.len())?;
        check("triangles", MAX_FACES, self.soup.faces.len() + surface.faces.len())?;
        let metre = self.metre;
        let place = |p: &DVec3| (at.linear * *p + at.shift) * metre;
        self.soup.points.extend(surface.points.iter().map(place));
        // What mirrors turns the corners of each face round.
        let mirrors = at.linear.determinant() < 0.0;
        let face = |&[a, b, c]: &[u32; 3]| {
            let first = first as u32;
            let [b, c] = if mirrors { [c, b] } else { [b, c] };
            [a + first, b + first, c + first]
        };
        self.soup.faces.extend(surface.faces.iter().map(face));
        Ok(())
    }
}

fn check(what: &'static str, limit: usize, found: usize) -> Result<(), DaeError> {
    if found <= limit {
        return Ok(());
    }
    Err(MeshError::TooLarge { what, limit, found }.into())
}

fn three(node: Node) -> Result<DVec3, DaeError> {
    match numbers(node)?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err(DaeError::at(node, "expected three numbers")),
    }
}

fn matrix(node: Node) -> Result<Affine, DaeError> {
    let m = numbers(node)?;
    if m.len() != 16 {
        return Err(DaeError::at(node, "expected sixteen numbers"));
    }
    let column = |c: usize| DVec3::new(m[c], m[4 + c], m[8 + c]);
    let linear = DMat3::from_cols(column(0), column(1), column(2));
    Ok(Affine { linear, shift: column(3) })
}

fn rotate(node: Node) -> Result<Affine, DaeError> {
    let numbers = numbers(node)?;
    let &[x, y, z, degrees] = &numbers[..] else {
        return Err(DaeError::at(node, "expected an axis and an angle"));
    };
    let Some(axis) = DVec3::new(x, y, z).try_normalize() else {
        return Ok(Affine::IDENTITY);
    };
    let turn = glamx::DQuat::from_axis_angle(axis, degrees.to_radians());
    Ok(Affine { linear: DMat3::from_quat(turn), ..Affine::IDENTITY })
}
