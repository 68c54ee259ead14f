//! State space of a PRISM model, value of a property, and the guarantee of that value.

pub mod state_space;
