//! Scenes: any robot, from its own description, among things and people, with its own code.
//!
//! A scene is TOML: robots and objects from URDF, SDF or MJCF files (or plain shapes), actuators,
//! sensors with rates, noise, bias, latency, dropout and faults, people who walk and react, and
//! controllers, which run behind [`crate::controller`]. It is a [`crate::Bench`]: a stimulus (an
//! abstract test and settings of the scene's data by dotted keys) and a seed give a recording, bit
//! for bit.
//!
//! ```
//! use std::sync::Arc;
//! use stimulus::Stimulus;
//! use testbench::controller::ControllerError;
//! use testbench::scene::{SceneBench, mujoco};
//! use testbench::{Bench, Cancel, Engine, Unwatched};
//!
//! let scene = r#"
//!     name = "a ball falls beside a person"
//!     simulation = { duration_secs = 1.0 }
//!     ground = { friction = 0.8 }
//!     abstract_test = [{ name = "wait", actions = [] }]
//!     [[object]]
//!     name = "ball"
//!     radius_m = 0.1
//!     mass_kg = 1.0
//!     z_m = { uniform = [0.5, 1.0] }
//!     [[person]]
//!     name = "anna"
//!     x_m = 1.0
//!     y_m = 0.0
//!     waypoint = [{ x_m = 2.0, y_m = 0.0 }]
//! "#;
//! # let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
//! # let library = root.join(".tools/mujoco-3.17.0/libmujoco.so.3.17.0");
//! # if !library.exists() { return Ok(()); }
//! let engine = Engine::load(&library)?;
//! let no_files = |file: &str| Err(format!("there is no {file}"));
//! let no_code = Arc::new(|_: &_| Err(ControllerError::Failed { message: "none".into() }));
//! let (bench, gaps) = SceneBench::new(scene, &no_files, mujoco(&engine), no_code)?;
//! assert!(gaps.is_empty());
//! let wait = Stimulus::of(bench.tests()[0].clone());
//! let recorded = bench.run(&wait, 7, &mut Unwatched, &Cancel::default())?;
//! assert!(recorded.trace.signal("/truth/anna.speed").is_some());
//! # Ok::<(), testbench::SimError>(())
//! ```
//!
//! # What a recording holds
//!
//! | topic | rate | signals |
//! |---|---|---|
//! | `/truth/ROBOT` | `record_hz` | `x`, `y`, `z`, `yaw`, `speed`, `turn_rate` of the root; `person_distance` between the surfaces of the robot and the nearest person; `person_force` and `other_force`, the largest sums of contact forces (the ground's aside) since the row before; of recorded joints `JOINT.position` and `.velocity` |
//! | `/truth/PERSON` | `record_hz` | `x`, `y`, `heading`, `speed`, `robot_distance`, `activity`, `reacting`, `distracted`, `arrived`; of one with arms the hands; of one who takes something `holding` |
//! | `/sensor/SENSOR` | when a measurement arrives | `measured_at`, `faulty`, and what it measured; a lidar's nearest range, its place and the number of returns, or all with `record_all` |
//! | `/command/ACTUATOR` | when a command takes effect, and when a fault begins or ends | the commanded values; `faulty` |
//! | `/group/GROUP` | `record_hz` | for each joint `JOINT.position`, `.velocity` and `.reference`; `moving`; `distance_left` and `angle_left`, by which the last goal was out of reach; `failed`, whether it was |
//! | `/gripper/GRIPPER` | `record_hz` | `holding` (a name, or `nothing`), `attached`, `force` by which what is attached is held; of a parallel one its `width` |
//! | `/controller/CONTROLLER` | each tick | `finished`, `said.MESSAGE` for each message that it may send, and what it reports |
//! | `/test` | `record_hz` | `actions_done`, `done` |
//!
//! Whatever else is true is recorded if somebody names it ([`SceneBench::record_truth`], [`SceneBench::truth`]): behind the fields
//! of a topic above, or as topics of its own behind `/test`.
//!
//! # Tests
//!
//! `send_signal` sends a message to the controllers that receive it; `receive_signal` waits for a
//! message of theirs, for `PERSON.arrived` or `PERSON.took`; `set_param` sets `PERSON.activity` (`stand`, `walk`,
//! `approach`, `follow`), `PERSON.speed_m_s`, `PERSON.distracted`, `PERSON.arms` (`swing`, `reach`,
//! `carry`, `withdraw`), `SENSOR.fault` (`none`, `stuck`, `silent`) and `ACTUATOR.fault` (`none`, `stuck`, `limp`), and it
//! commands groups and grippers as a controller would: `GRIPPER.width_m`, `GROUP.JOINT_rad`. A trajectory begins when its name is
//! sent; `TRAJECTORY.done` can be awaited, and `TRAJECTORY.failed`, which comes instead where a waypoint is out of reach.
//!
//! # Parts that are not simulated
//!
//! [`RunningScene::measure_outside`] puts measurements from outside in the place of a sensor's own, so
//! that hardware runs in the loop with a simulated rest.
//!
//! # What is modelled how
//!
//! * People go where their behaviour says and push what is in their way; nothing pushes them unless
//!   their body is compliant, and they do not avoid walls. Feet do not bear on the floor. Between people
//!   who do not give way and what is fixed to the world no force is known; their distance is.
//! * A robot whose root is free rests on its own wheels or feet by contact and friction. Links of
//!   one robot do not touch each other unless its description asks for it. Contact masks of MJCF are
//!   carried over only where a shape touches nothing.
//! * A lidar's rays are taken at one instant. Distances are between collision shapes; a mesh counts
//!   as its convex hull.
//! * Drives are those of the scene (actuators, groups, grippers); those that a description names (transmissions, actuators) are not
//!   used.
//! * What a gripper attaches (a cup, a tool changer, `attach = "when-grasped"`) is held by a spring and a damper, the same in
//!   both engines, not by a weld; a parallel gripper's servo has its full force at 2 % of its way.
//! * Goals of groups are rested at: waypoints are not blended.
//! * Cameras find markers and measure depth by rays; they have no picture. What a link bears follows in Rapier
//!   from momenta and contacts; of one that is fixed to the world it is known to MuJoCo alone.
//! * Lights, sound, soft bodies and slopes of the ground are absent.

