//! What is seen and touched: `visual-…`, `collision-…`, `scale-…`, `size-zero`, `quaternion-zero`,
//! textures and materials.

use glamx::DVec3;
use object::mesh::Bounds;
use sim_check::geometry::tessellate::tessellated;
use sim_check::read::source::{At, Edit};
use sim_check::robot::{Geometry, Link, Shape};

use super::language::Language;
use super::model::{Model, Role, quoted, vector};
use super::needed::every;
use super::planted::{Made, first, made};
use crate::fix::numbers::{short, triple};

const NO_PART: &str = "no moving part has such shapes of its own in this file";
/// How far a collision shape is moved: a share of its part's size, and of the model's; guesses.
const BESIDE: (f64, f64) = (0.5, 0.05);

/// The shapes of a role, of every moving part that has some.
fn parts<'m>(model: &'m Model, word: &str, role: Role) -> Vec<(usize, Found<'m>)> {
    let all = model.parts(word).into_iter();
    let one = |(l, link, at)| {
        let shapes = model.own_shapes(link, at, role);
        (!shapes.is_empty()).then_some((l, Found { link, shapes }))
    };
    all.filter_map(one).collect()
}

struct Found<'m> {
    link: &'m Link,
    shapes: Vec<(&'m Shape, At)>,
}

fn left_out(model: &Model, word: &str, role: Role) -> Made {
    first(parts(model, word, role), NO_PART, |(_, found)| {
        let Found { link, shapes } = found;
        let (own, other) = match role {
            Role::Visual => (&link.visuals, &link.collisions),
            Role::Collision => (&link.collisions, &link.visuals),
        };
        if shapes.len() != own.len() || other.is_empty() {
            return Err(NO_PART.into());
        }
        let edits = shapes.iter().map(|(_, at)| model.source.remove(*at)).collect();
        let words = format!("{} shapes left out", shapes.len());
        made(quoted("link", &link.name), link.line, words, edits)
    })
}

pub(super) fn visual_missing(model: &Model, word: &str) -> Made {
    left_out(model, word, Role::Visual)
}

pub(super) fn collision_missing(model: &Model, word: &str) -> Made {
    let own = left_out(model, word, Role::Collision);
    if own.is_ok() || model.language != Language::Mjcf {
        return own;
    }
    // A geom of MJCF that is seen, too, stays and touches nothing.
    first(model.parts(word), NO_PART, |(_, link, at)| {
        let shapes = model.shapes(link, at, Role::Collision);
        if shapes.is_empty() || shapes.len() != link.collisions.len() {
            return Err(NO_PART.into());
        }
        let edits = shapes.iter().flat_map(|(_, at)| masked(model, *at)).collect();
        made(quoted("link", &link.name), link.line, "its shapes touch nothing", edits)
    })
}

fn masked(model: &Model, at: At) -> [Edit; 2] {
    ["contype", "conaffinity"].map(|name| model.source.set(at, name, "0"))
}

pub(super) fn all_masked(model: &Model, _: &str) -> Made {
    let (source, geoms) = (&model.source, every(&model.source).into_iter());
    let geoms: Vec<At> = geoms.filter(|at| source.tag(*at) == "geom").collect();
    if geoms.is_empty() || every(source).iter().any(|at| source.tag(*at) == "pair") {
        return Err("it has no geoms, or pairs that touch whatever their masks".into());
    }
    // Classes are overruled by what each geom says of itself.
    let stands = |at: &At| {
        let mut above = std::iter::successors(source.parent(*at), |a| source.parent(*a));
        above.all(|a| source.tag(a) != "default")
    };
    let edits: Vec<Edit> =
        geoms.into_iter().filter(stands).flat_map(|at| masked(model, at)).collect();
    made("the model".into(), source.line(source.root()), "all contact masks 0", edits)
}

/// The size of some shapes.
fn size(shapes: &[(&Shape, At)]) -> f64 {
    let points = |s: &Shape| {
        let mesh = tessellated(&s.geometry).ok();
        let place = s.origin;
        mesh.map_or(vec![], |m| m.vertices().iter().map(|p| place.transform_point(*p)).collect())
    };
    let all: Vec<DVec3> = shapes.iter().flat_map(|(s, _)| points(s)).collect();
    if all.is_empty() { 0.0 } else { Bounds::of(all).diagonal() }
}

