//! What a surface does to light: pure functions.
