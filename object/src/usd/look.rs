//! Materials of a stage, and the primvars that colours and textures take.

use openusd::schemas::shade::{Connectable as _, Material, MaterialBindingAPI, Shader};
use openusd::sdf;
use openusd::usd::{Attribute, Prim, Stage, TimeCode};

use super::names;
use super::scene::{Bound, Input, Laid, Look, Over, Spread};
use crate::appearance::Wrap;

/// Most hops from an input to what it is connected to.
const HOPS: usize = 8;

/// What a mesh and its subsets are made of; materials that are new are added to `looks`.
pub(super) fn bound(
    stage: &Stage,
    prim: &Prim,
    faces: usize,
    looks: &mut Vec<Look>,
    notes: &mut Vec<String>,
) -> anyhow::Result<Bound> {
    let whole = material(stage, prim, looks, notes)?;
    let mut of_face = Vec::new();
    for child in prim.children()? {
        if child.type_name()?.is_none_or(|t| t.as_str() != "GeomSubset") {
            continue;
        }
        let indices = child.attribute("indices").get::<sdf::Value>()?;
        let (Some(sdf::Value::IntVec(indices)), Some(own)) =
            (indices, material(stage, &child, looks, notes)?)
        else {
            continue;
        };
        of_face.resize(faces, None);
        for index in indices {
            if let Some(slot) = usize::try_from(index).ok().and_then(|i| of_face.get_mut(i)) {
                *slot = Some(own);
            }
        }
    }
    Ok(Bound { whole, of_face })
}

fn material(
    stage: &Stage,
    prim: &Prim,
    looks: &mut Vec<Look>,
    notes: &mut Vec<String>,
) -> anyhow::Result<Option<usize>> {
    let Some(path) = binding(stage, prim)? else { return Ok(None) };
    let words = path.to_string();
    if let Some(known) = looks.iter().position(|l| l.path == words) {
        return Ok(Some(known));
    }
    let name = words.rsplit('/').next().unwrap_or_default().to_owned();
    let mut look = Look { path: words.clone(), name, ..Look::default() };
    let surface = match Material::get(stage, path)? {
        Some(material) => material.compute_surface_source()?,
        None => None,
    };
    match surface {
        Some(shader) if shader.id()?.as_deref() == Some("UsdPreviewSurface") => {
            look.base = input(stage, &shader, "diffuseColor")?;
            look.emissive = input(stage, &shader, "emissiveColor")?;
            look.metallic = input(stage, &shader, "metallic")?;
            look.roughness = input(stage, &shader, "roughness")?;
            look.opacity = input(stage, &shader, "opacity")?;
            look.threshold = input(stage, &shader, "opacityThreshold")?;
            look.normal = input(stage, &shader, "normal")?;
            let occlusion = input(stage, &shader, "occlusion")?;
            if occlusion.picture.is_some() {
                notes.push(format!("{words}: its occlusion texture is left out"));
            }
        }
        _ => notes.push(format!("{words}: a material that is no UsdPreviewSurface is left out")),
    }
    looks.push(look);
    Ok(Some(looks.len() - 1))
}

/// A path that the file names, if it is one.
fn sound(path: sdf::Path) -> anyhow::Result<sdf::Path> {
    let words = || format!("`{}` is no path of a prim or property", path.as_str().escape_default());
    anyhow::ensure!(names::is_path(path.as_str()), words());
    Ok(path)
}

/// The material bound to a prim or above it, whether or not the schema of bindings is said to be applied.
fn binding(stage: &Stage, prim: &Prim) -> anyhow::Result<Option<sdf::Path>> {
    let mut at = Some(prim.path().clone());
    while let Some(path) = at {
        if let Some(api) = MaterialBindingAPI::get(stage, path.clone())? {
            return api.compute_bound_material("")?.map(sound).transpose();
        }
        let direct = stage.prim(path.clone()).relationship("material:binding").targets()?;
        if let Some(material) = direct.into_iter().next() {
            return sound(material).map(Some);
        }
        at = path.parent().filter(|above| *above != path);
    }
    Ok(None)
}

