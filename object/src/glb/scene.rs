//! Walks the node forest and lays every primitive where its nodes put it.

use std::collections::BTreeMap;
use std::rc::Rc;

use glamx::{DMat3, DQuat, DVec3};

use super::accessor::Accessors;
use super::document::{Document, Node};
use super::error::GlbError;
use super::paint::Painter;
use super::primitive::{Budget, Source, Surface};
use crate::mesh::{FileFrame, Mesh, UpAxis};

/// A mesh and what of its file did not make it in.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The surface, object frame.
    pub mesh: Mesh,
    /// What was left out (animations, skins, points and lines, unreadable textures), in plain words.
    pub notes: Vec<String>,
}

/// A linear map and a shift: p becomes `linear · p + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
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

    fn of(node: &Node, place: &str) -> Result<Self, GlbError> {
        if let Some([a, b, c, p, d, e, f, q, g, h, i, r, x, y, z, w]) = node.matrix {
            if [p, q, r, w - 1.0].iter().any(|v| v.abs() > 1e-6) {
                let found = format!("{p} {q} {r} {w}");
                return Err(GlbError::rule(place, "a matrix ends in the row 0 0 0 1", found));
            }
            let columns = [[a, b, c], [d, e, f], [g, h, i]].map(DVec3::from_array);
            let linear = DMat3::from_cols(columns[0], columns[1], columns[2]);
            return Ok(Self { linear, shift: DVec3::new(x, y, z) });
        }
        let turn = node.rotation.map_or(DQuat::IDENTITY, DQuat::from_array);
        if !(turn.length_squared() > 0.0 && turn.length_squared().is_finite()) {
            let found = format!("{:?}", node.rotation);
            return Err(GlbError::rule(place, "a rotation must be a unit quaternion", found));
        }
        let scale = node.scale.map_or(DVec3::ONE, DVec3::from_array);
        let linear = DMat3::from_quat(turn.normalize()) * DMat3::from_diagonal(scale);
        Ok(Self { linear, shift: node.translation.map_or(DVec3::ZERO, DVec3::from_array) })
    }
}

/// Reads the default scene into one mesh, object frame.
pub(super) fn read(accessors: Accessors<'_>) -> Result<Reading, GlbError> {
    let document = accessors.document;
    let mut scene = Scene {
        accessors,
        painter: Painter::new(accessors)?,
        surfaces: BTreeMap::new(),
        budget: Budget::of(accessors.buffers.file_bytes()),
        notes: left_out(document),
        vertices: Vec::new(),
        colours: Vec::new(),
        coloured: false,
        faces: Vec::new(),
    };
    for root in document.roots()? {
        scene.place_node(root, Affine::IDENTITY)?;
    }
    if document.nodes.is_empty() {
        (0..document.meshes.len()).try_for_each(|m| scene.place_mesh(m, Affine::IDENTITY))?;
    }
    scene.finish()
}

struct Scene<'a> {
    accessors: Accessors<'a>,
    painter: Painter<'a>,
    surfaces: BTreeMap<usize, Rc<Vec<Surface>>>,
    budget: Budget,
    notes: Vec<String>,
    vertices: Vec<DVec3>,
    colours: Vec<[u8; 4]>,
    coloured: bool,
    faces: Vec<[u32; 3]>,
}

impl Scene<'_> {
    /// A node's mesh, then its children; the forest was proved to be at most 64 deep.
    fn place_node(&mut self, index: usize, above: Affine) -> Result<(), GlbError> {
        let document = self.accessors.document;
        let Some(node) = document.nodes.get(index) else { return Ok(()) };
        let place = above.then(Affine::of(node, &format!("node {index}"))?);
        if let Some(mesh) = node.mesh {
            if mesh >= document.meshes.len() {
                let count = document.meshes.len();
                return Err(GlbError::reference(format!("node {index}"), "mesh", mesh, count));
            }
            self.place_mesh(mesh, place)?;
        }
        node.children.iter().try_for_each(|&child| self.place_node(child, place))
    }

    fn place_mesh(&mut self, index: usize, place: Affine) -> Result<(), GlbError> {
        let surfaces = match self.surfaces.get(&index) {
            Some(known) => Rc::clone(known),
            None => {
                let fresh = Rc::new(self.read_mesh(index)?);
                self.surfaces.insert(index, Rc::clone(&fresh));
                fresh
            }
        };
        surfaces.iter().try_for_each(|surface| self.append(surface, place))
    }

    fn read_mesh(&mut self, index: usize) -> Result<Vec<Surface>, GlbError> {
        let Some(mesh) = self.accessors.document.meshes.get(index) else { return Ok(Vec::new()) };
        let mut left = self.budget;
        let mut surfaces = Vec::new();
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("mesh {index} primitive {p}");
            match primitive.mode {
                0..=3 => self.notes.push(format!("{place}: points and lines have no surface")),
                4..=6 => {
                    let source = Source::open(self.accessors, primitive, place, &mut left)?;
                    let surface = self.read_surface(&source)?;
                    left.spend(surface.positions.len(), surface.faces.len())?;
                    surfaces.push(surface);
                }
                mode => {
                    return Err(GlbError::rule(place, "the mode must be 0 to 6", mode.to_string()));
                }
            }
            if !primitive.targets.is_empty() {
                self.notes.push(format!("mesh {index} primitive {p}: morph targets are left out"));
            }
        }
        self.budget.keep_work_of(left);
        Ok(surfaces)
    }

    fn read_surface(&mut self, source: &Source<'_>) -> Result<Surface, GlbError> {
        let positions = source.positions()?;
        let faces = source.faces(positions.len())?;
        let colours = self.painter.colours(source, positions.len())?;
        Ok(Surface { positions, colours, faces })
    }

    /// Adds a surface at its place; a mirroring place turns the faces round, so that they still
    /// face outward.
    fn append(&mut self, surface: &Surface, place: Affine) -> Result<(), GlbError> {
        self.budget.place()?;
        self.budget.spend(surface.positions.len(), surface.faces.len())?;
        let first = self.vertices.len() as u32;
        let frame = FileFrame { up: UpAxis::Y };
        let placed = |p: &DVec3| frame.point_to_object(place.linear * *p + place.shift);
        self.vertices.extend(surface.positions.iter().map(placed));
        match &surface.colours {
            Some(colours) => self.colours.extend(colours),
            None => self.colours.resize(self.vertices.len(), [255; 4]),
        }
        self.coloured |= surface.colours.is_some();
        let mirrored = place.linear.determinant() < 0.0;
        let turned = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        let shifted = |f: &[u32; 3]| turned(f.map(|v| v + first));
        self.faces.extend(surface.faces.iter().map(shifted));
        Ok(())
    }

    fn finish(self) -> Result<Reading, GlbError> {
        let colours = self.coloured.then_some(self.colours);
        let mesh = Mesh::new(self.vertices, self.faces)?;
        let mesh = mesh.with_frame(FileFrame { up: UpAxis::Y }).with_colours(colours)?;
        let mut notes = self.notes;
        notes.extend(self.painter.notes);
        Ok(Reading { mesh, notes })
    }
}

fn left_out(document: &Document) -> Vec<String> {
    let lists = [
        ("animations", document.animations.len()),
        ("skins", document.skins.len()),
        ("cameras", document.cameras.len()),
    ];
    let present = lists.into_iter().filter(|&(_, count)| count > 0);
    present.map(|(what, count)| format!("{count} {what} are left out")).collect()
}
