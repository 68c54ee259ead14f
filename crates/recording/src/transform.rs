//! Coordinate frames: a tree of transforms over time, as published on `/tf` and `/tf_static`.
//!
//! # Definition
//! A [`Transform`] of frame c in frame p is a rotation R and a translation t (metres) with
//! x_p = R x_c + t: it takes the coordinates of a point in c to those in p, and it is the pose of
//! c seen from p. Each frame has at most one parent at a time, so frames form a forest. For two
//! frames a and b with the lowest common ancestor r, the pose of b in a is
//! (T_r,a)^-1 T_r,b, where T_r,a is the product of the transforms on the way from r down to a.
//!
//! Between two samples at t_i < t_(i+1) with u = (t - t_i) / (t_(i+1) - t_i), a translation is
//! (1 - u) p_i + u p_(i+1), and a rotation is interpolated spherically along the shorter arc
//! (K. Shoemake, "Animating rotation with quaternion curves", SIGGRAPH 1985, section 3.3). This is
//! what ROS's tf2 does.
//!
//! # Guarantees
//! Nothing is extrapolated: outside its samples a transform has no value, and [`LookupError`] says
//! which one was missing. Samples whose quaternion is not of unit length (by more than 1 %) are
//! refused with a [`TransformProblem`], as are loops and frames with two kinds of parents.
//! Deviation from tf2: a change of parent is not bridged, so that between the last sample under
//! the old parent and the first under the new one there is no value; a second sample for one time
//! never replaces the first; and "the latest" is never taken for an asked time.
//!
//! # Cost
//! Inserting in order takes O(1), looking up O(depth of the tree * log(samples kept)). The memory
//! is bounded by the history kept for each frame.
//!
//! # Example
//! ```
//! use recording::{Transform, TransformBuffer};
//! let mut buffer = TransformBuffer::new(10.0);
//! let quarter_turn = std::f64::consts::FRAC_PI_4;
//! let turned = [0.0, 0.0, quarter_turn.sin(), quarter_turn.cos()]; // 90 degrees about z
//! buffer.insert("world", "base", 0.0, Transform::new([1.0, 0.0, 0.0], turned)?, true)?;
//! let hand = |x| Transform::new([x, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]);
//! buffer.insert("base", "hand", 1.0, hand(0.2)?, false)?;
//! buffer.insert("base", "hand", 2.0, hand(0.4)?, false)?;
//! let hand_in_world = buffer.lookup("world", "hand", 1.5)?;
//! assert!((hand_in_world.translation_m[0] - 1.0).abs() < 1e-12);
//! assert!((hand_in_world.translation_m[1] - 0.3).abs() < 1e-12);
//! assert!(buffer.lookup("world", "hand", 2.5).is_err()); // not yet known
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod buffer;
mod error;
mod history;
mod pose;

pub use buffer::{FrameId, TransformBuffer};
pub use error::{LookupError, TransformProblem};
pub use pose::Transform;
