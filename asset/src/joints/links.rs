//! Links and joints of the asset: frames at the pivots, carriers between two joints of one part.

use glamx::{DMat3, DVec3};
use object::{ArticulatedObject, JointKind, JointMotion, Mesh, Origin, Range, Sourced};

use crate::asset::{Inertial, Joint, JointType, Link, LinkBody, Motion};
use crate::collision::piece::ConvexPiece;
use crate::joints::drive::{Load, drive};
use crate::joints::pivots::Pivots;
use crate::mass::balance::CARRIER_SHARE;
use crate::mass::moments::inertia_of;
use crate::mass::weigh::Body;
use crate::parts::Parts;
use crate::standing::ground::Foot;
use crate::standing::stand;
use crate::surface::repaired::Surface;

/// Colour of a part nobody coloured.
const CLAY: [f64; 4] = [0.75, 0.74, 0.72, 1.0];
/// Words of parts that are made to be gripped.
const GRIPS: &[&str] = &["handle", "knob", "grip", "lever", "button", "pull", "crank", "latch"];

/// The links and joints of the parts.
pub(crate) fn assemble(parts: Parts, origin: Origin) -> (Vec<Link>, Vec<Joint>) {
    let names = Names::of(&parts.object);
    let pivots = Pivots::new(&parts.object, &parts.surfaces);
    let feet = stand::feet(&parts.pieces, &parts.bodies);
    let mut builder =
        Builder { parts: &parts, origin, names, pivots, feet, links: vec![], joints: vec![] };
    let mut link_of = vec![0; parts.object.tree().len()];
    for &part in parts.object.tree().root_first() {
        let parent = parts.object.tree().parent(part).map(|p| (p, link_of[p]));
        link_of[part] = builder.add(part, parent);
    }
    (builder.links, builder.joints)
}

/// Names in use, so that every link and joint gets one of its own.
struct Names(Vec<String>);

impl Names {
    fn of(object: &ArticulatedObject) -> Self {
        Self(object.tree().parts().iter().map(|p| p.name.clone()).collect())
    }

    fn fresh(&mut self, base: &str, suffix: &str) -> String {
        let name = format!("{base}_{suffix}");
        let numbered = (2..).map(|n| format!("{name}_{n}"));
        let mut candidates = std::iter::once(name.clone()).chain(numbered);
        let is_free = |n: &String| !self.0.iter().any(|t| t.eq_ignore_ascii_case(n));
        let fresh = candidates.find(is_free).unwrap_or(name);
        self.0.push(fresh.clone());
        fresh
    }
}

struct Builder<'a> {
    parts: &'a Parts,
    origin: Origin,
    names: Names,
    pivots: Pivots,
    feet: Vec<Foot>,
    links: Vec<Link>,
    joints: Vec<Joint>,
}

