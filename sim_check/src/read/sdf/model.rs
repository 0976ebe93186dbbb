//! An SDFormat file while it is read.

use glamx::DPose3;

use super::frames::Frames;
use super::tree::Element;
use crate::read::draft::Draft;
use crate::read::meshes::Shelf;
use crate::robot::Unread;

/// A file being read.
pub(super) struct Sdf<'d> {
    pub draft: &'d mut Draft,
    pub shelf: &'d mut Shelf,
    pub frames: Frames,
    pub shapes: usize,
}

/// A joint and where in the model it stands.
pub(super) struct Told<'e> {
    pub element: &'e Element,
    pub scope: usize,
    /// Its own frame.
    pub frame: usize,
    /// Its name with those of the models around it.
    pub name: String,
    pub is_still: bool,
}

impl Sdf<'_> {
    pub(super) fn unread(&mut self, of: &Element, what: &str, checks: &'static [&'static str]) {
        let what = format!("{}: {what} is not read here", of.at());
        self.draft.beside.unread.push(Unread { what, checks });
    }

    /// Where a frame stands in the world.
    pub(super) fn absolute(&self, scope: usize, frame: usize) -> Option<DPose3> {
        let (around, own) = (self.frames.scope(scope)?, self.frames.place(frame)?);
        Some(if around == DPose3::identity() { own } else { around * own })
    }
}
