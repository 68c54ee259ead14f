//! Timed signals: read, write, resample, evaluate predicates.
