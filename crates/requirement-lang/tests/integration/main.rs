//! All integration tests of the crate in one program, since each program costs a link.

mod any_text;
mod engines;
mod library;
mod meaning;
mod other_forms;
mod prism;
mod support;
mod text;
