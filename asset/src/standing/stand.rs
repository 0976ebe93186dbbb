//! How the object stands: weighted, turned a little, its feet made level, so that it comes to rest
//! as it is shown.
//!
//! Nobody sees masses in a photo, and a generator's floor is not quite level. But what is shown
//! standing stands:
//!
//! - Where the guessed masses would tip it over, they are guessed again. Masses that somebody
//!   stated stay.
//! - Where it would lean once dropped, it is turned by that much.
//! - Where it would rock on uneven feet, the feet of its collision pieces are made level.

use std::ops::Range;

use glamx::{DMat3, DQuat, DVec3};
use object::articulated::ObjectError;
use object::mesh::{Bounds, MeshError};
use object::{ArticulatedObject, JointMotion, KinematicTree, Mesh};

use crate::change::Change;
use crate::collision::piece::ConvexPiece;
use crate::collision::quickhull::{Hull, hull};
use crate::error::{AssetError, whole_surface};
use crate::mass::weigh::{Body, DENSITY};
use crate::parts::{Parts, motions};
use crate::standing::ground::{Edge, Foot, GRAVITY, Ground};
use crate::surface::repaired::Surface;

/// How far inside the outline of its feet the centre of mass must be, as a share of the diagonal,
/// for an object to stay as it is shown. Another stance, or other masses, aim at the larger value.
const ENOUGH: f64 = 0.01;
const AIM: f64 = 0.03;
/// No more is asked for than this share of what any masses could bring.
const SHARE: f64 = 0.5;
/// A mass that is guessed again becomes at most this many times as much, or as little.
const MOST: f64 = 4.0;
/// One step of guessing, and how many there are.
const STEP: f64 = 1.05;
const STEPS: usize = 60;
/// What leans less is left alone, and what leans further would be called tipped over, radians.
const LEANS: [f64; 2] = [0.017, 0.166];
/// Feet are level where what touches the ground exactly holds the centre of mass this well, as a share
/// of how well what nearly touches it would.
const LEVEL: f64 = 0.8;
const WHY: &str = "what is shown standing stands (S2)";

/// Masses with which the object stands where those guessed before would let it tip, or as nearly as
/// they can; altered ones are returned as changes.
pub(crate) fn weighted(
    tree: &KinematicTree,
    pieces: &[Vec<ConvexPiece>],
    bodies: &mut [Body],
    stated: &[bool],
) -> Vec<Change> {
    let ground = Ground::new(pieces);
    let edges = ground.edges(DVec3::NEG_Z);
    let aim = (AIM * ground.diagonal).min(SHARE * room(&edges));
    let stands = ground.margin(DVec3::NEG_Z, centre(bodies)) >= aim;
    if stands || leaning(&ground, centre(bodies)).is_some() {
        return Vec::new();
    }
    let masses = guessed(&edges, bodies, stated, aim);
    let mut changes = Vec::new();
    for (part, (body, now)) in bodies.iter_mut().zip(masses).enumerate() {
        let was = body.mass.value;
        if was != now {
            body.mass.value = now;
            let (was, now) = (format!("{was:.6} kg"), format!("{now:.6} kg"));
            body.mass.how.push_str(&format!("; changed from {was}: {WHY}"));
            let name = &tree.parts()[part].name;
            changes.push(Change::new(name, "mass", was, now, WHY));
        }
    }
    changes
}

/// Half the least breadth of an outline, metres: no place is farther inside.
fn room(edges: &[Edge]) -> f64 {
    let breadth =
        |e: &Edge| edges.iter().map(|other| e.inside(other.from)).fold(0.0, f64::max) / 2.0;
    edges.iter().map(breadth).min_by(f64::total_cmp).unwrap_or(0.0)
}

