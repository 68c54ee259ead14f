#![doc = include_str!("../README.md")]
//!
//! [`Assembly`] gathers several models into one world, with prefixes and poses. `examples/to_mjcf.rs` is a program that
//! loads a file with its meshes and prints MJCF.
//!
//! # What is read
//!
//! | | URDF | SDF | MJCF |
//! |---|---|---|---|
//! | links, inertias, primitives, meshes (STL, OBJ, MSH) | yes | yes | yes |
//! | joints | all; planar as three | all but gearbox; screw as two that are coupled | hinge, slide, ball, free; several to a body |
//! | frames | origins | `relative_to`, `attached_to`, `expressed_in`, placement frames | `frame`, `childclass`, every orientation |
//! | files | meshes | includes, meshes | includes, meshes |
//! | coupled joints | `mimic` | `mimic`, screws | `equality/joint` |
//! | drives | transmissions, `ros2_control` | no (plugins are gaps) | motor, position, velocity, affine general, at joints |
//! | sensors | those of `<gazebo>`, state interfaces | lidar, camera, IMU, contact, force and torque | of joints; others by name |
//!
//! Gaps: closed loops, plugins, lights and materials, contact parameters of particular engines, tendons, muscles,
//! flexible bodies, replicas, height fields, COLLADA meshes.
//!
//! All three may be written in xacro: it is expanded first ([`expand_xacro`]).
//!
//! # Robustness
//!
//! Texts are foreign: no input panics, document type declarations are refused (so nothing expands), nesting, includes,
//! triangles and corners are limited, numbers must be finite. The same text and files give the same tree.

pub mod actuator;
mod assembly;
mod checks;
pub mod diagnostics;
mod dynamics;
pub mod inverse;
mod kinematics;
pub mod mesh;
mod mjcf;
pub mod model;
mod packages;
pub mod pose;
mod reader;
mod sdf;
pub mod sensor;
pub mod shape;
mod tree;
mod urdf;
mod write;
mod xacro;
mod xml;

pub use actuator::{Actuator, ActuatorKind, Coupling};
pub use assembly::{Assembly, Base, NameTaken};
pub use diagnostics::{Effect, Gap, Place, Problem, Problems};
pub use dynamics::Unphysical;
pub use kinematics::WrongSize;
pub use mesh::Mesh;
pub use mjcf::parse_mjcf;
pub use model::{Format, Joint, JointKind, Link, Mark, Model};
pub use packages::{own_package_path, package_paths};
pub use pose::Pose;
pub use reader::{Loaded, Resolver};
pub use sdf::parse_sdf;
pub use sensor::{Camera, Fan, Lidar, Noise, Sensor, SensorKind};
pub use shape::{Friction, Geometry, Inertial, Mask, Role, Shape};
pub use urdf::parse_urdf;
pub use xacro::{Arguments, expand_xacro};

/// Reads a description in any of the languages, by its root element: `<robot>`, `<sdf>` or `<mujoco>`.
///
/// # Errors
/// All problems that prevent loading, with their places.
pub fn parse(file: &str, text: &str, resolve: &mut Resolver<'_>) -> Result<Loaded, Problems> {
    parse_with(file, text, &Arguments::new(), resolve)
}

/// The same of a xacro file with values of its `xacro:arg`s by name.
///
/// # Errors
/// As of [`parse`]; and if the description has no such argument.
pub fn parse_with(
    file: &str,
    text: &str,
    arguments: &Arguments,
    resolve: &mut Resolver<'_>,
) -> Result<Loaded, Problems> {
    let root = xml::read(file, text).map_err(|problem| Problems(vec![problem]))?;
    let mut reader = reader::Reader::new(resolve);
    let root = reader.expanded(root, arguments)?;
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
