//! How MuJoCo weighs the meshes of bodies that do not say what they weigh.

use glamx::DVec3;
use object::Mesh;
use parry3d_f64::transformation::try_convex_hull;

use crate::mass::inertia::Moments;
use crate::mass::solid::Solid;

/// How a mesh is weighed, in MuJoCo's words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Weighing {
    /// Unless said otherwise: every face with the middle of all as a solid, whichever side of it
    /// the middle lies on. What bends inwards weighs too much.
    #[default]
    Legacy,
    /// As its convex hull.
    Convex,
    /// As the solid that it encloses.
    Exact,
    /// As its surface alone.
    Shell,
}

impl Weighing {
    /// The way a word of MJCF names, if it is one.
    pub(super) fn of(word: &str) -> Option<Self> {
        match word {
            "legacy" => Some(Self::Legacy),
            "convex" => Some(Self::Convex),
            "exact" => Some(Self::Exact),
            "shell" => Some(Self::Shell),
            _ => None,
        }
    }

    /// What a mesh weighs; `None` where it encloses nothing.
    pub(super) fn solid(self, mesh: &Mesh) -> Option<Solid> {
        let of = |moments: Moments| Solid::of(&moments);
        match self {
            Self::Legacy => legacy(mesh),
            Self::Exact => of(Moments::solid(mesh)),
            Self::Shell => of(Moments::shell(mesh)),
            Self::Convex => {
                let (points, faces) = hull(mesh.vertices())?;
                of(Moments::solid(&Mesh::new(points, faces).ok()?))
            }
        }
    }
}

/// As MuJoCo 4.0.0 computes it: the centre by volumes seen from the middle of the surface; volume
/// and inertia by volumes seen from that centre. None of them is ever negative.
fn legacy(mesh: &Mesh) -> Option<Solid> {
    let (middle, _) = Moments::shell(mesh).per_kilogram()?;
    let (centre, _) = Moments::unsigned(mesh, middle).per_kilogram()?;
    let moments = Moments::unsigned(mesh, centre);
    let inertia = moments.per_kilogram_about(centre)?;
    Some(Solid::new(moments.measure, centre, inertia))
}

/// The convex hull of points, if they span a body.
pub(super) fn hull(points: &[DVec3]) -> Option<(Vec<DVec3>, Vec<[u32; 3]>)> {
    std::panic::catch_unwind(|| try_convex_hull(points).ok()).ok()?
}
