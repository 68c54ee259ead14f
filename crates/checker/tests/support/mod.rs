//! What the tests of the checker share.

pub mod value;
