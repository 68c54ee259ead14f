//! Rigid transforms: a unit quaternion and a translation.

use super::error::TransformProblem;

/// How far the length of a quaternion may be from 1 before it is taken for a mistake. Single
/// precision and rounded text stay within 10^-3.
const LENGTH_TOLERANCE: f64 = 0.01;

/// A rotation followed by a translation: x -> R x + t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// The translation t in metres.
    pub translation_m: [f64; 3],
    /// The rotation R as a quaternion x, y, z, w of unit length.
    pub rotation_xyzw: [f64; 4],
}

impl Transform {
    /// The transform that changes nothing.
    pub const IDENTITY: Transform = Transform {
        translation_m: [0.0; 3],
        rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
    };

    /// A transform from a translation in metres and a quaternion x, y, z, w, which is normalised.
    ///
    /// # Errors
    /// [`TransformProblem`] if a number is not finite or the quaternion's length differs from 1 by
    /// more than 1 %, as that of a quaternion that was never set does.
    pub fn new(translation_m: [f64; 3], rotation_xyzw: [f64; 4]) -> Result<Self, TransformProblem> {
        let numbers = translation_m.iter().chain(&rotation_xyzw);
        if numbers.into_iter().any(|number| !number.is_finite()) {
            return Err(TransformProblem::NotFinite);
        }
        let length = dot(rotation_xyzw, rotation_xyzw).sqrt();
        if (length - 1.0).abs() > LENGTH_TOLERANCE {
            return Err(TransformProblem::NotUnit { length });
        }
        Ok(Transform {
            translation_m,
            rotation_xyzw: rotation_xyzw.map(|part| part / length),
        })
    }

    /// The coordinates in the parent frame of a point given in the child frame, in metres.
    #[must_use]
    pub fn apply(&self, point_m: [f64; 3]) -> [f64; 3] {
        let turned = rotate(self.rotation_xyzw, point_m);
        std::array::from_fn(|axis| turned[axis] + self.translation_m[axis])
    }

    /// The components in the parent frame of a free vector (a velocity, a force) given in the
    /// child frame; its unit stays.
    #[must_use]
    pub fn rotate(&self, vector: [f64; 3]) -> [f64; 3] {
        rotate(self.rotation_xyzw, vector)
    }

    /// The transform that undoes this one.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let [x, y, z, w] = self.rotation_xyzw;
        let rotation_xyzw = [-x, -y, -z, w];
        let translation_m = rotate(rotation_xyzw, self.translation_m).map(|part| -part);
        Transform {
            translation_m,
            rotation_xyzw,
        }
    }

    /// First `inner`, then this one: the pose of c in a from those of b in a and of c in b.
    #[must_use]
    pub fn then_inner(&self, inner: &Transform) -> Self {
        Transform {
            translation_m: self.apply(inner.translation_m),
            rotation_xyzw: normalised(product(self.rotation_xyzw, inner.rotation_xyzw)),
        }
    }

    /// The transform a share `u` in 0 to 1 of the way from this one to `other`: linear in the
    /// translation, spherical and by the shorter arc in the rotation.
    #[must_use]
    pub fn interpolate(&self, other: &Transform, u: f64) -> Self {
        let (from, to) = (self.translation_m, other.translation_m);
        Transform {
            translation_m: std::array::from_fn(|axis| (1.0 - u) * from[axis] + u * to[axis]),
            rotation_xyzw: slerp(self.rotation_xyzw, other.rotation_xyzw, u),
        }
    }

    /// The length of the translation in metres.
    #[must_use]
    pub fn distance_m(&self) -> f64 {
        let [x, y, z] = self.translation_m;
        x.hypot(y).hypot(z)
    }
}

fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    a.iter().zip(&b).map(|(a, b)| a * b).sum()
}

fn normalised(quaternion: [f64; 4]) -> [f64; 4] {
    let length = dot(quaternion, quaternion).sqrt();
    quaternion.map(|part| part / length)
}

/// The Hamilton product: rotating by `b`, then by `a`.
fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let ([ax, ay, az, aw], [bx, by, bz, bw]) = (a, b);
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// v + 2 q x (q x v + w v), with q the vector part.
fn rotate(rotation_xyzw: [f64; 4], vector: [f64; 3]) -> [f64; 3] {
    let [x, y, z, w] = rotation_xyzw;
    let axis = [x, y, z];
    let first = cross(axis, vector);
    let inner = std::array::from_fn(|i| first[i] + w * vector[i]);
    let second = cross(axis, inner);
    std::array::from_fn(|i| vector[i] + 2.0 * second[i])
}

