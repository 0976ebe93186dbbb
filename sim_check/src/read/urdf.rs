//! A `<robot>` element → links and joints, with every broken rule listed, not only the first.

use glamx::{DMat3, DPose3, DQuat, DVec3};
use roxmltree::Node;

use crate::read::draft::{Draft, JointDraft, MAX_LINKS, MAX_SHAPES, MimicDraft};
use crate::read::xml::Reader;
use crate::robot::{Dynamics, Geometry, Inertial, Joint, Limit, Link, Motion, Shape};

impl Reader<'_> {
    /// Reads a `<robot>` element.
    pub(crate) fn robot(&mut self, root: Node, draft: &mut Draft) {
        draft.name = root.attribute("name").unwrap_or_default().trim().to_owned();
        if draft.name.is_empty() {
            self.faults.names.push("the robot has no name".into());
        }
        self.find_macros(root);
        let of_kind = |tag: &'static str| {
            root.children().filter(move |n| n.has_tag_name(tag)).collect::<Vec<_>>()
        };
        let (links, joints) = (of_kind("link"), of_kind("joint"));
        if links.len().max(joints.len()) > MAX_LINKS {
            let (l, j) = (links.len(), joints.len());
            self.fault(root, format!("at most {MAX_LINKS} links and joints, found {l} and {j}"));
            return;
        }
        let is_shape = |n: &Node| n.has_tag_name("visual") || n.has_tag_name("collision");
        let shapes = root.descendants().filter(is_shape).count();
        if shapes > MAX_SHAPES {
            self.fault(root, format!("at most {MAX_SHAPES} shapes, found {shapes}"));
            return;
        }
        draft.links = links.into_iter().map(|n| self.link(n)).collect();
        draft.joints = joints.into_iter().map(|n| self.joint(n)).collect();
        self.check_names("link", draft.links.iter().map(|l| (l.name.as_str(), l.line)));
        self.check_names(
            "joint",
            draft.joints.iter().map(|j| (j.joint.name.as_str(), j.joint.line)),
        );
    }

    fn find_macros(&mut self, root: Node) {
        let is_macro = |n: &Node| n.tag_name().namespace().is_some_and(|s| s.contains("xacro"));
        if let Some(node) = root.descendants().find(is_macro) {
            self.fault(node, "a macro of xacro; expand it first");
        }
    }

    fn link(&mut self, node: Node) -> Link {
        let shapes = |this: &mut Self, tag: &str| {
            let of_tag = node.children().filter(|n| n.has_tag_name(tag));
            of_tag.map(|n| this.shape(n)).collect::<Vec<_>>()
        };
        Link {
            name: node.attribute("name").unwrap_or_default().to_owned(),
            inertial: self.only(node, "inertial").map(|n| self.inertial(n)),
            visuals: shapes(self, "visual"),
            collisions: shapes(self, "collision"),
            line: self.line(node),
        }
    }

    fn inertial(&mut self, node: Node) -> Inertial {
        let origin = self.origin(node);
        let mass = self.required(node, "mass").map_or(0.0, |n| self.number(n, "value"));
        let inertia = self.required(node, "inertia").map_or(DMat3::ZERO, |n| self.inertia(n));
        Inertial { origin, mass, inertia, line: self.line(node) }
    }

    fn inertia(&mut self, node: Node) -> DMat3 {
        let [xx, yy, zz, xy, xz, yz] =
            ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"].map(|a| self.number(node, a));
        let column = DVec3::new;
        DMat3::from_cols(column(xx, xy, xz), column(xy, yy, yz), column(xz, yz, zz))
    }

    fn shape(&mut self, node: Node) -> Shape {
        let origin = self.origin(node);
        let line = self.line(node);
        let mut shape = Shape {
            origin,
            geometry: Geometry::Unread { reason: format!("line {line}: no geometry") },
            scale: DVec3::ONE,
            source: String::new(),
            line,
        };
        let Some(geometry) = self.required(node, "geometry") else { return shape };
        let kinds: Vec<_> = geometry.children().filter(Node::is_element).collect();
        let &[kind] = &kinds[..] else {
            self.fault(geometry, format!("expected one shape, found {}", kinds.len()));
            return shape;
        };
        self.fill_geometry(kind, &mut shape);
        shape
    }

    fn fill_geometry(&mut self, kind: Node, shape: &mut Shape) {
        shape.source = kind.tag_name().name().to_owned();
        shape.geometry = match shape.source.as_str() {
            "box" => Geometry::Box { size: self.vector(kind, "size", None) },
            "sphere" => Geometry::Sphere { radius: self.length(kind, "radius") },
            "cylinder" => Geometry::Cylinder {
                radius: self.length(kind, "radius"),
                length: self.length(kind, "length"),
            },
            "mesh" => {
                shape.scale = self.vector(kind, "scale", Some(DVec3::ONE));
                shape.source = kind.attribute("filename").unwrap_or_default().to_owned();
                self.mesh(kind, shape)
            }
            other => {
                self.fault(
                    kind,
                    format!("expected box, cylinder, sphere or mesh, found `{other}`"),
                );
                Geometry::Unread { reason: format!("geometry `{other}` is unknown") }
            }
        };
    }

    fn mesh(&mut self, node: Node, shape: &Shape) -> Geometry {
        let mut faults = Vec::new();
        let geometry = self.shelf.geometry(&shape.source, shape.scale, &mut faults);
        let line = self.line(node);
        self.faults.files.extend(faults.into_iter().map(|f| format!("line {line}: {f}")));
        geometry
    }

    fn joint(&mut self, node: Node) -> JointDraft {
        let axis_as_written =
            self.only(node, "axis").map_or(DVec3::X, |n| self.vector(n, "xyz", None));
        let kind = self.motion(node);
        let joint = Joint {
            name: node.attribute("name").unwrap_or_default().to_owned(),
            kind,
            parent: usize::MAX,
            child: usize::MAX,
            origin: self.origin(node),
            axis: axis_as_written.normalize_or_zero(),
            axis_as_written,
            limit: self.only(node, "limit").map(|n| self.limit(n)),
            dynamics: self.only(node, "dynamics").map(|n| self.dynamics(n)),
            mimic: None,
            line: self.line(node),
        };
        let parent = self.link_name(node, "parent");
        let child = self.link_name(node, "child");
        let mimic = self.only(node, "mimic").map(|n| self.mimic(n));
        JointDraft { joint, parent, child, mimic }
    }

    fn motion(&mut self, node: Node) -> Motion {
        match node.attribute("type").unwrap_or_default() {
            "fixed" => Motion::Fixed,
            "revolute" => Motion::Revolute,
            "continuous" => Motion::Continuous,
            "prismatic" => Motion::Prismatic,
            "floating" => Motion::Floating,
            "planar" => Motion::Planar,
            other => {
                let at = self.at(node);
                self.faults.types.push(format!("{at}: joint type `{other}` is unknown"));
                Motion::Fixed
            }
        }
    }

    fn limit(&mut self, node: Node) -> Limit {
        Limit {
            lower: self.optional(node, "lower").unwrap_or(0.0),
            upper: self.optional(node, "upper").unwrap_or(0.0),
            effort: self.optional(node, "effort"),
            velocity: self.optional(node, "velocity"),
        }
    }

    fn dynamics(&mut self, node: Node) -> Dynamics {
        let damping = self.optional(node, "damping");
        Dynamics { damping, friction: self.optional(node, "friction") }
    }

    fn mimic(&mut self, node: Node) -> MimicDraft {
        MimicDraft {
            joint: node.attribute("joint").unwrap_or_default().to_owned(),
            multiplier: self.optional(node, "multiplier").unwrap_or(1.0),
            offset: self.optional(node, "offset").unwrap_or(0.0),
        }
    }

    fn link_name(&mut self, node: Node, tag: &str) -> String {
        let name = self.only(node, tag).and_then(|n| n.attribute("link"));
        if name.is_none() {
            let at = self.at(node);
            self.faults.references.push(format!("{at}: names no {tag} link"));
        }
        name.unwrap_or_default().to_owned()
    }

    /// `<origin>`: translation, then yaw about z, pitch about y, roll about x, as URDF has it.
    fn origin(&mut self, node: Node) -> DPose3 {
        let Some(origin) = self.only(node, "origin") else { return DPose3::identity() };
        let xyz = self.vector(origin, "xyz", Some(DVec3::ZERO));
        let rpy = self.vector(origin, "rpy", Some(DVec3::ZERO));
        let turn = DQuat::from_rotation_z(rpy.z)
            * DQuat::from_rotation_y(rpy.y)
            * DQuat::from_rotation_x(rpy.x);
        DPose3::from_parts(xyz, turn)
    }
}
