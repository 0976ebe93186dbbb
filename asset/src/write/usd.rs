//! The asset as USD text with UsdPhysics: an articulation of rigid bodies, metres, kilograms, z up.
//!
//! `/<asset>/Links` holds a rigid body per link, side by side, each with the surface to see and the
//! convex pieces to collide with; `/<asset>/Joints` the joints; `/<asset>/Materials` what each link
//! looks and feels like. The root is free: whoever wants it held joins it to the world. Damping is
//! a drive without stiffness. UsdPhysics has no words for a joint's dry friction and largest
//! velocity; they stand in PhysX's, Newton's and MuJoCo's, each of which the others pass over.

use std::collections::BTreeMap;

use glamx::{DQuat, DVec3};
use object::Mesh;
use object::glb::linear_of_srgb;
use object::normals::{CREASE_ANGLE, corner_normals};

use crate::asset::{Asset, Inertial, Joint, JointType, Link, LinkBody, Motion};
use crate::mass::principal::principal;
use crate::surface::fans::points_of;
use crate::write::adjacent::adjacent;
use crate::write::appearance::look::{AssetAppearance, Group};
use crate::write::moved::inertia;
use crate::write::runtimes::{Runtime, Words};
use crate::write::shading::{write_shading, write_subsets};
use crate::write::usda::{Usda, float, list, quaternion, quoted, schemas, tokens, triple};

impl Asset {
    /// The asset as one USD layer in text form (`.usda`), nothing beside it needed; the same asset
    /// gives the same bytes.
    pub fn to_usd(&self) -> String {
        self.to_usd_with(&AssetAppearance::default())
    }

    /// The same with materials and textures: the layer names the pictures of [`Asset::to_urdf_with`] and
    /// is to lie beside their folder.
    pub fn to_usd_with(&self, appearance: &AssetAppearance) -> String {
        self.layer(appearance, &Frame { runtimes: &Runtime::ALL, ..Frame::default() })
    }

    /// A layer with the words of some engines, and what else its frame says.
    pub(crate) fn layer(&self, appearance: &AssetAppearance, frame: &Frame<'_>) -> String {
        let mut metadata = frame.metadata.clone();
        metadata.extend([
            format!("defaultPrim = {}", quoted(&self.name)),
            "kilogramsPerUnit = 1".into(),
            "metersPerUnit = 1".into(),
            "upAxis = \"Z\"".into(),
        ]);
        let mut usda = Usda::new(&metadata);
        let mut root =
            vec![schemas(&["PhysicsArticulationRootAPI"]), "kind = \"component\"".into()];
        root.extend(frame.root.iter().cloned());
        usda.prim("Xform", &self.name, &root, |usda| {
            frame.variants.iter().for_each(|line| usda.line(line));
            usda.prim("Xform", "Links", &[], |usda| {
                write_links(usda, self, appearance, frame.runtimes);
            });
            usda.prim("Scope", "Joints", &[], |usda| {
                self.joints.iter().for_each(|joint| write_joint(usda, self, joint, frame.runtimes));
            });
            usda.prim("Scope", "Materials", &[], |usda| {
                for link in &self.links {
                    link.body.iter().for_each(|body| write_material(usda, self, link, body));
                }
                for (link, group) in (0..self.links.len())
                    .flat_map(|link| appearance.materials(link).iter().map(move |g| (link, g)))
                {
                    let path = format!("/{}/Materials/{}", self.name, group.name);
                    let of = self.links.get(link).and_then(|l| l.body.as_ref());
                    let made_of = of.map_or("", |body| body.substance.material.value.as_str());
                    write_shading(usda, (&path, made_of), group, appearance);
                }
            });
        });
        usda.finish()
    }

    pub(crate) fn path_of_link(&self, link: usize) -> String {
        let name = self.links.get(link).map_or("", |l| l.name.as_str());
        format!("</{}/Links/{name}>", self.name)
    }

    fn path_of_material(&self, link: &Link) -> String {
        format!("/{}/Materials/{}", self.name, link.name)
    }
}

/// What surrounds the links and joints of a layer.
#[derive(Debug, Default)]
pub(crate) struct Frame<'a> {
    /// Engines whose words stand beside those of UsdPhysics.
    pub(crate) runtimes: &'a [Runtime],
    /// Lines of the layer's metadata.
    pub(crate) metadata: Vec<String>,
    /// Lines of the root's metadata.
    pub(crate) root: Vec<String>,
    /// Lines of the root's variant sets.
    pub(crate) variants: Vec<String>,
}

