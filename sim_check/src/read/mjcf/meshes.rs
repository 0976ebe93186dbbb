//! Meshes of an MJCF model: files beside it, or points told in place.

use std::collections::BTreeMap;
use std::sync::Arc;

use glamx::{DQuat, DVec3};
use object::Mesh;
use roxmltree::Node;

use super::attributes::Element;
use super::model::{MeshAsset, Model};
use super::weighing::{Weighing, hull};
use crate::read::include::INCLUDED_FROM;
use crate::read::xml::shown;
use crate::robot::Geometry;

impl Model<'_, '_> {
    pub(super) fn mesh_assets(&mut self, root: Node) -> BTreeMap<String, MeshAsset> {
        let assets = root.children().filter(|n| n.has_tag_name("asset"));
        let meshes = assets.flat_map(|n| n.children()).filter(|n| n.has_tag_name("mesh"));
        let mut found = BTreeMap::new();
        for node in meshes {
            let element = self.defaults.element(node, None);
            let (name, asset) = self.mesh_asset(&element);
            if found.insert(name.clone(), asset).is_some() {
                self.reader.fault(node, format!("two meshes are called `{name}`"));
            }
        }
        found
    }

    fn mesh_asset(&mut self, element: &Element) -> (String, MeshAsset) {
        let weighing = self.mesh_weighing(element);
        let file = element.get("file").unwrap_or_default().to_owned();
        let stem = file.rsplit('/').next().unwrap_or_default();
        let stem = stem.rsplit_once('.').map_or(stem, |(stem, _)| stem).to_owned();
        let name = element.get("name").map_or(stem, str::to_owned);
        let scale = self.vector(element, "scale").unwrap_or(DVec3::ONE);
        if file.is_empty() {
            let geometry = if element.get("builtin").is_some() {
                let line = self.reader.line(element.node);
                Geometry::Unread { reason: format!("line {line}: a builtin mesh is not read here") }
            } else {
                self.told(element, scale)
            };
            return (name.clone(), MeshAsset { source: name, scale, geometry, weighing });
        }
        let file = match self.compiler.strips {
            true => file.rsplit(['/', '\\']).next().unwrap_or_default().to_owned(),
            false => file,
        };
        let (source, geometry, faults) = self.mesh_file(element, &file, scale);
        let line = self.reader.line(element.node);
        self.reader.faults.files.extend(faults.into_iter().map(|f| format!("line {line}: {f}")));
        let geometry = self.in_own_frame(element, geometry, scale);
        (name, MeshAsset { source, scale, geometry, weighing })
    }

    /// How a mesh is weighed; a word that names no way is a fault.
    fn mesh_weighing(&mut self, element: &Element) -> Weighing {
        let Some(word) = element.get("inertia") else { return Weighing::default() };
        Weighing::of(word).unwrap_or_else(|| {
            let rule = "must be legacy, convex, exact or shell";
            self.reader.fault(element.node, format!("inertia=\"{}\" {rule}", shown(word)));
            Weighing::default()
        })
    }

    /// A mesh's file where the settings say, or else, as MuJoCo looks for it, beside the included
    /// file that names it; what was found, and what is wrong with it.
    fn mesh_file(
        &mut self,
        element: &Element,
        file: &str,
        scale: DVec3,
    ) -> (String, Geometry, Vec<String>) {
        let source = format!("{}{file}", self.compiler.meshes);
        let mut faults = Vec::new();
        let geometry = self.reader.shelf.geometry(&source, scale, &mut faults);
        let Some(folder) = element.get(INCLUDED_FROM).filter(|_| !faults.is_empty()) else {
            return (source, geometry, faults);
        };
        let (beside, mut others) = (format!("{folder}{file}"), Vec::new());
        let found = self.reader.shelf.geometry(&beside, scale, &mut others);
        match others.is_empty() {
            true => (beside, found, others),
            false => (source, geometry, faults),
        }
    }

    /// A mesh told in a frame of its own (`refpos`, `refquat`): moved and turned back before it is
    /// scaled, as MuJoCo does.
    fn in_own_frame(&mut self, element: &Element, geometry: Geometry, scale: DVec3) -> Geometry {
        let at = self.vector(element, "refpos").unwrap_or(DVec3::ZERO);
        let turn = match self.numbers(element, "refquat", 4) {
            Some(q) => DQuat::from_xyzw(q[1], q[2], q[3], q[0]).normalize(),
            None => DQuat::IDENTITY,
        };
        let is_own = at != DVec3::ZERO || turn != DQuat::IDENTITY;
        let Geometry::Mesh(mesh) = &geometry else { return geometry };
        if !is_own || !turn.is_finite() || scale.abs().min_element() <= 0.0 {
            return geometry;
        }
        let back = turn.inverse();
        match mesh.map_vertices(|v| (back * (v / scale - at)) * scale) {
            Ok(mesh) => Geometry::Mesh(Arc::new(mesh)),
            Err(e) => Geometry::Unread { reason: e.to_string() },
        }
    }

    /// A mesh told in place: its faces, or the hull of its points.
    fn told(&mut self, element: &Element, scale: DVec3) -> Geometry {
        let numbers = self.numbers(element, "vertex", 9).unwrap_or_default();
        let points: Vec<_> =
            numbers.chunks_exact(3).map(|v| DVec3::new(v[0], v[1], v[2]) * scale).collect();
        let told = self.numbers(element, "face", 3).unwrap_or_default();
        let faces: Vec<_> =
            told.chunks_exact(3).map(|f| [f[0], f[1], f[2]].map(|i| i as u32)).collect();
        let whole = if faces.is_empty() { hull(&points) } else { Some((points, faces)) };
        let mesh = whole.ok_or("its points span no body".to_owned());
        let mesh =
            mesh.and_then(|(points, faces)| Mesh::new(points, faces).map_err(|e| e.to_string()));
        match mesh {
            Ok(mesh) => Geometry::Mesh(Arc::new(mesh)),
            Err(reason) => {
                self.reader.fault(element.node, &reason);
                Geometry::Unread { reason }
            }
        }
    }
}