/// An input's value, or what its connection leads to.
fn input(stage: &Stage, shader: &Shader, name: &str) -> anyhow::Result<Input> {
    let (value, source) = followed(stage, shader.input(name))?;
    let value = value.as_ref().and_then(numbers);
    let Some((texture, channel)) = source else { return Ok(Input { value, picture: None }) };
    let Some(texture) = Shader::get(stage, texture)? else {
        return Ok(Input { value, picture: None });
    };
    if texture.id()?.as_deref() != Some("UsdUVTexture") {
        return Ok(Input { value, picture: None });
    }
    let file = match followed(stage, texture.input("file"))?.0 {
        Some(sdf::Value::AssetPath(path)) => path.authored_path,
        _ => return Ok(Input { value, picture: None }),
    };
    let wrap = |name: &str| -> anyhow::Result<Wrap> {
        Ok(match followed(stage, texture.input(name))?.0 {
            Some(sdf::Value::Token(t)) if t.as_str() == "repeat" => Wrap::Repeat,
            Some(sdf::Value::Token(t)) if t.as_str() == "mirror" => Wrap::Mirror,
            Some(sdf::Value::Token(t)) if matches!(t.as_str(), "clamp" | "black") => Wrap::Clamp,
            // What the picture itself says, which ours never do.
            _ => Wrap::Repeat,
        })
    };
    let wrap = [wrap("wrapS")?, wrap("wrapT")?];
    let (set, moved) = coordinates(stage, &texture)?;
    let factor = followed(stage, texture.input("scale"))?.0.as_ref().and_then(numbers);
    Ok(Input { value: factor, picture: Some(Laid { file, wrap, set, moved, channel }) })
}

/// The set of coordinates a texture takes, and how they are moved first.
fn coordinates(stage: &Stage, texture: &Shader) -> anyhow::Result<(String, [f64; 5])> {
    let mut moved = [1.0, 1.0, 0.0, 0.0, 0.0];
    let mut set = "st".to_owned();
    let mut source = followed(stage, texture.input("st"))?.1;
    for _ in 0..HOPS {
        let Some((path, _)) = source.take() else { break };
        let Some(shader) = Shader::get(stage, path)? else { break };
        match shader.id()?.as_deref() {
            Some("UsdTransform2d") => {
                let number = |name| -> anyhow::Result<_> {
                    Ok(followed(stage, shader.input(name))?.0.as_ref().and_then(numbers))
                };
                if let Some([x, y]) = number("scale")?.as_deref() {
                    [moved[0], moved[1]] = [*x, *y];
                }
                if let Some([turn]) = number("rotation")?.as_deref() {
                    moved[2] = *turn;
                }
                if let Some([x, y]) = number("translation")?.as_deref() {
                    [moved[3], moved[4]] = [*x, *y];
                }
                source = followed(stage, shader.input("in"))?.1;
            }
            Some(id) if id.starts_with("UsdPrimvarReader_float2") => {
                match followed(stage, shader.input("varname"))?.0 {
                    Some(sdf::Value::Token(name)) => set = name.to_string(),
                    Some(sdf::Value::String(name)) => set = name,
                    _ => {}
                }
                let words = || format!("`{}` names no coordinates", set.escape_default());
                anyhow::ensure!(names::is_property(&set), words());
            }
            _ => {}
        }
    }
    Ok((set, moved))
}

/// A value, and the shader and output that it is connected to.
type Followed = (Option<sdf::Value>, Option<(sdf::Path, String)>);

