//! One material's faces of a surface as OBJ, and materials as MTL: what simulators without PBR read.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use glamx::DVec3;
use object::Mesh;
use object::appearance::{AlphaMode, Material};
use object::glb::srgb_of_linear;

use crate::write::appearance::look::{AssetAppearance, Group, TextureFile};
use crate::write::xml::number;

/// A group whose corners all lie within this share of its diagonal of one plane is flat: MuJoCo refuses
/// a URDF's mesh without a volume (below 1e-15 m³), though nothing is weighed by it.
const FLAT: f64 = 1e-6;
/// How far behind a flat group the small body lies that gives it a volume, and how high that is, as a
/// share of its diagonal. A guess: nothing that is seen.
const HIDDEN: f64 = 1e-4;

/// The faces of a group as OBJ text in the object frame: `normals` are those of the whole surface's
/// corners, `mtl` is the file that has its material. Positions are printed to a tenth of a micrometre:
/// text is much of what an asset weighs.
pub(crate) fn group_obj(mesh: &Mesh, normals: &[[DVec3; 3]], group: &Group, mtl: &str) -> String {
    let mut text = format!("# kinfold, metres, z up\nmtllib {mtl}\n");
    let mut obj = Obj::default();
    // Where a texture lies on it, colours of vertices are what is seen without the picture.
    let colours = mesh.colours().filter(|_| group.material.is_textured());
    for (n, &face) in group.faces.iter().enumerate() {
        let (Some(of), Some(normal)) =
            (mesh.faces().get(face as usize), normals.get(face as usize))
        else {
            continue;
        };
        let points = of.map(|v| mesh.vertices()[v as usize]);
        let shades = of.map(|v| colours.map(|c| c[v as usize]));
        obj.face(of.map(u64::from), points, shades, *normal, group.corners.get(n).copied());
    }
    let body = hidden_body(mesh, group);
    let middle = body.iter().flatten().sum::<DVec3>() / 12.0;
    for points in body {
        // Numbers that no vertex of a mesh has; each face has corners of its own.
        let first = u64::from(u32::MAX) + 1 + obj.vertices.len() as u64;
        let own = [first, first + 1, first + 2];
        let normal = (points[1] - points[0]).cross(points[2] - points[0]);
        let normal = normal.normalize_or(points[0] - middle);
        let (uv, colours) = (group.corners.first().map(|c| [c[0]; 3]), [obj.some_colour; 3]);
        obj.face(own, points, colours, [normal; 3], uv);
    }
    text.push_str(&obj.head);
    put(&mut text, format_args!("usemtl {}\n", group.name));
    text.push_str(&obj.faces);
    text
}

/// A small tetrahedron just behind the largest face of a flat group; nothing for any other group.
fn hidden_body(mesh: &Mesh, group: &Group) -> Vec<[DVec3; 3]> {
    let count = mesh.faces().len();
    let faces = || group.faces.iter().map(|&f| f as usize).filter(|f| *f < count);
    let Some(largest) = faces().max_by(|a, b| mesh.area(*a).total_cmp(&mesh.area(*b))) else {
        return Vec::new();
    };
    let (normal, middle) = (mesh.normal(largest), mesh.centroid(largest));
    let all = || faces().flat_map(|f| mesh.corners(f));
    let diagonal = object::mesh::Bounds::of(all()).diagonal();
    if all().any(|p| (p - middle).dot(normal).abs() > FLAT * diagonal) {
        return Vec::new();
    }
    let behind = normal * (HIDDEN * diagonal);
    let [a, b, c] = mesh.corners(largest).map(|p| (p + middle) / 2.0 - behind);
    let top = middle - behind * 2.0;
    vec![[a, b, c], [b, a, top], [c, b, top], [a, c, top]]
}

/// OBJ lines in the making.
#[derive(Default)]
struct Obj {
    head: String,
    faces: String,
    vertices: BTreeMap<u64, usize>,
    normals: BTreeMap<[i64; 3], usize>,
    places: BTreeMap<[u32; 2], usize>,
    some_colour: Option<[u8; 4]>,
}

impl Obj {
    fn face(
        &mut self,
        own: [u64; 3],
        points: [DVec3; 3],
        colours: [Option<[u8; 4]>; 3],
        normals: [DVec3; 3],
        uv: Option<[[f32; 2]; 3]>,
    ) {
        let corner = |k: usize, this: &mut Self| {
            let v = this.vertex(own[k], points[k], colours[k]);
            let n = this.normal(normals[k]);
            match uv.map(|uv| this.place(uv[k])) {
                Some(t) => format!(" {v}/{t}/{n}"),
                None => format!(" {v}//{n}"),
            }
        };
        let line: String = (0..3).map(|k| corner(k, self)).collect();
        put(&mut self.faces, format_args!("f{line}\n"));
    }

    fn vertex(&mut self, own: u64, p: DVec3, colour: Option<[u8; 4]>) -> usize {
        let (next, head) = (self.vertices.len() + 1, &mut self.head);
        self.some_colour = self.some_colour.or(colour);
        *self.vertices.entry(own).or_insert_with(|| {
            let [x, y, z] = p.to_array().map(|c| tidy(c, 1e7));
            put(head, format_args!("v {x} {y} {z}"));
            if let Some([r, g, b, _]) = colour {
                let [r, g, b] = [r, g, b].map(|c| f64::from(c) / 255.0);
                put(head, format_args!(" {r:.4} {g:.4} {b:.4}"));
            }
            head.push('\n');
            next
        })
    }

