//! What a stage shows, in plain numbers: meshes in the stage's frame, and what they are made of.

use glamx::{DMat3, DVec3};
use openusd::schemas::geom::{Imageable, Mesh, Purpose, Visibility, Xformable};
use openusd::usd::{Prim, SchemaBase, SchemaKind, Stage, TimeCode};
use openusd::{gf, sdf};

use super::error::{UsdError, shortened};
use super::look::bound;
use super::names;
use super::scene::{Scene, Surface};
use crate::mesh::{MAX_FACES, MAX_VERTICES, limit};

/// Most prims that are looked at; deepest below the root. Guesses with room: a car's CAD has some ten thousand.
pub(super) const MAX_PRIMS: usize = 200_000;
pub(super) const MAX_DEPTH: usize = 256;

/// Where something stands: rows times a matrix, as USD has it, kept as columns.
#[derive(Clone, Copy)]
pub(super) struct Place {
    linear: DMat3,
    shift: DVec3,
}

impl Place {
    pub(super) const HERE: Self = Self { linear: DMat3::IDENTITY, shift: DVec3::ZERO };

    fn of(m: gf::Matrix4d) -> Self {
        let row = |r: usize| DVec3::new(m.0[4 * r], m.0[4 * r + 1], m.0[4 * r + 2]);
        Self { linear: DMat3::from_cols(row(0), row(1), row(2)), shift: row(3) }
    }

    /// Three directions and a place.
    pub(super) fn columns(&self) -> [[f64; 3]; 4] {
        let Self { linear: l, shift } = self;
        [l.x_axis, l.y_axis, l.z_axis, *shift].map(|column| column.to_array())
    }

    fn then(self, below: Self) -> Self {
        let (linear, shift) = (self.linear * below.linear, self.linear * below.shift + self.shift);
        Self { linear, shift }
    }
}

/// A prim of any type, asked for its transform.
struct Any(Prim);

impl SchemaBase for Any {
    const KIND: SchemaKind = SchemaKind::AbstractBase;

    fn prim(&self) -> &Prim {
        &self.0
    }
}

impl Imageable for Any {}
impl Xformable for Any {}

/// A stage being walked through.
struct Walk<'a> {
    stage: &'a Stage,
    time: TimeCode,
    scene: Scene,
    prims: usize,
    points: usize,
    corners: usize,
}

/// Reads what a stage shows.
pub(super) fn scene(stage: &Stage) -> Result<Scene, UsdError> {
    let broken = |e: anyhow::Error| UsdError::Unreadable(shortened(&e));
    let said = |name: &str| stage.stage_metadata(name).ok().flatten();
    let up = match said("upAxis") {
        Some(sdf::Value::Token(axis)) => Some(axis.to_string()),
        Some(sdf::Value::String(axis)) => Some(axis),
        _ => None,
    };
    // Without a word it is a centimetre (UsdGeom).
    let unit = match said("metersPerUnit") {
        Some(sdf::Value::Double(unit)) => unit,
        Some(sdf::Value::Float(unit)) => f64::from(unit),
        _ => 0.01,
    };
    let time = TimeCode::from(stage.start_time_code() as f32);
    let scene = Scene { up, unit, ..Scene::default() };
    let mut walk = Walk { stage, time, scene, prims: 0, points: 0, corners: 0 };
    for name in stage.root_prims().map_err(broken)? {
        walk.prim(&stage.prim(format!("/{name}").as_str()), Place::HERE, 0)?;
    }
    let mut scene = walk.scene;
    let missing = stage.composition_errors();
    if let Some(first) = missing.first() {
        let first: String = first.to_string().chars().take(200).collect();
        let count = missing.len();
        scene.notes.push(format!(
            "{count} layers of other files are left out ({first}): flatten the stage first"
        ));
    }
    Ok(scene)
}