/// An attribute's value and the shader's output it is connected to, through interface inputs.
fn followed(stage: &Stage, attribute: Attribute) -> anyhow::Result<Followed> {
    let mut attribute = attribute;
    for _ in 0..HOPS {
        let Some(source) = attribute.connections()?.into_iter().next() else { break };
        let source = sound(source)?;
        let words = source.to_string();
        let property = words.rsplit_once('.').map_or("", |(_, property)| property);
        if let Some(channel) = property.strip_prefix("outputs:") {
            return Ok((attribute.get()?, Some((source.prim_path(), channel.to_owned()))));
        }
        attribute = stage.attribute(source);
    }
    Ok((attribute.get()?, None))
}

fn numbers(value: &sdf::Value) -> Option<Vec<f64>> {
    let all = match value {
        sdf::Value::Float(x) => vec![f64::from(*x)],
        sdf::Value::Double(x) => vec![*x],
        sdf::Value::Half(x) => vec![x.to_f64()],
        sdf::Value::Int(x) => vec![f64::from(*x)],
        sdf::Value::Vec2f(v) => vec![v.x.into(), v.y.into()],
        sdf::Value::Vec3f(v) => vec![v.x.into(), v.y.into(), v.z.into()],
        sdf::Value::Vec3d(v) => vec![v.x, v.y, v.z],
        sdf::Value::Vec4f(v) => vec![v.x.into(), v.y.into(), v.z.into(), v.w.into()],
        _ => return None,
    };
    all.iter().all(|x| x.is_finite()).then_some(all)
}

/// `displayColor` and `displayOpacity`, linear light.
pub(super) fn colours(prim: &Prim, time: TimeCode) -> Option<Spread<[f64; 4]>> {
    let (over, values) = primvar(prim, "displayColor", time)?;
    let sdf::Value::Vec3fVec(all) = values else { return None };
    let values: Vec<_> = all.iter().map(|c| [c.x.into(), c.y.into(), c.z.into(), 1.0]).collect();
    let values = indexed(prim, "displayColor", values)?;
    Some(Spread { over, values })
}

/// All sets of texture coordinates.
pub(super) fn places(prim: &Prim, time: TimeCode) -> Vec<(String, Spread<[f64; 2]>)> {
    let names = prim.property_names().unwrap_or_default();
    let names = names.iter().filter_map(|n| n.strip_prefix("primvars:"));
    let sets = names.filter(|n| !n.contains(':')).take(16).filter_map(|name| {
        let (over, values) = primvar(prim, name, time)?;
        let values: Vec<[f64; 2]> = match values {
            sdf::Value::Vec2fVec(all) => all.iter().map(|p| [p.x.into(), p.y.into()]).collect(),
            sdf::Value::Vec2dVec(all) => all.iter().map(|p| [p.x, p.y]).collect(),
            _ => return None,
        };
        Some((name.to_owned(), Spread { over, values: indexed(prim, name, values)? }))
    });
    sets.collect()
}

fn primvar(prim: &Prim, name: &str, time: TimeCode) -> Option<(Over, sdf::Value)> {
    let attribute = prim.attribute(format!("primvars:{name}").as_str());
    let value = attribute.get_at::<sdf::Value>(Some(time)).ok()??;
    let over = match attribute.get_metadata::<sdf::Value>("interpolation").ok()? {
        Some(sdf::Value::Token(t)) => match t.as_str() {
            "uniform" => Over::Faces,
            "vertex" | "varying" => Over::Points,
            "faceVarying" => Over::Corners,
            _ => Over::All,
        },
        _ => Over::All,
    };
    Some((over, value))
}

/// Values by the primvar's indices, where it has any.
fn indexed<T: Copy>(prim: &Prim, name: &str, values: Vec<T>) -> Option<Vec<T>> {
    let indices = prim.attribute(format!("primvars:{name}:indices").as_str());
    match indices.get::<sdf::Value>().ok()? {
        Some(sdf::Value::IntVec(indices)) => {
            indices.iter().map(|&i| values.get(usize::try_from(i).ok()?).copied()).collect()
        }
        _ => Some(values),
    }
}
