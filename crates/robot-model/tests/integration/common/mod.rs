//! What the tests share; not each uses all of it.
#![allow(dead_code)]

use robot_model::{Gap, Loaded, Problems, parse};

/// The test files.
pub const ARM: &str = include_str!("../../data/arm.urdf");
/// See [`ARM`].
pub const BASE: &str = include_str!("../../data/base.sdf");
/// See [`ARM`].
pub const SWING: &str = include_str!("../../data/swing.xml");

/// Loads a text that names no files.
pub fn load(file: &str, text: &str) -> Result<Loaded, Problems> {
    parse(file, text, &mut |address: &str| {
        Err(format!("{address} is not here"))
    })
}

/// Loads a text that must load.
pub fn loaded(file: &str, text: &str) -> Loaded {
    load(file, text).unwrap_or_else(|problems| panic!("{problems}"))
}

/// Elements of gaps, in order.
pub fn elements(gaps: &[Gap]) -> Vec<&str> {
    gaps.iter().map(|gap| gap.element.as_str()).collect()
}

/// Whether two lists of numbers agree to 1e-12.
pub fn close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
}
