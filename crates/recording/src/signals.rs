//! Signals of a recording, one instant after another.

mod frames;
mod linear;
mod plan;
mod report;
mod sequencer;
mod source;
mod tf_message;

pub use report::{StreamNote, StreamNoteKind};