impl Builder<'_> {
    /// Adds a part's link, its joints and the carrier between them; returns the link's index.
    fn add(&mut self, part: usize, parent: Option<(usize, usize)>) -> usize {
        let Some((parent_part, parent)) = parent else {
            return self.link(part, DVec3::ZERO, 1.0);
        };
        let (pair, child) = ([part, parent_part], &self.parts.surfaces[part].mesh);
        let frame_of =
            |index: usize, m: &JointMotion| match self.parts.given.joint(part, index).pivot {
                Some(_) => m.pivot,
                None => self.pivots.settle(m, pair, child),
            };
        match self.parts.object.joints(part) {
            [] => {
                let frame = self.pivots.contact(pair, child);
                let link = self.link(part, frame, 1.0);
                self.fixed(part, parent, link)
            }
            [only] => {
                let frame = frame_of(0, only);
                let link = self.link(part, frame, 1.0);
                self.moving(part, 0, parent, link)
            }
            [first, .., last] => {
                let (first, last) = (frame_of(0, first), frame_of(1, last));
                let carrier = self.carrier(part, first);
                self.moving(part, 0, parent, carrier);
                let link = self.link(part, last, 1.0 - CARRIER_SHARE);
                self.moving(part, 1, carrier, link)
            }
        }
    }

    fn link(&mut self, part: usize, frame: DVec3, share: f64) -> usize {
        let p = self.parts;
        let described = &p.object.tree().parts()[part];
        let body = LinkBody {
            visual: shifted(&p.seen[part], frame),
            repaired: p.surfaces[part].report,
            colour: colour(&p.surfaces[part]),
            collision: p.pieces[part].iter().map(|c| shifted_piece(c, frame)).collect(),
            substance: p.substances[part].clone(),
            volume: p.bodies[part].volume.clone(),
            graspable: is_grip(&described.text),
        };
        self.push(Link {
            name: described.name.clone(),
            part,
            label: described.text.clone(),
            frame,
            inertial: inertial(&p.bodies[part], frame, share),
            body: Some(body),
        })
    }

    fn carrier(&mut self, part: usize, frame: DVec3) -> usize {
        let described = &self.parts.object.tree().parts()[part];
        let name = self.names.fresh(&described.name, "carrier");
        let inertial = inertial(&self.parts.bodies[part], frame, CARRIER_SHARE);
        let label = format!("carrier of {}", described.text);
        self.push(Link { name, part, label, frame, inertial, body: None })
    }

    fn push(&mut self, link: Link) -> usize {
        self.links.push(link);
        self.links.len() - 1
    }

    fn fixed(&mut self, part: usize, parent: usize, child: usize) -> usize {
        let base = &self.parts.object.tree().parts()[part].name;
        let name = self.names.fresh(base, "fixed");
        let origin = self.origin_of(parent, child);
        self.joints.push(Joint {
            name,
            kind: JointType::Fixed,
            parent,
            child,
            origin: Sourced::new(origin, Origin::Measured, "point nearest the parent"),
            motion: None,
        });
        child
    }

    fn origin_of(&self, parent: usize, child: usize) -> DVec3 {
        self.links[child].frame - self.links[parent].frame
    }

    fn moving(&mut self, part: usize, index: usize, parent: usize, child: usize) -> usize {
        let motion = self.parts.object.joints(part)[index];
        let base = &self.parts.object.tree().parts()[part].name;
        let (kind, suffix) = match motion.kind {
            JointKind::Revolute => (JointType::Revolute, "turn"),
            JointKind::Continuous => (JointType::Continuous, "turn"),
            JointKind::Prismatic => (JointType::Prismatic, "slide"),
        };
        let name = self.names.fresh(base, suffix);
        let moved = self.links[child].frame != motion.pivot;
        let (source, how) = match (self.parts.given.joint(part, index).pivot, moved) {
            (Some(_), _) => (Origin::User, "given pivot"),
            (None, true) => (self.origin, "moved along the joint to near both parts"),
            (None, false) => (self.origin, "fitted pivot"),
        };
        let origin = Sourced::new(self.origin_of(parent, child), source, how);
        let motion = Some(self.motion(part, index, &motion));
        self.joints.push(Joint { name, kind, parent, child, origin, motion });
        child
    }

    fn motion(&self, part: usize, index: usize, motion: &JointMotion) -> Motion {
        let loads = self.loads(part);
        let tree = self.parts.object.tree();
        let under = |f: &&Foot| tree.is_under(f.part, part);
        let feet: Vec<Foot> = self.feet.iter().filter(under).copied().collect();
        let drive = drive(motion, &loads, &feet);
        let wanted = self.parts.wanted[part][index].range;
        let given = self.parts.given.joint(part, index);
        let axis = match given.axis {
            Some(_) => Sourced::new(motion.axis, Origin::User, "given axis"),
            None => Sourced::new(motion.axis.normalize(), self.origin, "fitted axis"),
        };
        let said = |value: Option<f64>, rule: Sourced<f64>| {
            value.map_or(rule, |value| Sourced::new(value, Origin::User, "given"))
        };
        Motion {
            axis,
            limits: self.limits(motion.range, wanted, self.parts.given.ends(part, index)),
            effort: said(given.effort, drive.effort),
            velocity: drive.velocity,
            damping: said(given.damping, drive.damping),
            friction: drive.friction,
        }
    }

    fn limits(
        &self,
        range: Range,
        wanted: Range,
        [lower_given, upper_given]: [bool; 2],
    ) -> Option<[Sourced<f64>; 2]> {
        let Range::Limits { lower, upper } = range else { return None };
        let (was_lower, was_upper) = wanted.ends();
        let end = |now: f64, was: f64, is_given: bool| {
            if is_given {
                return Sourced::new(now, Origin::User, "given range");
            }
            if now == was {
                return Sourced::new(now, self.origin, "fitted range");
            }
            Sourced::new(now, Origin::Measured, format!("free of contact; fitted was {was:.4}"))
        };
        Some([end(lower, was_lower, lower_given), end(upper, was_upper, upper_given)])
    }

    /// Everything that moves with a part: the part and what hangs below it.
    fn loads(&self, part: usize) -> Vec<Load> {
        let tree = self.parts.object.tree();
        let under = (0..tree.len()).filter(|&p| tree.is_under(p, part));
        under.map(|p| load(&self.parts.bodies[p])).collect()
    }
}

