//! The asset as files: a URDF in the dialect every simulator reads, its meshes and the sidecar.
//!
//! Relative `meshes/*.obj` with forward slashes, no scale, no rotation, explicit inertials, limits
//! and dynamics. A `<mujoco>` element, which all others ignore, keeps MuJoCo from stripping the mesh
//! folder, from fusing links away and from letting what dry friction holds creep. A transmission for
//! each moving joint gives Drake an actuator.
//!
//! ```
//! use asset::{BuildOptions, build};
//! use object::{ArticulatedObject, Condition, DVec3, KinematicTree, Mesh, Part};
//! let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
//! let mesh = Mesh::new(corners, faces)?;
//! let stone = Part { name: "stone".into(), text: "stone".into(), parent: None, joints: vec![] };
//! let tree = KinematicTree::new(vec![stone])?;
//! let object = ArticulatedObject::new(mesh, tree, vec![0; 4], vec![vec![]])?;
//! let condition = Condition::from_json(
//!     r#"{"schema": "kinfold-condition/1", "category": "stone", "size": {"height": 0.5},
//!         "parts": [{"name": "stone", "mass": 3}]}"#,
//! )?;
//! let asset = build(&object, &condition, &[Some(0)], &BuildOptions::default())?;
//! let package = asset.to_urdf();
//! let paths: Vec<&str> = package.files.keys().map(String::as_str).collect();
//! assert_eq!(paths, ["asset.json", "asset.urdf", "meshes/stone.obj", "meshes/stone_c00.obj"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeMap;

use object::Mesh;
use object::normals::{CREASE_ANGLE, corner_normals};
use object::obj::{self, ObjNormals};

use crate::asset::{Asset, Joint, Link, LinkBody, Motion};
use crate::collision::piece::ConvexPiece;
use crate::write::appearance::look::{AssetAppearance, Group};
use crate::write::obj::{group_obj, mtl};
use crate::write::paths::{MeshPaths, mesh_paths};
use crate::write::sidecar;
use crate::write::xml::{Xml, number, numbers};

/// Passes in which MuJoCo makes dry friction hold. Its friction is soft on purpose: without such a pass
/// a lid sinks at the same pace whatever its friction. One pass holds a lid, chains of joints took up to
/// five (measured on the development cases); each costs only what friction there is.
const HOLDING_PASSES: &str = "20";

/// Files of an asset by their path below the package's folder, forward slashes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Package {
    /// Path to content: `asset.urdf`, `asset.json`, `meshes/<link>.obj`, `meshes/<link>_c00.obj`…
    pub files: BTreeMap<String, Vec<u8>>,
}

impl Asset {
    /// The asset as a package of files, one colour a link; the same asset gives the same bytes.
    pub fn to_urdf(&self) -> Package {
        self.to_urdf_with(&AssetAppearance::default())
    }

    /// The same with materials and textures: an OBJ for each material of a link, an MTL for each link,
    /// and PNG pictures beside them.
    pub fn to_urdf_with(&self, appearance: &AssetAppearance) -> Package {
        let paths = mesh_paths(&self.links, appearance);
        let mut files = BTreeMap::new();
        for (index, (link, paths)) in self.links.iter().zip(&paths).enumerate() {
            let Some(body) = &link.body else { continue };
            match appearance.groups(index) {
                [] => {
                    files.insert(paths.visual().into(), visual_obj(&body.visual));
                }
                groups => visual_groups(&mut files, appearance, (body, groups), paths),
            }
            for (piece, path) in body.collision.iter().zip(&paths.collision) {
                files.insert(path.clone(), piece_obj(piece));
            }
        }
        for texture in &appearance.textures {
            files.insert(texture.path.clone(), texture.picture.bytes().to_vec());
        }
        files.insert("asset.urdf".into(), robot(self, appearance, &paths).into_bytes());
        let described = sidecar::describe(self, appearance, &paths, &files);
        files.insert("asset.json".into(), described);
        Package { files }
    }
}

fn visual_groups(
    files: &mut BTreeMap<String, Vec<u8>>,
    appearance: &AssetAppearance,
    (body, groups): (&LinkBody, &[Group]),
    paths: &MeshPaths,
) {
    let path = paths.materials();
    let name = path.rsplit_once('/').map_or(path.as_str(), |(_, file)| file);
    let normals = corner_normals(&body.visual, CREASE_ANGLE);
    for (group, path) in groups.iter().zip(&paths.visuals) {
        let text = group_obj(&body.visual, &normals, group, name);
        files.insert(path.clone(), text.into_bytes());
    }
    files.insert(path.clone(), mtl(groups, appearance).into_bytes());
}

fn visual_obj(mesh: &Mesh) -> Vec<u8> {
    obj::write(mesh, ObjNormals::Smooth).into_bytes()
}

/// A piece as OBJ with flat normals; one that is no mesh leaves an empty file, which no reader
/// accepts.
fn piece_obj(piece: &ConvexPiece) -> Vec<u8> {
    let mesh = Mesh::new(piece.vertices.clone(), piece.faces.clone());
    mesh.map(|m| visual_obj(&m)).unwrap_or_default()
}

