//! Walks the node forest and lays every primitive where its nodes put it.

use std::collections::BTreeMap;
use std::rc::Rc;

use glamx::DVec3;

use super::accessor::Accessors;
use super::affine::Affine;
use super::document::Document;
use super::error::GlbError;
use super::look::{Look, Looks};
use super::paint::Painter;
use super::primitive::{Budget, Source, Surface};
use crate::mesh::{FileFrame, Mesh, UpAxis};
use crate::reading::{Reading, shortened};

/// Reads the default scene into one mesh, object frame.
pub(super) fn read(accessors: Accessors<'_>, looks: Looks) -> Result<Reading, GlbError> {
    let document = accessors.document;
    let painter = Painter::new(accessors)?;
    let mut scene = Scene {
        accessors,
        look: Look::new(accessors, &painter, looks)?,
        painter,
        parents: document.parents(),
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
    look: Look<'a>,
    painter: Painter<'a>,
    parents: Vec<Option<usize>>,
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
        if node.extensions.visibility.as_ref().is_some_and(|v| !v.visible) {
            self.notes
                .push(format!("node {index} is hidden and left out with what hangs below it"));
            return Ok(());
        }
        let place = above.then(Affine::of(node, &format!("node {index}"))?);
        if let Some(mesh) = node.mesh {
            let place = match node.skin {
                Some(skin) => Affine::of_skin(self.accessors, &self.parents, skin)?,
                None => place,
            };
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
        let look = self.look.of(source, (positions.len(), &faces))?;
        Ok(Surface { positions, colours, faces, look })
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
        self.look.append(&surface.look, surface.faces.iter().map(|f| turned(*f)));
        Ok(())
    }

    fn finish(self) -> Result<Reading, GlbError> {
        let colours = self.coloured.then_some(self.colours);
        let mesh = Mesh::new(self.vertices, self.faces)?;
        let mesh = mesh.with_frame(FileFrame { up: UpAxis::Y }).with_colours(colours)?;
        let mut notes = self.notes;
        notes.extend(self.painter.notes);
        let (appearance, more) = self.look.finish();
        notes.extend(more);
        Ok(Reading { mesh, appearance, notes: shortened(notes) })
    }
}

fn left_out(document: &Document) -> Vec<String> {
    let lists = [
        ("animations", document.animations.len()),
        ("skins", document.skins.len()),
        ("cameras", document.cameras.len()),
    ];
    let present = lists.into_iter().filter(|&(_, count)| count > 0);
    let counted = present.map(|(what, count)| format!("{count} {what} are left out"));
    document.asset.left_out().chain(counted).collect()
}
