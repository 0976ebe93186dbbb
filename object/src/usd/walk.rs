//! The prims of a stage, one after the other.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Cursor};
use std::sync::{Arc, Mutex, PoisonError};

use openusd::ar::{Asset, ResolvedPath, Resolver};
use openusd::sdf;
use openusd::usd::{Prim as UsdPrim, Stage as UsdStage, TimeCode};

use super::error::{UsdError, shortened};
use super::extract::{MAX_DEPTH, MAX_PRIMS, Place, is_there, moves_are_named, place_of};
use super::names;
use super::prims::{Bundle, Polygons, Prim, Stage, Told};
use crate::mesh::{MAX_FACES, MAX_VERTICES, limit};

/// Beginnings of the names of attributes that are told, and whole names of others.
const TOLD: &[&str] =
    &["physics:", "drive:", "limit:", "physx", "newton:", "mjc:", "state:", "inputs:diffuseColor"];
const NAMED: &[&str] = &["size", "radius", "height", "axis", "info:id"];
/// Beginnings of the names of relationships that are told.
const POINTING: &[&str] = &["physics:", "physx", "newton:", "mjc:", "material:binding"];
/// Most numbers of an attribute that are told.
const MOST_NUMBERS: usize = 64;
/// Most errors of composition that are told.
const MOST_MISSING: usize = 8;

/// The files of a bundle, and which others were asked for.
struct Files {
    name: &'static str,
    root: Vec<u8>,
    files: BTreeMap<String, Vec<u8>>,
    absent: BTreeSet<String>,
    lacks: Arc<Mutex<BTreeSet<String>>>,
}

/// A name told from the folder of the file that says it, without `.` and `..` where that can be.
fn beside(name: &str, file: &str) -> String {
    if name.contains("://") || name.starts_with('/') {
        return name.to_owned();
    }
    let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut parts: Vec<&str> = folder.split('/').filter(|p| !p.is_empty()).collect();
    for part in name.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|last| *last != "..") => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

impl Resolver for Files {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        match anchor.and_then(|anchor| anchor.to_str()) {
            Some(anchor) => beside(asset_path, anchor),
            None => asset_path.to_owned(),
        }
    }

    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        if asset_path == self.name || self.files.contains_key(asset_path) {
            return Some(ResolvedPath::new(asset_path));
        }
        let lower = asset_path.to_ascii_lowercase();
        let is_layer = [".usd", ".usda", ".usdc", ".usdz"].iter().any(|end| lower.ends_with(end));
        if is_layer && !self.absent.contains(asset_path) {
            let lacks = self.lacks.lock();
            lacks.unwrap_or_else(PoisonError::into_inner).insert(asset_path.to_owned());
        }
        None
    }

    fn resolve_for_new_asset(&self, _asset_path: &str) -> Option<ResolvedPath> {
        None
    }

    fn open_asset(&self, resolved_path: &ResolvedPath) -> io::Result<Box<dyn Asset>> {
        let name = resolved_path.to_str().unwrap_or_default();
        let bytes = if name == self.name { Some(&self.root) } else { self.files.get(name) };
        let bytes = bytes.ok_or(io::ErrorKind::NotFound)?;
        Ok(Box::new(Cursor::new(bytes.clone())))
    }

    fn get_modification_timestamp(
        &self,
        _: &str,
        _: &ResolvedPath,
    ) -> Option<std::time::SystemTime> {
        None
    }
}

