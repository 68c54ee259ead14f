//! What can be seen of a run: shapes on bodies, and where the bodies are over time.
//!
//! A [`Watch`] that has a [`Viewer`] is told, each time the bench writes the truth
//! down, where every body is. Looking changes nothing: the recording is the same to the byte.
//!
//! Poses are those of bodies' frames in the world, metres and `[w, x, y, z]`; a shape's pose is in
//! its body's frame.

use crate::bench::{Control, Watch};
use crate::geometry::Pose;
use crate::physics::Form;

/// What something is, for who looks at it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Part of a robot.
    Robot,
    /// What is handled, or stands about and can move.
    Object,
    /// Part of a person.
    Person,
    /// What never moves.
    Surroundings,
}

/// A shape on a body.
#[derive(Debug, Clone, PartialEq)]
pub struct VisibleShape {
    /// Its name, unique among shapes.
    pub name: String,
    /// Place of its body in [`Geometry::bodies`]; `None` for the world.
    pub body: Option<usize>,
    /// What it belongs to.
    pub role: Role,
    /// Its frame in the body's.
    pub pose: Pose,
    /// Its form.
    pub form: Form,
}

/// Everything that can be seen.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Geometry {
    /// The names of the bodies, each once.
    pub bodies: Vec<String>,
    /// Their shapes, and those of the world.
    pub shapes: Vec<VisibleShape>,
}

/// Something that sees where bodies are.
pub trait Viewer {
    /// The bodies are at `poses`, in the order of [`Geometry::bodies`]. Times rise. `geometry` is
    /// the same during a run; it is made when it is called.
    fn see(&mut self, time_secs: f64, geometry: &dyn Fn() -> Geometry, poses: &[Pose]);
}

/// Keeps all that is seen of a run, and lets it go on to its own end.
///
/// ```
/// use testbench::geometry::{IDENTITY, Pose};
/// use testbench::{Geometry, ViewKeeper, Viewer, Watch};
///
/// let mut keeper = ViewKeeper::default();
/// let pose = Pose { position_m: [1.0, 0.0, 0.5], orientation: IDENTITY };
/// let viewer = keeper.viewer().ok_or("it looks at poses")?;
/// viewer.see(0.0, &|| Geometry { bodies: vec!["cup".into()], shapes: vec![] }, &[pose]);
/// assert_eq!((keeper.geometry.bodies[0].as_str(), keeper.times_secs[0]), ("cup", 0.0));
/// assert_eq!(keeper.poses[0], [pose]);
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ViewKeeper {
    /// What was seen.
    pub geometry: Geometry,
    /// When.
    pub times_secs: Vec<f64>,
    /// Where, for each time, in the order of the bodies.
    pub poses: Vec<Vec<Pose>>,
}

impl Watch for ViewKeeper {
    fn row(&mut self, _: usize, _: f64, _: &[f64]) -> Control {
        Control::Continue
    }

    fn viewer(&mut self) -> Option<&mut dyn Viewer> {
        Some(self)
    }
}

impl Viewer for ViewKeeper {
    fn see(&mut self, time_secs: f64, geometry: &dyn Fn() -> Geometry, poses: &[Pose]) {
        if self.times_secs.is_empty() {
            self.geometry = geometry();
        }
        self.times_secs.push(time_secs);
        self.poses.push(poses.to_vec());
    }
}
