//! All integration tests of the crate in one program, since each program costs a link.

mod bench;
mod common;
mod controller;
mod engines;
mod episodes;
mod fast;
mod physics;
mod physics_actuators;
mod physics_contact;
mod physics_energy;
mod physics_engines;
mod physics_handover;
mod physics_sensors;
mod robot_model;
mod scenario;
mod scene;
mod scene_drives;
mod viewer;