fn write_links(usda: &mut Usda, asset: &Asset, appearance: &AssetAppearance, runtimes: &[Runtime]) {
    let pairs = adjacent(asset);
    for (index, link) in asset.links.iter().enumerate() {
        let mine = pairs.iter().filter(|p| p[0] == index).map(|p| asset.path_of_link(p[1]));
        let filtered: Vec<String> = mine.collect();
        let groups = appearance.materials(index);
        write_link(usda, (asset, groups, runtimes), link, filtered);
    }
}

fn write_link(
    usda: &mut Usda,
    (asset, groups, runtimes): (&Asset, &[Group], &[Runtime]),
    link: &Link,
    filtered: Vec<String>,
) {
    let mut applied = vec!["PhysicsRigidBodyAPI", "PhysicsMassAPI", "SemanticsLabelsAPI:class"];
    if !filtered.is_empty() {
        applied.push("PhysicsFilteredPairsAPI");
    }
    usda.prim("Xform", &link.name, &[schemas(&applied)], |usda| {
        write_inertial(usda, &link.inertial);
        if !filtered.is_empty() {
            usda.set("rel physics:filteredPairs", &list(filtered));
        }
        usda.set("token[] semantics:labels:class", &tokens(&[&link.label]));
        let place = link.frame.to_array().map(crate::write::xml::number).join(", ");
        usda.set("double3 xformOp:translate", &format!("({place})"));
        usda.set("uniform token[] xformOpOrder", "[\"xformOp:translate\"]");
        if let Some(body) = &link.body {
            write_visual(usda, (asset, groups), link, body);
            usda.prim("Scope", "collision", &[], |usda| {
                write_pieces(usda, (asset, runtimes), link, body);
            });
        }
    });
}

fn write_inertial(usda: &mut Usda, inertial: &Inertial) {
    let principal = principal(inertial.inertia.value);
    usda.set("point3f physics:centerOfMass", &triple(inertial.centre.value));
    usda.set("float3 physics:diagonalInertia", &triple(principal.moments));
    usda.set("float physics:mass", &float(inertial.mass.value));
    usda.set("quatf physics:principalAxes", &quaternion(principal.axes));
}

fn write_visual(
    usda: &mut Usda,
    (asset, groups): (&Asset, &[Group]),
    link: &Link,
    body: &LinkBody,
) {
    let material = format!("<{}>", asset.path_of_material(link));
    usda.prim("Mesh", "visual", &[schemas(&["MaterialBindingAPI"])], |usda| {
        usda.set("rel material:binding", &material);
        let normals = if groups.is_empty() { write_normals } else { write_shared_normals };
        write_surface(usda, &body.visual, normals);
        write_subsets(usda, &format!("/{}/Materials", asset.name), &body.visual, groups);
        match body.visual.colours().filter(|_| groups.is_empty()) {
            Some(colours) => write_colours(usda, &body.visual, colours),
            None => usda.set("color3f[] primvars:displayColor", &format!("[{}]", plain(body))),
        }
    });
}

/// Each colour once, in linear light, and which of them every corner of a face has.
fn write_colours(usda: &mut Usda, mesh: &Mesh, colours: &[[u8; 4]]) {
    let mut places: BTreeMap<[u8; 4], usize> = colours.iter().map(|&c| (c, 0)).collect();
    places.values_mut().enumerate().for_each(|(i, place)| *place = i);
    let shown = |&[r, g, b, _]: &[u8; 4]| triple(light([r, g, b].map(|c| f64::from(c) / 255.0)));
    let table = list(places.keys().map(shown));
    usda.set_each("color3f[] primvars:displayColor", &table, "faceVarying");
    let corners = mesh.faces().iter().flatten().filter_map(|&v| colours.get(v as usize));
    let which = corners.filter_map(|c| places.get(c)).map(usize::to_string);
    usda.set("int[] primvars:displayColor:indices", &list(which));
}

/// Points, faces and normals of a surface, smooth but for its creases.
fn write_surface(usda: &mut Usda, mesh: &Mesh, normals: fn(&mut Usda, &Mesh)) {
    let (bounds, (points, faces)) = (mesh.bounds(), merged(mesh));
    usda.set("uniform bool doubleSided", "1");
    usda.set("float3[] extent", &list([bounds.min, bounds.max].map(triple)));
    usda.set("int[] faceVertexCounts", &list(mesh.faces().iter().map(|_| "3".to_string())));
    let indices = faces.iter().flatten().map(u32::to_string);
    usda.set("int[] faceVertexIndices", &list(indices));
    normals(usda, mesh);
    usda.set("point3f[] points", &list(points.into_iter().map(triple)));
    usda.set("uniform token subdivisionScheme", "\"none\"");
}

