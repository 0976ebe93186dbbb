//! Cases of our own, written, read back and measured.

use std::path::{Path, PathBuf};

use model::{Articulate, ArticulateError, Articulation, Geometric};
use object::{Condition, DVec3, KinematicTree, Mesh, Part};

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
        Ok(Articulation { object, part_of_condition, notes: vec![], confidence: None })
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
        let s = row.scores();
        assert_eq!((s.precision, s.recall, s.point_iou), (1.0, 1.0, Some(1.0)), "{}", row.case);
        // A box that has turned does not fill the upright box around it, not even on its own.
        assert!(s.giou > 0.7 && s.moved_giou > 0.5, "{} {s:?}", row.case);
        assert!(s.chamfer < 0.01 && s.moved_overall < 0.01, "{} {s:?}", row.case);
        assert_eq!(s.joints.near, Some(1.0));
        assert!(s.joints.angle.unwrap() < 1e-5 && s.joints.range.is_none_or(|r| r > 0.999));
        // Boxes around moved points know no such loss, and what is true opens the true way.
        assert!(s.moved_points > 0.9, "{} {s:?}", row.case);
        assert!(s.joints.opening.right.is_none_or(|r| r == 1.0), "{} {s:?}", row.case);
        assert_eq!(s.fully_right, Some(true), "{}", row.case);
        assert!(row.points.iter().all(|p| p.iou == 1.0) && row.points.len() == row.parts);
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
        Report::new(&solver, how(), rows).to_json().unwrap()
    };
    assert_eq!(report(1), report(3));
}

#[test]
fn a_twin_shares_the_vote_of_its_object() {
    let dir = tempfile::tempdir().unwrap();
    let solver = Solver::JointsOnTrueLabels;
    let rows = evaluate_all(&cases(dir.path()), &solver, &how(), 2, |_, _| ()).unwrap();
    let report = Report::new(&solver, how(), rows);
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
    assert_eq!(columns, [49; 5], "{csv}");
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
        let s = row.scores();
        assert_eq!((s.precision, s.recall, s.giou, s.point_iou), (0.0, 0.0, -1.0, Some(0.0)));
        assert_eq!((s.joints.near, s.joints.angle), (Some(0.0), None), "{}", row.case);
    }
    let report = Report::new(&solver, how(), rows);
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
fn prompts_anywhere_lie_on_the_true_part_and_come_from_the_seed() {
    let dir = tempfile::tempdir().unwrap();
    let folders = cases(dir.path());
    let read = |prompts, seed| Case::read_with(&folders[0], prompts, seed).unwrap();
    let points =
        |case: &Case| -> Vec<_> { case.condition.prompts.iter().map(|p| p.point).collect() };
    let given = read(Prompts::AsGiven, 1);
    let anywhere = read(Prompts::Anywhere, 1);
    assert_eq!(points(&anywhere), points(&read(Prompts::Anywhere, 1)));
    assert_ne!(points(&anywhere), points(&given));
    assert_ne!(points(&anywhere), points(&read(Prompts::Anywhere, 2)));
    for (part, (there, was)) in points(&anywhere).iter().zip(points(&given)).enumerate() {
        assert_eq!(there.is_some(), was.is_some());
        let Some(there) = *there else { continue };
        let (face, _) = object::weld::nearest_face(&anywhere.mesh, there);
        assert_eq!(usize::from(anywhere.part_of_face[face]), part);
    }
}

#[test]
fn the_worst_cases_are_drawn_at_rest_and_opened() {
    let dir = tempfile::tempdir().unwrap();
    let folders = cases(dir.path());
    let solver = Solver::Whole(Box::new(Geometric));
    let row = evaluate(&folders[0], &solver, &how());
    let strip = sheet::strip(&folders[0], &row, &solver, &how()).unwrap();
    let [truth, _, opened, _] = &strip;
    assert_ne!(truth.colour, opened.colour, "an opened cabinet looks otherwise than a shut one");
    let png = sheet::sheet(vec![strip.clone(), strip]).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    assert!(sheet::sheet(vec![]).is_err());
}

/// Says what is true of objects it knows by their number of faces, parts told apart by their names.
struct Namesake;

impl Articulate for Namesake {
    fn identity(&self) -> String {
        "namesake/1".into()
    }

