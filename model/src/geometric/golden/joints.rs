//! What is computed of joints, by name.

use object::{DVec3, Range};

use super::super::features::NAMES;
use super::super::joints::{Fitted, Labelled, candidates, comes_near, endless, fit_watched};
use super::super::range::usual;
use super::super::reach::{self, amounts};
use super::super::score::{self, said, scores};
use super::super::setting::Setting;
use super::super::sweep::Axis;
use super::super::vote::Ballot;
use super::super::words::{ROLES, Role};
use super::record::{Record, few};

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
    let (setting, name) = (fitted.setting, &from.tree.parts()[fitted.setting.part].name);
    of_setting(record, setting, name);
    let ballots = fitted.united.iter().zip(&fitted.voted);
    for ((united, voted), travel) in ballots.zip(&fitted.travels) {
        let title = format!("{name} {:?}", united.kind);
        of_candidates(record, setting, &title, united);
        of_ballots(record, &title, (united, voted));
        record.section(format!("motion, {title}"));
        let Axis { direction, pivot, .. } = travel.axis;
        record.numbers("direction", &direction.to_array());
        record.numbers("pivot", &pivot.to_array());
        record.numbers("joint_pivot", &setting.pivot(&travel.axis).to_array());
        record.exact("stuck, rough", format!("{} {}", travel.stuck, travel.rough));
        match travel.range {
            Range::Limits { lower, upper } => {
                record.numbers("limits", &[lower, upper]);
                of_range(record, setting, &title, (&travel.axis, united.role));
            }
            Range::Continuous => record.numbers("spin", &[setting.spin(&travel.axis)]),
        }
    }
}

fn of_setting(record: &mut Record, setting: &Setting, name: &str) {
    record.section(format!("setting, {name}"));
    let contact = &setting.contact;
    record.exact("words", format!("{:?}", setting.meaning));
    record.numbers("gap", &[contact.gap]);
    record.numbers("touches", &[&contact.child, &contact.parent].map(|side| side.len() as f64));
    record.numbers("contact", &contact.centroid(DVec3::ZERO).to_array());
    record.numbers("outward", &setting.outward().to_array());
    let points = [
        ("handle", setting.handle),
        ("grip", setting.grip),
        ("knuckle", setting.knuckle),
        ("twin", setting.twin),
        ("reached", setting.reached),
        ("rolling", setting.rolling),
        ("wheeled", setting.wheeled),
        ("parent_axis", setting.parent_axis),
    ];
    for (what, at) in points {
        record.numbers(what, &at.map_or(Vec::new(), |at| at.to_array().to_vec()));
    }
}

fn of_candidates(record: &mut Record, setting: &Setting, title: &str, ballot: &Ballot) {
    let (kind, role) = (ballot.kind, ballot.role);
    let found = candidates(setting, kind);
    let features: Vec<_> = found.iter().map(|c| &c.features).collect();
    let row = |i: usize| (i.to_string(), features[i].to_vec());
    let rows: Vec<_> = few(found.len(), CANDIDATES).into_iter().map(row).collect();
    record.table(format!("axis, {title}"), &NAMES, &rows);
    let told = score::numbers(&features, kind, role);
    let row = |i: usize| (i.to_string(), told[i].map(f64::from).to_vec());
    let rows: Vec<_> = few(found.len(), TOLD).into_iter().map(row).collect();
    record.table(format!("axis inputs, {title}"), &score::names(), &rows);
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
        record.numbers("gap", &each(&|a| setting.gap(a)));
    }
    record.numbers("comes_near", &each(&|a| f64::from(u8::from(comes_near(setting, a)))));
}

fn of_ballots(record: &mut Record, title: &str, (united, voted): (&Ballot, &Ballot)) {
    record.section(format!("axes heard, {title}"));
    record.exact("role", format!("{:?} {:?}", united.role, united.stem));
    let of = |ballot: &Ballot| ballot.axes.iter().map(|a| a.0).collect::<Vec<_>>();
    record.numbers("over labellings", &of(united));
    record.numbers("over siblings", &of(voted));
}

fn of_range(record: &mut Record, setting: &Setting, title: &str, (axis, role): (&Axis, Role)) {
    let axis = setting.opening(axis, role);
    let free = setting.freedom_of(&axis, role);
    record.numbers("opening", &axis.direction.to_array());
    record.numbers("free ahead", &free.ahead);
    record.numbers("free back", &free.back);
    record.numbers("reaches", &setting.reaches(&axis, role));
    let mut rows = Vec::new();
    for (way, asked) in setting.asked(&axis, role).iter().enumerate() {
        let row = |i: usize| (format!("{way}>{i}"), asked[i].map(f64::from).to_vec());
        rows.extend(few(asked.len(), AMOUNTS).into_iter().map(row));
    }
    record.table(format!("range, {title}"), &reach::names(), &rows);
    record.section(format!("range said, {title}"));
    for (way, chances) in ["ahead", "back"].iter().zip(setting.range_chances(&axis, role)) {
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
    let alike = pairs.map(|(a, b)| reach::likeness(a, b));
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
