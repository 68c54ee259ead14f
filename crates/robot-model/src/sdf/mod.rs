//! SDF
pub(crate) mod pose;
pub(crate) mod sensor;
