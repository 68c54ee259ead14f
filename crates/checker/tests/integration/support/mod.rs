//! What the tests of the checker share.

pub mod corpus;
pub mod judge;
pub mod value;
