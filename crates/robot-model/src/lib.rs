//! A robot's or scene's description in URDF, SDF or MJCF to one tree of links, joints and shapes.
pub mod actuator;
mod assembly;
mod checks;
pub mod diagnostics;
mod kinematics;
pub mod mesh;
mod mjcf;
pub mod model;
pub mod pose;
mod reader;
mod sdf;
pub mod sensor;
pub mod shape;
mod tree;
mod urdf;
mod write;
mod xml;

pub use actuator::{Actuator, ActuatorKind, Coupling};
pub use assembly::{Assembly, Base, NameTaken};
pub use diagnostics::{Effect, Gap, Place, Problem, Problems};
pub use kinematics::WrongSize;
pub use mesh::Mesh;
pub use mjcf::parse_mjcf;
pub use model::{Format, Joint, JointKind, Link, Mark, Model};
pub use pose::Pose;
pub use reader::{Loaded, Resolver};
pub use sdf::parse_sdf;
pub use sensor::{Camera, Fan, Lidar, Noise, Sensor, SensorKind};
pub use shape::{Friction, Geometry, Inertial, Mask, Role, Shape};
pub use urdf::parse_urdf;

/// Reads a description in any of the languages, by its root element: `<robot>`, `<sdf>` or `<mujoco>`.
///
/// # Errors
/// All problems that prevent loading, with their places.
pub fn parse(file: &str, text: &str, resolve: &mut Resolver<'_>) -> Result<Loaded, Problems> {
    let root = xml::read(file, text).map_err(|problem| Problems(vec![problem]))?;
    let mut reader = reader::Reader::new(resolve);
    let model = match root.name.as_str() {
        "robot" => urdf::robot(&mut reader, &root),
        "mujoco" => mjcf::document(&mut reader, root),
        "sdf" | "gazebo" => sdf::document(&mut reader, root),
        other => {
            let message = format!("<{other}> starts no robot description");
            let remedy = "name a URDF (<robot>), an SDF (<sdf>) or an MJCF (<mujoco>) file";
            reader.problem(&root.place, message, remedy);
            None
        }
    };
    reader.finish(model)
}
pub use write::{Mjcf, MjcfError, MjcfOptions, shape_name, to_mjcf};
