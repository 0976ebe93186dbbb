//! A COLLADA `<geometry>`: its points, and its polygons as triangles.

use glamx::DVec3;
use object::mesh::{MAX_FACES, MAX_VERTICES};
use roxmltree::Node;

use super::xml::{DaeError, child, children, numbers};

/// Points in the file's unit, and triangles between them.
#[derive(Default)]
pub(super) struct Surface {
    pub points: Vec<DVec3>,
    pub faces: Vec<[u32; 3]>,
}

/// Reads a geometry; one without a mesh (a spline) has no surface.
pub(super) fn surface(geometry: Node) -> Result<Surface, DaeError> {
    let Some(mesh) = child(geometry, "mesh") else {
        return Err(DaeError::at(geometry, "holds no mesh"));
    };
    let mut surface = Surface::default();
    for vertices in children(mesh).filter(|n| n.tag_name().name() == "vertices") {
        let first = surface.points.len();
        surface.points.extend(positions(mesh, vertices)?);
        if surface.points.len() > MAX_VERTICES {
            return Err(DaeError::at(mesh, format!("has at most {MAX_VERTICES} points")));
        }
        let id = vertices.attribute("id").unwrap_or_default();
        for primitive in children(mesh) {
            polygons(primitive, id, first, &mut surface)?;
        }
    }
    Ok(surface)
}

/// What an input of an element names.
fn source<'d>(node: Node<'d, 'd>, semantic: &str) -> Option<&'d str> {
    let is_it =
        |n: &Node| n.tag_name().name() == "input" && n.attribute("semantic") == Some(semantic);
    children(node).find(is_it)?.attribute("source")?.trim().strip_prefix('#')
}

fn positions(mesh: Node, vertices: Node) -> Result<Vec<DVec3>, DaeError> {
    let missing = |what: &str| DaeError::at(vertices, format!("has no {what}"));
    let id = source(vertices, "POSITION").ok_or_else(|| missing("POSITION"))?;
    let is_it = |n: &Node| n.tag_name().name() == "source" && n.attribute("id") == Some(id);
    let found = children(mesh).find(is_it).ok_or_else(|| missing("source of that name"))?;
    let array = child(found, "float_array").ok_or_else(|| missing("float_array"))?;
    let accessor = child(found, "technique_common").and_then(|t| child(t, "accessor"));
    let number = |name: &str, default: usize| {
        let said = accessor.and_then(|a| a.attribute(name)?.trim().parse::<usize>().ok());
        said.unwrap_or(default)
    };
    let (stride, offset) = (number("stride", 3), number("offset", 0));
    if stride < 3 {
        return Err(DaeError::at(found, format!("points have three numbers, found {stride}")));
    }
    let numbers = numbers(array)?;
    let rest = numbers.get(offset..).unwrap_or_default();
    Ok(rest.chunks_exact(stride).map(|p| DVec3::new(p[0], p[1], p[2])).collect())
}

/// Which corners a kind of primitive makes of the points it lists.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Triangles,
    /// So many corners each, told apart.
    Polylist,
    /// A list each.
    Polygons,
    Fans,
    Strips,
}

fn kind(node: Node) -> Option<Kind> {
    Some(match node.tag_name().name() {
        "triangles" => Kind::Triangles,
        "polylist" => Kind::Polylist,
        "polygons" => Kind::Polygons,
        "trifans" => Kind::Fans,
        "tristrips" => Kind::Strips,
        _ => return None,
    })
}

fn polygons(
    node: Node,
    vertices: &str,
    first: usize,
    surface: &mut Surface,
) -> Result<(), DaeError> {
    let Some(kind) = kind(node).filter(|_| source(node, "VERTEX") == Some(vertices)) else {
        return Ok(());
    };
    let inputs = || children(node).filter(|n| n.tag_name().name() == "input");
    let offset = |n: Node| n.attribute("offset").and_then(|o| o.trim().parse::<usize>().ok());
    let stride = inputs().filter_map(offset).max().unwrap_or(0).saturating_add(1);
    let mine = inputs().find(|n| n.attribute("semantic") == Some("VERTEX")).and_then(offset);
    let mine = mine.unwrap_or(0);
    let count = surface.points.len();
    let lists = children(node).flat_map(|n| match n.tag_name().name() {
        "p" => vec![n],
        "ph" => children(n).filter(|n| n.tag_name().name() == "p").collect(),
        _ => vec![],
    });
    let mut corners: Vec<Vec<u32>> = Vec::new();
    for list in lists {
        let words = list.text().unwrap_or_default().split_ascii_whitespace();
        let index = |word: &str| {
            let found = word.parse::<usize>().ok().and_then(|i| i.checked_add(first));
            found.filter(|i| *i < count).map(|i| i as u32)
        };
        let all: Option<Vec<u32>> = words.skip(mine).step_by(stride).map(index).collect();
        corners.push(all.ok_or_else(|| DaeError::at(list, "names a point that is not there"))?);
    }
    let faces = &mut surface.faces;
    match kind {
        Kind::Triangles => {
            faces
                .extend(corners.iter().flat_map(|c| c.chunks_exact(3)).map(|c| [c[0], c[1], c[2]]));
        }
        Kind::Polygons | Kind::Fans => corners.iter().for_each(|c| fan(c, faces)),
        Kind::Strips => corners.iter().for_each(|c| strip(c, faces)),
        Kind::Polylist => {
            let counts = child(node, "vcount").map(numbers).transpose()?.unwrap_or_default();
            let mut rest = corners.first().map_or(&[][..], Vec::as_slice);
            for count in counts {
                let Some((polygon, after)) = rest.split_at_checked(count as usize) else {
                    return Err(DaeError::at(node, "counts more corners than it lists"));
                };
                fan(polygon, faces);
                rest = after;
            }
        }
    }
    if faces.len() > MAX_FACES {
        return Err(DaeError::at(node, format!("a mesh has at most {MAX_FACES} triangles")));
    }
    Ok(())
}

fn fan(corners: &[u32], faces: &mut Vec<[u32; 3]>) {
    if let Some((hub, rest)) = corners.split_first() {
        faces.extend(rest.windows(2).map(|pair| [*hub, pair[0], pair[1]]));
    }
}

fn strip(corners: &[u32], faces: &mut Vec<[u32; 3]>) {
    let face = |(k, c): (usize, &[u32])| match k % 2 {
        0 => [c[0], c[1], c[2]],
        _ => [c[1], c[0], c[2]],
    };
    faces.extend(corners.windows(3).enumerate().map(face));
}
