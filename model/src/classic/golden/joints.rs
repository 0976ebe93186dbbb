//! What is computed of joints, by name.

use object::{DVec3, Range};

use crate::classic::golden::record::{Record, few};
use crate::classic::joints::axis_model;
use crate::classic::joints::axis_model::{said, scores};
use crate::classic::joints::context::JointContext;
use crate::classic::joints::features::NAMES;
use crate::classic::joints::range::usual;
use crate::classic::joints::range_model;
use crate::classic::joints::range_model::amounts;
use crate::classic::joints::siblings::Ballot;
use crate::classic::joints::sweep::Axis;
use crate::classic::joints::ways::{self, WAYS, Way};
use crate::classic::joints::{Fitted, Labelled, candidates, comes_near, endless, fit_watched};
use crate::classic::lexicon::words::{ROLES, Role};

/// How many candidates of a joint are recorded feature by feature, and how many as the trees are told.
const CANDIDATES: usize = 8;
const TOLD: usize = 3;
/// How many amounts of a range are recorded feature by feature, each way.
const AMOUNTS: usize = 3;
/// The seed of scenes.
const SEED: u64 = 1;

/// Records how the joints of a labelled mesh are found.
pub(super) fn record(record: &mut Record, from: &Labelled, others: &[Vec<u16>]) {
    let mut found = Vec::new();
    let joints = fit_watched((from, others), SEED, |fitted| {
        let mut one = Record::default();
        of_part(&mut one, from, fitted);
        found.push(one);
    });
    for one in found {
        record.take(one);
    }
    record.section("joints");
    for (part, motions) in from.tree.parts().iter().zip(&joints.motions) {
        for motion in motions {
            // As many digits as say exactly this.
            let name = format!("{} {:?}", part.name, motion.kind);
            let vector = |v: DVec3| format!("{:?} {:?} {:?}", v.x, v.y, v.z);
            let range = match motion.range {
                Range::Limits { lower, upper } => format!("{lower:?} to {upper:?}"),
                Range::Continuous => "endless".into(),
            };
            let (axis, pivot) = (vector(motion.axis), vector(motion.pivot));
            record.exact(name, format!("axis {axis}, pivot {pivot}, {range}"));
        }
    }
    for note in &joints.notes {
        record.exact(format!("note on {}", note.part), &note.message);
    }
}

fn of_part(record: &mut Record, from: &Labelled, fitted: &Fitted) {
    let (context, name) = (fitted.context, &from.tree.parts()[fitted.context.part].name);
    of_context(record, context, name);
    let ballots = fitted.united.iter().zip(&fitted.voted);
    for ((united, voted), travel) in ballots.zip(&fitted.travels) {
        let title = format!("{name} {:?}", united.kind);
        of_candidates(record, context, &title, united);
        of_ballots(record, &title, (united, voted));
        record.section(format!("motion, {title}"));
        let Axis { direction, pivot, .. } = travel.axis;
        record.numbers("direction", &direction.to_array());
        record.numbers("pivot", &pivot.to_array());
        record.numbers("joint_pivot", &context.pivot(&travel.axis).to_array());
        record.exact("stuck, rough", format!("{} {}", travel.stuck, travel.rough));
        match travel.range {
            Range::Limits { lower, upper } => {
                record.numbers("limits", &[lower, upper]);
                of_range(record, context, &title, (&travel.axis, united.role));
            }
            Range::Continuous => record.numbers("spin", &[context.spin(&travel.axis)]),
        }
    }
}

fn of_context(record: &mut Record, context: &JointContext, name: &str) {
    record.section(format!("setting, {name}"));
    let contact = &context.contact;
    record.exact("words", format!("{:?}", context.meaning));
    record.numbers("gap", &[contact.gap]);
    record.numbers("touches", &[&contact.child, &contact.parent].map(|side| side.len() as f64));
    record.numbers("contact", &contact.centroid(DVec3::ZERO).to_array());
    record.numbers("outward", &context.outward().to_array());
    let points = [
        ("handle", context.handle),
        ("grip", context.grip),
        ("knuckle", context.knuckle),
        ("twin", context.twin),
        ("reached", context.reached),
        ("rolling", context.rolling),
        ("wheeled", context.wheeled),
        ("parent_axis", context.parent_axis),
    ];
    for (what, at) in points {
        record.numbers(what, &at.map_or(Vec::new(), |at| at.to_array().to_vec()));
    }
}

