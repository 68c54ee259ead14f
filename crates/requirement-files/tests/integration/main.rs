//! Integration tests of requirement-files.

mod doorstop;
mod fret;
mod other_tools;
mod reqif;
mod support;
mod tables;