fn write_normals(usda: &mut Usda, mesh: &Mesh) {
    let normals = corner_normals(mesh, CREASE_ANGLE).into_iter().flatten().map(triple);
    usda.set_each("normal3f[] normals", &list(normals), "faceVarying");
}

/// Each normal once, to five digits, and which of them every corner has.
fn write_shared_normals(usda: &mut Usda, mesh: &Mesh) {
    let mut known: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    let (mut table, mut which) = (Vec::new(), Vec::new());
    for normal in corner_normals(mesh, CREASE_ANGLE).into_iter().flatten() {
        let rounded = normal.to_array().map(|c| (c * 1e5).round() as i64);
        let index = *known.entry(rounded).or_insert_with(|| {
            table.push(triple(DVec3::from_array(rounded.map(|c| c as f64 / 1e5))));
            table.len() - 1
        });
        which.push(index.to_string());
    }
    usda.set_each("normal3f[] primvars:normals", &list(table), "faceVarying");
    usda.set("int[] primvars:normals:indices", &list(which));
}

/// Points and faces of a surface with one point to a place: what differs from corner to corner is
/// told by corner, and bodies that touch keep points of their own.
fn merged(mesh: &Mesh) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let written = |v: &DVec3| (v.as_vec3() + 0.0).to_array().map(f32::to_bits);
    let (mut number, mut positions) = (BTreeMap::new(), Vec::new());
    let mut place = |v: &DVec3| {
        *number.entry(written(v)).or_insert_with(|| {
            positions.push(*v);
            positions.len() as u32 - 1
        })
    };
    let place_of: Vec<u32> = mesh.vertices().iter().map(&mut place).collect();
    let places: Vec<_> = mesh.faces().iter().map(|f| f.map(|v| place_of[v as usize])).collect();
    let faces = points_of(&positions, &places, mesh.faces());
    let count = faces.iter().flatten().max().map_or(0, |&last| last as usize + 1);
    let mut points = vec![DVec3::ZERO; count];
    for (point, vertex) in faces.iter().flatten().zip(mesh.faces().iter().flatten()) {
        points[*point as usize] = mesh.vertices()[*vertex as usize];
    }
    (points, faces)
}

