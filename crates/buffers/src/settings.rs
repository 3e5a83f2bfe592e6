//! What belongs to the scene as a whole.

use glam::UVec2;

use crate::Backdrop;

/// The scene's settings, each of which a command line can overrule.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Width and height of the picture in pixels, each at least 1.
    pub resolution: UVec2,
    /// How light is carried.
    pub integrator: Integrator,
    /// The number of interactions on a path that may scatter on. The lectures' 2.
    pub max_depth: u32,
    /// Samples per pixel, at least 1.
    pub samples: u32,
    /// Blocks of pixels whose estimated noise is below this get no more samples; above 0. None: all get as many.
    pub noise_threshold: Option<f32>,
    /// Chooses the pattern of samples.
    pub seed: u64,
    /// Where the numbers come from that decide what a sample does.
    pub sampler: SamplerKind,
    /// `Path`: a smooth dielectric sends both rays while a ray's depth is below this, later one of them by chance.
    pub split_depth: u32,
    /// `Path`: whether rays of little weight are ended by chance and the others carry what they would have brought.
    pub roulette: bool,
    /// `Path`: whether diffuse surfaces look for light where mirrors and glass throw it on them, which is found out before the first sample.
    pub guiding: bool,
    /// `Path`: the largest radiance that one contribution may bring, above 0; infinite lets all pass and leaves the picture
    /// unbiased.
    pub clamp: f32,
    /// `Path`: by how much further off a surface than rounding asks for scattered rays start, as a part of 1 + the largest of
    /// their coordinates. 0, but for comparisons with tracers that do so.
    pub ray_offset: f32,
    /// How samples lie around their pixel.
    pub filter: PixelFilter,
    /// Whether shadow rays pass dielectrics, weakened by F_t and absorption, or are stopped by them.
    pub transparent_shadows: bool,
    /// A ray whose largest weight falls below this is not followed. 0 follows all.
    pub contribution_threshold: f32,
    /// What camera rays see that meet nothing.
    pub backdrop: Backdrop,
    /// Stops: the picture is scaled by 2^exposure before tone mapping.
    pub exposure: f32,
    /// How radiance becomes display values.
    pub tone_mapping: ToneMapping,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            resolution: UVec2::new(960, 540),
            integrator: Integrator::Whitted,
            max_depth: 2,
            samples: 16,
            noise_threshold: None,
            seed: 0,
            sampler: SamplerKind::Sobol,
            split_depth: 1,
            roulette: true,
            guiding: false,
            clamp: f32::INFINITY,
            ray_offset: 0.0,
            filter: PixelFilter::BlackmanHarris,
            transparent_shadows: false,
            contribution_threshold: 0.0,
            backdrop: Backdrop::Background,
            exposure: 0.0,
            tone_mapping: ToneMapping::Srgb,
        }
    }
}

/// How light is carried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integrator {
    /// The deterministic algorithm of the lectures.
    Whitted,
    /// Unbiased path tracing.
    Path,
}

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplerKind {
    /// Owen-scrambled Sobol points in screen-space order: even over every pixel and over its neighbors.
    #[default]
    Sobol,
    /// Numbers without any relation to each other: for tests and for measures of error.
    Independent,
}

/// How samples lie around their pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFilter {
    /// Evenly over the pixel.
    Box,
    /// A pyramid two pixels wide.
    Tent,
    /// A bell curve three pixels wide.
    Gaussian,
    /// A window four pixels wide, close to a bell curve of finite width.
    BlackmanHarris,
}

/// How radiance becomes display values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToneMapping {
    /// Clamped, without any curve.
    None,
    /// Clamped, then the sRGB curve.
    Srgb,
    /// A filmic curve that rolls highlights off, then the sRGB curve.
    Filmic,
    /// A fit of the ACES reference transforms.
    Aces,
    /// AgX.
    Agx,
    /// Khronos PBR Neutral, which keeps base colors.
    PbrNeutral,
}
