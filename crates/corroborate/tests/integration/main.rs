//! The engine as a library: no process is started for it, and nothing of a process is shared by those who use it.

mod all_mistakes;
mod bad_files;
mod datasets;
mod episodes;
mod exchange;
mod exploring;
mod own_technique;
mod plans;
mod side_by_side;
mod stopping;
mod support;
mod whole_study;
