//! The worst cases side by side: what is true and what was found, at rest with the axes drawn, and
//! opened.

use object::{DVec3, JointKind, Mesh};
use view::camera::framed;
use view::{Camera, Paint, Picture, ViewError, caption, contact_sheet, draw_axis, render};

use super::case::{Case, CaseError, object_of};
use super::solver::{labels_by_condition, links};
use super::{Answer, How, Row, Solver};
use crate::metrics::moved::{opened, opened_alike, poses};
use crate::metrics::{JointComparison, Link, Motion, Opening};

/// Pixels of one picture.
const SIZE: [u32; 2] = [480, 440];
/// Pictures of a case, one row of the sheet.
const OF_A_CASE: usize = 4;
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

/// A case drawn four times: what is true and what was found at rest, then both with every joint opened
/// the true way, as far as each goes. The found ones show the surface it was found on; the case is read
/// and answered again.
/// Axes found are green, those that only point the right way orange, others red.
///
/// # Errors
/// [`SheetError::Case`] when the case cannot be read.
pub fn strip(
    folder: &std::path::Path,
    row: &Row,
    solver: &Solver,
    how: &How,
) -> Result<[Picture; OF_A_CASE], SheetError> {
    let case = Case::read_with(folder, how.prompts, how.seed)?;
    let true_side = Labelled { mesh: &case.mesh, labels: &case.part_of_face };
    let mut truth = at_rest(true_side, &case.links, &|_, _| TRUE_AXIS);
    caption(&mut truth, &shortened(&row.case));
    let mut true_opened = opened_picture(true_side, &case.links, &opened(&case.links));
    caption(&mut true_opened, "opened");
    let (mut found, mut found_opened) = match solver.answer(&case, how) {
        Ok(Answer { made, .. }) => {
            let labels = labels_by_condition(&made);
            let side = Labelled { mesh: made.object.mesh(), labels: &labels };
            let links = links(&made);
            let colour = |part, motion: &Motion| colour_of(row, part, motion.kind);
            let values = opened_alike(&links, &case.links, &together(row, links.len()));
            (at_rest(side, &links, &colour), opened_picture(side, &links, &values))
        }
        Err(_) => {
            let plain = || {
                let camera = framed(&case.mesh.bounds(), STANDPOINT, SIZE);
                render(&case.mesh, &Paint::Surface, &camera)
            };
            (plain(), plain())
        }
    };
    caption(&mut found, &verdict(row));
    caption(&mut found_opened, &openings(row));
    Ok([truth, found, true_opened, found_opened])
}

/// Which predicted part goes with which true one.
fn together(row: &Row, parts: usize) -> Vec<(u16, u16)> {
    let by_number = row.identity.is_some();
    if by_number { (0..parts as u16).map(|p| (p, p)).collect() } else { row.pairs.clone() }
}

fn at_rest(
    side: Labelled<'_>,
    links: &[Link],
    colour: &dyn Fn(usize, &Motion) -> [u8; 3],
) -> Picture {
    let camera = framed(&side.mesh.bounds(), STANDPOINT, SIZE);
    let mut picture = render(side.mesh, &Paint::Parts(side.labels), &camera);
    draw_links(&mut picture, &camera, side, links, colour);
    picture
}

/// The surface with every joint at its value; as at rest where it cannot be moved.
fn opened_picture(side: Labelled<'_>, links: &[Link], values: &[Vec<f64>]) -> Picture {
    let poses = poses(links, values);
    let mut vertices = Vec::with_capacity(3 * side.labels.len());
    for (face, &part) in side.labels.iter().enumerate() {
        let pose = poses.get(usize::from(part)).copied().unwrap_or_default();
        vertices.extend(side.mesh.corners(face).map(|corner| pose * corner));
    }
    let faces = (0..side.labels.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let moved = Mesh::new(vertices, faces);
    let mesh = moved.as_ref().unwrap_or(side.mesh);
    let camera = framed(&mesh.bounds(), STANDPOINT, SIZE);
    render(mesh, &Paint::Parts(side.labels), &camera)
}

/// Strips laid out on one sheet, one below the other.
///
/// # Errors
/// [`SheetError::View`] when there are none.
pub fn sheet(strips: Vec<[Picture; OF_A_CASE]>) -> Result<Vec<u8>, SheetError> {
    let pictures: Vec<_> = strips.into_iter().flatten().collect();
    Ok(view::encode_png(&contact_sheet(&pictures, OF_A_CASE)?)?)
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

/// Which way joints open whose axes were found.
fn openings(row: &Row) -> String {
    let known = row.joints.iter().filter_map(|j| j.joint.opening_if_found());
    let count = |which: Opening| known.clone().filter(|o| *o == which).count();
    let [right, both, wrong] = [Opening::Right, Opening::Both, Opening::Wrong].map(count);
    match right + both + wrong {
        0 => "opened as the truth".into(),
        all => format!("opens right {right}/{all}  both {both}  wrong {wrong}"),
    }
}

/// A case's name without where it comes from, short enough for a caption.
fn shortened(case: &str) -> String {
    let name = case.split_once("__").map_or(case, |(_, name)| name);
    let stem = object_of(name);
    let twin = if stem == name { "" } else { " fused" };
    let kept: String = stem.chars().take(34).collect();
    kept.replace(['_', '-'], " ") + twin
}