mod actuating;
mod attachment;
mod bench;
mod build;
mod capture;
mod cautions;
mod compliant;
mod data;
mod draws;
mod drive_errors;
mod fingers;
mod gaps;
mod grip;
mod gripping;
mod grouping;
mod inertia;
mod load;
mod materials;
mod measure;
mod person;
mod piloting;
mod profile;
mod recorder;
mod run;
mod saving;
mod script;
mod sensing;
mod taking;
mod translate;
mod truth;
mod vision;
mod walker;
mod wrench;

pub use bench::{BuildPhysics, Checked, SceneBench, StartController, mujoco, rapier};
pub use cautions::Caution;
pub use data::{
    Activity, Actuator, ActuatorFault, ActuatorFaultKind, ActuatorKind, ArmAngles, ArmPose, Attach,
    Avoidance, Capture, CaptureAxis, CaptureNames, CaptureUnit, Compliance, ConeKind,
    ControllerData, Fault, FaultKind, Gripper, GripperKind, Ground, Group, GroupMode,
    GroupWaypoint, Hesitation, JointGroup, Material, MujocoKeys, Object, PerJoint, Person,
    PersonBody, PlaceKeys, ProfileKind, RapierKeys, Reaction, ReactionKind, Region, Robot,
    SceneData, Sensor, SensorKind, Simulation, Takes, ToolPoint, Trajectory, TruthKeys, Waypoint,
};
pub use draws::drawn_number;
pub use gaps::{SceneGap, description_gaps};
pub use saving::{RunningScene, SavedScene};
pub use truth::{TruthPattern, TruthTopic, TruthVocabulary, UnknownTruth};
