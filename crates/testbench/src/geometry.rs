//! Rotations and the inertia of solid bodies: the little geometry the test bench needs.
//!
//! Quaternions are `[w, x, y, z]`, unit length, mapping body coordinates to world coordinates.

/// A vector or point in three dimensions.
pub type Vector = [f64; 3];

/// A unit quaternion `[w, x, y, z]`.
pub type Quaternion = [f64; 4];

/// A position (m) and an orientation, in the world frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Position in metres.
    pub position_m: Vector,
    /// Orientation.
    pub orientation: Quaternion,
}

/// The orientation that turns nothing.
pub const IDENTITY: Quaternion = [1.0, 0.0, 0.0, 0.0];

/// The rotation by `angle_rad` about `axis` (of any length but zero).
#[must_use]
pub fn about(axis: Vector, angle_rad: f64) -> Quaternion {
    let length = norm(axis);
    if length == 0.0 {
        return IDENTITY;
    }
    let (sine, cosine) = (angle_rad / 2.0).sin_cos();
    let scale = sine / length;
    [cosine, axis[0] * scale, axis[1] * scale, axis[2] * scale]
}

/// The rotation by roll, pitch and yaw about the fixed x, y and z axes, in that order.
#[must_use]
pub fn from_roll_pitch_yaw(rpy_rad: Vector) -> Quaternion {
    let roll = about([1.0, 0.0, 0.0], rpy_rad[0]);
    let pitch = about([0.0, 1.0, 0.0], rpy_rad[1]);
    let yaw = about([0.0, 0.0, 1.0], rpy_rad[2]);
    compose(yaw, compose(pitch, roll))
}

/// The rotation that first applies `inner`, then `outer`.
#[inline]
#[must_use]
pub fn compose(outer: Quaternion, inner: Quaternion) -> Quaternion {
    let ([a, b, c, d], [e, f, g, h]) = (outer, inner);
    [
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    ]
}

/// The rotation back.
#[inline]
#[must_use]
pub fn inverse(rotation: Quaternion) -> Quaternion {
    let [w, x, y, z] = rotation;
    [w, -x, -y, -z]
}

/// The rotation vector (axis times angle in rad, in the frame both refer to) that takes `from` to
/// `to`.
#[must_use]
pub fn rotation_between(from: Quaternion, to: Quaternion) -> Vector {
    let [w, x, y, z] = compose(to, inverse(from));
    let sign = if w < 0.0 { -1.0 } else { 1.0 };
    let axis = scale(sign, [x, y, z]);
    let sine = norm(axis);
    if sine < 1e-12 {
        return [0.0; 3];
    }
    scale(2.0 * sine.atan2(sign * w) / sine, axis)
}

/// A rotation turned on by a rotation vector (axis times angle in rad, in the outer frame).
#[must_use]
pub fn turned_by(rotation: Quaternion, turn: Vector) -> Quaternion {
    compose(about(turn, norm(turn)), rotation)
}

impl Pose {
    /// The pose in the outer frame of something whose pose in the frame `self` is `inner`.
    #[inline]
    #[must_use]
    pub fn then(&self, inner: &Pose) -> Pose {
        Pose {
            position_m: add(self.position_m, rotate(self.orientation, inner.position_m)),
            orientation: compose(self.orientation, inner.orientation),
        }
    }

    /// The pose of `self` as seen from `frame`.
    #[inline]
    #[must_use]
    pub fn seen_from(&self, frame: &Pose) -> Pose {
        let back = inverse(frame.orientation);
        Pose {
            position_m: rotate(back, subtract(self.position_m, frame.position_m)),
            orientation: compose(back, self.orientation),
        }
    }
}

