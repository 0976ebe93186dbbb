//! Cases of our own, written, read back and measured.

use std::path::{Path, PathBuf};

use model::{Articulate, ArticulateError, Articulation, Geometric};
use object::{Condition, Mesh};

use super::*;
use crate::procedural::FAMILIES;

/// Says what is true.
struct Oracle;

impl Articulate for Oracle {
    fn identity(&self) -> String {
        "oracle/1".into()
    }

    fn articulate(
        &self,
        mesh: &Mesh,
        condition: &Condition,
        _: u64,
    ) -> Result<Articulation, ArticulateError> {
        let made = FAMILIES.iter().map(|f| f.make().unwrap());
        let known = made.map(|m| m.object).find(|o| o.mesh().faces().len() == mesh.faces().len());
        let object = known.ok_or(ArticulateError::NothingLabelled("never seen".into()))?;
        let part_of_condition = (0..condition.tree.len()).map(Some).collect();
        Ok(Articulation { object, part_of_condition, notes: vec![] })
    }
}

fn how() -> How {
    How { points: 4_001, ..How::default() }
}

/// The families as case folders, under names of every set.
fn cases(root: &Path) -> Vec<PathBuf> {
    let names =
        ["articraft__cabinet", "articraft__cabinet-fused", "paper__pedal_bin", "home__cart"];
    let families = [0, 0, 1, 2].map(|i| FAMILIES[i].make().unwrap());
    for (name, made) in names.iter().zip(&families) {
        case::write(&root.join(name), &made.object, &made.condition).unwrap();
    }
    case::folders(root).unwrap()
}

#[test]
fn a_case_survives_being_written_and_read() {
    let dir = tempfile::tempdir().unwrap();
    let made = FAMILIES[0].make().unwrap();
    case::write(dir.path(), &made.object, &made.condition).unwrap();
    let case = Case::read(dir.path()).unwrap();
    assert_eq!(case.part_of_face, made.object.part_of_face());
    assert_eq!(case.condition, made.condition.resolve().unwrap());
    for (part, link) in case.links.iter().enumerate() {
        assert_eq!(link.parent, made.object.tree().parent(part));
        for (read, written) in link.motions.iter().zip(made.object.joints(part)) {
            assert!((read.axis - written.axis).length() < 1e-12);
            assert_eq!((read.lower, read.upper), written.range.ends());
        }
    }
    assert_eq!(case::folders(dir.path()).unwrap(), [dir.path()]);
}

#[test]
fn the_truth_itself_gets_nearly_full_marks() {
    let dir = tempfile::tempdir().unwrap();
    let rows =
        evaluate_all(&cases(dir.path()), &Solver::Whole(Box::new(Oracle)), &how(), 2, |_, _| ())
            .unwrap();
    for row in &rows {
        assert_eq!(row.error, None);
        let s = &row.identity;
        assert_eq!((s.precision, s.recall, s.point_iou), (1.0, 1.0, Some(1.0)), "{}", row.case);
        // A box that has turned does not fill the upright box around it, not even on its own.
        assert!(s.giou > 0.7 && s.moved_giou > 0.5, "{} {s:?}", row.case);
        assert!(s.chamfer < 0.01 && s.moved_overall < 0.01, "{} {s:?}", row.case);
        assert_eq!(s.joints.near, Some(1.0));
        assert!(s.joints.angle.unwrap() < 1e-5 && s.joints.range.is_none_or(|r| r > 0.999));
    }
}

#[test]
fn the_number_of_jobs_changes_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let folders = cases(dir.path());
    let report = |jobs| {
        let solver = Solver::Whole(Box::new(Geometric));
        let mut heard = 0;
        let rows = evaluate_all(&folders, &solver, &how(), jobs, |_, _| heard += 1).unwrap();
        assert_eq!(heard, folders.len());
        Report::new(solver.identity(), how(), rows).to_json().unwrap()
    };
    assert_eq!(report(1), report(3));
}