fn of_candidates(record: &mut Record, context: &JointContext, title: &str, ballot: &Ballot) {
    let (kind, role) = (ballot.kind, ballot.role);
    let found = candidates(context, kind);
    let features: Vec<_> = found.iter().map(|c| &c.features).collect();
    let row = |i: usize| (i.to_string(), features[i].to_vec());
    let rows: Vec<_> = few(found.len(), CANDIDATES).into_iter().map(row).collect();
    record.table(format!("axis, {title}"), &NAMES, &rows);
    let told = axis_model::inputs(&features, kind, role);
    let row = |i: usize| (i.to_string(), told[i].map(f64::from).to_vec());
    let rows: Vec<_> = few(found.len(), TOLD).into_iter().map(row).collect();
    record.table(format!("axis inputs, {title}"), &axis_model::names(), &rows);
    record.section(format!("candidates, {title}"));
    let (chances, nets) = said(&features, kind, role);
    let each = |of: &dyn Fn(&Axis) -> f64| found.iter().map(|c| of(&c.axis)).collect::<Vec<_>>();
    for (name, axis) in [("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)] {
        record.numbers(format!("direction_{name}"), &each(&|a| a.direction.dot(axis)));
        record.numbers(format!("pivot_{name}"), &each(&|a| a.pivot.dot(axis)));
    }
    record.numbers("tree_probability", &chances.iter().map(|&c| f64::from(c)).collect::<Vec<_>>());
    record.numbers("network_score", &nets);
    record.numbers("score", &scores(&features, kind, role));
    if kind.turns() {
        record.numbers("gap", &each(&|a| context.gap(a)));
    }
    record.numbers("comes_near", &each(&|a| f64::from(u8::from(comes_near(context, a)))));
}

fn of_ballots(record: &mut Record, title: &str, (united, voted): (&Ballot, &Ballot)) {
    record.section(format!("axes heard, {title}"));
    record.exact("role", format!("{:?} {:?}", united.role, united.stem));
    let of = |ballot: &Ballot| ballot.axes.iter().map(|a| a.0).collect::<Vec<_>>();
    record.numbers("over labellings", &of(united));
    record.numbers("over siblings", &of(voted));
}

fn of_range(record: &mut Record, context: &JointContext, title: &str, (axis, role): (&Axis, Role)) {
    let axis = context.opening(axis, role);
    let free = context.freedom_of(&axis, role);
    record.numbers("opening", &axis.direction.to_array());
    record.numbers("free ahead", &free.ahead);
    record.numbers("free back", &free.back);
    record.numbers("reaches", &context.reaches(&axis, role).0);
    let mut rows = Vec::new();
    let asked = context.asked(&axis, role);
    for (way, asked) in asked.amounts.iter().enumerate() {
        let row = |i: usize| (format!("{way}>{i}"), asked[i].map(f64::from).to_vec());
        rows.extend(few(asked.len(), AMOUNTS).into_iter().map(row));
    }
    record.table(format!("range, {title}"), &range_model::names(), &rows);
    let row = |(way, row): (&Way, &ways::Inputs)| (format!("{way:?}"), row.map(f64::from).to_vec());
    let rows: Vec<_> = WAYS.iter().zip(&asked.ways).map(row).collect();
    record.table(format!("ways, {title}"), &ways::names(), &rows);
    record.section(format!("range said, {title}"));
    let said = context.range_said(&axis, role);
    record.numbers("ways", &said.ways);
    for (way, chances) in ["ahead", "back"].iter().zip(said.amounts) {
        record.numbers(*way, &chances.iter().map(|&c| f64::from(c)).collect::<Vec<_>>());
    }
}

/// Records what is said of amounts and roles, whatever the object.
pub(super) fn tables(record: &mut Record) {
    record.section("amounts");
    for turns in [false, true] {
        record.numbers(if turns { "turns" } else { "slides" }, &amounts(turns));
    }
    record.section("likeness");
    let pairs = [(0.0, 0.0), (0.0, 0.01), (0.01, 0.0), (0.5, 0.5), (0.5, 0.52), (1.5, 1.4)];
    let alike = pairs.map(|(a, b)| range_model::likeness(a, b));
    record.numbers("pairs", &alike);
    record.section("usual ranges");
    for role in ROLES {
        for turns in [false, true] {
            let reach = usual(role, turns);
            let name = format!("{role:?} {}", if turns { "turns" } else { "slides" });
            record.numbers(name, &[reach.open, reach.close]);
        }
    }
    record.section("endless");
    for role in ROLES {
        record.exact(format!("{role:?}"), format!("{:?}", endless(role)));
    }
}