impl Walk<'_> {
    fn prim(&mut self, prim: &Prim, above: Place, depth: usize) -> Result<(), UsdError> {
        self.prims += 1;
        if self.prims > MAX_PRIMS || depth > MAX_DEPTH {
            let found = format!("more, at {}", prim.path().as_str());
            let rule = "a stage has at most 200000 prims, 256 deep";
            return Err(UsdError::Rule { prim: prim.path().to_string(), rule: rule.into(), found });
        }
        let own = prim.path().as_str();
        names::asked(own, own == "/" || names::is_path(own), own)?;
        let broken = |e: anyhow::Error| UsdError::Unreadable(shortened(&e));
        if !is_there(prim).map_err(broken)? {
            return Ok(());
        }
        let kind = prim.type_name().map_err(broken)?.map(|t| t.to_string()).unwrap_or_default();
        moves_are_named(prim)?;
        let place = place_of(prim, above, self.time).map_err(broken)?;
        match kind.as_str() {
            "Mesh" => self.mesh(prim, place)?,
            "Cube" | "Sphere" | "Cylinder" | "Cone" | "Capsule" | "Plane" | "PointInstancer"
            | "BasisCurves" | "NurbsPatch" | "Points" | "SkelRoot" | "Camera" => {
                self.scene.notes.push(match kind.as_str() {
                    "SkelRoot" => format!("{}: its skeleton is left out", prim.path().as_str()),
                    _ => format!("{}: a {kind} is left out", prim.path().as_str()),
                });
                if kind == "PointInstancer" {
                    return Ok(());
                }
            }
            "Material" | "Shader" => return Ok(()),
            _ => {}
        }
        let children = match prim.is_instance().map_err(broken)? {
            true => prim.prototype().map_err(broken)?.map(|path| self.stage.prim(path)),
            false => None,
        };
        let children = children.as_ref().unwrap_or(prim).children().map_err(broken)?;
        children.iter().try_for_each(|child| self.prim(child, place, depth + 1))
    }

    fn mesh(&mut self, prim: &Prim, place: Place) -> Result<(), UsdError> {
        let path = prim.path().to_string();
        let broken = |e: anyhow::Error| UsdError::Unreadable(shortened(&e));
        let Some(mesh) = Mesh::get(self.stage, prim.path().clone()).map_err(broken)? else {
            return Ok(());
        };
        if mesh.compute_visibility().map_err(broken)? == Visibility::Invisible {
            self.scene.notes.push(format!("{path} is hidden and left out"));
            return Ok(());
        }
        if matches!(mesh.compute_purpose().map_err(broken)?, Purpose::Proxy | Purpose::Guide) {
            self.scene.notes.push(format!("{path} is a proxy or guide and left out"));
            return Ok(());
        }
        let value = |name: &str| -> Option<sdf::Value> {
            prim.attribute(name).get_at(Some(self.time)).ok().flatten()
        };
        let points: Vec<DVec3> = match value("points") {
            Some(sdf::Value::Vec3fVec(all)) => {
                all.iter().map(|p| DVec3::new(p.x.into(), p.y.into(), p.z.into())).collect()
            }
            Some(sdf::Value::Vec3dVec(all)) => {
                all.iter().map(|p| DVec3::new(p.x, p.y, p.z)).collect()
            }
            _ => Vec::new(),
        };
        let whole = |name| match value(name) {
            Some(sdf::Value::IntVec(all)) => all,
            _ => Vec::new(),
        };
        let (counts, indices) = (whole("faceVertexCounts"), whole("faceVertexIndices"));
        self.points += points.len();
        self.corners += indices.len();
        limit("vertices", MAX_VERTICES, self.points)?;
        limit("triangles", MAX_FACES, self.corners)?;
        let polygons = polygons(&path, &counts, &indices, points.len())?;
        if let Some(sdf::Value::Token(scheme)) = value("subdivisionScheme")
            && scheme.as_str() != "none"
        {
            self.scene
                .notes
                .push(format!("{path}: its cage is taken, not the smooth surface of it"));
        }
        let is_left = matches!(value("orientation"), Some(sdf::Value::Token(t)) if t.as_str() == "leftHanded");
        let is_turned = is_left != (place.linear.determinant() < 0.0);
        let points: Vec<DVec3> = points.iter().map(|p| place.linear * *p + place.shift).collect();
        if let Some(point) = points.iter().position(|p| !p.is_finite()) {
            let (rule, found) = ("positions must be finite", format!("point {point}"));
            return Err(UsdError::Rule { prim: path, rule: rule.into(), found });
        }
        let (colours, places) =
            (super::look::colours(prim, self.time), super::look::places(prim, self.time));
        let bound =
            bound(self.stage, prim, counts.len(), &mut self.scene.looks, &mut self.scene.notes)
                .map_err(broken)?;
        let polygons = if is_turned { turned(polygons) } else { polygons };
        self.scene.surfaces.push(Surface { points, polygons, colours, places, bound });
        Ok(())
    }
}

