//! All integration tests of the crate in one program, since each program costs a link.

mod diagnostics;
mod meaning;
mod parsing;
mod roundtrip;
mod typed;
