//! All integration tests of the crate in one program, since each program costs a link.

mod assurance;
mod fixture;
mod junit;
mod markup;
mod page;
mod preview;
mod replay;
mod statements;
mod style;
mod summary;
#[path = "../../../evidence/tests/integration/support/mod.rs"]
mod support;
