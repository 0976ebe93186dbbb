//! What geoms weigh, where an MJCF body does not say what it weighs itself.

use glamx::{DMat3, DPose3, DVec3};
use roxmltree::Node;

use super::attributes::{Element, FromGeoms};
use super::model::Model;
use crate::mass::inertia::principal_axes;
use crate::mass::solid::{Weight, together};
use crate::robot::Inertial;

/// The same inertia with no principal moment below the least; where they break the triangle
/// inequality and that is to be balanced, all three are their mean.
fn bounded(inertia: DMat3, least: f64, balances: bool) -> DMat3 {
    let Some((moments, axes)) = principal_axes(inertia) else { return inertia };
    let mut moments = moments.max(DVec3::splat(least));
    let breaks = 2.0 * moments.max_element() > moments.element_sum();
    if breaks && balances {
        moments = DVec3::splat(moments.element_sum() / 3.0);
    }
    axes * DMat3::from_diagonal(moments) * axes.transpose()
}

impl Model<'_, '_> {
    /// Mass and inertia of a body whose frame stands at `own` in its link's: as told, or from its
    /// geoms, whose weights stand in the link's frame already.
    pub(super) fn inertial(
        &mut self,
        told: Option<&Element>,
        own: DPose3,
        weights: &[Weight],
        line: u32,
    ) -> Option<Inertial> {
        let told = told.filter(|_| self.compiler.from_geoms != FromGeoms::Always);
        if let Some(element) = told {
            return Some(self.told_inertial(element, own));
        }
        if self.compiler.from_geoms == FromGeoms::Never {
            return None;
        }
        together(weights, line)
    }

    /// What the compiler's settings make of all masses once they are known.
    pub(super) fn bound_masses(&mut self, root: Node) {
        let [mass, moment] = self.compiler.least;
        let balances = self.compiler.balances;
        for inertial in self.draft.links.iter_mut().filter_map(|l| l.inertial.as_mut()) {
            if mass > 0.0 {
                inertial.mass = inertial.mass.max(mass);
            }
            if moment > 0.0 || balances {
                inertial.inertia = bounded(inertial.inertia, moment, balances);
            }
        }
        let Some(total) = self.compiler.total else { return };
        let inertials = self.draft.links.iter_mut().filter_map(|l| l.inertial.as_mut());
        let all: Vec<_> = inertials.collect();
        let sum: f64 = all.iter().map(|i| i.mass).sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return self.reader.fault(root, "settotalmass: the bodies weigh nothing to scale");
        }
        for inertial in all {
            inertial.mass *= total / sum;
            inertial.inertia *= total / sum;
        }
    }

    fn told_inertial(&mut self, element: &Element, own: DPose3) -> Inertial {
        let line = self.reader.line(element.node);
        let mass = self.number(element, "mass").unwrap_or(0.0);
        let place = self.place(element);
        let full = self.numbers(element, "fullinertia", 6);
        let diagonal = self.vector(element, "diaginertia");
        let inertia = match (full, diagonal) {
            (Some(m), _) => {
                let column = DVec3::new;
                DMat3::from_cols(
                    column(m[0], m[3], m[4]),
                    column(m[3], m[1], m[5]),
                    column(m[4], m[5], m[2]),
                )
            }
            (None, Some(d)) => DMat3::from_diagonal(d),
            (None, None) => {
                self.reader.fault(element.node, "has neither `diaginertia` nor `fullinertia`");
                DMat3::ZERO
            }
        };
        Inertial { origin: own * place, mass, inertia, line }
    }
}
