//! Convex hulls, for who looks at shapes.
//!
//! # Definition
//! The hull of points is the smallest convex body that has them all; its surface is given as
//! triangles, counter-clockwise seen from outside.
//!
//! Source: the incremental algorithm (M. Kallay, "The complexity of incremental convex hull
//! algorithms in R^d", 1984): a point outside takes away the triangles that it sees and is joined to
//! the edge of what is left. Deviation: all triangles are tried for each point. Cost: O(n f) for n
//! points and f triangles. Guarantee: for points that do not lie in one plane, no point is further
//! outside than 1e-9 of their extent times a small factor; for display, not for contact.

use std::collections::BTreeSet;

use crate::geometry::{Vector, cross, dot, norm, subtract};

/// The triangles of the hull of points, by their places; none if they lie in one plane.
///
/// ```
/// let corners: Vec<[f64; 3]> = (0..8).map(|i| [0, 1, 2].map(|axis| f64::from(i >> axis & 1))).collect();
/// assert_eq!(testbench::hull_triangles(&corners).len(), 12);
/// ```
#[must_use]
pub fn hull_triangles(points_m: &[Vector]) -> Vec<[usize; 3]> {
    let Some(first) = first_solid(points_m) else {
        return Vec::new();
    };
    let tolerance_m = tolerance(points_m);
    let [a, b, c, d] = first;
    let mut triangles = match beyond(points_m, [a, b, c], d) > 0.0 {
        true => vec![[a, c, b], [a, b, d], [b, c, d], [c, a, d]],
        false => vec![[a, b, c], [a, d, b], [b, d, c], [c, d, a]],
    };
    for point in 0..points_m.len() {
        if first.contains(&point) {
            continue;
        }
        let (seen, kept): (Vec<_>, Vec<_>) = triangles
            .iter()
            .copied()
            .partition(|triangle| beyond(points_m, *triangle, point) > tolerance_m);
        if seen.is_empty() {
            continue;
        }
        let edges: BTreeSet<(usize, usize)> = seen
            .iter()
            .flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)])
            .collect();
        // An edge of the hole is one whose other side is not seen.
        let rim = edges.iter().filter(|(a, b)| !edges.contains(&(*b, *a)));
        let joined = rim.map(|(a, b)| [*a, *b, point]);
        triangles = kept.into_iter().chain(joined).collect();
    }
    triangles
}

fn tolerance(points_m: &[Vector]) -> f64 {
    let largest = points_m
        .iter()
        .flatten()
        .fold(0.0_f64, |a, b| a.max(b.abs()));
    1e-9 * largest
}

/// How far a point is in front of a triangle's plane, in metres.
fn beyond(points_m: &[Vector], [a, b, c]: [usize; 3], point: usize) -> f64 {
    let from = |to: usize| subtract(points_m[to], points_m[a]);
    let normal = cross(from(b), from(c));
    let length = norm(normal);
    match length > 0.0 {
        true => dot(normal, from(point)) / length,
        false => 0.0,
    }
}

/// Four points that are not in one plane.
fn first_solid(points_m: &[Vector]) -> Option<[usize; 4]> {
    let least = 1e3 * tolerance(points_m);
    let best = |of: &dyn Fn(usize) -> f64| {
        let found = (0..points_m.len()).max_by(|a, b| of(*a).total_cmp(&of(*b)))?;
        (of(found) > least).then_some(found)
    };
    let a = 0;
    let b = best(&|point| norm(subtract(points_m[point], points_m[a])))?;
    let along = subtract(points_m[b], points_m[a]);
    let c =
        best(&|point| norm(cross(along, subtract(points_m[point], points_m[a]))) / norm(along))?;
    let d = best(&|point| beyond(points_m, [a, b, c], point).abs())?;
    Some([a, b, c, d])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    /// By the divergence theorem.
    fn volume(points_m: &[Vector], triangles: &[[usize; 3]]) -> f64 {
        let each = triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|at| points_m[at]);
            dot(a, cross(b, c)) / 6.0
        });
        each.sum()
    }

    #[test]
    fn a_box_with_points_within_and_on_it_has_its_volume() {
        let mut points: Vec<Vector> = (0..27)
            .map(|i| [i % 3, i / 3 % 3, i / 9].map(|at| f64::from(at) / 2.0))
            .collect();
        points.push([0.3, 0.4, 0.5]);
        let triangles = hull_triangles(&points);
        assert!((volume(&points, &triangles) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn no_point_is_outside_and_the_surface_is_closed() {
        let mut stream = Stream::new(7, 1_u32);
        let points: Vec<Vector> = (0..300)
            .map(|_| [0, 1, 2].map(|_| stream.standard_normal()))
            .collect();
        let triangles = hull_triangles(&points);
        for triangle in &triangles {
            let furthest = (0..points.len()).map(|point| beyond(&points, *triangle, point));
            assert!(furthest.fold(0.0, f64::max) < 1e-7);
        }
        let edges: BTreeSet<(usize, usize)> = triangles
            .iter()
            .flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)])
            .collect();
        assert_eq!(edges.len(), 3 * triangles.len());
        assert!(edges.iter().all(|(a, b)| edges.contains(&(*b, *a))));
        assert!(volume(&points, &triangles) > 0.0);
    }

    #[test]
    fn points_in_a_plane_or_too_few_have_none() {
        let flat: Vec<Vector> = (0..9)
            .map(|i| [f64::from(i % 3), f64::from(i / 3), 2.0])
            .collect();
        assert!(hull_triangles(&flat).is_empty());
        assert!(hull_triangles(&flat[..2]).is_empty());
        assert!(hull_triangles(&[]).is_empty());
        assert!(hull_triangles(&[[1.0; 3]; 5]).is_empty());
    }
}
