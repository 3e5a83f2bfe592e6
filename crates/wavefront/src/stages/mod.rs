//! The stages of a bounce: each is a loop over the rows of queues that writes other queues.
//!
//! A stage never calls a stage; the integrator does. Its file, function, [`Stage`](crate::stats::Stage) variant and counter
//! have one name.

mod absorb;
mod cross;
mod draw;
mod escape;
mod fly;
mod fold;
mod gather;
mod generate;
mod glow;
mod order;
mod outlet;
mod record;
pub mod scatter;
pub mod shade;
mod shadow;
mod sort;
mod trace;
mod vectors;

pub use absorb::absorb;
pub(crate) use absorb::weaken;
pub(crate) use cross::behind;
pub use cross::cross;
pub use draw::{Draw, DrawOnDemand, Drawn, Draws, DrawsView, Numbers, Points, draw};
pub use escape::escape;
pub(crate) use escape::seen_behind;
pub(crate) use fly::{Arrived, Traveler, fly_on};
pub use fly::{FlyScratch, Progress, fly};
pub use fold::fold;
pub(crate) use fold::fold_one;
pub use gather::gather;
pub(crate) use gather::settle;
pub(crate) use generate::camera_ray;
pub use generate::generate;
pub use glow::glow;
pub(crate) use glow::glowing;
pub(crate) use order::octant;
pub use order::{OrderScratch, order};
pub use outlet::{Outlet, Queues};
pub(crate) use record::{first_hit, first_scattering};
pub use record::{record, record_scatterings};
pub(crate) use shadow::{Met, may_go_on, meet, reached};
pub use shadow::{ShadowScratch, shadow};
pub(crate) use sort::{Arrival, arrive};
pub use sort::{Arrivals, SortedHits, sort};
pub(crate) use trace::behind_veil;
pub use trace::{TraceScratch, trace};
pub(crate) use vectors::{LANES, Vectors};
