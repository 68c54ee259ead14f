//! All integration tests of the crate in one program, since each program costs a link.

mod any_count;
mod calibration;
mod cluster_coverage;
mod copies;
mod deciding;
mod exhaustive_size;
mod extremes;
mod handover_figures;
mod sequential;
mod special_functions;