fn load(body: &Body) -> Load {
    let mass = body.mass.value;
    Load { mass, centre: body.centre, inertia: inertia_of(body.covariance, mass) }
}

fn inertial(body: &Body, frame: DVec3, share: f64) -> Inertial {
    let mass = body.mass.value * share;
    let inertia = tidy(inertia_of(body.covariance, mass));
    let mut how = body.mass.how.clone();
    if share < 1.0 {
        how.push_str(&format!("; {:.0} % of the part's mass", share * 100.0));
    }
    Inertial {
        mass: Sourced::new(mass, body.mass.origin, how),
        centre: Sourced::new(body.centre - frame, Origin::Measured, "uniform density"),
        inertia: Sourced::new(inertia, Origin::Measured, "uniform density, scaled to the mass"),
    }
}

/// The tensor without products that are rounding noise.
fn tidy(m: DMat3) -> DMat3 {
    let noise = 1e-12 * (m.x_axis.x + m.y_axis.y + m.z_axis.z);
    let keep = |v: f64| if v.abs() <= noise { 0.0 } else { v };
    let [xy, xz, yz] = [keep(m.x_axis.y), keep(m.x_axis.z), keep(m.y_axis.z)];
    DMat3::from_cols(
        DVec3::new(m.x_axis.x, xy, xz),
        DVec3::new(xy, m.y_axis.y, yz),
        DVec3::new(xz, yz, m.z_axis.z),
    )
}

/// The surface in a frame whose origin is `frame`; a shift cannot break a mesh's rules.
fn shifted(mesh: &Mesh, frame: DVec3) -> Mesh {
    mesh.map_vertices(|v| v - frame).unwrap_or_else(|_| mesh.clone())
}

fn shifted_piece(piece: &ConvexPiece, frame: DVec3) -> ConvexPiece {
    let vertices = piece.vertices.iter().map(|&v| v - frame).collect();
    ConvexPiece { vertices, faces: piece.faces.clone() }
}

/// Mean colour by area, sRGB.
fn colour(surface: &Surface) -> Sourced<[f64; 4]> {
    let mesh = &surface.mesh;
    let clay = || Sourced::new(CLAY, Origin::Default, "no colour given");
    let Some(colours) = mesh.colours() else { return clay() };
    let (mut sum, mut total) = ([0.0; 4], 0.0);
    for (f, face) in mesh.faces().iter().enumerate() {
        let area = mesh.area(f);
        total += 3.0 * area;
        for c in face.map(|v| colours[v as usize]) {
            sum.iter_mut().zip(c).for_each(|(s, c)| *s += area * f64::from(c));
        }
    }
    if total <= 0.0 {
        return clay();
    }
    let mean = sum.map(|s| (s / total / 255.0 * 1e4).round() / 1e4);
    Sourced::new(mean, Origin::Measured, "mean over the surface")
}

fn is_grip(text: &str) -> bool {
    let text = text.to_lowercase();
    text.split(|c: char| !c.is_alphanumeric())
        .any(|t| GRIPS.contains(&t.strip_suffix('s').unwrap_or(t)))
}
