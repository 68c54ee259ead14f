//! Tests of the crate from outside.

mod diagnostics;
mod hostile;
mod random;
mod support;
mod worlds;
