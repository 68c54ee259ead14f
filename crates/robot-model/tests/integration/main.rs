//! All integration tests of the crate in one program, since each program costs a link.

mod common;
mod hostile;
mod inverse;
mod masses;
mod mjcf;
mod sdf;
mod shapes;
mod trifles;
mod urdf;
mod xacro;
