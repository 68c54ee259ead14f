//! placeholder
pub mod bench;
pub mod coverage;
pub mod family;
pub mod fault;
pub mod formal;
pub mod judges;
pub mod matrix;
pub mod random;
pub mod requirements;
pub mod score;
pub mod study;
pub mod table;
pub mod task;
pub mod theory;
pub mod trials;
