//! The samples of a tile: what all rays of one camera ray's path add to.

use brewster_film::Light;
use brewster_lanes::columns;

use crate::context::Context;
use crate::random::{PixelKey, Sampler, Stream};

columns! {
    /// A sample of a pixel. Rays, shadow rays and contributions name it by its row.
    pub struct Sample => SampleColumns, SamplesView, SamplesViewMut {
        /// The pixel's place in the batch's tile.
        pub pixel: u32,
        /// The pixel's place in the picture.
        pub key: PixelKey,
        /// The number of the sample.
        pub number: u32,
        /// The light found so far.
        pub light: Light,
        /// Rays traced so far, of every kind.
        pub rays: u32,
        /// Contributions so far that were no light.
        pub rejected: u32,
    }
}

impl SamplesView<'_> {
    /// When a sample's path looks: [`Context::time`].
    #[inline(always)]
    pub fn time(&self, context: &Context<'_>, sample: u32) -> f32 {
        context.time(self.key[sample as usize], self.number[sample as usize])
    }

    /// The random numbers of a branch of a sample's path.
    #[inline(always)]
    pub fn stream(&self, sampler: &Sampler, sample: u32, branch: u32) -> Stream {
        sampler.stream(self.key[sample as usize], self.number[sample as usize], branch)
    }
}
