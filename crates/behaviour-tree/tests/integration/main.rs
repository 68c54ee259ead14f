//! What is read, what the models mean, and what is counted.

mod against_ticks;
mod logs;
mod random;
mod reading;
mod support;
mod ticks;
