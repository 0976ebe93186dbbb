//! The worst cases side by side: what is true, and what was found, with the axes drawn.

use object::{DVec3, JointKind, Mesh};
use view::camera::framed;
use view::{Camera, Paint, Picture, ViewError, caption, contact_sheet, draw_axis, render};

use super::case::{Case, CaseError, object_of};
use super::solver::{labels_by_condition, links};
use super::{Answer, How, Row, Solver};
use crate::metrics::{JointComparison, Link, Motion};

/// Pixels of one picture.
const SIZE: [u32; 2] = [480, 440];
/// Cases side by side; two pictures each.
const ABREAST: usize = 2;
/// Length of an axis to either side of its middle, as a share of the object's diagonal.
const REACH: f64 = 0.14;
/// Towards the eye: from the front right, a little from above.
const STANDPOINT: DVec3 = DVec3::new(0.6, -1.0, 0.55);

const TRUE_AXIS: [u8; 3] = [24, 60, 140];
pub(super) const FOUND: [u8; 3] = [20, 140, 60];
const MISPLACED: [u8; 3] = [214, 120, 0];
pub(super) const WRONG: [u8; 3] = [205, 20, 40];

/// Why a case cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum SheetError {
    /// It cannot be read again.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The sheet cannot be made.
    #[error(transparent)]
    View(#[from] ViewError),
}

/// A case drawn twice, what is true and what was found, on the surface it was found on; the case is
/// read and answered again.
/// Axes found are green, those that only point the right way orange, others red.
///
/// # Errors
/// [`SheetError::Case`] when the case cannot be read.
pub fn pair(
    folder: &std::path::Path,
    row: &Row,
    solver: &Solver,
    how: &How,
) -> Result<[Picture; 2], SheetError> {
    let case = Case::read(folder)?;
    let bounds = case.mesh.bounds();
    let camera = framed(&bounds, STANDPOINT, SIZE);
    let mut truth = render(&case.mesh, &Paint::Parts(&case.part_of_face), &camera);
    let (mesh, labels) = (&case.mesh, &case.part_of_face);
    draw_links(&mut truth, &camera, Labelled { mesh, labels }, &case.links, &|_, _| TRUE_AXIS);
    caption(&mut truth, &shortened(&row.case));
    let mut found = match solver.answer(&case, how) {
        Ok(Answer { made, .. }) => {
            let (mesh, labels) = (made.object.mesh(), labels_by_condition(&made));
            let camera = framed(&mesh.bounds(), STANDPOINT, SIZE);
            let mut picture = render(mesh, &Paint::Parts(&labels), &camera);
            let colour = |part, motion: &Motion| colour_of(row, part, motion.kind);
            let labels = &labels;
            draw_links(&mut picture, &camera, Labelled { mesh, labels }, &links(&made), &colour);
            picture
        }
        Err(_) => render(&case.mesh, &Paint::Surface, &camera),
    };
    caption(&mut found, &verdict(row));
    Ok([truth, found])
}

/// Pairs laid out on one sheet.
///
/// # Errors
/// [`SheetError::View`] when there are none.
pub fn sheet(pairs: Vec<[Picture; 2]>) -> Result<Vec<u8>, SheetError> {
    let pictures: Vec<_> = pairs.into_iter().flatten().collect();
    Ok(view::encode_png(&contact_sheet(&pictures, 2 * ABREAST)?)?)
}

/// A surface and the part of each face.
#[derive(Clone, Copy)]
struct Labelled<'a> {
    mesh: &'a Mesh,
    labels: &'a [u16],
}

impl Labelled<'_> {
    /// The middle of a part's surface; none of a part without a face.
    fn middle(&self, part: usize) -> Option<DVec3> {
        let mine = self.labels.iter().enumerate().filter(|(_, p)| usize::from(**p) == part);
        let (sum, area) = mine.fold((DVec3::ZERO, 0.0), |(sum, total), (face, _)| {
            let area = self.mesh.area(face);
            (sum + self.mesh.centroid(face) * area, total + area)
        });
        (area > 0.0).then(|| sum / area)
    }
}

/// Draws each turn's axis where it passes its part, each slide from the middle of its part.
fn draw_links(
    picture: &mut Picture,
    camera: &Camera,
    surface: Labelled<'_>,
    links: &[Link],
    colour: &dyn Fn(usize, &Motion) -> [u8; 3],
) {
    for (part, link) in links.iter().enumerate() {
        for motion in &link.motions {
            let reach = motion.axis * surface.mesh.bounds().diagonal() * REACH;
            let middle = surface.middle(part).unwrap_or(motion.pivot);
            let passing = motion.pivot + motion.axis * (middle - motion.pivot).dot(motion.axis);
            let [from, to] = if motion.kind.turns() {
                [passing - reach, passing + reach]
            } else {
                [middle, middle + reach * 1.5]
            };
            draw_axis(picture, camera, from, to, colour(part, motion));
        }
    }
}

fn colour_of(row: &Row, part: usize, kind: JointKind) -> [u8; 3] {
    let goes_with = |&&(found, _): &&(u16, u16)| usize::from(found) == part;
    let truth = match row.pairs.iter().find(goes_with) {
        Some(&(_, truth)) => usize::from(truth),
        None if row.identity.is_some() => part,
        None => return WRONG,
    };
    let same =
        |j: &&JointComparison| usize::from(j.part) == truth && j.kind.turns() == kind.turns();
    match row.joints.iter().map(|j| &j.joint).find(same) {
        Some(joint) if joint.is_found() => FOUND,
        Some(joint) if joint.is_near() => MISPLACED,
        _ => WRONG,
    }
}

fn verdict(row: &Row) -> String {
    if let Some(error) = &row.error {
        return format!("no answer: {error}");
    }
    let scores = row.scores();
    let found = row.joints.iter().filter(|j| j.joint.is_found()).count();
    let points = scores.point_iou.map_or_else(|| "-".into(), |p| format!("{p:.2}"));
    format!("points {points}  gIoU {:.2}  joints {found}/{}", scores.giou, row.joints.len())
}

/// A case's name without where it comes from, short enough for a caption.
fn shortened(case: &str) -> String {
    let name = case.split_once("__").map_or(case, |(_, name)| name);
    let stem = object_of(name);
    let twin = if stem == name { "" } else { " fused" };
    let kept: String = stem.chars().take(34).collect();
    kept.replace(['_', '-'], " ") + twin
}