fn write_pieces(
    usda: &mut Usda,
    (asset, runtimes): (&Asset, &[Runtime]),
    link: &Link,
    body: &LinkBody,
) {
    let own = Words::of(runtimes, Runtime::collider);
    let mut applied = vec!["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "MaterialBindingAPI"];
    applied.extend(own.schemas.iter().map(String::as_str));
    let material = format!("<{}>", asset.path_of_material(link));
    for (index, piece) in body.collision.iter().enumerate() {
        // A piece that is no mesh has nothing to collide with.
        let Ok(mesh) = Mesh::new(piece.vertices.clone(), piece.faces.clone()) else { continue };
        usda.prim("Mesh", &format!("piece_{index:02}"), &[schemas(&applied)], |usda| {
            usda.set("rel material:binding:physics", &material);
            usda.set("uniform token physics:approximation", "\"convexHull\"");
            usda.set("uniform token purpose", "\"guide\"");
            write_surface(usda, &mesh, write_normals);
        });
    }
}

/// Linear light of an sRGB colour.
fn light(srgb: [f64; 3]) -> DVec3 {
    DVec3::from_array(srgb.map(linear_of_srgb))
}

/// The link's mean colour in linear light.
fn plain(body: &LinkBody) -> String {
    let [r, g, b, _] = body.colour.value;
    triple(light([r, g, b]))
}

fn write_material(usda: &mut Usda, asset: &Asset, link: &Link, body: &LinkBody) {
    let path = asset.path_of_material(link);
    let applied = ["PhysicsMaterialAPI", "SemanticsLabelsAPI:material"];
    usda.prim("Material", &link.name, &[schemas(&applied)], |usda| {
        let made_of = tokens(&[&body.substance.material.value]);
        usda.set("token[] semantics:labels:material", &made_of);
        let friction = float(body.substance.friction.value);
        usda.set("float physics:dynamicFriction", &friction);
        usda.set("float physics:restitution", "0");
        usda.set("float physics:staticFriction", &friction);
        usda.set("token outputs:surface.connect", &format!("<{path}/surface.outputs:surface>"));
        let is_painted = body.visual.colours().is_some();
        usda.prim("Shader", "surface", &[], |usda| {
            usda.set("uniform token info:id", "\"UsdPreviewSurface\"");
            if is_painted {
                let from = format!("<{path}/colour.outputs:result>");
                usda.set("color3f inputs:diffuseColor.connect", &from);
            } else {
                usda.set("color3f inputs:diffuseColor", &plain(body));
            }
            usda.set("float inputs:metallic", "0");
            usda.set("float inputs:opacity", &float(body.colour.value[3]));
            usda.set("float inputs:roughness", "0.8");
            usda.line("token outputs:surface");
        });
        if is_painted {
            usda.prim("Shader", "colour", &[], |usda| {
                usda.set("uniform token info:id", "\"UsdPrimvarReader_float3\"");
                usda.set("string inputs:varname", "\"displayColor\"");
                usda.line("float3 outputs:result");
            });
        }
    });
}

fn write_joint(usda: &mut Usda, asset: &Asset, joint: &Joint, runtimes: &[Runtime]) {
    let [body0, body1] = [joint.parent, joint.child].map(|l| asset.path_of_link(l));
    let axis = joint.motion.as_ref().map_or(DVec3::X, |m| m.axis.value);
    let turn = quaternion(DQuat::from_rotation_arc(DVec3::X, axis));
    let (kind, drive) = kind_and_drive(joint);
    let moves = drive.zip(joint.motion.as_ref());
    let own = moves.map(|(drive, motion)| {
        let inertia = inertia(asset, joint);
        Words::of(runtimes, |runtime| runtime.joint(drive, motion, inertia))
    });
    let driven = drive.map(|d| format!("PhysicsDriveAPI:{d}"));
    let mut applied: Vec<&str> = driven.iter().map(String::as_str).collect();
    applied.extend(own.iter().flat_map(|w| &w.schemas).map(String::as_str));
    let applied = (!applied.is_empty()).then(|| schemas(&applied));
    usda.prim(kind, &joint.name, applied.as_slice(), |usda| {
        usda.set("rel physics:body0", &body0);
        usda.set("rel physics:body1", &body1);
        usda.set("point3f physics:localPos0", &triple(joint.origin.value));
        usda.set("point3f physics:localPos1", "(0, 0, 0)");
        usda.set("quatf physics:localRot0", &turn);
        usda.set("quatf physics:localRot1", &turn);
        if let Some((drive, motion)) = moves {
            write_motion(usda, drive, motion);
        }
        let values = own.iter().flat_map(|w| &w.values);
        values.for_each(|(name, value)| usda.set(name, value));
    });
}

/// The type of a joint's prim, and the name of its drive.
pub(crate) fn kind_and_drive(joint: &Joint) -> (&'static str, Option<&'static str>) {
    match joint.kind {
        JointType::Fixed => ("PhysicsFixedJoint", None),
        JointType::Revolute | JointType::Continuous => ("PhysicsRevoluteJoint", Some("angular")),
        JointType::Prismatic => ("PhysicsPrismaticJoint", Some("linear")),
    }
}

/// Axis, limits and drive. USD counts a turn in degrees, and its damping likewise.
fn write_motion(usda: &mut Usda, drive: &str, motion: &Motion) {
    let unit = if drive == "angular" { 1.0_f64.to_degrees() } else { 1.0 };
    usda.set("uniform token physics:axis", "\"X\"");
    if let Some([lower, upper]) = &motion.limits {
        usda.set("float physics:lowerLimit", &float(lower.value * unit));
        usda.set("float physics:upperLimit", &float(upper.value * unit));
    }
    let mut of_drive = |kind: &str, name: &str, value: &str| {
        usda.set(&format!("{kind} drive:{drive}:physics:{name}"), value);
    };
    of_drive("float", "damping", &float(motion.damping.value / unit));
    of_drive("float", "maxForce", &float(motion.effort.value));
    of_drive("float", "stiffness", "0");
    of_drive("float", "targetVelocity", "0");
    of_drive("uniform token", "type", "\"force\"");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{block, joined};

    #[test]
    fn corners_of_two_colours_are_one_point_but_bodies_that_touch_keep_their_own() {
        let cube = block(DVec3::ONE, DVec3::ZERO);
        let apart: Vec<_> = (0..12).map(|f| cube.corners(f)).collect();
        let split = Mesh::of_triangles(&apart).unwrap();
        let (points, faces) = merged(&split);
        assert_eq!((points.len(), faces.len()), (8, 12));
        let two = joined(&[cube, block(DVec3::ONE, DVec3::X)]);
        assert_eq!(merged(&two).0.len(), 16);
    }
}
