//! The fuzzing targets on the inputs that are kept, and on variations of them, without a fuzzing engine.
//!
//! Variations are pseudo-random but always the same: bytes changed, removed, repeated, and pieces of two inputs joined.

use crate::support;

#[path = "../../../../fuzz/src/lib.rs"]
mod targets;

use std::path::PathBuf;
use support::{files_below, root};

/// How many variations of each input are tried.
const VARIATIONS: u64 = 400;

/// Xorshift (Marsaglia 2003): enough for choosing bytes.
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit.max(1) as u64) as usize
    }
}

fn inputs(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let files = files_below(&root().join("fuzz/inputs").join(target));
    assert!(!files.is_empty(), "no inputs for {target}");
    let read = |path: PathBuf| {
        let bytes = std::fs::read(&path).expect("an input can be read");
        (path, bytes)
    };
    files.into_iter().map(read).collect()
}

fn varied(bytes: &[u8], other: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=dice.below(3) {
        let at = dice.below(bytes.len());
        match dice.below(6) {
            0 if !bytes.is_empty() => bytes[at] = dice.below(256) as u8,
            1 if !bytes.is_empty() => bytes[at] ^= 1 << dice.below(8),
            2 => bytes.truncate(at),
            3 => {
                let end = (at + dice.below(20)).min(bytes.len());
                bytes.drain(at.min(end)..end);
            }
            4 => {
                let end = (at + dice.below(30)).min(bytes.len());
                let piece = bytes[at.min(end)..end].to_vec();
                bytes.splice(at..at, piece);
            }
            _ => {
                let from = dice.below(other.len());
                let end = (from + dice.below(60)).min(other.len());
                bytes.splice(at..at, other[from..end].iter().copied());
            }
        }
    }
    bytes
}

fn replay(name: &str, target: fn(&[u8])) {
    let inputs = inputs(name);
    for (index, (path, bytes)) in inputs.iter().enumerate() {
        assert_passes(target, bytes, &format!("{}", path.display()));
        let mut dice = Dice(0x9e37_79b9_7f4a_7c15 ^ (index as u64 + 1));
        for variation in 0..VARIATIONS {
            let other = &inputs[dice.below(inputs.len())].1;
            let bytes = varied(bytes, other, &mut dice);
            assert_passes(
                target,
                &bytes,
                &format!("variation {variation} of {}", path.display()),
            );
        }
    }
}

fn assert_passes(target: fn(&[u8]), bytes: &[u8], what: &str) {
    let passed = std::panic::catch_unwind(|| target(bytes));
    assert!(
        passed.is_ok(),
        "{what}, keep it in fuzz/inputs:\n{:?}",
        String::from_utf8_lossy(bytes)
    );
}

#[test]
fn models() {
    replay("model", targets::model);
}

#[test]
fn properties() {
    replay("properties", targets::properties);
}

#[test]
fn predicates() {
    replay("predicate", targets::predicate);
}

#[test]
fn recordings() {
    replay("mcap", targets::mcap);
}

#[test]
fn tables() {
    replay("csv", targets::csv);
}

#[test]
fn requirements_of_other_tools() {
    replay("requirements", targets::requirements);
}

#[test]
fn foreign_recordings() {
    replay("recording", targets::recording);
}

#[test]
fn messages_and_their_schemas() {
    replay("message", targets::message);
}

#[test]
fn formulas() {
    replay("formula", targets::formula);
}

#[test]
fn sentences() {
    replay("sentence", targets::sentence);
}

#[test]
fn topic_maps() {
    replay("topic_map", targets::topic_map);
}

#[test]
fn texts_of_editors() {
    replay("editor", targets::editor);
}

#[test]
fn descriptions_of_robots() {
    replay("robot", targets::robot);
}

#[test]
fn behaviour_trees() {
    replay("behaviour_tree", targets::behaviour_tree);
}

#[test]
fn packs() {
    replay("pack", targets::pack);
}

#[test]
fn tables_in_parquet() {
    replay("parquet", targets::parquet);
}
