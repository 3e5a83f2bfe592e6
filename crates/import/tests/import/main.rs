//! What importing promises: one module a claim.

mod broken_scenes;
mod edits;
mod manual;
mod mutations;
mod random;
mod scenes;
