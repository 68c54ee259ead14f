//! What is read, what the models mean, and what is counted.

mod against_ticks;
mod random;
mod support;
mod ticks;
