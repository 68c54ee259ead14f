//! One scenario and one seed give one trace, bit for bit.