#[test]
fn a_twin_shares_the_vote_of_its_object() {
    let dir = tempfile::tempdir().unwrap();
    let solver = Solver::JointsOnTrueLabels;
    let rows = evaluate_all(&cases(dir.path()), &solver, &how(), 2, |_, _| ()).unwrap();
    let report = Report::new(solver.identity(), how(), rows);
    assert_eq!(
        report.sets.iter().map(|(s, _)| s.name()).collect::<Vec<_>>(),
        ["cad", "simulation", "fused", "paper"]
    );
    let all = report.all.clone().unwrap();
    assert_eq!((all.cases, all.objects, all.failed), (4, 3.0, 0));
    let text = table::table(&report);
    assert_eq!(text.lines().filter(|l| l.starts_with("all")).count(), 3, "{text}");
    let csv = csv::csv(&report.cases);
    let columns: Vec<_> = csv.lines().map(|l| l.split(',').count()).collect();
    assert_eq!(columns, [37; 5], "{csv}");
}

#[test]
fn a_case_that_fails_is_a_row_at_its_worst() {
    let dir = tempfile::tempdir().unwrap();
    let folders = cases(dir.path());
    std::fs::write(folders[0].join("face_labels.u16le"), [0, 0, 1]).unwrap();
    let made = FAMILIES[3].make().unwrap();
    case::write(&dir.path().join("home__fan"), &made.object, &made.condition).unwrap();
    let solver = Solver::Whole(Box::new(Deaf));
    let rows = evaluate_all(&case::folders(dir.path()).unwrap(), &solver, &how(), 1, |_, _| ());
    let rows = rows.unwrap();
    let unread = rows.iter().find(|r| r.parts == 0).unwrap();
    assert!(unread.error.as_ref().unwrap().contains("face_labels.u16le: expected"), "{unread:?}");
    for row in &rows {
        assert!(row.error.is_some());
        let s = &row.identity;
        assert_eq!((s.precision, s.recall, s.giou, s.point_iou), (0.0, 0.0, -1.0, Some(0.0)));
        assert_eq!((s.joints.near, s.joints.angle), (Some(0.0), None), "{}", row.case);
    }
    let report = Report::new(solver.identity(), how(), rows);
    assert_eq!((report.failed().count(), report.all.unwrap().failed), (5, 5));
}

/// Answers nothing.
struct Deaf;

impl Articulate for Deaf {
    fn identity(&self) -> String {
        "deaf/1".into()
    }

    fn articulate(&self, _: &Mesh, _: &Condition, _: u64) -> Result<Articulation, ArticulateError> {
        Err(ArticulateError::NothingLabelled("heard nothing".into()))
    }
}

#[test]
fn a_solver_is_told_no_word_and_no_point_that_is_left_out() {
    /// Fails if it hears anything.
    struct Listener;
    impl Articulate for Listener {
        fn identity(&self) -> String {
            "listener/1".into()
        }
        fn articulate(
            &self,
            _: &Mesh,
            c: &Condition,
            _: u64,
        ) -> Result<Articulation, ArticulateError> {
            assert!(c.category.is_empty() && c.prompts.iter().all(|p| p.point.is_none()));
            let parts = c.tree.parts().iter().enumerate();
            assert!(parts.clone().all(|(i, p)| p.text.is_empty() && p.name == format!("part_{i}")));
            Err(ArticulateError::NothingLabelled("as it should be".into()))
        }
    }
    let dir = tempfile::tempdir().unwrap();
    let folders = cases(dir.path());
    let without = Without { text: true, points: true };
    let row = evaluate(&folders[0], &Solver::Whole(Box::new(Listener)), &How { without, ..how() });
    assert!(row.error.unwrap().contains("as it should be"));
}

#[test]
fn the_worst_cases_are_drawn_twice() {
    let dir = tempfile::tempdir().unwrap();
    let folders = cases(dir.path());
    let solver = Solver::Whole(Box::new(Geometric));
    let row = evaluate(&folders[0], &solver, &how());
    let pair = sheet::pair(&folders[0], &row, &solver, &how()).unwrap();
    let png = sheet::sheet(vec![pair.clone(), pair]).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    assert!(sheet::sheet(vec![]).is_err());
}
