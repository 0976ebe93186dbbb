//! The asset as SDFormat 1.9, which Gazebo and Drake read: a model folder of `asset.sdf` and
//! `model.config`, beside the meshes of the URDF package.
//!
//! Links stand side by side in the model's frame, each where it rests; joints sit in their child's frame.
//! The root is free: a world that wants it held welds it. Links of one model collide with each other only
//! where the model says so; joined ones never do.
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
//! let files = asset.to_sdf_with(&Default::default()).files;
//! let names: Vec<&str> = files.keys().map(String::as_str).collect();
//! assert_eq!(names, ["asset.sdf", "model.config"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeMap;

use crate::asset::{Asset, Joint, Link, LinkBody, Motion};
use crate::write::appearance::look::{AssetAppearance, Group};
use crate::write::obj::{opacity, shown};
use crate::write::paths::{MeshPaths, mesh_paths};
use crate::write::urdf::Package;
use crate::write::xml::{Xml, number, numbers};

/// The version of the format: the newest that both Gazebo Garden and Drake 1.51 read.
const VERSION: &str = "1.9";

impl Asset {
    /// The asset as an SDFormat model and its `model.config`, to lie beside the `meshes` folder of
    /// [`Asset::to_urdf_with`]; metres, kilograms, radians, z up. The same asset gives the same bytes.
    pub fn to_sdf_with(&self, appearance: &AssetAppearance) -> Package {
        let files = [("asset.sdf", model(self, appearance)), ("model.config", config(self))];
        let files = files.map(|(path, text)| (path.into(), text.into_bytes()));
        Package { files: BTreeMap::from(files) }
    }
}

/// What Gazebo lists a model folder by.
fn config(asset: &Asset) -> String {
    let mut xml = Xml::new();
    xml.element("model", &[], |xml| {
        xml.text("name", &[], &asset.name);
        xml.text("version", &[], "1.0");
        xml.text("sdf", &[("version", VERSION)], "asset.sdf");
        xml.text("description", &[], &asset.category);
    });
    xml.finish()
}

fn model(asset: &Asset, appearance: &AssetAppearance) -> String {
    let paths = mesh_paths(&asset.links, appearance);
    let mut xml = Xml::new();
    xml.element("sdf", &[("version", VERSION)], |xml| {
        xml.element("model", &[("name", &asset.name)], |xml| {
            // Neighbours in a joint never collide; all others are clear of each other.
            xml.text("self_collide", &[], "true");
            for (index, (link, paths)) in asset.links.iter().zip(&paths).enumerate() {
                write_link(xml, link, (appearance, appearance.groups(index)), paths);
            }
            for joint in &asset.joints {
                write_joint(xml, asset, joint);
            }
        });
    });
    xml.finish()
}

fn write_link(
    xml: &mut Xml,
    link: &Link,
    (appearance, groups): (&AssetAppearance, &[Group]),
    paths: &MeshPaths,
) {
    xml.element("link", &[("name", &link.name)], |xml| {
        write_pose(xml, &numbers(link.frame));
        write_inertial(xml, link);
        let Some(body) = &link.body else { return };
        if groups.is_empty() {
            let [r, g, b, a] = body.colour.value;
            write_visual(xml, ("visual", paths.visual()), Some([r, g, b, a]));
        }
        for (group, path) in groups.iter().zip(&paths.visuals) {
            // A mesh with a picture brings its own material; a colour here would hide it.
            let of = &group.material;
            let picture = of.base_texture.and_then(|t| appearance.textures.get(t.picture));
            let [r, g, b] = shown(of);
            let colour = picture.is_none().then(|| [r, g, b, opacity(of)]);
            write_visual(xml, (&group.name, path), colour);
        }
        for (index, path) in paths.collision.iter().enumerate() {
            write_collision(xml, index, path, body);
        }
    });
}

fn write_pose(xml: &mut Xml, place: &str) {
    xml.text("pose", &[], &format!("{place} 0 0 0"));
}

fn write_inertial(xml: &mut Xml, link: &Link) {
    let (i, m) = (&link.inertial, link.inertial.inertia.value);
    let tensor = [
        ("ixx", m.x_axis.x),
        ("ixy", m.x_axis.y),
        ("ixz", m.x_axis.z),
        ("iyy", m.y_axis.y),
        ("iyz", m.y_axis.z),
        ("izz", m.z_axis.z),
    ];
    xml.element("inertial", &[], |xml| {
        write_pose(xml, &numbers(i.centre.value));
        xml.text("mass", &[], &number(i.mass.value));
        xml.element("inertia", &[], |xml| {
            tensor.iter().for_each(|(name, value)| xml.text(name, &[], &number(*value)));
        });
    });
}

fn write_visual(xml: &mut Xml, (name, path): (&str, &str), colour: Option<[f64; 4]>) {
    xml.element("visual", &[("name", name)], |xml| {
        write_mesh(xml, path);
        let Some(colour) = colour else { return };
        let rgba = colour.map(number).join(" ");
        xml.element("material", &[], |xml| {
            xml.text("ambient", &[], &rgba);
            xml.text("diffuse", &[], &rgba);
        });
    });
}

fn write_collision(xml: &mut Xml, index: usize, path: &str, body: &LinkBody) {
    xml.element("collision", &[("name", &format!("piece_{index:02}"))], |xml| {
        write_mesh(xml, path);
        let friction = number(body.substance.friction.value);
        xml.element("surface", &[], |xml| {
            xml.element("friction", &[], |xml| {
                xml.element("ode", &[], |xml| {
                    xml.text("mu", &[], &friction);
                    xml.text("mu2", &[], &friction);
                });
            });
        });
    });
}

fn write_mesh(xml: &mut Xml, path: &str) {
    xml.element("geometry", &[], |xml| {
        xml.element("mesh", &[], |xml| xml.text("uri", &[], path));
    });
}

fn write_joint(xml: &mut Xml, asset: &Asset, joint: &Joint) {
    let name = |link: usize| asset.links.get(link).map_or("", |l| l.name.as_str());
    xml.element("joint", &[("name", &joint.name), ("type", joint.kind.name())], |xml| {
        xml.text("parent", &[], name(joint.parent));
        xml.text("child", &[], name(joint.child));
        if let Some(motion) = &joint.motion {
            xml.element("axis", &[], |xml| write_axis(xml, motion));
        }
    });
}

fn write_axis(xml: &mut Xml, motion: &Motion) {
    xml.text("xyz", &[], &numbers(motion.axis.value));
    xml.element("limit", &[], |xml| {
        if let Some([lower, upper]) = &motion.limits {
            xml.text("lower", &[], &number(lower.value));
            xml.text("upper", &[], &number(upper.value));
        }
        xml.text("effort", &[], &number(motion.effort.value));
        xml.text("velocity", &[], &number(motion.velocity.value));
    });
    xml.element("dynamics", &[], |xml| {
        xml.text("damping", &[], &number(motion.damping.value));
        xml.text("friction", &[], &number(motion.friction.value));
    });
}