/// The shortest distance between two straight pieces, each given by its ends: minimise
/// `|a0 + s u - b0 - t v|` over `s, t` in \[0, 1\] (Ericson, "Real-Time Collision Detection", 2005,
/// section 5.1.9).
#[inline]
#[must_use]
pub fn distance_of_pieces(a: [Vector; 2], b: [Vector; 2]) -> f64 {
    let (u, v, between) = (
        subtract(a[1], a[0]),
        subtract(b[1], b[0]),
        subtract(a[0], b[0]),
    );
    let (uu, vv, uv) = (dot(u, u), dot(v, v), dot(u, v));
    let (from_u, from_v) = (dot(u, between), dot(v, between));
    let along = |numerator: f64, denominator: f64| {
        if denominator > 0.0 {
            (numerator / denominator).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    let first = along(uv * from_v - from_u * vv, uu * vv - uv * uv);
    let second = along(uv * first + from_v, vv);
    // Where the second was cut off at an end, the first moves with it.
    let first = along(uv * second - from_u, uu);
    let apart = add(between, subtract(scale(first, u), scale(second, v)));
    norm(apart)
}

/// Turns a vector by a rotation.
#[inline]
#[must_use]
pub fn rotate(rotation: Quaternion, vector: Vector) -> Vector {
    let imaginary = [rotation[1], rotation[2], rotation[3]];
    let twice = scale(2.0, cross(imaginary, vector));
    add(
        add(vector, scale(rotation[0], twice)),
        cross(imaginary, twice),
    )
}

/// `a + b`.
#[inline]
#[must_use]
pub fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
#[inline]
#[must_use]
pub fn subtract(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `factor * vector`.
#[inline]
#[must_use]
pub fn scale(factor: f64, vector: Vector) -> Vector {
    [factor * vector[0], factor * vector[1], factor * vector[2]]
}

/// The vector product of `a` and `b`.
#[inline]
#[must_use]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The scalar product of `a` and `b`.
#[inline]
#[must_use]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The Euclidean length of a vector.
#[inline]
#[must_use]
pub fn norm(vector: Vector) -> f64 {
    dot(vector, vector).sqrt()
}

/// Whether `a` and `b` differ by at most `tolerance` along each axis.
#[must_use]
pub fn within_box(a: Vector, b: Vector, tolerance: Vector) -> bool {
    (0..3).all(|axis| (a[axis] - b[axis]).abs() <= tolerance[axis])
}

/// Principal moments (kg m²) of a solid box of full edge lengths `edges_m` about its centre.
#[must_use]
pub fn box_inertia(mass_kg: f64, edges_m: Vector) -> Vector {
    let [x, y, z] = edges_m.map(|edge| edge * edge);
    [y + z, x + z, x + y].map(|sum| mass_kg * sum / 12.0)
}

/// Principal moments (kg m²) of a solid cylinder along z about its centre.
#[must_use]
pub fn cylinder_inertia(mass_kg: f64, length_m: f64, radius_m: f64) -> Vector {
    let across = mass_kg * (3.0 * radius_m * radius_m + length_m * length_m) / 12.0;
    [across, across, mass_kg * radius_m * radius_m / 2.0]
}

/// Principal moments (kg m²) of a solid sphere about its centre.
#[must_use]
pub fn sphere_inertia(mass_kg: f64, radius_m: f64) -> Vector {
    [0.4 * mass_kg * radius_m * radius_m; 3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn assert_close(a: &[f64], b: &[f64]) {
        for (left, right) in a.iter().zip(b) {
            assert!((left - right).abs() < 1e-12, "{a:?} is not {b:?}");
        }
    }

    #[test]
    fn roll_pitch_yaw_turns_about_the_fixed_axes_in_that_order() {
        // Roll a quarter turn: y goes to z; then yaw a quarter turn: z stays, x goes to y.
        let rotation = from_roll_pitch_yaw([FRAC_PI_2, 0.0, FRAC_PI_2]);
        assert_close(&rotate(rotation, [0.0, 1.0, 0.0]), &[0.0, 0.0, 1.0]);
        assert_close(&rotate(rotation, [1.0, 0.0, 0.0]), &[0.0, 1.0, 0.0]);
    }

    #[test]
    fn composition_applies_the_inner_rotation_first() {
        let inner = about([1.0, 0.0, 0.0], 0.3);
        let outer = about([0.2, 1.0, -0.4], 1.1);
        let vector = [0.3, -0.7, 1.9];
        let both = rotate(compose(outer, inner), vector);
        assert_close(&both, &rotate(outer, rotate(inner, vector)));
    }

    #[test]
    fn solids_have_the_textbook_inertia() {
        // A 12 kg cube of 1 m: m (a² + a²) / 12 = 2 kg m² about each axis.
        assert_close(&box_inertia(12.0, [1.0; 3]), &[2.0; 3]);
        // A thin rod, m l² / 12, and a disc, m r² / 2.
        assert_close(&cylinder_inertia(12.0, 1.0, 0.0), &[1.0, 1.0, 0.0]);
        assert_close(&cylinder_inertia(2.0, 0.0, 1.0), &[0.5, 0.5, 1.0]);
        assert_close(&sphere_inertia(5.0, 1.0), &[2.0; 3]);
    }
}