    fn articulate(
        &self,
        mesh: &Mesh,
        condition: &Condition,
        _: u64,
    ) -> Result<Articulation, ArticulateError> {
        let mut all = FAMILIES.iter().map(|f| f.make().unwrap().object);
        let known = all.find(|o| o.mesh().faces().len() == mesh.faces().len()).unwrap();
        let scale = mesh.bounds().diagonal() / known.mesh().bounds().diagonal();
        let at = mesh.bounds().centre() - known.mesh().bounds().centre() * scale;
        let numbered = |name: &str| known.tree().parts().iter().position(|p| p.name == name);
        let parts = condition.tree.parts().iter();
        let part_of_condition = parts.map(|part| numbered(&part.name)).collect();
        let object = known.scaled(scale, at).unwrap();
        Ok(Articulation { object, part_of_condition, notes: vec![], confidence: None })
    }
}

/// Proposes the true parts in the opposite order, and makes the true mesh in another size and place.
struct Stranger(Mode);

impl Supply for Stranger {
    fn mode(&self) -> Mode {
        self.0
    }

    fn identity(&self) -> String {
        "stranger/1".into()
    }

    fn given(&self, folder: &Path) -> Result<Given, SupplyError> {
        let Case { mesh, mut condition, .. } = Case::read(folder).unwrap();
        let last = condition.tree.len() - 1;
        let turned = condition.tree.parts().iter().rev();
        let turned = turned.map(|p| Part { parent: p.parent.map(|i| last - i), ..p.clone() });
        condition.tree = KinematicTree::new(turned.collect()).unwrap();
        condition.prompts.reverse();
        let elsewhere = |p: DVec3| if self.0 == Mode::Image { p * 3.0 + DVec3::X } else { p };
        Ok(Given { mesh: mesh.map_vertices(elsewhere).unwrap(), condition })
    }
}

#[test]
fn parts_that_were_proposed_go_with_the_true_ones_by_where_they_are() {
    let dir = tempfile::tempdir().unwrap();
    let folders = cases(dir.path());
    for mode in [Mode::Mesh, Mode::Image] {
        let solver = Solver::Supplied(Box::new(Namesake), Box::new(Stranger(mode)));
        let rows = evaluate_all(&folders, &solver, &how(), 2, |_, _| ()).unwrap();
        for row in &rows {
            assert_eq!((&row.error, &row.identity), (&None, &None));
            let (s, surface) = (row.scores(), mode.has_surface());
            assert_eq!((s.precision, s.recall), (1.0, 1.0), "{}", row.case);
            assert_eq!(s.point_iou, surface.then_some(1.0), "{mode:?}: {}", row.case);
            assert_eq!(s.joints.near, Some(1.0), "{mode:?}: {}", row.case);
            assert!(s.joints.line.is_none_or(|l| l < 1e-6), "{mode:?}: {} {s:?}", row.case);
            let last = row.parts as u16 - 1;
            assert!(row.pairs.iter().all(|&(found, truth)| found == last - truth), "{row:?}");
        }
        let report = Report::new(&solver, how(), rows);
        assert_eq!(report.articulator, "namesake/1, stranger/1");
        let json: serde_json::Value = serde_json::from_str(&report.to_json().unwrap()).unwrap();
        assert_eq!(json["mode"], mode.name());
        let text = table::table(&report);
        assert!(!text.contains("identity") && text.contains("hungarian"), "{text}");
        let csv = csv::csv(&report.cases);
        let columns: Vec<_> = csv.lines().map(|l| l.split(',').count()).collect();
        assert_eq!(columns, [49; 5], "{csv}");
        let [_, found, ..] = sheet::strip(&folders[0], &report.cases[0], &solver, &how()).unwrap();
        let axes = |colour: [u8; 3]| found.colour.iter().filter(|p| p[..3] == colour).count();
        assert!(axes(sheet::FOUND) > 0 && axes(sheet::WRONG) == 0, "{mode:?}");
    }
}

#[test]
fn what_is_not_supplied_is_no_answer() {
    /// Has nothing.
    struct Pauper;
    impl Supply for Pauper {
        fn mode(&self) -> Mode {
            Mode::Mesh
        }
        fn identity(&self) -> String {
            "pauper/1".into()
        }
        fn given(&self, _: &Path) -> Result<Given, SupplyError> {
            Err(SupplyError("no picture".into()))
        }
    }
    let dir = tempfile::tempdir().unwrap();
    let solver = Solver::Supplied(Box::new(Namesake), Box::new(Pauper));
    let row = evaluate(&cases(dir.path())[0], &solver, &how());
    assert_eq!((row.error.as_deref(), &row.identity), (Some("no picture"), &None));
    assert_eq!((row.scores().recall, row.scores().joints.near), (0.0, Some(0.0)));
}