pub(super) fn collision_off(model: &Model, word: &str) -> Made {
    let diagonal = model.diagonal()?;
    first(parts(model, word, Role::Collision), NO_PART, |(_, found)| {
        let Found { link, shapes } = found;
        if link.visuals.is_empty() {
            return Err("no part is both seen and touched".into());
        }
        let far = (BESIDE.0 * size(&shapes)).max(BESIDE.1 * diagonal);
        let by = DVec3::new(0.0, 0.0, far);
        let moved = |(s, at): &(&Shape, At)| model.moved(*at, s.origin.translation, by);
        let edits: Vec<Edit> = shapes.iter().map(moved).collect::<Result<_, _>>()?;
        let words = format!("collision geometry moved by {} m", short(far));
        made(quoted("link", &link.name), link.line, words, edits)
    })
}

/// A mesh's scale as it stands.
fn scale(model: &Model, at: At) -> DVec3 {
    let told = match model.language {
        Language::Sdf => {
            let all = model.source.child(at, "scale").map_or(vec![], |s| model.numbers(s));
            <[f64; 3]>::try_from(all).ok().map(DVec3::from_array)
        }
        _ => model.source.get(at, "scale").and_then(vector),
    };
    told.unwrap_or(DVec3::ONE)
}

fn scaled(model: &Model, at: At, by: DVec3) -> Edit {
    let told = triple(scale(model, at) * by);
    match model.language {
        Language::Sdf => model.text(at, "scale", &told),
        _ => model.source.set(at, "scale", &told),
    }
}

/// Numbers of a primitive times a factor.
fn grown(model: &Model, at: At, by: f64) -> Result<Vec<Edit>, String> {
    let source = &model.source;
    let times = |text: &str| -> Result<String, String> {
        let all: Vec<f64> = text.split_whitespace().map_while(|w| w.parse().ok()).collect();
        match all.is_empty() {
            true => Err("its size is not told in numbers".into()),
            false => Ok(all.iter().map(|v| short(v * by)).collect::<Vec<_>>().join(" ")),
        }
    };
    if model.language == Language::Mjcf {
        let size = source.get(at, "size").ok_or("its size is not its own")?;
        return Ok(vec![source.set(at, "size", &times(size)?)]);
    }
    let shape = source.first_child(model.child_of(at, "geometry")?).ok_or("it has no shape")?;
    if source.tag(shape) == "mesh" {
        return Ok(vec![scaled(model, shape, DVec3::splat(by))]);
    }
    let names = ["size", "radius", "length"];
    let edits: Vec<Edit> = match model.language {
        Language::Sdf => names
            .into_iter()
            .filter_map(|n| Some((n, source.child(shape, n)?)))
            .map(|(n, c)| {
                let all = model.numbers(c).iter().map(|v| short(v * by)).collect::<Vec<_>>();
                source.replace(c, format!("<{n}>{}</{n}>", all.join(" ")))
            })
            .collect(),
        _ => names
            .into_iter()
            .filter_map(|n| Some((n, source.get(shape, n)?)))
            .map(|(n, told)| Ok(source.set(shape, n, &times(told)?)))
            .collect::<Result<_, String>>()?,
    };
    if edits.is_empty() { Err("its size is not told".into()) } else { Ok(edits) }
}

pub(super) fn collision_large(model: &Model, word: &str) -> Made {
    first(parts(model, word, Role::Collision), NO_PART, |(_, found)| {
        let Found { link, shapes } = found;
        if link.visuals.is_empty() {
            return Err("no part is both seen and touched".into());
        }
        let all: Vec<Vec<Edit>> =
            shapes.iter().map(|(_, at)| grown(model, *at, 3.0)).collect::<Result<_, _>>()?;
        let line = link.line;
        made(
            quoted("link", &link.name),
            line,
            "collision geometry three times as large",
            all.concat(),
        )
    })
}