/// Whether a prim is drawn at all. Above one in a prototype may stand no more than an `over`.
pub(super) fn is_there(prim: &Prim) -> anyhow::Result<bool> {
    if !prim.is_active()? || prim.is_abstract()? {
        return Ok(false);
    }
    let is_own = prim.is_in_prototype() && prim.specifier()? == Some(sdf::Specifier::Def);
    Ok(is_own || prim.is_defined()?)
}

/// Where a prim stands, from where the one above it does.
pub(super) fn place_of(prim: &Prim, above: Place, time: TimeCode) -> anyhow::Result<Place> {
    let xform = Any(prim.clone());
    let own = Place::of(xform.local_to_parent_transform(time)?);
    Ok(if xform.resets_xform_stack()? { own } else { above.then(own) })
}

/// Refuses an order of moves that names what can be none.
pub(super) fn moves_are_named(prim: &Prim) -> Result<(), UsdError> {
    let order = prim.attribute("xformOpOrder").get::<sdf::Value>();
    let order = order.map_err(|e| UsdError::Unreadable(shortened(&e)))?;
    let Some(sdf::Value::TokenVec(moves)) = order else { return Ok(()) };
    for name in &moves {
        let name = name.as_str();
        let own = name.strip_prefix("!invert!").unwrap_or(name);
        let is_sound = own == "!resetXformStack!" || names::is_property(own);
        names::asked(prim.path().as_str(), is_sound, name)?;
    }
    Ok(())
}

/// Corners by polygon: each the point and, above it, its own number, in pairs.
pub(super) fn polygons(
    prim: &str,
    counts: &[i32],
    indices: &[i32],
    points: usize,
) -> Result<Vec<Vec<u32>>, UsdError> {
    let rule = |rule: &'static str, found: String| {
        Err(UsdError::Rule { prim: prim.into(), rule: rule.into(), found })
    };
    let mut at = 0usize;
    let mut all = Vec::with_capacity(counts.len().min(indices.len()));
    for &count in counts {
        let end = usize::try_from(count).ok().and_then(|n| at.checked_add(n));
        let Some(corners) = end.and_then(|end| indices.get(at..end)) else {
            return rule(
                "faceVertexCounts add up to faceVertexIndices",
                format!("{count} at {at}"),
            );
        };
        let mut polygon = Vec::with_capacity(2 * corners.len());
        for (n, &index) in corners.iter().enumerate() {
            let Some(index) = u32::try_from(index).ok().filter(|i| (*i as usize) < points) else {
                return rule("an index must name a point", format!("{index} of {points}"));
            };
            polygon.extend([index, (at + n) as u32]);
        }
        at += corners.len();
        all.push(polygon);
    }
    Ok(all)
}

/// The same polygons seen from behind; each still begins with its first corner.
fn turned(mut polygons: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    for polygon in &mut polygons {
        let mut pairs: Vec<[u32; 2]> = polygon.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
        if let Some(rest) = pairs.get_mut(1..) {
            rest.reverse();
        }
        *polygon = pairs.concat();
    }
    polygons
}