/// What the stage of a bundle holds, or which files it lacks.
pub(super) fn told(bundle: Bundle) -> Result<Told, UsdError> {
    let Bundle { root, mut files, mut absent } = bundle;
    let is_text = |layer: &[u8]| layer.starts_with(b"#usda");
    let root_is_text = is_text(&root);
    if !root_is_text {
        super::bounds::bounded(&root).map_err(UsdError::Unreadable)?;
    }
    let mut missing = Vec::new();
    files.retain(|name, layer| {
        let refused = if is_text(layer) { None } else { super::bounds::bounded(layer).err() };
        if let Some(why) = refused {
            missing.push(format!("layer `{name}`: {why}"));
            absent.insert(name.clone());
            return false;
        }
        true
    });
    let name = if root_is_text { "layer.usda" } else { "layer.usdc" };
    let lacks = Arc::new(Mutex::new(BTreeSet::new()));
    let resolver = Files { name, root, files, absent, lacks: lacks.clone() };
    let broken = |e: anyhow::Error| UsdError::Unreadable(shortened(&e));
    let stage = UsdStage::builder().resolver(resolver).open(name).map_err(broken)?;
    let mut walked = walked(&stage)?;
    let lacks: Vec<String> =
        lacks.lock().unwrap_or_else(PoisonError::into_inner).iter().cloned().collect();
    if !lacks.is_empty() {
        return Ok(Told::Lacks(lacks));
    }
    walked.missing.splice(0..0, missing);
    Ok(Told::Stage(walked))
}

struct Walk<'a> {
    stage: &'a UsdStage,
    time: TimeCode,
    told: Stage,
    points: usize,
    corners: usize,
}

fn walked(stage: &UsdStage) -> Result<Stage, UsdError> {
    let broken = |e: anyhow::Error| UsdError::Unreadable(shortened(&e));
    let said = |name: &str| stage.stage_metadata(name).ok().flatten();
    let number = |name: &str, unsaid: f64| match said(name).as_ref().and_then(numbers) {
        Some(all) if all.len() == 1 => all[0],
        _ => unsaid,
    };
    let told = Stage {
        up: said("upAxis").as_ref().and_then(word),
        metres: number("metersPerUnit", 0.01),
        kilograms: number("kilogramsPerUnit", 1.0),
        default_prim: stage.default_prim().map(|name| name.to_string()),
        ..Stage::default()
    };
    let time = TimeCode::from(stage.start_time_code() as f32);
    let mut walk = Walk { stage, time, told, points: 0, corners: 0 };
    for name in stage.root_prims().map_err(broken)? {
        let path = format!("/{name}");
        walk.prim(&stage.prim(path.as_str()), (path, None), Place::HERE, 0)?;
    }
    let mut told = walk.told;
    let errors = stage.composition_errors();
    let shown = |e: &dyn std::fmt::Display| e.to_string().chars().take(200).collect();
    told.missing.extend(errors.iter().take(MOST_MISSING).map(|e| shown(e)));
    Ok(told)
}

