//! Rigid poses: where one frame stands in another.
//!
//! A [`Pose`] written `b_in_a` maps points given in frame `b` to frame `a`: `p_a = R p_b + t`. Rotations are unit
//! quaternions (w, x, y, z) in Hamilton's convention: `q v q*` turns `v`.

/// A vector in metres, or a direction without unit.
pub type Vector = [f64; 3];

/// A unit quaternion (w, x, y, z).
pub type Quaternion = [f64; 4];

/// Where a frame stands in another: `p_outer = rotate(rotation, p_inner) + position_m`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Origin of the inner frame in the outer one, metres.
    pub position_m: Vector,
    /// Orientation of the inner frame in the outer one, unit quaternion (w, x, y, z).
    pub rotation: Quaternion,
}

impl Default for Pose {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Pose {
    /// The same frame.
    pub const IDENTITY: Self = Self {
        position_m: [0.0; 3],
        rotation: [1.0, 0.0, 0.0, 0.0],
    };

    /// A displacement without a turn.
    #[must_use]
    pub const fn at(position_m: Vector) -> Self {
        Self {
            position_m,
            rotation: [1.0, 0.0, 0.0, 0.0],
        }
    }

    /// A turn without a displacement.
    #[must_use]
    pub const fn turned(rotation: Quaternion) -> Self {
        Self {
            position_m: [0.0; 3],
            rotation,
        }
    }

    /// `c_in_a = b_in_a.then(c_in_b)`.
    #[must_use]
    pub fn then(&self, inner: &Self) -> Self {
        Self {
            position_m: self.apply(inner.position_m),
            rotation: normalized(multiply(self.rotation, inner.rotation)),
        }
    }

    /// `a_in_b` of `b_in_a`.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = conjugate(self.rotation);
        Self {
            position_m: rotate(rotation, scaled(self.position_m, -1.0)),
            rotation,
        }
    }

    /// A point of the inner frame in the outer one.
    #[must_use]
    pub fn apply(&self, point: Vector) -> Vector {
        add(rotate(self.rotation, point), self.position_m)
    }
}

/// Sum of two vectors.
#[must_use]
pub fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
#[must_use]
pub fn subtract(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `v` times `factor`.
#[must_use]
pub fn scaled(v: Vector, factor: f64) -> Vector {
    v.map(|x| x * factor)
}

/// Inner product.
#[must_use]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
#[must_use]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Euclidean length.
#[must_use]
pub fn length(v: Vector) -> f64 {
    dot(v, v).sqrt()
}

/// `v` with length 1, or `None` for a vector too short to have a direction.
#[must_use]
pub fn direction(v: Vector) -> Option<Vector> {
    let length = length(v);
    (length > 1e-12).then(|| scaled(v, 1.0 / length))
}

/// Hamilton's product.
#[must_use]
pub fn multiply(a: Quaternion, b: Quaternion) -> Quaternion {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The inverse of a unit quaternion.
#[must_use]
pub fn conjugate(q: Quaternion) -> Quaternion {
    [q[0], -q[1], -q[2], -q[3]]
}

/// `q` with norm 1; the identity if it has none.
#[must_use]
pub fn normalized(q: Quaternion) -> Quaternion {
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    if norm > 1e-12 {
        q.map(|x| x / norm)
    } else {
        [1.0, 0.0, 0.0, 0.0]
    }
}

/// Turns a vector.
#[must_use]
pub fn rotate(q: Quaternion, v: Vector) -> Vector {
    let u = [q[1], q[2], q[3]];
    let t = scaled(cross(u, v), 2.0);
    add(add(v, scaled(t, q[0])), cross(u, t))
}

/// The turn by `angle_rad` about a unit `axis`.
#[must_use]
pub fn about(axis: Vector, angle_rad: f64) -> Quaternion {
    let (sin, cos) = (angle_rad / 2.0).sin_cos();
    [cos, axis[0] * sin, axis[1] * sin, axis[2] * sin]
}

/// Roll, pitch, yaw about the fixed x, y, z axes in this order: `Rz(yaw) Ry(pitch) Rx(roll)`, as URDF and SDF have it.
#[must_use]
pub fn from_roll_pitch_yaw([roll, pitch, yaw]: Vector) -> Quaternion {
    let x = about([1.0, 0.0, 0.0], roll);
    let y = about([0.0, 1.0, 0.0], pitch);
    let z = about([0.0, 0.0, 1.0], yaw);
    normalized(multiply(z, multiply(y, x)))
}

/// The rows of the rotation matrix.
#[must_use]
pub fn matrix(q: Quaternion) -> [Vector; 3] {
    let columns = [
        rotate(q, [1.0, 0.0, 0.0]),
        rotate(q, [0.0, 1.0, 0.0]),
        rotate(q, [0.0, 0.0, 1.0]),
    ];
    std::array::from_fn(|row| std::array::from_fn(|column| columns[column][row]))
}

/// The quaternion of a rotation whose columns are the given right-handed orthonormal axes.
///
/// Source: S. W. Shepperd, "Quaternion from rotation matrix", 1978: divide by the largest component, so that nothing
/// small is divided by.
#[must_use]
pub fn from_axes(x: Vector, y: Vector, z: Vector) -> Quaternion {
    let squares = [
        1.0 + x[0] + y[1] + z[2],
        1.0 + x[0] - y[1] - z[2],
        1.0 - x[0] + y[1] - z[2],
        1.0 - x[0] - y[1] + z[2],
    ];
    let differences = [y[2] - z[1], z[0] - x[2], x[1] - y[0]];
    let sums = [x[1] + y[0], x[2] + z[0], y[2] + z[1]];
    let largest = (0..4).fold(0, |best, index| {
        if squares[index] > squares[best] {
            index
        } else {
            best
        }
    });
    let square = squares[largest];
    normalized(match largest {
        0 => [square, differences[0], differences[1], differences[2]],
        1 => [differences[0], square, sums[0], sums[1]],
        2 => [differences[1], sums[0], square, sums[2]],
        _ => [differences[2], sums[1], sums[2], square],
    })
}

/// The shortest turn that takes the z axis to the unit vector `target`; about x if it points the opposite way.
#[must_use]
pub fn z_axis_to(target: Vector) -> Quaternion {
    let axis = cross([0.0, 0.0, 1.0], target);
    let sin = length(axis);
    match direction(axis) {
        Some(axis) => about(axis, sin.atan2(target[2])),
        None if target[2] < 0.0 => [0.0, 1.0, 0.0, 0.0],
        None => [1.0, 0.0, 0.0, 0.0],
    }
}
