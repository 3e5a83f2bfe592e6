//! The scene as columns.
