//! Axes, pivots and places of parts: `axis-…`, `pivot-off`, `part-…`, `joint-into-parent`, `below-floor`.

use glamx::{DPose3, DQuat, DVec3};
use sim_check::Subject;
use sim_check::read::source::Edit;
use sim_check::robot::Motion;

use super::language::Language;
use super::limits::{STILL, deep};
use super::model::{Model, Mover, Role, quoted};
use super::planted::{Made, first, made};
use super::touch::Solids;
use crate::fix::numbers::{short, triple};

const NO_AXIS: &str = "no joint with an axis stands in this file";

/// The edit that writes another axis.
fn axis(model: &Model, mover: &Mover, told: &str) -> Result<Edit, String> {
    let source = &model.source;
    Ok(match model.language {
        Language::Urdf => match source.child(mover.at, "axis") {
            Some(axis) => source.set(axis, "xyz", told),
            None => source.insert_last(mover.at, &format!("<axis xyz=\"{told}\"/>")),
        },
        Language::Mjcf => source.set(mover.at, "axis", told),
        Language::Sdf => model.text(model.child_of(mover.at, "axis")?, "xyz", told),
    })
}

fn retold(model: &Model, word: &str, of: impl Fn(&Mover) -> Result<DVec3, String>) -> Made {
    first(model.movers(word), NO_AXIS, |mover| {
        let (was, told) = (triple(mover.joint.axis_as_written), triple(of(&mover)?));
        let edit = axis(model, &mover, &told)?;
        let words = format!("axis {told} (was {was})");
        made(quoted("joint", &mover.joint.name), mover.joint.line, words, vec![edit])
    })
}

pub(super) fn zero(model: &Model, word: &str) -> Made {
    retold(model, word, |_| Ok(DVec3::ZERO))
}

pub(super) fn long(model: &Model, word: &str) -> Made {
    retold(model, word, |mover| Ok(2.0 * mover.joint.axis_as_written))
}

/// Its coordinates change places, so that it stands across.
pub(super) fn other_frame(model: &Model, word: &str) -> Made {
    retold(model, word, |mover| {
        let told = mover.joint.axis_as_written;
        let across = DVec3::new(told.z, told.x, told.y);
        match told.normalize_or_zero().dot(across.normalize_or_zero()).abs() < 0.5 {
            true => Ok(across),
            false => Err("its axis has no main direction".into()),
        }
    })
}

/// Turned round, where the part then goes into another one, and did not before.
pub(super) fn flipped(model: &Model, word: &str) -> Made {
    let (bound, solids) = (deep(model)?, Solids::of(&model.robot));
    retold(model, word, |mover| {
        let joint = mover.joint;
        let ends = joint.ends().filter(|_| joint.kind != Motion::Continuous);
        let (lower, upper) = ends.ok_or("it turns without limits")?;
        let most = |sign: f64| {
            let steps = (0..=8).map(|k| lower + (upper - lower) * f64::from(k) / 8.0);
            let deep = steps.map(|q| solids.depth(joint, joint.origin, joint.motion(sign * q)));
            deep.fold(0.0, f64::max)
        };
        match (most(1.0), most(-1.0)) {
            (now, then) if now < 0.2 * bound && then > bound => Ok(-joint.axis_as_written),
            _ => Err("turned round, no part meets another one".into()),
        }
    })
}

pub(super) fn missing(model: &Model, word: &str) -> Made {
    let default = if model.language == Language::Urdf { DVec3::X } else { DVec3::Z };
    first(model.movers(word), NO_AXIS, |mover| {
        if mover.joint.axis_as_written.normalize_or_zero().dot(default).abs() > 0.9 {
            return Err("every axis is the default one".into());
        }
        let source = &model.source;
        let edit = match model.language {
            Language::Urdf => source.remove(model.child_of(mover.at, "axis")?),
            Language::Mjcf => source.unset(mover.at, "axis").ok_or("its axis stands in a class")?,
            Language::Sdf => {
                let axis = model.child_of(mover.at, "axis")?;
                source.remove(model.child_of(axis, "xyz")?)
            }
        };
        made(quoted("joint", &mover.joint.name), mover.joint.line, "axis left out", vec![edit])
    })
}

