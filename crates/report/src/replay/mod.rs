//! One episode as a page: what moved, in three dimensions, with the signals and
//! verdicts of the requirement beside it.
//!
//! The page is one file that opens offline: geometry, poses and signals are in
//! it, and a renderer of its own (WebGL). Without script or WebGL everything
//! but the moving picture is still there. As elsewhere in this crate nothing is
//! computed: poses are rounded and thinned for display, and the page says so.
//!
//! ```
//! use report::replay::{Form, Replay, Role, Scene, Shape};
//! let still = ([0.0, 0.0, 0.5], [1.0, 0.0, 0.0, 0.0]);
//! let moved = ([0.4, 0.0, 0.5], [1.0, 0.0, 0.0, 0.0]);
//! let replay = Replay {
//!     title: "The cup is dropped".into(),
//!     scene: Scene {
//!         bodies: vec!["cup".into()],
//!         shapes: vec![Shape {
//!             body: Some(0), role: Role::Object, pose: ([0.0; 3], [1.0, 0.0, 0.0, 0.0]),
//!             form: Form::Cylinder { radius_m: 0.04, length_m: 0.1 },
//!         }],
//!         times_secs: vec![0.0, 0.02],
//!         poses: vec![vec![still], vec![moved]],
//!     },
//!     ..Replay::default()
//! };
//! assert!(report::replay::html(&replay).starts_with("<!DOCTYPE html>"));
//! ```

mod data;
mod page;
mod strip;

pub use evidence::replay::{
    Form, Mark, Pose, Replay, Role, Scene, Shape, Signal, SignalKind, Tone, Verdict,
};

/// The replay as one HTML file that opens offline.
pub fn html(replay: &Replay) -> String {
    page::render(replay)
}
