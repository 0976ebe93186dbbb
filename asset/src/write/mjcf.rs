//! The asset as MJCF, which MuJoCo loads as it stands: links as nested bodies, drives as motors.
//!
//! The model names the meshes of the URDF package and is to lie beside them. The root stands still
//! in the world, as it does when MuJoCo reads the URDF. Links that meet in a joint are excluded from
//! contact: MuJoCo does that by itself only where the parent moves. MJCF has no word for a joint's
//! largest velocity; it stands under `custom`, as `<joint>_velocity`.

use crate::asset::{Asset, Joint, JointType, Link, Motion};
use crate::write::adjacent::adjacent;
use crate::write::appearance::look::{AssetAppearance, Group};
use crate::write::obj::{opacity, shown};
use crate::write::paths::{MeshPaths, mesh_paths};
use crate::write::runtimes::{FIRM, FIRM_LIMIT, SOON};
use crate::write::xml::{Xml, number, numbers};

impl Asset {
    /// The asset as the text of an MJCF model, to lie beside the `meshes` folder of
    /// [`Asset::to_urdf`]; metres, kilograms, radians, z up.
    pub fn to_mjcf(&self) -> String {
        self.to_mjcf_with(&AssetAppearance::default())
    }

    /// The same with materials and textures, to lie beside the `meshes` folder of
    /// [`Asset::to_urdf_with`].
    pub fn to_mjcf_with(&self, appearance: &AssetAppearance) -> String {
        let paths = mesh_paths(&self.links, appearance);
        let mut xml = Xml::new();
        xml.element("mujoco", &[("model", &self.name)], |xml| {
            let exact = [("angle", "radian"), ("autolimits", "true"), ("inertiafromgeom", "false")];
            xml.empty("compiler", &exact);
            xml.empty("option", &[("integrator", "implicitfast")]);
            write_defaults(xml);
            xml.element("asset", &[], |xml| {
                write_meshes(xml, self, &paths);
                write_materials(xml, self, appearance);
            });
            let seen = Seen { asset: self, appearance, paths: &paths };
            xml.element("worldbody", &[], |xml| write_body(xml, &seen, 0));
            xml.element("contact", &[], |xml| write_exclusions(xml, self));
            xml.element("actuator", &[], |xml| write_motors(xml, self));
            xml.element("custom", &[], |xml| write_velocities(xml, self));
        });
        xml.finish()
    }
}

/// Visual geoms touch nothing and weigh nothing; groups 2 and 3 are what viewers show and hide.
fn write_defaults(xml: &mut Xml) {
    let visual = [
        ("type", "mesh"),
        ("group", "2"),
        ("contype", "0"),
        ("conaffinity", "0"),
        ("density", "0"),
    ];
    let collision = [("type", "mesh"), ("group", "3"), ("density", "0")];
    let class = |xml: &mut Xml, name: &str, geom: &[(&str, &str)]| {
        xml.element("default", &[("class", name)], |xml| xml.empty("geom", geom));
    };
    xml.element("default", &[], |xml| {
        let [firm, limit] = [FIRM, FIRM_LIMIT].map(|of| of.map(number).join(" "));
        let soon = SOON.map(number).join(" ");
        let holds = [
            ("solimpfriction", firm.as_str()),
            ("solimplimit", &limit),
            ("solreffriction", &soon),
            ("solreflimit", &soon),
        ];
        xml.empty("joint", &holds);
        class(xml, "visual", &visual);
        class(xml, "collision", &collision);
    });
}

/// The name a mesh goes by: its file's, without folder and ending.
fn mesh_name(path: &str) -> &str {
    let file = path.rsplit_once('/').map_or(path, |(_, file)| file);
    file.rsplit_once('.').map_or(file, |(stem, _)| stem)
}

fn write_meshes(xml: &mut Xml, asset: &Asset, paths: &[MeshPaths]) {
    let mut mesh = |path: &str, inertia| {
        xml.empty("mesh", &[("name", mesh_name(path)), ("file", path), ("inertia", inertia)]);
    };
    for (link, paths) in asset.links.iter().zip(paths) {
        if link.body.is_some() {
            // What is seen may be an open sheet; its volume is nobody's business.
            paths.visuals.iter().for_each(|path| mesh(path, "shell"));
        }
        paths.collision.iter().for_each(|path| mesh(path, "convex"));
    }
}

/// Pictures and materials. MuJoCo multiplies a texture by `rgba` without linear light.
fn write_materials(xml: &mut Xml, asset: &Asset, appearance: &AssetAppearance) {
    let groups = || (0..asset.links.len()).flat_map(|link| appearance.groups(link));
    let base = |g: &Group| g.material.base_texture.map(|t| t.picture);
    for (index, texture) in appearance.textures.iter().enumerate() {
        if groups().any(|g| base(g) == Some(index)) {
            let (name, file) = (texture.name(), texture.path.as_str());
            xml.empty("texture", &[("name", name), ("type", "2d"), ("file", file)]);
        }
    }
    for group in groups() {
        let of = &group.material;
        let [r, g, b] = shown(of);
        let rgba = [r, g, b, opacity(of)].map(number).join(" ");
        let texture = base(group).and_then(|t| appearance.textures.get(t));
        let shine = number((50.0 * (1.0 - of.roughness)).round() / 100.0);
        let glow = number(of.emissive.iter().sum::<f64>().min(3.0) / 3.0);
        let (metallic, roughness) = (number(of.metallic), number(of.roughness));
        let mut attributes = vec![("name", group.name.as_str()), ("rgba", &rgba)];
        attributes.extend(texture.map(|t| ("texture", t.name())));
        attributes.extend([("specular", shine.as_str()), ("shininess", &shine)]);
        attributes.extend([("metallic", metallic.as_str()), ("roughness", &roughness)]);
        if of.emissive.iter().any(|e| *e > 0.0) {
            attributes.push(("emission", &glow));
        }
        xml.empty("material", &attributes);
    }
}