/// The pivot of a hinge away from its parts; nothing moves at rest.
pub(super) fn pivot_off(model: &Model, word: &str) -> Made {
    let diagonal = model.diagonal()?;
    let hinges = model.movers(word).into_iter().filter(|m| m.joint.kind.turns());
    first(hinges, "no joint turns", |mover| {
        let joint = mover.joint;
        if joint.rest != 0.0 || joint.axis == DVec3::ZERO {
            return Err("it is not told from where it stands at rest".into());
        }
        let across = joint.axis.any_orthonormal_vector();
        let other = joint.axis.cross(across);
        let back = joint.origin.inverse();
        let own = model.points(joint.child);
        let parent = model.points(joint.parent);
        if own.is_empty() || parent.is_empty() {
            return Err("one of its parts has no shape".into());
        }
        let all: Vec<DVec3> =
            own.into_iter().chain(parent.iter().map(|p| back.transform_point(*p))).collect();
        let clear = |by: DVec3| {
            let apart = |p: &DVec3| (*p - by).cross(joint.axis).length();
            all.iter().map(apart).fold(f64::INFINITY, f64::min)
        };
        let tried = [across, -across, other, -other].map(|d| d * diagonal);
        let by = tried.into_iter().max_by(|a, b| clear(*a).total_cmp(&clear(*b)));
        let by = by.filter(|by| clear(*by) > 0.2 * diagonal).ok_or("its parts are all around")?;
        let words = format!("pivot moved by {} m", triple(by));
        made(quoted("joint", &joint.name), joint.line, words, pivoted(model, &mover, by)?)
    })
}

/// A joint moved in its own frame, and all that hangs on it moved back.
fn pivoted(model: &Model, mover: &Mover, by: DVec3) -> Result<Vec<Edit>, String> {
    let joint = mover.joint;
    if model.language == Language::Mjcf {
        return Ok(vec![model.moved(mover.at, DVec3::ZERO, by)?]);
    }
    let link = model.child(mover);
    let at = model.link_at(link).ok_or("its link has no element")?;
    let mut edits =
        vec![model.moved(mover.at, joint.origin.translation, joint.origin.rotation * by)?];
    for role in [Role::Visual, Role::Collision] {
        for (shape, at) in model.shapes(link, at, role) {
            edits.push(model.moved(at, shape.origin.translation, -by)?);
        }
    }
    if let (Some(inertial), Some(at)) = (link.inertial, model.source.child(at, "inertial")) {
        edits.push(model.moved(at, inertial.origin.translation, -by)?);
    }
    for next in model.robot.joints.iter().filter(|j| j.parent == joint.child) {
        let at = model.joint_at(next).ok_or("a joint below it has no element")?;
        edits.push(model.moved(at, next.origin.translation, -by)?);
    }
    Ok(edits)
}

/// Where the shapes of all links but those below a joint have their middle, in its parent's frame.
fn middle(model: &Model, mover: &Mover, below: bool) -> Option<DVec3> {
    let poses = model.robot.link_poses(&[]);
    let back = poses[mover.joint.parent].inverse();
    let links = (0..model.robot.links.len())
        .filter(|l| model.robot.is_under(*l, mover.joint.child) == below);
    let points: Vec<DVec3> = links
        .flat_map(|l| {
            let at = back * poses[l];
            model.points(l).into_iter().map(move |p| at.transform_point(p))
        })
        .collect();
    (!points.is_empty()).then(|| object::mesh::Bounds::of(points).centre())
}

pub(super) fn detached(model: &Model, word: &str) -> Made {
    let diagonal = model.diagonal()?;
    first(model.movers(word), NO_AXIS, |mover| {
        let (own, rest) = (middle(model, &mover, true), middle(model, &mover, false));
        let (own, rest) = own.zip(rest).ok_or("it or all else has no shape")?;
        let away = (own - rest).try_normalize().unwrap_or(DVec3::X);
        let by = away * diagonal;
        let edit = model.part_moved(&mover, by)?;
        let words = format!("moved by {} m", triple(by));
        let name = &model.child(&mover).name;
        made(quoted("link", name), model.child(&mover).line, words, vec![edit])
    })
}

pub(super) fn into_parent(model: &Model, word: &str) -> Made {
    let (bound, solids) = (deep(model)?, Solids::of(&model.robot));
    first(model.movers(word), NO_AXIS, |mover| {
        let joint = mover.joint;
        if solids.depth(joint, joint.origin, STILL) > 0.2 * bound {
            return Err("its part stands in another one already".into());
        }
        let (own, rest) = (middle(model, &mover, true), middle(model, &mover, false));
        let (own, rest) = own.zip(rest).ok_or("it or all else has no shape")?;
        let shares = (1..=8).map(|k| (rest - own) * (f64::from(k) / 8.0));
        let deep = |by: &DVec3| {
            let origin = DPose3::from_parts(joint.origin.translation + *by, joint.origin.rotation);
            solids.depth(joint, origin, STILL) > bound
        };
        let by = shares.into_iter().find(deep).ok_or("moved there, it meets nothing solid")?;
        let edit = model.part_moved(&mover, by)?;
        let words = format!("moved by {} m, into what it hangs on", triple(by));
        let name = &model.child(&mover).name;
        made(quoted("link", name), model.child(&mover).line, words, vec![edit])
    })
}

