//! A URDF as plain values: made good, changed in one place, written to a folder.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// x, y, z.
pub type Triple = [f64; 3];

/// A URDF and the files beside it.
#[derive(Clone, Debug, Default)]
pub struct Model {
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
    /// Files by path beside the URDF.
    pub files: BTreeMap<String, String>,
    /// Replacements in the finished text, in order.
    pub edits: Vec<(String, String)>,
}

#[derive(Clone, Debug, Default)]
pub struct Link {
    pub name: String,
    pub inertial: Option<Inertial>,
    pub visuals: Vec<Shape>,
    pub collisions: Vec<Shape>,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct Inertial {
    pub mass: f64,
    pub centre: Triple,
    /// xx, yy, zz, xy, xz, yz.
    pub tensor: [f64; 6],
}

#[derive(Clone, Debug)]
pub struct Shape {
    pub centre: Triple,
    pub rpy: Triple,
    pub geometry: Geometry,
}

#[derive(Clone, Debug)]
pub enum Geometry {
    Block(Triple),
    Cylinder { radius: f64, length: f64 },
    Mesh { file: String, scale: f64 },
}

#[derive(Clone, Debug)]
pub struct Joint {
    pub name: String,
    pub kind: &'static str,
    pub parent: String,
    pub child: String,
    pub origin: Triple,
    pub axis: Triple,
    pub limits: Option<[f64; 2]>,
    pub effort: f64,
    pub velocity: f64,
    pub friction: f64,
    pub mimic: Option<String>,
}

impl Model {
    pub fn link(&mut self, name: &str) -> &mut Link {
        self.links.iter_mut().find(|l| l.name == name).expect("a link of that name")
    }

    pub fn joint(&mut self, name: &str) -> &mut Joint {
        self.joints.iter_mut().find(|j| j.name == name).expect("a joint of that name")
    }

    pub fn inertial(&mut self, link: &str) -> &mut Inertial {
        self.link(link).inertial.as_mut().expect("a link with mass")
    }

    /// Replaces a text in the finished URDF, which must be there.
    pub fn edit(&mut self, from: &str, to: &str) {
        self.edits.push((from.into(), to.into()));
    }

    /// Writes `<name>.urdf` and its files into a folder.
    pub fn write(&self, folder: &Path, name: &str) {
        let path = folder.join(format!("{name}.urdf"));
        std::fs::create_dir_all(folder).unwrap();
        std::fs::write(path, self.text(name)).unwrap();
        for (file, content) in &self.files {
            let path = folder.join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, content).unwrap();
        }
    }

    fn text(&self, name: &str) -> String {
        let mut text = format!("<?xml version=\"1.0\"?>\n<robot name=\"{name}\">\n");
        self.links.iter().for_each(|l| write_link(&mut text, l));
        self.joints.iter().for_each(|j| write_joint(&mut text, j));
        text.push_str("</robot>\n");
        for (from, to) in &self.edits {
            assert!(text.contains(from), "`{from}` does not occur in {name}:\n{text}");
            text = text.replacen(from, to, 1);
        }
        text
    }

    /// The same with every block and cylinder as an OBJ file, and one visual file per link.
    pub fn in_meshes(mut self) -> Self {
        for link in &mut self.links {
            let mut seen = String::new();
            let mut first = 1;
            for shape in &link.visuals {
                let (vertices, faces) = surface(shape);
                seen.push_str(&obj(&vertices, &faces, first));
                first += vertices.len();
            }
            if link.visuals.is_empty() {
                continue;
            }
            let file = |suffix: &str| format!("meshes/{}{suffix}.obj", link.name);
            self.files.insert(file(""), seen);
            link.visuals = vec![Shape::mesh(&file(""))];
            for (i, shape) in link.collisions.iter_mut().enumerate() {
                let (vertices, faces) = surface(shape);
                self.files.insert(file(&format!("_c{i}")), obj(&vertices, &faces, 1));
                *shape = Shape::mesh(&file(&format!("_c{i}")));
            }
        }
        self
    }
}

impl Shape {
    pub fn block(size: Triple, centre: Triple) -> Self {
        Self { centre, rpy: [0.0; 3], geometry: Geometry::Block(size) }
    }

    /// A cylinder along y.
    pub fn roller(radius: f64, length: f64, centre: Triple) -> Self {
        let geometry = Geometry::Cylinder { radius, length };
        Self { centre, rpy: [std::f64::consts::FRAC_PI_2, 0.0, 0.0], geometry }
    }

    /// A cylinder along z.
    pub fn post(radius: f64, length: f64, centre: Triple) -> Self {
        Self { centre, rpy: [0.0; 3], geometry: Geometry::Cylinder { radius, length } }
    }