fn robot(asset: &Asset, appearance: &AssetAppearance, paths: &[MeshPaths]) -> String {
    let mut xml = Xml::new();
    xml.element("robot", &[("name", &asset.name)], |xml| {
        xml.element("mujoco", &[], |xml| {
            let keep =
                [("strippath", "false"), ("fusestatic", "false"), ("discardvisual", "false")];
            xml.empty("compiler", &keep);
            xml.empty("option", &[("noslip_iterations", HOLDING_PASSES)]);
        });
        for (index, (link, paths)) in asset.links.iter().zip(paths).enumerate() {
            write_link(xml, link, appearance.groups(index), paths);
        }
        for joint in &asset.joints {
            write_joint(xml, asset, joint);
        }
        for joint in asset.joints.iter().filter(|j| j.motion.is_some()) {
            write_transmission(xml, joint);
        }
    });
    xml.finish()
}

fn write_link(xml: &mut Xml, link: &Link, groups: &[Group], paths: &MeshPaths) {
    xml.element("link", &[("name", &link.name)], |xml| {
        write_inertial(xml, link);
        let Some(body) = &link.body else { return };
        match groups {
            [] => {
                let name = format!("{}_colour", link.name);
                write_visual(xml, paths.visual(), &name, body.colour.value);
            }
            groups => {
                for (group, path) in groups.iter().zip(&paths.visuals) {
                    write_visual(xml, path, &group.name, group.mean);
                }
            }
        }
        for path in &paths.collision {
            xml.element("collision", &[], |xml| write_geometry(xml, path));
        }
    });
}

fn write_inertial(xml: &mut Xml, link: &Link) {
    let (i, m) = (&link.inertial, link.inertial.inertia.value);
    let [ixx, ixy, ixz] = [m.x_axis.x, m.x_axis.y, m.x_axis.z].map(number);
    let [iyy, iyz, izz] = [m.y_axis.y, m.y_axis.z, m.z_axis.z].map(number);
    xml.element("inertial", &[], |xml| {
        write_origin(xml, &numbers(i.centre.value));
        xml.empty("mass", &[("value", &number(i.mass.value))]);
        let tensor = [
            ("ixx", &ixx),
            ("ixy", &ixy),
            ("ixz", &ixz),
            ("iyy", &iyy),
            ("iyz", &iyz),
            ("izz", &izz),
        ];
        xml.empty("inertia", &tensor.map(|(k, v)| (k, v.as_str())));
    });
}

fn write_visual(xml: &mut Xml, path: &str, material: &str, colour: [f64; 4]) {
    xml.element("visual", &[], |xml| {
        write_geometry(xml, path);
        let rgba = colour.map(number).join(" ");
        xml.element("material", &[("name", material)], |xml| {
            xml.empty("color", &[("rgba", &rgba)]);
        });
    });
}

fn write_geometry(xml: &mut Xml, path: &str) {
    write_origin(xml, "0 0 0");
    xml.element("geometry", &[], |xml| xml.empty("mesh", &[("filename", path)]));
}

fn write_origin(xml: &mut Xml, xyz: &str) {
    xml.empty("origin", &[("xyz", xyz), ("rpy", "0 0 0")]);
}

fn write_joint(xml: &mut Xml, asset: &Asset, joint: &Joint) {
    let name = |link: usize| asset.links.get(link).map_or("", |l| l.name.as_str());
    xml.element("joint", &[("name", &joint.name), ("type", joint.kind.name())], |xml| {
        write_origin(xml, &numbers(joint.origin.value));
        xml.empty("parent", &[("link", name(joint.parent))]);
        xml.empty("child", &[("link", name(joint.child))]);
        if let Some(motion) = &joint.motion {
            write_motion(xml, motion);
        }
    });
}

fn write_motion(xml: &mut Xml, motion: &Motion) {
    xml.empty("axis", &[("xyz", &numbers(motion.axis.value))]);
    let mut limit = Vec::new();
    if let Some([lower, upper]) = &motion.limits {
        limit.extend([("lower", number(lower.value)), ("upper", number(upper.value))]);
    }
    limit.push(("effort", number(motion.effort.value)));
    limit.push(("velocity", number(motion.velocity.value)));
    let limit: Vec<_> = limit.iter().map(|(k, v)| (*k, v.as_str())).collect();
    xml.empty("limit", &limit);
    let (damping, friction) = (number(motion.damping.value), number(motion.friction.value));
    xml.empty("dynamics", &[("damping", &damping), ("friction", &friction)]);
}

/// An actuator that pushes a joint with its effort; damping and friction are the joint's own.
fn write_transmission(xml: &mut Xml, joint: &Joint) {
    let name = format!("{}_transmission", joint.name);
    let effort = "hardware_interface/EffortJointInterface";
    xml.element("transmission", &[("name", &name)], |xml| {
        xml.text("type", &[], "transmission_interface/SimpleTransmission");
        xml.element("joint", &[("name", &joint.name)], |xml| {
            xml.text("hardwareInterface", &[], effort);
        });
        xml.element("actuator", &[("name", &format!("{}_motor", joint.name))], |xml| {
            xml.text("mechanicalReduction", &[], "1");
            xml.text("hardwareInterface", &[], effort);
        });
    });
}
