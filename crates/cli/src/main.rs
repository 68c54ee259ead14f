//! The corroborate command: the only place where techniques meet evidence.
fn main() {}