    pub fn mesh(file: &str) -> Self {
        let geometry = Geometry::Mesh { file: file.into(), scale: 1.0 };
        Self { centre: [0.0; 3], rpy: [0.0; 3], geometry }
    }

    /// Volume and moments of inertia about the centre per kilogram, along the link's axes.
    fn solid(&self) -> (f64, Triple) {
        match self.geometry {
            Geometry::Block([x, y, z]) => {
                (x * y * z, [y * y + z * z, x * x + z * z, x * x + y * y].map(|i| i / 12.0))
            }
            Geometry::Cylinder { radius: r, length: l } => {
                let (along, across) = (r * r / 2.0, (3.0 * r * r + l * l) / 12.0);
                let turned = self.rpy[0] != 0.0;
                let moments =
                    if turned { [across, along, across] } else { [across, across, along] };
                (std::f64::consts::PI * r * r * l, moments)
            }
            Geometry::Mesh { .. } => panic!("a mesh has no closed form here"),
        }
    }
}

impl Link {
    /// A body of some shapes, seen as it collides, of one density (kg/m³).
    pub fn solid(name: &str, density: f64, shapes: &[Shape]) -> Self {
        let solids: Vec<_> = shapes.iter().map(|s| (s.centre, s.solid())).collect();
        let mass = density * solids.iter().map(|(_, (v, _))| v).sum::<f64>();
        let mean = |axis: usize| {
            density * solids.iter().map(|(c, (v, _))| c[axis] * v).sum::<f64>() / mass
        };
        let centre = [mean(0), mean(1), mean(2)];
        let mut tensor = [0.0; 6];
        for (at, (volume, moments)) in &solids {
            let m = density * volume;
            let d: Triple = std::array::from_fn(|i| at[i] - centre[i]);
            let square = d.iter().map(|x| x * x).sum::<f64>();
            for i in 0..3 {
                tensor[i] += m * (moments[i] + square - d[i] * d[i]);
            }
            for (k, (i, j)) in [(0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
                tensor[3 + k] -= m * d[i] * d[j];
            }
        }
        Self {
            name: name.into(),
            inertial: Some(Inertial { mass, centre, tensor }),
            visuals: shapes.to_vec(),
            collisions: shapes.to_vec(),
        }
    }
}

impl Joint {
    fn new(
        kind: &'static str,
        name: &str,
        [parent, child]: [&str; 2],
        [origin, axis]: [Triple; 2],
        limits: Option<[f64; 2]>,
    ) -> Self {
        Self {
            name: name.into(),
            kind,
            parent: parent.into(),
            child: child.into(),
            origin,
            axis,
            limits,
            effort: 50.0,
            velocity: 1.0,
            friction: 0.1,
            mimic: None,
        }
    }

    pub fn hinge(name: &str, links: [&str; 2], place: [Triple; 2], limits: [f64; 2]) -> Self {
        Self::new("revolute", name, links, place, Some(limits))
    }

    pub fn slide(name: &str, links: [&str; 2], place: [Triple; 2], limits: [f64; 2]) -> Self {
        Self::new("prismatic", name, links, place, Some(limits))
    }

