//! Evidence as pages and tables; computes nothing.
