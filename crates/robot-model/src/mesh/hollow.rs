//! How far a mesh is from its convex hull.
//!
//! A closed surface is convex if and only if all its corners lie on one side of the plane of each triangle. The depth of
//! a triangle is the distance of the farthest corner on the side with the nearer farthest one, so that it does not
//! matter which way triangles face; the depth of the mesh is the greatest of them: 0 for a convex one, and at least the
//! depth of its deepest hollow for another. Triangles of less than a millionth of the extent squared have no plane
//! worth the name and are passed over.
//!
//! Cost: triangles times corners, at most [`MOST`]; of larger meshes every n-th triangle is looked at, evenly, so a
//! hollow of few triangles may be missed. The depth is then a lower bound.

use super::Mesh;
use crate::pose::{cross, dot, length, scaled, subtract};

/// How many distances are computed at most.
const MOST: usize = 20_000_000;

/// The depth in metres, and the extent of the mesh (the greatest edge of its box).
pub(super) fn depth_and_extent(mesh: &Mesh) -> (f64, f64) {
    let axis = |axis: usize| mesh.vertices_m.iter().map(move |corner| corner[axis]);
    let extent = (0..3)
        .map(|i| axis(i).fold(f64::NEG_INFINITY, f64::max) - axis(i).fold(f64::INFINITY, f64::min));
    let extent = extent.fold(0.0, f64::max);
    let work = mesh.triangles.len().saturating_mul(mesh.vertices_m.len());
    let every = work.div_ceil(MOST).max(1);
    let mut deepest: f64 = 0.0;
    for triangle in mesh.triangles.iter().step_by(every) {
        let [a, b, c] = triangle.map(|corner| mesh.vertices_m[corner as usize]);
        let normal = cross(subtract(b, a), subtract(c, a));
        let area = length(normal) / 2.0;
        if area < 1e-6 * extent * extent {
            continue;
        }
        let normal = scaled(normal, 0.5 / area);
        let (mut ahead, mut behind) = (0.0_f64, 0.0_f64);
        for corner in &mesh.vertices_m {
            let height = dot(normal, subtract(*corner, a));
            ahead = ahead.max(height);
            behind = behind.max(-height);
        }
        deepest = deepest.max(ahead.min(behind));
    }
    (deepest, extent)
}
