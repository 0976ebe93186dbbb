//! Where nodes and skins put a mesh.

use glamx::{DMat3, DQuat, DVec3};

use super::accessor::Accessors;
use super::document::Node;
use super::error::GlbError;

/// A linear map and a shift: p becomes `linear · p + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine {
    pub linear: DMat3,
    pub shift: DVec3,
}

impl Affine {
    pub(super) const IDENTITY: Self = Self { linear: DMat3::IDENTITY, shift: DVec3::ZERO };

    pub(super) fn then(self, inner: Self) -> Self {
        let shift = self.linear * inner.shift + self.shift;
        Self { linear: self.linear * inner.linear, shift }
    }

    pub(super) fn of(node: &Node, place: &str) -> Result<Self, GlbError> {
        if let Some(matrix) = node.matrix {
            return Self::of_matrix(matrix, place);
        }
        let turn = node.rotation.map_or(DQuat::IDENTITY, DQuat::from_array);
        if !(turn.length_squared() > 0.0 && turn.length_squared().is_finite()) {
            let found = format!("{:?}", node.rotation);
            return Err(GlbError::rule(place, "a rotation must be a unit quaternion", found));
        }
        let scale = node.scale.map_or(DVec3::ONE, DVec3::from_array);
        let linear = DMat3::from_quat(turn.normalize()) * DMat3::from_diagonal(scale);
        Ok(Self { linear, shift: node.translation.map_or(DVec3::ZERO, DVec3::from_array) })
    }

    /// Of a matrix, column by column.
    fn of_matrix(matrix: [f64; 16], place: &str) -> Result<Self, GlbError> {
        let [a, b, c, p, d, e, f, q, g, h, i, r, x, y, z, w] = matrix;
        if [p, q, r, w - 1.0].iter().any(|v| v.abs() > 1e-6) {
            let found = format!("{p} {q} {r} {w}");
            return Err(GlbError::rule(place, "a matrix ends in the row 0 0 0 1", found));
        }
        let columns = [[a, b, c], [d, e, f], [g, h, i]].map(DVec3::from_array);
        let linear = DMat3::from_cols(columns[0], columns[1], columns[2]);
        Ok(Self { linear, shift: DVec3::new(x, y, z) })
    }

    /// Where a skin puts a mesh, whatever its own node says: by its first joint, as all joints agree
    /// in the pose that the skin was bound in. Without joints it stays as it is.
    pub(super) fn of_skin(
        accessors: Accessors<'_>,
        parents: &[Option<usize>],
        index: usize,
    ) -> Result<Self, GlbError> {
        let document = accessors.document;
        let place = format!("skin {index}");
        let missing = || GlbError::reference("a node", "skin", index, document.skins.len());
        let skin = document.skins.get(index).ok_or_else(missing)?;
        let Some(&joint) = skin.joints.first() else { return Ok(Self::IDENTITY) };
        let bound = skin.inverse_bind_matrices.map(|of| accessors.first::<16>(of, &place));
        let bound = bound.transpose()?.flatten();
        let bound = match bound {
            Some(matrix) => Self::of_matrix(matrix, &place)?,
            None => Self::IDENTITY,
        };
        let mut chain = bound;
        let mut next = Some(joint);
        while let Some(at) = next {
            let count = document.nodes.len();
            let node = document.nodes.get(at);
            let node = node.ok_or_else(|| GlbError::reference(&place, "node", at, count))?;
            chain = Self::of(node, &format!("node {at}"))?.then(chain);
            next = parents.get(at).copied().flatten();
        }
        Ok(chain)
    }
}
