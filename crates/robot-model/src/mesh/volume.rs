//! Volume, centre and inertia of the body that triangles enclose.
//!
//! The sum over triangles of signed pyramids: apex `p`, volume `V = (a - p) · ((b - p) × (c - p)) / 6`, centre
//! `(a + b + c + p) / 4`, second moments about the apex `V/20 (Σ v vᵀ + (Σ v)(Σ v)ᵀ)` (F. Tonon, "Explicit exact formulas
//! for the 3-D tetrahedron inertia tensor", Journal of Mathematics and Statistics 1(1), 2005). The centre is found with
//! the centroid of the surface as apex, the moments with the centre. Exact for closed, consistently oriented meshes,
//! whatever the apex; a mesh whose triangles all face inwards counts as if turned.
//!
//! MuJoCo's default (`inertia="legacy"`) counts every pyramid as positive, so that badly oriented meshes have a mass and
//! hollow or overhanging ones have too much. A mesh of an MJCF is computed like that, since that is what its text means.
//! Cost: linear in triangles.

use super::Mesh;
use crate::pose::{Vector, add, cross, dot, length, scaled, subtract};
use crate::shape::Inertial;

/// See [`Mesh::solid`].
pub(super) fn solid(mesh: &Mesh) -> Inertial {
    let centroid = surface_centroid(mesh);
    let mut volume = 0.0;
    let mut first = [0.0; 3];
    for [a, b, c] in corners(mesh, centroid) {
        let part = pyramid(mesh, [a, b, c]);
        volume += part;
        first = add(first, scaled(add(a, add(b, c)), part / 4.0));
    }
    if volume == 0.0 || !volume.is_finite() {
        return NOTHING;
    }
    let centre = add(centroid, scaled(first, 1.0 / volume));
    // xx, yy, zz, xy, xz, yz of the integral of x xᵀ about the centre.
    let mut second = [0.0; 6];
    let mut volume = 0.0;
    for [a, b, c] in corners(mesh, centre) {
        let part = pyramid(mesh, [a, b, c]);
        let sum = add(a, add(b, c));
        volume += part;
        let entry = |i: usize, j: usize| a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + sum[i] * sum[j];
        for (moment, (i, j)) in second.iter_mut().zip(PAIRS) {
            *moment += part / 20.0 * entry(i, j);
        }
    }
    let sign = if volume < 0.0 { -1.0 } else { 1.0 };
    let [xx, yy, zz, xy, xz, yz] = second.map(|moment| sign * moment);
    Inertial {
        mass_kg: volume * sign,
        centre_m: centre,
        tensor_kg_m2: [yy + zz, xx + zz, xx + yy, -xy, -xz, -yz],
    }
}

/// Volume of the pyramid over a triangle with the origin as apex.
fn pyramid(mesh: &Mesh, [a, b, c]: [Vector; 3]) -> f64 {
    let volume = dot(a, cross(b, c)) / 6.0;
    if mesh.unsigned_volume {
        volume.abs()
    } else {
        volume
    }
}

/// The corners of all triangles, seen from a point.
fn corners(mesh: &Mesh, from: Vector) -> impl Iterator<Item = [Vector; 3]> {
    mesh.triangles.iter().map(move |triangle| {
        triangle.map(|corner| subtract(mesh.vertices_m[corner as usize], from))
    })
}

/// The mean of the triangles' centres, weighted by area.
fn surface_centroid(mesh: &Mesh) -> Vector {
    let mut total = 0.0;
    let mut sum = [0.0; 3];
    for [a, b, c] in corners(mesh, [0.0; 3]) {
        let area = length(cross(subtract(b, a), subtract(c, a))) / 2.0;
        total += area;
        sum = add(sum, scaled(add(a, add(b, c)), area / 3.0));
    }
    if total > 0.0 {
        scaled(sum, 1.0 / total)
    } else {
        sum
    }
}

const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

const NOTHING: Inertial = Inertial {
    mass_kg: 0.0,
    centre_m: [0.0; 3],
    tensor_kg_m2: [0.0; 6],
};

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
