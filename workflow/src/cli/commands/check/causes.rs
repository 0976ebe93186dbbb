//! Why a check could not be judged, or fails as another does: the check that must be mended first.

use sim_check::{Check, Status, Verdict};

/// Reasons as the checks say them, and whose failure may be behind them, the likeliest first.
const REASONS: [(&str, &[&str]); 10] = [
    ("(see F1, T1, T2)", &["F1", "T1", "T2"]),
    ("nothing could be read", &["F1"]),
    ("could not be read as one tree", &["F1", "T1", "T2"]),
    ("cannot be moved:", &["J2", "J1"]),
    ("C1 does not hold", &["C1"]),
    ("C1 is unknown", &["C1"]),
    ("is stuck in an overlap at rest", &["C1"]),
    ("no collision geometry", &["G2"]),
    ("colliders built", &["G2", "F2"]),
    ("has no <inertial>", &["M1"]),
];
/// What stands before reasons of its own.
const GENERAL: &str = "some geometry could not be read";
/// Checks of the same parts on their way.
const ON_THE_WAY: [&str; 2] = ["C2", "C3"];
/// Between the two that overlap and how deep.
pub(super) const OVERLAP: &str = " overlap by ";

/// The check behind this one, which is not judged: one that fails, or that nobody knows of either.
pub(super) fn cause<'v>(verdict: &'v Verdict, check: &Check) -> Option<&'v Check> {
    let mut found = direct(verdict, check)?;
    // Reasons lead to checks nearer the file each time; nothing leads in a circle for longer.
    for _ in 0..verdict.checks.len() {
        match direct(verdict, found).filter(|_| found.status == Status::Unknown) {
            Some(next) if next.id != check.id => found = next,
            _ => break,
        }
    }
    Some(found)
}

fn direct<'v>(verdict: &'v Verdict, check: &Check) -> Option<&'v Check> {
    let reason = reason(check);
    let same = |c: &&Check| c.status == Status::Fail && c.evidence.first() == Some(&reason);
    if let Some(cause) = verdict.checks.iter().find(same) {
        return Some(cause);
    }
    let (_, ids) = REASONS.iter().find(|(words, _)| reason.contains(words))?;
    let is_behind = |c: &&Check| !c.holds() && c.id != check.id && c.waived.is_none();
    ids.iter().find_map(|id| verdict.check(id).filter(is_behind))
}

/// Why a check is not judged.
pub(super) fn reason(check: &Check) -> String {
    let mut told = check.evidence.iter().filter(|e| *e != GENERAL);
    told.next().or(check.evidence.first()).cloned().unwrap_or_default()
}

/// Whether a check fails as C1 does: what overlaps on the way overlaps at rest already.
pub(super) fn follows(verdict: &Verdict, check: &Check) -> bool {
    let fails = |c: &&Check| c.status == Status::Fail && c.waived.is_none();
    let Some(at_rest) = verdict.check("C1").filter(fails) else { return false };
    if !fails(&check) || !ON_THE_WAY.contains(&check.id.as_str()) {
        return false;
    }
    let known: Vec<&str> = at_rest.evidence.iter().filter_map(|e| parts(e)).collect();
    let mut found = check.evidence.iter().filter_map(|e| parts(pose(e).1)).peekable();
    let is_whole = !check.evidence.iter().any(|e| more(e).is_some());
    is_whole && found.peek().is_some() && found.all(|parts| known.contains(&parts))
}

/// The pose a finding is of, and what was found there.
pub(super) fn pose(finding: &str) -> (&str, &str) {
    finding.split_once(": ").unwrap_or(("", finding))
}

/// The two that overlap, where it is about that.
pub(super) fn parts(found: &str) -> Option<&str> {
    found.rsplit_once(OVERLAP).map(|(parts, _)| parts)
}

/// How many findings are not told, where a finding says that.
pub(super) fn more(finding: &str) -> Option<usize> {
    finding.strip_prefix("and ")?.strip_suffix(" more")?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim_check::CheckOptions;

    fn verdict(text: &str) -> Verdict {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.urdf");
        std::fs::write(&path, text).unwrap();
        sim_check::check(&path, &CheckOptions::default())
    }

    fn cause_of(verdict: &Verdict, id: &str) -> String {
        let check = verdict.check(id).unwrap();
        assert_eq!(check.status, Status::Unknown, "{check:?}");
        cause(verdict, check).map(|c| c.id.clone()).unwrap_or_default()
    }

    fn link(name: &str, shape: &str) -> String {
        format!(
            "<link name='{name}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' \
             ixz='0' iyz='0'/></inertial><visual>{shape}</visual><collision>{shape}</collision></link>"
        )
    }

    fn hinged(limit: &str) -> String {
        let shape = "<geometry><box size='1 1 1'/></geometry>";
        let joint = format!(
            "<joint name='j' type='revolute'><parent link='a'/><child link='b'/>\
             <axis xyz='0 0 1'/>{limit}</joint>"
        );
        format!("<robot name='r'>{}{}{joint}</robot>", link("a", shape), link("b", shape))
    }

    #[test]
    fn what_cannot_be_read_is_why_nothing_else_is_judged() {
        let broken = verdict("<robot name='r'><link");
        for check in broken.checks.iter().filter(|c| c.id != "F1") {
            assert_eq!(cause_of(&broken, &check.id), "F1", "{check:?}");
        }
        let forest = verdict("<robot name='r'><link name='a'/><link name='b'/></robot>");
        assert_eq!(cause_of(&forest, "C1"), "T1");
    }

    #[test]
    fn a_joint_that_cannot_be_moved_is_why_nothing_is_moved() {
        let still = verdict(&hinged("<limit lower='1' upper='0' effort='1' velocity='1'/>"));
        for (id, why) in [("J7", "J2"), ("C3", "J2"), ("S1", "C1"), ("S3", "C1")] {
            assert_eq!(cause_of(&still, id), why, "{id}");
        }
        // At rest nothing has to move: the overlap is found, and is why nothing is dropped.
        assert_eq!(still.check("C1").unwrap().status, Status::Fail);
    }

    #[test]
    fn an_overlap_at_rest_is_why_nothing_is_dropped_and_why_it_overlaps_on_the_way() {
        let inside = verdict(&hinged("<limit lower='0' upper='1' effort='1' velocity='1'/>"));
        for id in ["C5", "S1", "S3"] {
            assert_eq!(cause_of(&inside, id), "C1", "{id}");
        }
        assert!(follows(&inside, inside.check("C2").unwrap()), "{:?}", inside.check("C2"));
        assert!(!follows(&inside, inside.check("C1").unwrap()));
    }

    #[test]
    fn what_has_nothing_to_touch_has_no_other_cause() {
        let bare = verdict("<robot name='r'><link name='a'/></robot>");
        assert_eq!(cause_of(&bare, "S1"), cause_of(&bare, "C1"));
    }
}