    pub fn spin(name: &str, links: [&str; 2], place: [Triple; 2]) -> Self {
        Self::new("continuous", name, links, place, None)
    }
}

fn shown([x, y, z]: Triple) -> String {
    format!("{x} {y} {z}")
}

fn write_link(text: &mut String, link: &Link) {
    let _ = writeln!(text, "<link name=\"{}\">", link.name);
    if let Some(Inertial { mass, centre, tensor: [xx, yy, zz, xy, xz, yz] }) = link.inertial {
        let centre = shown(centre);
        let _ = writeln!(
            text,
            "<inertial><origin xyz=\"{centre}\"/><mass value=\"{mass}\"/><inertia ixx=\"{xx}\" \
             iyy=\"{yy}\" izz=\"{zz}\" ixy=\"{xy}\" ixz=\"{xz}\" iyz=\"{yz}\"/></inertial>"
        );
    }
    for (tag, shapes) in [("visual", &link.visuals), ("collision", &link.collisions)] {
        for shape in shapes {
            let (xyz, rpy) = (shown(shape.centre), shown(shape.rpy));
            let geometry = match &shape.geometry {
                Geometry::Block(size) => format!("<box size=\"{}\"/>", shown(*size)),
                Geometry::Cylinder { radius, length } => {
                    format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>")
                }
                Geometry::Mesh { file, scale } => {
                    format!("<mesh filename=\"{file}\" scale=\"{scale} {scale} {scale}\"/>")
                }
            };
            let _ = writeln!(
                text,
                "<{tag}><origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><geometry>{geometry}</geometry></{tag}>"
            );
        }
    }
    text.push_str("</link>\n");
}

fn write_joint(text: &mut String, joint: &Joint) {
    let Joint { name, kind, parent, child, effort, velocity, friction, .. } = joint;
    let (origin, axis) = (shown(joint.origin), shown(joint.axis));
    let limits = joint.limits.map(|[l, u]| format!("lower=\"{l}\" upper=\"{u}\" "));
    let limits = limits.unwrap_or_default();
    let mimic = joint.mimic.iter().map(|m| format!("<mimic joint=\"{m}\"/>"));
    let mimic: String = mimic.collect();
    let _ = writeln!(
        text,
        "<joint name=\"{name}\" type=\"{kind}\"><origin xyz=\"{origin}\"/><parent link=\"{parent}\"/>\
         <child link=\"{child}\"/><axis xyz=\"{axis}\"/><limit {limits}effort=\"{effort}\" \
         velocity=\"{velocity}\"/><dynamics damping=\"0.1\" friction=\"{friction}\"/>{mimic}</joint>"
    );
}

/// A closed surface: vertices, and faces counter-clockwise seen from outside.
pub type Surface = (Vec<Triple>, Vec<[usize; 3]>);

/// The surface of a shape in its link's frame.
fn surface(shape: &Shape) -> Surface {
    let (vertices, faces) = match shape.geometry {
        Geometry::Block(size) => block(size),
        Geometry::Cylinder { radius, length } => prism(radius, length, 24),
        Geometry::Mesh { .. } => panic!("already a mesh"),
    };
    let (sin, cos) = shape.rpy[0].sin_cos();
    let place = |[x, y, z]: Triple| {
        let turned = [x, y * cos - z * sin, y * sin + z * cos];
        std::array::from_fn(|i| turned[i] + shape.centre[i])
    };
    (vertices.into_iter().map(place).collect(), faces)
}

/// A block around the origin.
pub fn block(size: Triple) -> Surface {
    let corner =
        |i: usize| std::array::from_fn(|k| if i >> k & 1 == 1 { size[k] } else { -size[k] } / 2.0);
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    ((0..8).map(corner).collect(), halves(&quads))
}

/// An upright prism around the origin.
pub fn prism(radius: f64, length: f64, sides: usize) -> Surface {
    let ring = |z: f64| {
        (0..sides).map(move |i| {
            let angle = std::f64::consts::TAU * i as f64 / sides as f64;
            [radius * angle.cos(), radius * angle.sin(), z]
        })
    };
    let vertices = ring(-length / 2.0).chain(ring(length / 2.0)).collect();
    let mut faces = Vec::new();
    for i in 0..sides {
        let j = (i + 1) % sides;
        faces.extend([[i, j, sides + j], [i, sides + j, sides + i]]);
        if (1..sides - 1).contains(&i) {
            faces.extend([[0, i + 1, i], [sides, sides + i, sides + i + 1]]);
        }
    }
    (vertices, faces)
}

/// An open tray around the origin: a block with a hollow from above, walls and floor `wall` thick.
pub fn tray(size: Triple, wall: f64) -> Surface {
    let [x, y, z] = size.map(|s| s / 2.0);
    let ring = |x: f64, y: f64, z: f64| [[-x, -y, z], [x, -y, z], [x, y, z], [-x, y, z]];
    let vertices = [
        ring(x, y, -z),
        ring(x, y, z),
        ring(x - wall, y - wall, z),
        ring(x - wall, y - wall, wall - z),
    ];
    let mut quads = vec![[0, 3, 2, 1], [12, 13, 14, 15]];
    for i in 0..4 {
        let j = (i + 1) % 4;
        quads.extend([
            [i, j, 4 + j, 4 + i],
            [4 + i, 4 + j, 8 + j, 8 + i],
            [8 + i, 8 + j, 12 + j, 12 + i],
        ]);
    }
    (vertices.concat(), halves(&quads))
}

fn halves(quads: &[[usize; 4]]) -> Vec<[usize; 3]> {
    quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
}

/// OBJ text whose first vertex has the number `first`.
pub fn obj(vertices: &[Triple], faces: &[[usize; 3]], first: usize) -> String {
    let mut text = String::new();
    for v in vertices {
        let _ = writeln!(text, "v {}", shown(*v));
    }
    for [a, b, c] in faces {
        let _ = writeln!(text, "f {} {} {}", a + first, b + first, c + first);
    }
    text
}
