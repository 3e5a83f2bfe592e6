//! What importing promises: one module a claim.

mod broken_scenes;
mod edits;
mod gltf;
mod loaded;
mod manual;
mod models;
mod mutations;
mod path;
mod scenes;
