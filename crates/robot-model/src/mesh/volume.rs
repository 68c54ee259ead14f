//! Volume, centre and inertia of the body that triangles enclose.
//!
//! The sum over triangles of signed tetrahedra with the mean corner as apex: volume `a · (b × c) / 6`, centre
//! `(a + b + c) / 4`, second moments `V/20 (Σ v vᵀ + (Σ v)(Σ v)ᵀ)` (F. Tonon, "Explicit exact formulas for the 3-D
//! tetrahedron inertia tensor", Journal of Mathematics and Statistics 1(1), 2005). Exact for closed, consistently
//! oriented meshes; a mesh whose triangles all face inwards counts as if turned. Cost: linear in triangles.

use super::Mesh;
use crate::pose::{Vector, add, cross, dot, length, scaled, subtract};
use crate::shape::Inertial;

/// See [`Mesh::solid`].
pub(super) fn solid(mesh: &Mesh) -> Inertial {
    let apex = mean(&mesh.vertices_m);
    let mut volume = 0.0;
    let mut first = [0.0; 3];
    // xx, yy, zz, xy, xz, yz of the integral of x xᵀ.
    let mut second = [0.0; 6];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| subtract(mesh.vertices_m[corner as usize], apex));
        let part = dot(a, cross(b, c)) / 6.0;
        let sum = add(a, add(b, c));
        volume += part;
        first = add(first, scaled(sum, part / 4.0));
        let entry = |i: usize, j: usize| a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + sum[i] * sum[j];
        for (moment, (i, j)) in second.iter_mut().zip(PAIRS) {
            *moment += part / 20.0 * entry(i, j);
        }
    }
    let sign = if volume < 0.0 { -1.0 } else { 1.0 };
    if volume == 0.0 || !volume.is_finite() {
        return NOTHING;
    }
    let centre = scaled(first, 1.0 / volume);
    let mut about_centre = [0.0; 6];
    for ((result, moment), (i, j)) in about_centre.iter_mut().zip(second).zip(PAIRS) {
        *result = sign * (moment - volume * centre[i] * centre[j]);
    }
    let [xx, yy, zz, xy, xz, yz] = about_centre;
    Inertial {
        mass_kg: volume * sign,
        centre_m: add(centre, apex),
        tensor_kg_m2: [yy + zz, xx + zz, xx + yy, -xy, -xz, -yz],
    }
}

const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

const NOTHING: Inertial = Inertial {
    mass_kg: 0.0,
    centre_m: [0.0; 3],
    tensor_kg_m2: [0.0; 6],
};

fn mean(points: &[Vector]) -> Vector {
    let sum = points.iter().fold([0.0; 3], |sum, point| add(sum, *point));
    scaled(sum, 1.0 / points.len().max(1) as f64)
}

/// Whether points lie in no common plane, to a millionth of their extent.
pub(super) fn spans_a_volume(points: &[Vector]) -> bool {
    let farthest = |value: &dyn Fn(&Vector) -> f64| {
        let best = points.iter().max_by(|a, b| value(a).total_cmp(&value(b)));
        best.map(|point| (value(point), *point))
    };
    let Some(origin) = points.first().copied() else {
        return false;
    };
    let Some((extent, far)) = farthest(&|point| length(subtract(*point, origin))) else {
        return false;
    };
    let along = subtract(far, origin);
    let off_line = |point: &Vector| length(cross(along, subtract(*point, origin)));
    let Some((area, side)) = farthest(&off_line) else {
        return false;
    };
    let normal = cross(along, subtract(side, origin));
    let off_plane = |point: &Vector| dot(normal, subtract(*point, origin)).abs();
    let Some((volume, _)) = farthest(&off_plane) else {
        return false;
    };
    extent > 0.0 && area > 1e-6 * extent * extent && volume > 1e-6 * extent * area
}
