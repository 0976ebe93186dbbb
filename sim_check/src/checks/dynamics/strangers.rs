//! Which colliders the engine lets touch: those of two bodies that no joint connects.
//!
//! The engine knows this of its own bodies only. Several bodies of the scene may be welded into
//! one of those.

use rapier3d_f64::geometry::{Collider, ColliderHandle, SolverFlags};
use rapier3d_f64::pipeline::{PairFilterContext, PhysicsHooks};

use crate::checks::sweep::Scene;
use crate::checks::sweep::terms::Terms;

/// Pairs of a scene's bodies that may touch.
pub struct Strangers {
    /// For each body the one it hangs on.
    above: Vec<Option<usize>>,
    /// Whether a joint ties links within a body together.
    inner: Vec<bool>,
    /// Which others count.
    terms: Terms,
}

impl Strangers {
    /// All pairs of a scene but those that a joint ties together.
    pub fn of(scene: &Scene) -> Self {
        let mut above = vec![None; scene.bodies.len()];
        let mut inner = vec![false; scene.bodies.len()];
        for joint in &scene.robot.joints {
            let [a, b] = [joint.parent, joint.child].map(|l| scene.body_index(l));
            if a == b {
                inner[a] = true;
            } else {
                above[b] = Some(a);
            }
        }
        Self { above, inner, terms: scene.terms.clone() }
    }

    /// Whether two bodies of the scene may touch.
    pub fn meet(&self, [a, b]: [usize; 2]) -> bool {
        let above = |body: usize| self.above.get(body).copied().flatten();
        if a == b {
            return self.inner.get(a).is_none_or(|inner| !inner);
        }
        above(a) != Some(b) && above(b) != Some(a) && self.terms.look_at(a, b)
    }
}

/// A collider's `user_data` is its body's index in the scene.
impl PhysicsHooks for Strangers {
    fn filter_contact_pair(&self, context: &PairFilterContext) -> Option<SolverFlags> {
        let collider = |handle: ColliderHandle| context.colliders.get(handle);
        let body = |c: &Collider| c.user_data as usize;
        let pair = [collider(context.collider1)?, collider(context.collider2)?].map(body);
        self.meet(pair).then_some(SolverFlags::COMPUTE_RIGID_IMPULSES)
    }
}
