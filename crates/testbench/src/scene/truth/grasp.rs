//! Who holds what between two of its bodies.
//!
//! Definition: a holder grasps an object if two of its bodies touch it with normals more than 120 degrees apart, each with at
//! least the scene's `truth.grasp_newtons`. Of several holders the one that presses most.

use crate::geometry::{Vector, dot, scale};
use crate::physics::{Layout, Touch};

/// The cosine of the angle beyond which two fingers oppose each other.
const OPPOSED: f64 = -0.5;

/// A touch of a holder with the object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::scene) struct Finger {
    pub(in crate::scene) body: usize,
    pub(in crate::scene) shapes: [usize; 2],
    /// From the finger into the object, in the world.
    pub(in crate::scene) into: Vector,
    pub(in crate::scene) normal_newtons: f64,
    pub(in crate::scene) tangential_newtons: f64,
}

/// The touches of a holder's shapes with an object's, if the holder grasps it.
pub(in crate::scene) fn grasp(
    layout: &Layout,
    touches: &[Touch],
    holder: &dyn Fn(usize) -> bool,
    object: &dyn Fn(usize) -> bool,
    least_newtons: f64,
) -> Option<Vec<Finger>> {
    let fingers: Vec<Finger> = touches
        .iter()
        .filter_map(|touch| {
            let [a, b] = touch.shapes;
            let (shapes, into) = match (holder(a) && object(b), holder(b) && object(a)) {
                (true, _) => ([a, b], touch.normal),
                (_, true) => ([b, a], scale(-1.0, touch.normal)),
                _ => return None,
            };
            Some(Finger {
                body: layout.shapes[shapes[0]].body?,
                shapes,
                into,
                normal_newtons: touch.normal_newtons,
                tangential_newtons: touch.tangential_newtons,
            })
        })
        .collect();
    let pressing = |finger: &&Finger| finger.normal_newtons >= least_newtons.max(1e-12);
    let pressing: Vec<&Finger> = fingers.iter().filter(pressing).collect();
    let opposes = |a: &Finger, b: &Finger| a.body != b.body && dot(a.into, b.into) < OPPOSED;
    let is_grasped = pressing
        .iter()
        .any(|a| pressing.iter().any(|b| opposes(a, b)));
    is_grasped.then_some(fingers)
}

/// How hard fingers press together.
pub(in crate::scene) fn pressed_newtons(fingers: &[Finger]) -> f64 {
    fingers.iter().map(|finger| finger.normal_newtons).sum()
}
