//! Small vectors, turns and symmetric systems.

/// x, y, z.
pub(crate) type Vector = [f64; 3];

/// The scalar product.
pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a + by * b`.
pub(crate) fn plus(a: Vector, b: Vector, by: f64) -> Vector {
    [0, 1, 2].map(|i| a[i] + by * b[i])
}

/// A rotation, by its rows.
pub(crate) type Turn = [Vector; 3];

/// No turn.
pub(crate) const STRAIGHT: Turn = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A vector turned.
pub(crate) fn apply(turn: &Turn, v: Vector) -> Vector {
    turn.map(|row| dot(row, v))
}

/// First `b`, then `a`.
pub(crate) fn after(a: &Turn, b: &Turn) -> Turn {
    let column = |j: usize| [b[0][j], b[1][j], b[2][j]];
    a.map(|row| [0, 1, 2].map(|j| dot(row, column(j))))
}

/// Roll, pitch, yaw, as URDF turns.
pub(crate) fn of_angles([roll, pitch, yaw]: Vector) -> Turn {
    let z = about([0.0, 0.0, 1.0], yaw);
    after(&after(&z, &about([0.0, 1.0, 0.0], pitch)), &about([1.0, 0.0, 0.0], roll))
}

/// A turn about a unit axis.
pub(crate) fn about([x, y, z]: Vector, angle: f64) -> Turn {
    let (s, c) = angle.sin_cos();
    let t = 1.0 - c;
    [
        [t * x * x + c, t * x * y - s * z, t * x * z + s * y],
        [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
        [t * x * z - s * y, t * y * z + s * x, t * z * z + c],
    ]
}

/// A tensor of six products, turned.
pub(crate) fn along(turn: &Turn, [xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Turn {
    let own = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let turned = after(turn, &own);
    turned.map(|row| turn.map(|axis| dot(row, axis)))
}

/// The solution of a symmetric positive system, by Cholesky's decomposition; none where it is not.
pub(crate) fn solved(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Option<Vec<f64>> {
    let count = right.len();
    for i in 0..count {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            let left = matrix[i][j] - sum;
            matrix[i][j] = if i == j { left.sqrt() } else { left / matrix[j][j] };
            if !matrix[i][j].is_finite() || (i == j && matrix[i][j] <= 0.0) {
                return None;
            }
        }
    }
    for i in 0..count {
        let sum: f64 = (0..i).map(|k| matrix[i][k] * right[k]).sum();
        right[i] = (right[i] - sum) / matrix[i][i];
    }
    for i in (0..count).rev() {
        let sum: f64 = (i + 1..count).map(|k| matrix[k][i] * right[k]).sum();
        right[i] = (right[i] - sum) / matrix[i][i];
    }
    Some(right)
}
