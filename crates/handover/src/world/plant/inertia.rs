//! The inertia of links that move as one.
//!
//! A composite is held as mass `m`, first moment `m c` and the inertia about the frame's origin, so
//! that composites add up (Featherstone, "Rigid Body Dynamics Algorithms", 2008, section 2.13).

use testbench::geometry::{
    IDENTITY, Pose, Vector, add, cross, dot, inverse, rotate, scale, subtract,
};

use super::body::{Blueprint, Configuration};
use super::joints::DrivenJoint;
use super::tree::Tree;

/// Mass, first moment and inertia about a frame's origin, by rows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Composite {
    mass_kg: f64,
    first_kg_m: Vector,
    about_origin_kg_m2: [Vector; 3],
}

impl Composite {
    /// Takes in another composite of the same frame.
    #[inline]
    pub(super) fn add(&mut self, other: &Self) {
        self.mass_kg += other.mass_kg;
        self.first_kg_m = add(self.first_kg_m, other.first_kg_m);
        for row in 0..3 {
            let sum = add(self.about_origin_kg_m2[row], other.about_origin_kg_m2[row]);
            self.about_origin_kg_m2[row] = sum;
        }
    }

    /// A body with its principal moments about its centre, which is at `pose`.
    fn body(mass_kg: f64, moments_kg_m2: Vector, pose: &Pose) -> Self {
        let centre = pose.position_m;
        let row = |axis: usize| {
            let mut unit = [0.0; 3];
            unit[axis] = 1.0;
            let inner = rotate(inverse(pose.orientation), unit);
            let inner = [0, 1, 2].map(|i| moments_kg_m2[i] * inner[i]);
            let steiner = subtract(
                scale(dot(centre, centre), unit),
                scale(centre[axis], centre),
            );
            add(rotate(pose.orientation, inner), scale(mass_kg, steiner))
        };
        Self {
            mass_kg,
            first_kg_m: scale(mass_kg, centre),
            about_origin_kg_m2: [row(0), row(1), row(2)],
        }
    }

    /// The same composite in the outer frame in which its own stands at `pose`.
    pub(super) fn placed(&self, pose: &Pose) -> Self {
        let shift = pose.position_m;
        // The columns of the rotation's matrix R; R I R' has the entry u . (I v) for rows u and v.
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|unit| rotate(pose.orientation, unit));
        let rows: [Vector; 3] =
            std::array::from_fn(|row| [columns[0][row], columns[1][row], columns[2][row]]);
        let across = [
            self.times(rows[0]),
            self.times(rows[1]),
            self.times(rows[2]),
        ];
        let first = [
            dot(rows[0], self.first_kg_m),
            dot(rows[1], self.first_kg_m),
            dot(rows[2], self.first_kg_m),
        ];
        // Parallel axes for a shift by s of a body with first moment f: the inertia gains
        // (2 f.s + m s.s) 1 - (f s' + s f' + m s s').
        let trace = 2.0 * dot(first, shift) + self.mass_kg * dot(shift, shift);
        let mut about_origin_kg_m2 = [[0.0; 3]; 3];
        for (row, entries) in about_origin_kg_m2.iter_mut().enumerate() {
            for (column, entry) in entries.iter_mut().enumerate() {
                *entry = dot(rows[row], across[column])
                    - first[row] * shift[column]
                    - shift[row] * (first[column] + self.mass_kg * shift[column]);
            }
            entries[row] += trace;
        }
        Self {
            mass_kg: self.mass_kg,
            first_kg_m: add(first, scale(self.mass_kg, shift)),
            about_origin_kg_m2,
        }
    }

    #[inline]
    fn times(&self, vector: Vector) -> Vector {
        let [x, y, z] = self.about_origin_kg_m2;
        [dot(x, vector), dot(y, vector), dot(z, vector)]
    }

    /// Momentum, and angular momentum about the origin, when it turns at `spin_rad_s` and what of it
    /// is at the origin moves at `origin_m_s`.
    #[inline]
    pub(super) fn momenta(&self, spin_rad_s: Vector, origin_m_s: Vector) -> (Vector, Vector) {
        (
            add(
                scale(self.mass_kg, origin_m_s),
                cross(spin_rad_s, self.first_kg_m),
            ),
            add(self.times(spin_rad_s), cross(self.first_kg_m, origin_m_s)),
        )
    }
}

/// For each joint of a tree what turns with it and not with the next, in the frame behind it.
pub(super) fn segments(
    blueprint: &Blueprint,
    joints: &[DrivenJoint],
    now: &Configuration,
    tree: &Tree,
) -> Vec<Composite> {
    let mut segments = vec![Composite::default(); tree.nodes.len()];
    for link in &blueprint.scenario.bodies {
        let (node, frame) = tree.place_of(&blueprint.scenario, joints, now, link);
        let Some(node) = node else { continue };
        let centre = frame.then(&Pose {
            position_m: link.shape_position_m,
            orientation: IDENTITY,
        });
        let moments = crate::model::link_inertia_kg_m2(&blueprint.parameters, link);
        segments[node].add(&Composite::body(link.mass_kg, moments, &centre));
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::*;
    use testbench::geometry::about;

    #[test]
    fn a_composite_moved_on_is_the_body_moved_on() {
        let place = |position_m, axis, angle| Pose {
            position_m,
            orientation: about(axis, angle),
        };
        let inner = place([0.3, -0.2, 0.5], [1.0, 0.4, -0.3], 0.8);
        let outer = place([-1.0, 0.7, 0.2], [0.2, -1.0, 0.6], 1.9);
        let moments = [0.02, 0.05, 0.04];
        let moved = Composite::body(1.5, moments, &inner).placed(&outer);
        let there = Composite::body(1.5, moments, &outer.then(&inner));
        for row in 0..3 {
            assert!((moved.first_kg_m[row] - there.first_kg_m[row]).abs() < 1e-12);
            let apart = subtract(moved.about_origin_kg_m2[row], there.about_origin_kg_m2[row]);
            assert!(dot(apart, apart) < 1e-24, "{moved:?} {there:?}");
        }
    }

    #[test]
    fn a_point_on_a_lever_has_the_textbook_momenta() {
        // 2 kg at x = 3, turning about the z axis through x = 1: 2 * 2 = 4 kg m/s along y, and about
        // the origin 3 * 4 = 12.
        let place = Pose {
            position_m: [3.0, 0.0, 0.0],
            orientation: IDENTITY,
        };
        let point = Composite::body(2.0, [0.0; 3], &place);
        let (momentum, about_origin) = point.momenta([0.0, 0.0, 1.0], [0.0, -1.0, 0.0]);
        assert_eq!(momentum, [0.0, 4.0, 0.0]);
        assert_eq!(about_origin, [0.0, 0.0, 12.0]);
    }
}
