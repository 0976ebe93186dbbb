//! An object as the measures see it: labelled points of its surface at rest, and how its parts move.

use object::pose::turn_about;
use object::{DPose3, DVec3, JointKind};

/// One degree of freedom of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Turn or slide.
    pub kind: JointKind,
    /// Unit direction, at rest.
    pub axis: DVec3,
    /// A point on the axis, at rest.
    pub pivot: DVec3,
    /// Lower end: radians, or lengths of the unit cube; need not hold the rest pose.
    pub lower: f64,
    /// Upper end, not below the lower.
    pub upper: f64,
}

/// A part's place in the tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Link {
    /// Index of the parent; none for the root.
    pub parent: Option<usize>,
    /// Its motions relative to the parent, the first nearest the parent.
    pub motions: Vec<Motion>,
}

/// Labelled points and the joints that move them; valid by construction.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    points: Vec<DVec3>,
    part_of_point: Vec<u16>,
    links: Vec<Link>,
}

/// Why points and links are not a body.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BodyError {
    /// Nothing to compare.
    #[error("a body needs at least one point, found none")]
    NoPoints,
    /// NaN or infinity.
    #[error("point {0} is not finite")]
    NotFinite(usize),
    /// Not one label per point.
    #[error("expected one part per point ({points}), found {labels}")]
    Length {
        /// Points given.
        points: usize,
        /// Labels given.
        labels: usize,
    },
    /// A label no part has.
    #[error("a point is of part {part}, but there are only {parts}")]
    UnknownPart {
        /// The label.
        part: u16,
        /// Number of parts.
        parts: usize,
    },
    /// A part that hangs on nothing, or on itself.
    #[error("part {0} does not hang on a root")]
    Rootless(usize),
}

/// How far the joints along a chain are driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Every joint this share of its range above its lower end.
    Share(f64),
    /// As the public code moves boxes: this share of the range away from rest, and of a part that
    /// turns and slides the turn alone.
    BoxShare(f64),
}

impl Body {
    /// Proves that every point has a part and every part a root.
    ///
    /// # Errors
    /// [`BodyError`], the first broken rule.
    pub fn new(
        points: Vec<DVec3>,
        part_of_point: Vec<u16>,
        links: Vec<Link>,
    ) -> Result<Self, BodyError> {
        if points.is_empty() {
            return Err(BodyError::NoPoints);
        }
        if let Some(bad) = points.iter().position(|p| !p.is_finite()) {
            return Err(BodyError::NotFinite(bad));
        }
        let (labels, parts) = (part_of_point.len(), links.len());
        if points.len() != labels {
            return Err(BodyError::Length { points: points.len(), labels });
        }
        if let Some(&part) = part_of_point.iter().find(|&&p| usize::from(p) >= parts) {
            return Err(BodyError::UnknownPart { part, parts });
        }
        match (0..parts).find(|&p| !reaches_root(&links, p)) {
            Some(lost) => Err(BodyError::Rootless(lost)),
            None => Ok(Self { points, part_of_point, links }),
        }
    }

    /// Points at rest, unit cube.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The part of each point.
    pub fn part_of_point(&self) -> &[u16] {
        &self.part_of_point
    }

    /// Every part's parent and motions.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The same body whose root stands still.
    #[must_use]
    pub fn with_still_root(mut self) -> Self {
        let roots = self.links.iter_mut().filter(|l| l.parent.is_none());
        roots.for_each(|root| root.motions.clear());
        self
    }

    /// Whether the part or one it hangs on has a joint.
    pub fn moves(&self, part: usize) -> bool {
        self.chain(part).any(|link| !link.motions.is_empty())
    }

    /// The motion of a part from rest to a pose.
    pub fn pose(&self, part: usize, drive: Drive) -> DPose3 {
        self.chain(part).fold(DPose3::identity(), |below, link| link.pose(drive) * below)
    }

    /// All points in a pose.
    pub fn moved(&self, drive: Drive) -> Vec<DVec3> {
        let poses: Vec<_> = (0..self.links.len()).map(|p| self.pose(p, drive)).collect();
        let labelled = self.points.iter().zip(&self.part_of_point);
        labelled.map(|(&p, &part)| poses[usize::from(part)] * p).collect()
    }

    /// A part's link, then its parent's, up to the root.
    fn chain(&self, part: usize) -> impl Iterator<Item = &Link> {
        std::iter::successors(self.links.get(part), |link| self.links.get(link.parent?))
    }
}

fn reaches_root(links: &[Link], part: usize) -> bool {
    let up = |&p: &usize| links.get(p).and_then(|l| l.parent);
    let chain = std::iter::successors(Some(part), up).take(links.len());
    chain.last().and_then(|p| links.get(p)).is_some_and(|last| last.parent.is_none())
}

impl Link {
    fn pose(&self, drive: Drive) -> DPose3 {
        let turn = self.motions.iter().find(|m| m.kind.turns());
        match (drive, turn) {
            (Drive::Share(s), _) => self
                .motions
                .iter()
                .fold(DPose3::identity(), |pose, m| pose * m.pose(m.lower + s * m.span())),
            (Drive::BoxShare(s), Some(m)) => m.pose(s * m.span()),
            (Drive::BoxShare(s), None) => {
                self.motions.first().map_or(DPose3::identity(), |m| m.pose(s * m.span()))
            }
        }
    }
}

impl Motion {
    fn span(&self) -> f64 {
        self.upper - self.lower
    }

    /// The motion from rest to `q` radians, or lengths.
    pub fn pose(&self, q: f64) -> DPose3 {
        if self.kind.turns() {
            turn_about(self.axis, self.pivot, q)
        } else {
            DPose3::from_translation(self.axis * q)
        }
    }
}
