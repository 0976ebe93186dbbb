//! The means as a table for a terminal, in the order of the paper's columns.

use std::fmt::Write as _;

use super::summary::{JointMeans, Means, Summary};
use super::{Report, Set};

const HEAD: &str = "     n   Prec    Rec    gIoU     PC   mIoU  point  a-gIoU  a-pts   a-PC   a-OC     AE     LE  joints  right";

/// Three blocks: parts of the same number together, where numbers say anything, parts together by
/// centroid as in the paper, and joints one by one.
pub fn table(report: &Report) -> String {
    let mut out = String::new();
    let mut block = |title: &str, means: fn(&Summary) -> Option<&Means>| {
        let known = || sets(report).filter_map(|(name, s)| Some((name, s.cases, means(s)?)));
        if known().next().is_none() {
            return;
        }
        let _ = writeln!(out, "{title:<11}{HEAD}");
        for (name, cases, means) in known() {
            let _ = writeln!(out, "{name:<11}{cases:>6}{}", line(means));
        }
        out.push('\n');
    };
    block("identity", |s| s.identity.as_ref());
    block("hungarian", |s| Some(&s.hungarian));
    let _ = writeln!(
        out,
        "by joint      joints  compared     AE     LE   ≤15°    +LE  one way  opens   both  wrong"
    );
    for (name, summary) in sets(report) {
        let j = &summary.by_joint;
        let _ = writeln!(out, "{name:<11}{:>9}{:>10}{}", j.joints, j.compared, by_joint(j));
    }
    confidence(&mut out, report);
    out
}

/// How sure the articulator is, where it says so: how many, how many of them are right, calibration error and
/// AUROC of parts, joints and objects, and what is accepted at 0.9.
fn confidence(out: &mut String, report: &Report) {
    let known = || sets(report).filter_map(|(name, s)| Some((name, s.confidence.as_ref()?)));
    if known().next().is_none() {
        return;
    }
    let _ = writeln!(out, "\nconfidence   of            n  right    ECE  AUROC  ≥0.9: all  right");
    for (name, said) in known() {
        for (of, told) in
            [("parts", &said.parts), ("joints", &said.joints), ("objects", &said.objects)]
        {
            let all = [percent(told.right, 7), number(told.ece, 7, 3), number(told.auroc, 7, 3)];
            let accepted = match of {
                "objects" => percent(Some(said.accepted), 11) + &percent(said.accepted_right, 7),
                _ => String::new(),
            };
            let _ = writeln!(out, "{name:<13}{of:<8}{:>7}{}{accepted}", told.count, all.concat());
        }
    }
}

fn sets(report: &Report) -> impl Iterator<Item = (&'static str, &Summary)> {
    let named = report.sets.iter().map(|(set, summary): &(Set, Summary)| (set.name(), summary));
    let several = report.sets.len() > 1;
    named.chain(report.all.iter().filter(move |_| several).map(|all| ("all", all)))
}

fn line(m: &Means) -> String {
    let columns = [
        percent(m.precision, 7),
        percent(m.recall, 7),
        number(m.giou, 8, 3),
        number(m.chamfer, 7, 4),
        number(m.box_iou, 7, 3),
        number(m.point_iou, 7, 3),
        number(m.moved_giou, 8, 3),
        number(m.moved_points, 7, 3),
        number(m.moved_chamfer, 7, 4),
        number(m.moved_overall, 7, 4),
        number(m.joints.angle, 7, 1),
        number(m.joints.line, 7, 3),
        percent(m.joints.found, 8),
        percent(m.fully_right, 7),
    ];
    columns.concat()
}

fn by_joint(j: &JointMeans) -> String {
    let opening = &j.opening;
    let columns = [
        number(j.angle, 7, 1),
        number(j.line, 7, 3),
        percent(j.near, 7),
        percent(j.found, 7),
        format!("{:>9}", opening.joints),
        percent(opening.right, 7),
        percent(opening.both, 7),
        percent(opening.wrong, 7),
    ];
    columns.concat()
}

fn number(value: Option<f64>, width: usize, digits: usize) -> String {
    value.map_or_else(|| format!("{:>width$}", "–"), |v| format!("{v:>width$.digits$}"))
}

fn percent(value: Option<f64>, width: usize) -> String {
    number(value.map(|v| v * 100.0), width, 1)
}
