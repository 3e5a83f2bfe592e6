//! The Rust API and the command line.
