//! The scene as entities, and the systems that flatten it.

pub mod components;
