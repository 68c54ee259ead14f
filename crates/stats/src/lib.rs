//! From counts to intervals, tests and sample sizes.
