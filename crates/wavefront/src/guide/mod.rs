//! Path guiding: where diffuse surfaces look for light that mirrors and glass throw on them.
//!
//! Such light, a caustic, is met by no ray toward a light, for what bends it stands in between, and by few of the rays that a surface
//! scatters evenly: where a small lamp makes it, it is most of the noise. Before the first sample, photons go from the lights toward what may bend them;
//! where they come to surfaces that scatter, cells keep the directions that they came from. There a part of a surface's rays, the larger
//! the brighter the caustic is, is sent into directions near to these, as in H. W. Jensen, *Importance Driven Path Tracing Using the
//! Photon Map*, EGWR 1995.
//!
//! A ray weighs what the light is worth over the density of both ways to choose it, so that the picture is unbiased whatever the photons
//! say: they decide where its noise is. They have random numbers of their own and depend on the scene alone.

mod cells;
mod photons;

use std::time::{Duration, Instant};

use brewster_buffers::Integrator;

pub(crate) use self::cells::{Cell, Cells};
use crate::context::Context;

/// From where light comes to diffuse surfaces by way of what is smooth.
#[derive(Clone, Debug)]
pub struct Guide {
    pub(crate) cells: Cells,
    /// Photons that were sent.
    pub sent: u64,
    /// Rays that were traced for them.
    pub rays: u64,
    /// How long that took, with the growing of the cells.
    pub time: Duration,
}

impl Guide {
    /// Sends the photons of a scene. None if they find no place where light from mirrors or glass could be looked for.
    pub(crate) fn new(context: &Context<'_>) -> Option<Guide> {
        let start = Instant::now();
        let settings = &context.scene.settings;
        if settings.integrator != Integrator::Path || !settings.guiding {
            return None;
        }
        let flight = photons::send(context)?;
        let cells = Cells::new(&flight.photons, flight.sent)?;
        Some(Guide { cells, sent: flight.sent, rays: flight.rays, time: start.elapsed() })
    }

    /// Photons whose directions are kept.
    pub fn kept(&self) -> usize {
        self.cells.kept()
    }

    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        self.cells.bytes()
    }
}