/// Masses that bring the centre of all inside every edge by `aim` metres, or as near to that as they
/// can.
fn guessed(edges: &[Edge], bodies: &[Body], stated: &[bool], aim: f64) -> Vec<f64> {
    let masses = |bodies: &[Body]| bodies.iter().map(|b| b.mass.value).collect::<Vec<f64>>();
    let mut bodies = bodies.to_vec();
    let first = masses(&bodies);
    let mut best = (f64::NEG_INFINITY, first.clone());
    for _ in 0..=STEPS {
        let middle = centre(&bodies);
        let Some(worst) = edges.iter().min_by(|a, b| a.inside(middle).total_cmp(&b.inside(middle)))
        else {
            break;
        };
        if worst.inside(middle) > best.0 {
            best = (worst.inside(middle), masses(&bodies));
        }
        if best.0 >= aim {
            break;
        }
        for (part, body) in bodies.iter_mut().enumerate().filter(|(p, _)| !stated[*p]) {
            let was = body.mass.value;
            let heaviest = (MOST * first[part]).min(DENSITY[1] * body.volume.value).max(was);
            let lightest = (first[part] / MOST).max(body.least).min(was);
            let helps = worst.inside(body.centre) > aim;
            body.mass.value =
                if helps { (was * STEP).min(heaviest) } else { (was / STEP).max(lightest) };
        }
    }
    best.1
}

/// The parts set down on the side they would come to rest on, the turn that took, and by how much they
/// were moved behind it, metres.
///
/// # Errors
/// [`AssetError`] if the result breaks a rule of articulated objects.
pub(crate) fn upright(parts: Parts) -> Result<(Parts, DQuat, DVec3), AssetError> {
    let Some(turn) = leaning(&Ground::new(&parts.pieces), centre(&parts.bodies)) else {
        return Ok((parts, DQuat::IDENTITY, DVec3::ZERO));
    };
    let (parts, shift) = parts.turned(turn)?;
    Ok((parts, turn, shift))
}

/// The turn that sets an object down on the side it would come to rest on; `middle` is its centre
/// of mass. `None` if it stands as it is, or if that side is not near. Of the near sides, it is the
/// nearest on which the object stands firmly, or else the firmest.
fn leaning(ground: &Ground, middle: DVec3) -> Option<DQuat> {
    if ground.margin(DVec3::NEG_Z, middle) >= ENOUGH * ground.diagonal {
        return None;
    }
    let [least, most] = LEANS;
    let margin = |side: &(f64, DVec3)| ground.margin(side.1, middle) / ground.diagonal;
    let sides = ground.sides(middle, most);
    let firm = sides.iter().find(|s| margin(s) >= AIM);
    let firmest = || {
        let stable = sides.iter().filter(|s| margin(s) >= ENOUGH);
        stable.max_by(|a, b| margin(a).total_cmp(&margin(b)))
    };
    let &(lean, down) = firm.or_else(firmest)?;
    (lean >= least).then(|| DQuat::from_rotation_arc(down, DVec3::NEG_Z))
}

/// Sets what nearly touches the ground on it where an object stands a good deal more firmly on all of
/// that than on what touches it exactly; each part altered is returned as a change.
pub(crate) fn levelled(
    object: &ArticulatedObject,
    pieces: &mut [Vec<ConvexPiece>],
    bodies: &[Body],
) -> Vec<Change> {
    let ground = Ground::new(pieces);
    let middle = centre(bodies);
    let [margin, firm] =
        [Ground::margin, Ground::firm_margin].map(|margin| margin(&ground, DVec3::NEG_Z, middle));
    if margin < ENOUGH * ground.diagonal || firm >= LEVEL * margin {
        return Vec::new();
    }
    let touching = ground.touching();
    let mut changes = Vec::new();
    for (part, pieces) in pieces.iter_mut().enumerate() {
        let raised = pieces.iter_mut().map(|piece| lowered(piece, &touching));
        let most = raised.fold(0.0, f64::max);
        if most > 0.0 {
            let name = &object.tree().parts()[part].name;
            let before = format!("feet up to {:.2} mm above the ground", 1000.0 * most);
            changes.push(Change::new(name, "collision", before, "level feet".into(), WHY));
        }
    }
    changes
}

/// Sets the corners of a piece within `layer`, heights in metres, on the lower end of that; how far the
/// highest of them was above it, metres, 0 where nothing was done. What would become flat stays.
fn lowered(piece: &mut ConvexPiece, layer: &Range<f64>) -> f64 {
    let is_foot = |v: &&DVec3| layer.contains(&v.z);
    let most = piece.vertices.iter().filter(is_foot).map(|v| v.z - layer.start).fold(0.0, f64::max);
    if most <= 0.0 {
        return 0.0;
    }
    let set = |v: &DVec3| if layer.contains(&v.z) { v.with_z(layer.start) } else { *v };
    let corners: Vec<DVec3> = piece.vertices.iter().map(set).collect();
    let Some(Hull { vertices, faces }) = hull(&corners, corners.len(), 0.0) else { return 0.0 };
    *piece = ConvexPiece { vertices, faces };
    most
}