    fn normal(&mut self, n: DVec3) -> usize {
        let rounded = n.to_array().map(|c| (c * 1e5).round() as i64);
        let (next, head) = (self.normals.len() + 1, &mut self.head);
        *self.normals.entry(rounded).or_insert_with(|| {
            let [x, y, z] = rounded.map(|c| c as f64 / 1e5);
            put(head, format_args!("vn {x} {y} {z}\n"));
            next
        })
    }

    /// OBJ's v points upward.
    fn place(&mut self, uv: [f32; 2]) -> usize {
        let (next, head) = (self.places.len() + 1, &mut self.head);
        *self.places.entry(uv.map(f32::to_bits)).or_insert_with(|| {
            let [u, v] = [f64::from(uv[0]), 1.0 - f64::from(uv[1])].map(|c| tidy(c, 1e6));
            put(head, format_args!("vt {u} {v}\n"));
            next
        })
    }
}

/// The materials of a link as MTL text, to lie beside its meshes and pictures: what every reader knows,
/// and what readers of PBR know (`Pr`, `Pm`, `norm`).
pub(crate) fn mtl(groups: &[Group], appearance: &AssetAppearance) -> String {
    let mut text = String::from("# kinfold\n");
    for group in groups {
        let of = &group.material;
        let [r, g, b] = shown(of).map(number);
        put(&mut text, format_args!("newmtl {}\nKd {r} {g} {b}\nKs 0 0 0\n", group.name));
        let [r, g, b] =
            of.emissive.map(|e| srgb_of_linear(e.clamp(0.0, 1.0))).map(rounded).map(number);
        put(&mut text, format_args!("Ke {r} {g} {b}\nd {}\nillum 2\n", number(opacity(of))));
        let (rough, metal) = (number(of.roughness), number(of.metallic));
        put(&mut text, format_args!("Pr {rough}\nPm {metal}\n"));
        let [base, _, normal, emissive] = of.textures();
        for (word, texture) in [("map_Kd", base), ("map_Ke", emissive), ("norm", normal)] {
            let file = texture.and_then(|t| appearance.textures.get(t.picture));
            if let Some(file) = file.map(TextureFile::name) {
                put(&mut text, format_args!("{word} {file}.png\n"));
            }
        }
    }
    text
}

/// The base colour's factor as sRGB, 0 to 1: what formats without linear light multiply a texture by.
pub(crate) fn shown(of: &Material) -> [f64; 3] {
    let [r, g, b, _] = of.base_colour;
    [r, g, b].map(|c| rounded(srgb_of_linear(c)))
}

/// Opacity of a material, 1 unless it blends.
pub(crate) fn opacity(of: &Material) -> f64 {
    if of.alpha == AlphaMode::Blend { of.base_colour[3] } else { 1.0 }
}

fn rounded(c: f64) -> f64 {
    (c.clamp(0.0, 1.0) * 1e4).round() / 1e4
}

/// Without digits that nobody sees: what is left is a multiple of `1 / per`.
fn tidy(c: f64, per: f64) -> f64 {
    (c * per).round() / per + 0.0
}

/// Writing to a string cannot fail.
fn put(text: &mut String, line: std::fmt::Arguments<'_>) {
    let _ = text.write_fmt(line);
}

#[cfg(test)]
mod tests {
    use super::*;
    use object::mesh::UpAxis;
    use object::normals::{CREASE_ANGLE, corner_normals};

    fn square(lift: f64) -> (Mesh, Group) {
        let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let corners = vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(1.0, 1.0, lift), p(0.0, 1.0, 0.0)];
        let mesh = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let corners =
            vec![[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]];
        let group = Group {
            name: "door_wood".into(),
            material: Material::default(),
            mean: [1.0; 4],
            faces: vec![0, 1],
            corners,
        };
        (mesh, group)
    }

    #[test]
    fn coordinates_are_written_with_v_upward_and_once_each() {
        let (mesh, group) = square(0.1);
        let text = group_obj(&mesh, &corner_normals(&mesh, CREASE_ANGLE), &group, "door.mtl");
        let lines = |word: &str| text.lines().filter(|l| l.starts_with(word)).collect::<Vec<_>>();
        assert_eq!(lines("vt"), ["vt 0 1", "vt 1 1", "vt 1 0", "vt 0 0"]);
        assert_eq!(lines("f "), ["f 1/1/1 2/2/2 3/3/1", "f 1/1/1 3/3/1 4/4/3"]);
        assert!(text.contains("mtllib door.mtl\n") && text.contains("usemtl door_wood\n"));
        let back = object::obj::read(&text, UpAxis::Z).unwrap();
        assert_eq!((back.vertices(), back.faces()), (mesh.vertices(), mesh.faces()));
    }

    #[test]
    fn mujoco_refuses_no_flat_group_for_it_has_a_volume() {
        let (mesh, group) = square(0.0);
        let text = group_obj(&mesh, &corner_normals(&mesh, CREASE_ANGLE), &group, "door.mtl");
        let back = object::obj::read(&text, UpAxis::Z).unwrap();
        assert_eq!(back.faces().len(), 6);
        assert!(back.bounds().size().z > 1e-5 && back.bounds().max.z == 0.0);
    }
}
