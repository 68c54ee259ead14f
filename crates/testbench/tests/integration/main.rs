//! All integration tests of the crate in one program, since each program costs a link.

mod capture;
mod cautions;
mod common;
mod compliant;
mod engines;
mod fingers;
mod grippers;
mod groups;
mod physics;
mod physics_actuators;
mod physics_contact;
mod physics_energy;
mod physics_engines;
mod physics_sensors;
mod robot_model;
mod robots;
mod scene;
mod scene_drives;
mod taking;
mod truth;
mod truth_arm;
mod truth_contact;
mod truth_names;
mod truth_shelves;
mod truths;