impl Walk<'_> {
    fn prim(
        &mut self,
        prim: &UsdPrim,
        (path, above): (String, Option<usize>),
        around: Place,
        depth: usize,
    ) -> Result<(), UsdError> {
        if self.told.prims.len() >= MAX_PRIMS || depth > MAX_DEPTH {
            let rule = "a stage has at most 200000 prims, 256 deep";
            let found = format!("more, at {path}");
            return Err(UsdError::Rule { prim: path, rule: rule.into(), found });
        }
        let own = prim.path().as_str();
        names::asked(own, own == "/" || names::is_path(own), own)?;
        let broken = |e: anyhow::Error| UsdError::Unreadable(shortened(&e));
        if !is_there(prim).map_err(broken)? {
            return Ok(());
        }
        moves_are_named(prim)?;
        let place = place_of(prim, around, self.time).map_err(broken)?;
        let kind = prim.type_name().map_err(broken)?.map(|t| t.to_string()).unwrap_or_default();
        let value = |name: &str| prim.attribute(name).get_at(Some(self.time)).ok().flatten();
        let parent = above.and_then(|a| self.told.prims.get(a));
        let is_hidden = parent.is_some_and(|p| p.is_hidden)
            || value("visibility").as_ref().and_then(word).as_deref() == Some("invisible");
        let purpose = value("purpose").as_ref().and_then(word);
        let purpose = purpose.or_else(|| parent.map(|p| p.purpose.clone()));
        let schemas = prim.api_schemas().map_err(broken)?;
        let mut told = Prim {
            kind,
            schemas: schemas.iter().map(ToString::to_string).collect(),
            above,
            place: place.columns(),
            is_hidden,
            purpose: purpose.unwrap_or_else(|| "default".into()),
            ..Prim::default()
        };
        for name in prim.property_names().map_err(broken)? {
            let name = name.to_string();
            let is_told =
                TOLD.iter().any(|t| name.starts_with(t)) || NAMED.contains(&name.as_str());
            let is_told = is_told && names::is_property(&name);
            if let Some(of) = is_told.then(|| value(&name)).flatten() {
                if let Some(all) = numbers(&of).filter(|all| all.len() <= MOST_NUMBERS) {
                    told.numbers.insert(name.clone(), all);
                } else if let Some(word) = word(&of) {
                    told.words.insert(name.clone(), word.chars().take(200).collect());
                }
            }
            let points = POINTING.iter().any(|t| name.starts_with(t));
            if points && names::is_property(&name) {
                let targets = prim.relationship(name.as_str()).targets().unwrap_or_default();
                let all = targets.iter().map(|t| t.as_str().to_owned());
                let all: Vec<String> = all.filter(|t| names::is_path(t)).take(4096).collect();
                if !all.is_empty() {
                    told.targets.insert(name, all);
                }
            }
        }
        if told.kind == "Mesh" {
            told.surface = Some(self.surface(prim, &path)?);
        }
        let index = self.told.prims.len();
        told.path.clone_from(&path);
        self.told.prims.push(told);
        let children = match prim.is_instance().map_err(broken)? {
            true => prim.prototype().map_err(broken)?.map(|path| self.stage.prim(path)),
            false => None,
        };
        for child in children.as_ref().unwrap_or(prim).children().map_err(broken)? {
            let name = child.path().as_str().rsplit('/').next().unwrap_or_default().to_owned();
            let path = format!("{path}/{name}");
            self.prim(&child, (path, Some(index)), place, depth + 1)?;
        }
        Ok(())
    }

    fn surface(&mut self, prim: &UsdPrim, path: &str) -> Result<Polygons, UsdError> {
        let value = |name: &str| -> Option<sdf::Value> {
            prim.attribute(name).get_at(Some(self.time)).ok().flatten()
        };
        let points: Vec<[f64; 3]> = match value("points") {
            Some(sdf::Value::Vec3fVec(all)) => {
                all.iter().map(|p| [p.x.into(), p.y.into(), p.z.into()]).collect()
            }
            Some(sdf::Value::Vec3dVec(all)) => all.iter().map(|p| [p.x, p.y, p.z]).collect(),
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
        let polygons = super::extract::polygons(path, &counts, &indices, points.len())?;
        let mut faces: Vec<Vec<u32>> =
            polygons.into_iter().map(|pairs| pairs.into_iter().step_by(2).collect()).collect();
        if value("orientation").as_ref().and_then(word).as_deref() == Some("leftHanded") {
            faces.iter_mut().for_each(|face| face.reverse());
        }
        Ok(Polygons { points, faces })
    }
}

fn word(value: &sdf::Value) -> Option<String> {
    match value {
        sdf::Value::Token(word) => Some(word.to_string()),
        sdf::Value::String(word) => Some(word.clone()),
        _ => None,
    }
}

/// A value's numbers; a turn's real part comes last.
fn numbers(value: &sdf::Value) -> Option<Vec<f64>> {
    use sdf::Value;
    Some(match value {
        Value::Bool(b) => vec![f64::from(u8::from(*b))],
        Value::Int(n) => vec![f64::from(*n)],
        Value::Uint(n) => vec![f64::from(*n)],
        Value::Float(n) => vec![f64::from(*n)],
        Value::Double(n) => vec![*n],
        Value::Half(n) => vec![f64::from(*n)],
        Value::Vec3f(v) => vec![v.x.into(), v.y.into(), v.z.into()],
        Value::Vec3d(v) => vec![v.x, v.y, v.z],
        Value::Quatf(q) => vec![q.x.into(), q.y.into(), q.z.into(), q.w.into()],
        Value::Quatd(q) => vec![q.x, q.y, q.z, q.w],
        Value::FloatVec(all) => all.iter().map(|n| f64::from(*n)).collect(),
        Value::DoubleVec(all) => all.clone(),
        _ => return None,
    })
}