/// What is said of a turn.
pub(crate) fn told(turn: DQuat) -> Change {
    let angle = 2.0 * turn.w.abs().min(1.0).acos().to_degrees();
    let (before, after) = ("as in the mesh".into(), format!("turned by {angle:.1} deg"));
    Change::new("", "stance", before, after, WHY)
}

/// What stands on the ground, and with what force.
pub(crate) fn feet(pieces: &[Vec<ConvexPiece>], bodies: &[Body]) -> Vec<Foot> {
    let mass: f64 = bodies.iter().map(|b| b.mass.value).sum();
    Ground::new(pieces).feet(mass * GRAVITY, centre(bodies))
}

fn centre(bodies: &[Body]) -> DVec3 {
    let mass: f64 = bodies.iter().map(|b| b.mass.value).sum();
    bodies.iter().map(|b| b.centre * b.mass.value).sum::<DVec3>() / mass
}

impl Parts {
    /// Everything turned about the origin, and set down again with the root's base centred at x = y = 0
    /// and the lowest point at z = 0; also by how much it was moved then, metres.
    ///
    /// # Errors
    /// [`AssetError`] if the result breaks a rule of articulated objects.
    fn turned(self, turn: DQuat) -> Result<(Self, DVec3), AssetError> {
        let root = self.object.tree().root();
        let turned = |v: &DVec3| turn * *v;
        let all = || self.surfaces.iter().flat_map(|s| s.mesh.vertices()).map(turned);
        let base = Bounds::of(self.surfaces[root].mesh.vertices().iter().map(turned)).centre();
        let shift = -base.with_z(Bounds::of(all()).min.z);
        let rigid = Rigid { turn, shift };
        let mesh = |m: &Mesh| rigid.mesh(m).map_err(whole_surface);
        let surface = |s: Surface| Ok(Surface { mesh: mesh(&s.mesh)?, ..s });
        let piece = |p: ConvexPiece| ConvexPiece {
            vertices: p.vertices.into_iter().map(|v| rigid.point(v)).collect(),
            ..p
        };
        let wanted = self.wanted.iter().map(|of| of.iter().map(|m| rigid.motion(m)).collect());
        let parts = Self {
            object: rigid.object(&self.object)?,
            wanted: wanted.collect(),
            seen: self.seen.iter().map(mesh).collect::<Result<_, _>>()?,
            surfaces: self.surfaces.into_iter().map(surface).collect::<Result<_, AssetError>>()?,
            pieces: self.pieces.into_iter().map(|of| of.into_iter().map(piece).collect()).collect(),
            bodies: self.bodies.into_iter().map(|b| rigid.body(b)).collect(),
            ..self
        };
        Ok((parts, shift))
    }
}

/// A turn about the origin and a shift behind it.
#[derive(Clone, Copy)]
struct Rigid {
    turn: DQuat,
    shift: DVec3,
}

impl Rigid {
    fn point(&self, v: DVec3) -> DVec3 {
        self.turn * v + self.shift
    }

    fn mesh(&self, mesh: &Mesh) -> Result<Mesh, MeshError> {
        mesh.map_vertices(|v| self.point(v))
    }

    fn motion(&self, m: &JointMotion) -> JointMotion {
        JointMotion {
            axis: (self.turn * m.axis).normalize_or(m.axis),
            pivot: self.point(m.pivot),
            ..*m
        }
    }

    fn object(&self, of: &ArticulatedObject) -> Result<ArticulatedObject, AssetError> {
        let mesh = self.mesh(of.mesh()).map_err(whole_surface)?;
        let motions = motions(of);
        let moved = motions.iter().map(|ms| ms.iter().map(|m| self.motion(m)).collect());
        let labels = of.part_of_face().to_vec();
        let made: Result<_, ObjectError> =
            ArticulatedObject::new(mesh, of.tree().clone(), labels, moved.collect());
        Ok(made?)
    }

    fn body(&self, body: Body) -> Body {
        let turn = DMat3::from_quat(self.turn);
        let covariance = turn * body.covariance * turn.transpose();
        Body { centre: self.point(body.centre), covariance, ..body }
    }
}