/// A part turned by a right angle about a line across its axis.
pub(super) fn turned(model: &Model, word: &str) -> Made {
    first(model.movers(word), NO_AXIS, |mover| {
        let joint = mover.joint;
        let size = model.bounds(joint.child).map(|b| b.size()).unwrap_or_default();
        let [least, most] = [size.min_element(), size.max_element()];
        if most < 2.0 * least || joint.axis == DVec3::ZERO {
            return Err("no part is so long that it would show".into());
        }
        let across = joint.axis.any_orthonormal_vector();
        let turn = DQuat::from_axis_angle(across, std::f64::consts::FRAC_PI_2);
        let source = &model.source;
        let edit = match model.language {
            Language::Urdf => {
                let told = rpy(joint.origin.rotation * turn);
                match source.child(mover.at, "origin") {
                    Some(origin) => source.set(origin, "rpy", &told),
                    None => source.insert_first(mover.at, &format!("<origin rpy=\"{told}\"/>")),
                }
            }
            Language::Mjcf => {
                let body = model.body(&mover)?;
                let others = ["euler", "axisangle", "xyaxes", "zaxis"];
                if others.iter().any(|name| source.get(body, name).is_some()) {
                    return Err("its turn is told in another way than by quaternion".into());
                }
                let was = source.get(body, "quat").map_or(Some(DQuat::IDENTITY), quaternion);
                let q = was.ok_or("its quaternion is not four numbers")? * turn;
                source.set(body, "quat", &[q.w, q.x, q.y, q.z].map(short).join(" "))
            }
            Language::Sdf => {
                let at = model.link_at(model.child(&mover)).ok_or("its link has no element")?;
                let pose = model.child_of(at, "pose")?;
                let was = model.numbers(pose);
                if was.len() != 6 || was[3..].iter().any(|v| *v != 0.0) {
                    return Err("its <pose> is turned already".into());
                }
                let place = triple(DVec3::new(was[0], was[1], was[2]));
                source.replace(pose, format!("<pose>{place} {}</pose>", rpy(turn)))
            }
        };
        let name = &model.child(&mover).name;
        made(quoted("link", name), model.child(&mover).line, "turned by 90 degrees", vec![edit])
    })
}

/// A turn as roll, pitch and yaw, as URDF means them.
fn rpy(q: DQuat) -> String {
    let m = glamx::DMat3::from_quat(q);
    let pitch = (-m.x_axis.z).clamp(-1.0, 1.0).asin();
    let (roll, yaw) = match pitch.cos() > 1e-9 {
        true => (m.y_axis.z.atan2(m.z_axis.z), m.x_axis.y.atan2(m.x_axis.x)),
        false => ((-m.z_axis.y).atan2(m.y_axis.y), 0.0),
    };
    triple(DVec3::new(roll, pitch, yaw))
}

fn quaternion(text: &str) -> Option<DQuat> {
    let all: Vec<f64> = text.split_whitespace().map_while(|w| w.parse().ok()).collect();
    match all[..] {
        [w, x, y, z] => {
            let q = DQuat::from_xyzw(x, y, z, w);
            (q.length() > 0.0).then(|| q.normalize())
        }
        _ => None,
    }
}

/// The whole object lowered, where it stands on the floor.
pub(super) fn below_floor(model: &Model, _: &str) -> Made {
    /// How near the floor it must stand, metres: what the profile asks of an object.
    const ON_IT: f64 = 2e-3;
    let robot = &model.robot;
    if model.subject == Subject::Robot {
        return Err("a robot need not stand on the floor".into());
    }
    let whole = model.whole().ok_or("it has no shape")?;
    if whole.min.z.abs() > ON_IT {
        return Err("it does not stand on the floor in the first place".into());
    }
    let by = DVec3::new(0.0, 0.0, -0.1 * whole.diagonal());
    let (source, mut edits) = (&model.source, Vec::new());
    let line = source.line(source.root());
    if model.language == Language::Mjcf {
        let worlds = source.children(source.root(), "worldbody").into_iter();
        for body in worlds.flat_map(|w| source.children(w, "body")) {
            edits.push(model.moved(body, DVec3::ZERO, by)?);
        }
        if edits.is_empty() {
            return Err("it has no body of its own".into());
        }
        return made("the model".into(), line, format!("lowered by {} m", short(-by.z)), edits);
    }
    let root = &robot.links[robot.root()];
    let at = model.link_at(root).ok_or("its root has no element")?;
    for role in [Role::Visual, Role::Collision] {
        for (shape, at) in model.shapes(root, at, role) {
            edits.push(model.moved(at, shape.origin.translation, by)?);
        }
    }
    if let (Some(inertial), Some(at)) = (root.inertial, source.child(at, "inertial")) {
        edits.push(model.moved(at, inertial.origin.translation, by)?);
    }
    for next in robot.joints.iter().filter(|j| j.parent == robot.root()) {
        let at = model.joint_at(next).ok_or("a joint of the root has no element")?;
        edits.push(model.moved(at, next.origin.translation, by)?);
    }
    made("the model".into(), line, format!("lowered by {} m", short(-by.z)), edits)
}
