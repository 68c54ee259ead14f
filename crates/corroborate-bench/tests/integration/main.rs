//! All integration tests of the crate in one program, since each program costs a link.

mod small;