/// What bodies are written from.
struct Seen<'a> {
    asset: &'a Asset,
    appearance: &'a AssetAppearance,
    paths: &'a [MeshPaths],
}

fn write_body(xml: &mut Xml, seen: &Seen<'_>, index: usize) {
    let Seen { asset, appearance, paths } = seen;
    let (Some(link), Some(paths_of)) = (asset.links.get(index), paths.get(index)) else { return };
    let joint = asset.joint_of(index);
    let place = numbers(joint.map_or(link.frame, |j| j.origin.value));
    xml.element("body", &[("name", &link.name), ("pos", &place)], |xml| {
        write_inertial(xml, link);
        if let Some((joint, motion)) = joint.and_then(|j| Some((j, j.motion.as_ref()?))) {
            write_joint(xml, joint, motion);
        }
        write_geoms(xml, link, appearance.groups(index), paths_of);
        let below = asset.joints.iter().filter(|j| j.parent == index && j.child > index);
        below.for_each(|j| write_body(xml, seen, j.child));
    });
}

fn write_inertial(xml: &mut Xml, link: &Link) {
    let (i, m) = (&link.inertial, link.inertial.inertia.value);
    let tensor = [m.x_axis.x, m.y_axis.y, m.z_axis.z, m.x_axis.y, m.x_axis.z, m.y_axis.z];
    let (centre, mass) = (numbers(i.centre.value), number(i.mass.value));
    let tensor = tensor.map(number).join(" ");
    xml.empty("inertial", &[("pos", &centre), ("mass", &mass), ("fullinertia", &tensor)]);
}

fn write_joint(xml: &mut Xml, joint: &Joint, motion: &Motion) {
    let kind = if joint.kind == JointType::Prismatic { "slide" } else { "hinge" };
    let axis = numbers(motion.axis.value);
    let range = motion.limits.as_ref().map(|l| l.clone().map(|end| number(end.value)).join(" "));
    let force = both_ways(motion.effort.value);
    let (damping, friction) = (number(motion.damping.value), number(motion.friction.value));
    let mut attributes = vec![("name", joint.name.as_str()), ("type", kind), ("axis", &axis)];
    match &range {
        // Said aloud: a range of no extent would be taken for none at all.
        Some(range) => attributes.extend([("limited", "true"), ("range", range.as_str())]),
        None => attributes.push(("limited", "false")),
    }
    attributes.extend([
        ("damping", damping.as_str()),
        ("frictionloss", &friction),
        ("actuatorfrcrange", &force),
    ]);
    xml.empty("joint", &attributes);
}

/// The range of a force or torque that acts either way.
fn both_ways(effort: f64) -> String {
    format!("{} {}", number(-effort), number(effort))
}

fn write_geoms(xml: &mut Xml, link: &Link, groups: &[Group], paths: &MeshPaths) {
    let Some(body) = &link.body else { return };
    if groups.is_empty() {
        let rgba = body.colour.value.map(number).join(" ");
        let seen = [("class", "visual"), ("mesh", mesh_name(paths.visual())), ("rgba", &rgba)];
        xml.empty("geom", &seen);
    }
    for (group, path) in groups.iter().zip(&paths.visuals) {
        let seen = [("class", "visual"), ("mesh", mesh_name(path)), ("material", &group.name)];
        xml.empty("geom", &seen);
    }
    let friction = format!("{} 0.005 0.0001", number(body.substance.friction.value));
    for path in &paths.collision {
        let piece = [("class", "collision"), ("mesh", mesh_name(path)), ("friction", &friction)];
        xml.empty("geom", &piece);
    }
}

fn write_exclusions(xml: &mut Xml, asset: &Asset) {
    for pair in adjacent(asset) {
        let [a, b] = pair.map(|l| asset.links[l].name.as_str());
        xml.empty("exclude", &[("body1", a), ("body2", b)]);
    }
}

fn moving(asset: &Asset) -> impl Iterator<Item = (&Joint, &Motion)> {
    asset.joints.iter().filter_map(|j| Some((j, j.motion.as_ref()?)))
}

/// One motor per joint; at rest it does nothing, so the asset behaves as if it had none.
fn write_motors(xml: &mut Xml, asset: &Asset) {
    for (joint, motion) in moving(asset) {
        let force = both_ways(motion.effort.value);
        let name = joint.name.as_str();
        let motor =
            [("name", name), ("joint", name), ("ctrlrange", &force), ("forcerange", &force)];
        xml.empty("motor", &motor);
    }
}

fn write_velocities(xml: &mut Xml, asset: &Asset) {
    for (joint, motion) in moving(asset) {
        let name = format!("{}_velocity", joint.name);
        xml.empty("numeric", &[("name", &name), ("data", &number(motion.velocity.value))]);
    }
}
