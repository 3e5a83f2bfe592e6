//! What the project claims as a whole, one module a claim.
//!
//! - `layers`: crates depend on each other as the architecture page says, and on nothing else.
//! - `tidy`: every source file says what it is.

mod layers;
mod tidy;