fn slerp(from: [f64; 4], to: [f64; 4], u: f64) -> [f64; 4] {
    let cosine = dot(from, to);
    // q and -q are one rotation; the nearer of them gives the shorter arc.
    let (to, cosine) = if cosine < 0.0 {
        (to.map(|part| -part), -cosine)
    } else {
        (to, cosine)
    };
    let angle = cosine.min(1.0).acos();
    let (share_from, share_to) = if angle < 1e-6 {
        // The sines cancel; the chord differs from the arc by less than a double can hold.
        (1.0 - u, u)
    } else {
        let sine = angle.sin();
        (((1.0 - u) * angle).sin() / sine, (u * angle).sin() / sine)
    };
    normalised(std::array::from_fn(|i| {
        share_from * from[i] + share_to * to[i]
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn about_z(angle_rad: f64) -> [f64; 4] {
        [0.0, 0.0, (angle_rad / 2.0).sin(), (angle_rad / 2.0).cos()]
    }

    fn close(a: &[f64], b: &[f64]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
    }

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let turn = Transform::new([1.0, 2.0, 3.0], about_z(std::f64::consts::FRAC_PI_2)).unwrap();
        assert!(close(&turn.apply([1.0, 0.0, 0.0]), &[1.0, 3.0, 3.0]));
        assert!(close(&turn.rotate([0.0, 1.0, 0.5]), &[-1.0, 0.0, 0.5]));
    }

    #[test]
    fn interpolated_turns_about_one_axis_have_interpolated_angles() {
        for (from, to) in [(0.1, 2.9), (-1.0, 1.0), (0.0, 1e-7), (3.0, 3.0)] {
            let [a, b] = [from, to].map(|angle| Transform::new([0.0; 3], about_z(angle)).unwrap());
            for u in [0.0, 0.25, 0.5, 1.0] {
                let expected = about_z((1.0 - u) * from + u * to);
                let found = a.interpolate(&b, u).rotation_xyzw;
                assert!(close(&found, &expected), "{from} {to} {u}: {found:?}");
            }
        }
    }

    #[test]
    fn the_shorter_arc_is_taken() {
        // From 170 to 190 degrees, written as -170: through 180, not through 0.
        let [a, b] = [170_f64, -170_f64]
            .map(|angle| Transform::new([0.0; 3], about_z(angle.to_radians())).unwrap());
        let half = a.interpolate(&b, 0.5).rotate([1.0, 0.0, 0.0]);
        assert!(close(&half, &[-1.0, 0.0, 0.0]), "{half:?}");
    }

    #[test]
    fn what_is_no_rotation_is_refused() {
        let new = |rotation| Transform::new([0.0; 3], rotation);
        assert!(
            matches!(new([0.0; 4]), Err(TransformProblem::NotUnit { length }) if length == 0.0)
        );
        assert!(new([0.0, 0.0, 0.0, 1.02]).is_err());
        assert!(new([0.0, f64::NAN, 0.0, 1.0]).is_err());
        assert!(Transform::new([f64::INFINITY, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]).is_err());
        assert_eq!(new([0.0, 0.0, 0.0, 1.005]).unwrap(), Transform::IDENTITY);
    }

    fn any_transform() -> impl Strategy<Value = Transform> {
        let part = -1.0..1.0_f64;
        let quaternion = [part.clone(), part.clone(), part.clone(), part];
        let quaternion = quaternion.prop_filter("too short to normalise", |q| dot(*q, *q) > 0.01);
        (prop::array::uniform3(-5.0..5.0_f64), quaternion)
            .prop_map(|(t, q)| Transform::new(t, normalised(q)).unwrap())
    }

    proptest! {
        #[test]
        fn transforms_form_a_group(a in any_transform(), b in any_transform(),
                                   point in prop::array::uniform3(-5.0..5.0_f64)) {
            let both = a.then_inner(&b);
            prop_assert!(close(&both.apply(point), &a.apply(b.apply(point))));
            prop_assert!(close(&a.inverse().apply(a.apply(point)), &point));
            let back = both.then_inner(&both.inverse());
            prop_assert!(close(&back.translation_m, &[0.0; 3]));
        }
    }
}
