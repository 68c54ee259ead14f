//! All integration tests of the crate in one program, since each program costs a link.

mod bench;
mod both_engines;
mod common;
mod controller;
mod episodes;
mod fast;
mod model;
mod scenario;
mod second_engine;
mod viewer;