pub(super) fn size_zero(model: &Model, word: &str) -> Made {
    let roles = [Role::Collision, Role::Visual];
    let all = roles.into_iter().flat_map(|role| {
        let all = model.parts(word).into_iter();
        all.flat_map(move |(_, link, at)| {
            let shapes = model.shapes(link, at, role).into_iter();
            shapes.map(move |(s, at)| (link, s, at))
        })
    });
    let all = all.filter(|(_, s, _)| !matches!(s.geometry, Geometry::Mesh(_)));
    first(all.collect::<Vec<_>>(), "no moving part has a primitive", |(link, _, at)| {
        let source = &model.source;
        let none = |told: &str| -> String {
            let rest: Vec<&str> = told.split_whitespace().skip(1).collect();
            ["0"].into_iter().chain(rest).collect::<Vec<_>>().join(" ")
        };
        let edit = match model.language {
            Language::Mjcf => {
                let size = source.get(at, "size").ok_or("its size is not its own")?;
                source.set(at, "size", &none(size))
            }
            language => {
                let shape = source.first_child(model.child_of(at, "geometry")?);
                let shape = shape.ok_or("it has no shape")?;
                let name = if source.tag(shape) == "box" { "size" } else { "radius" };
                match language {
                    Language::Sdf => {
                        let child = model.child_of(shape, name)?;
                        let told: Vec<String> =
                            model.numbers(child).iter().map(|v| short(*v)).collect();
                        source.replace(child, format!("<{name}>{}</{name}>", none(&told.join(" "))))
                    }
                    _ => {
                        let told = source.get(shape, name).ok_or("its size is not told")?;
                        source.set(shape, name, &none(told))
                    }
                }
            }
        };
        made(quoted("link", &link.name), source.line(at), "a side or radius of 0", vec![edit])
    })
}

/// The elements that tell the scale of a mesh.
fn mesh_elements(model: &Model) -> Vec<At> {
    let source = &model.source;
    every(source).into_iter().filter(|at| source.tag(*at) == "mesh").collect()
}

fn rescaled(model: &Model, by: f64) -> Made {
    let all = mesh_elements(model);
    if all.is_empty() {
        return Err("it has no mesh".into());
    }
    let edits = all.iter().map(|at| scaled(model, *at, DVec3::splat(by))).collect();
    let source = &model.source;
    let words = format!("{} meshes scaled by {}", all.len(), short(by));
    made("the model".into(), source.line(source.root()), words, edits)
}

pub(super) fn millimetres(model: &Model, _: &str) -> Made {
    rescaled(model, 1000.0)
}

pub(super) fn small(model: &Model, _: &str) -> Made {
    rescaled(model, 0.001)
}

pub(super) fn mirrored(model: &Model, word: &str) -> Made {
    first(model.drawn(word, mesh_elements(model)), "it has no mesh", |at| {
        let edit = scaled(model, at, DVec3::new(1.0, -1.0, 1.0));
        made("a mesh".into(), model.source.line(at), "mirrored in y", vec![edit])
    })
}

pub(super) fn quaternion(model: &Model, word: &str) -> Made {
    first(model.parts(word), "it has no moving body", |(_, link, at)| {
        let others = ["euler", "axisangle", "xyaxes", "zaxis"];
        if others.iter().any(|name| model.source.get(at, name).is_some()) {
            return Err("its turn is told in another way".into());
        }
        let edit = model.source.set(at, "quat", "0 0 0 0");
        made(quoted("link", &link.name), link.line, "quat 0 0 0 0", vec![edit])
    })
}

pub(super) fn texture(model: &Model, word: &str) -> Made {
    let source = &model.source;
    let name = if model.language == Language::Mjcf { "file" } else { "filename" };
    let all = every(source).into_iter().filter(|at| source.tag(*at) == "texture");
    let all: Vec<At> = all.filter(|at| source.get(*at, name).is_some()).collect();
    first(model.drawn(word, all), "it has no texture", |at| {
        let edit = source.set(at, name, "not_there.png");
        made("a texture".into(), source.line(at), "not_there.png", vec![edit])
    })
}

pub(super) fn material(model: &Model, word: &str) -> Made {
    const NOBODY: &str = "material_that_is_not_there";
    first(model.parts(word), "no moving part is seen", |(_, link, at)| {
        let shapes = model.shapes(link, at, Role::Visual);
        let (_, at) = *shapes.first().ok_or("no moving part is seen")?;
        let source = &model.source;
        let edit = match (model.language, source.child(at, "material")) {
            (Language::Mjcf, _) => source.set(at, "material", NOBODY),
            (_, Some(old)) => source.replace(old, format!("<material name=\"{NOBODY}\"/>")),
            (_, None) => source.insert_last(at, &format!("<material name=\"{NOBODY}\"/>")),
        };
        let words = format!("material `{NOBODY}`");
        made(quoted("link", &link.name), source.line(at), words, vec![edit])
    })
}
