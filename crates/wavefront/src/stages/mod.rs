//! The stages of a bounce: each is a loop over the rows of queues that writes other queues.
//!
//! A stage never calls a stage; the integrator does. Its file, function, [`Stage`](crate::stats::Stage) variant and counter
//! have one name.

mod absorb;
mod cross;
mod draw;
mod escape;
mod fold;
mod gather;
mod generate;
mod glow;
mod order;
mod record;
pub mod scatter;
pub mod shade;
mod shadow;
mod sort;
mod trace;

pub use absorb::absorb;
pub use cross::cross;
pub use draw::{Draw, Draws, DrawsView, draw};
pub use escape::escape;
pub use fold::fold;
pub use gather::gather;
pub use generate::generate;
pub use glow::glow;
pub use order::order;
pub use record::record;
pub use shadow::{ShadowScratch, shadow};
pub use sort::{Arrivals, SortedHits, sort};
pub use trace::{TraceScratch, trace};
