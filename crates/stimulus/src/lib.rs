//! What is done to a system under test.
