//! What the project claims as a whole, one module a claim.
//!
//! - `layers`: crates depend on each other as the architecture page says, and on nothing else.
//! - `recursion_agrees`: the queues compute what a plain recursion of the lecture's algorithm computes.
//! - `tidy`: every source file says what it is.
//!
//! What claims share: `scene` reads and renders, `recursion` is the plain recursion.

mod layers;
mod recursion;
mod recursion_agrees;
mod scene;
mod tidy;
