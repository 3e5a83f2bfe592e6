//! What every stage of a render reads.

use brewster_buffers::{Camera, Integrator, Opacity, PixelFilter, Projection, SceneBuffers, SeenPlace, Texture};
use brewster_film::{Filter, FilterSampler};
use brewster_geometry::{SceneGeometry, SurfacePlace};
use brewster_optics::dispersion::PathWavelength;
use glam::{Vec2, Vec3};

use crate::albedo::Albedos;
use crate::guide::Guide;
use crate::media::{MediaId, MediaStacks, Medium, media_around};
use crate::pattern::pattern;
use crate::policy::Policy;
use crate::queues::SamplesView;
use crate::random::{Decision, PixelKey, Sampler};

/// What every stage of a render reads; shared by all workers, written by none.
#[derive(Clone, Debug)]
pub struct Context<'a> {
    /// The scene.
    pub scene: &'a SceneBuffers,
    /// What traversal reads of it.
    pub geometry: SceneGeometry<'a>,
    /// The camera.
    pub camera: &'a Camera,
    /// The media around the camera, the outermost first.
    pub camera_media: Vec<Medium>,
    /// The medium that fills the place of the camera.
    pub camera_medium: Medium,
    /// Where `Whitted`'s samples lie around the center of every pixel, in pixels, by number of the sample.
    pub pattern: Vec<Vec2>,
    /// Where `Path`'s random numbers come from.
    pub sampler: Sampler,
    /// How `Path`'s samples lie around their pixel.
    pub filter: FilterSampler,
    /// Whether anything moves while the shutter is open, be it the camera.
    pub moves: bool,
    /// How wide a pixel is, in meters: at a distance of 0 and by how much more a meter. None where no texture looks otherwise from
    /// afar.
    pub pixel: Option<[f32; 2]>,
    /// Whether there are surfaces that may be absent somewhere.
    pub has_veils: bool,
    /// Whether there are surfaces that show cameras their front alone.
    pub has_fronts: bool,
    /// Whether there are sheets that light may go straight through, and lights that no path meets by chance.
    pub has_sheets: bool,
    /// Whether there are media that scatter, or that have no surface.
    pub has_fog: bool,
    /// What rough surfaces are expected to send on, if a ledger is kept.
    pub albedos: Option<Albedos>,
    /// Where diffuse surfaces look for light from mirrors and glass, if there is any.
    pub guide: Option<Guide>,
    /// How batches are scheduled.
    pub policy: Policy,
}

impl<'a> Context<'a> {
    /// What a render of a scene through one of its cameras reads.
    pub fn new(scene: &'a SceneBuffers, camera: &'a Camera, policy: Policy) -> Context<'a> {
        let settings = &scene.settings;
        let filter = FilterSampler::new(match settings.filter {
            PixelFilter::Box => Filter::BOX,
            PixelFilter::Tent => Filter::TENT,
            PixelFilter::Gaussian => Filter::GAUSSIAN,
            PixelFilter::BlackmanHarris => Filter::BLACKMAN_HARRIS,
        })
        .expect("the built-in filters are valid");
        let camera_media = media_around(scene, camera.position, 0.0, policy.level);
        let dielectrics = scene.materials.dielectric.view();
        let mut stacks = MediaStacks::default();
        let around = stacks.enter_all(&camera_media, &dielectrics);
        let mut context = Context {
            scene,
            geometry: scene.geometry(),
            camera,
            camera_media,
            camera_medium: stacks.filling(around),
            pattern: match settings.integrator {
                Integrator::Whitted => pattern(settings.samples, settings.seed, &filter),
                Integrator::Path => Vec::new(),
            },
            sampler: Sampler::new(settings.sampler, settings.seed, settings.samples),
            filter,
            moves: scene.moves() || !camera.motion.is_empty(),
            pixel: pixel(scene, camera),
            has_veils: scene.materials.details.iter().any(|detail| detail.opacity != Opacity::Opaque),
            has_fronts: scene.materials.details.iter().any(|detail| detail.front_only),
            has_sheets: !scene.lights.is_empty()
                && (dielectrics.thin.contains(&true)
                    || (scene.materials.principled.view().transmission.iter()).any(|part| !part.is_zero())),
            has_fog: settings.integrator == Integrator::Path
                && (dielectrics.bare.contains(&true) || dielectrics.scattering.iter().any(|&part| part != Vec3::ZERO)),
            albedos: (policy.ledger && settings.integrator == Integrator::Path).then(|| Albedos::new(scene)),
            guide: None,
            policy,
        };
        context.guide = Guide::new(&context);
        context
    }

    /// When a sample of a pixel looks, 0 ≤ time < 1 of the shutter's time: all rays of its path look then, so that none has to carry it.
    #[inline(always)]
    pub fn time(&self, pixel: PixelKey, sample: u32) -> f32 {
        if self.moves { self.sampler.one(self.sampler.stream(pixel, sample, 1), Decision::Time.at(0)) } else { 0.0 }
    }

    /// When rays of some samples look, for those that look for what moves; otherwise nothing.
    pub fn times(&self, samples: SamplesView<'_>, of: &[u32], times: &mut Vec<f32>) {
        times.clear();
        if !self.scene.motions.is_empty() {
            times.extend(of.iter().map(|&sample| samples.time(self, sample)));
        }
    }

    /// Whether rays of a depth may meet surfaces that are not there for them.
    #[inline(always)]
    pub fn may_be_absent(&self, depth: u32) -> bool {
        self.has_veils || depth == 0 && self.has_fronts
    }

    /// A place, and how much of the surface is looked at there: half a pixel's width at the distance from the camera to it. By way of mirrors it is
    /// farther, so that what is seen there may be sharper than it has to be, and is hardly ever less sharp; whatever ray asks gets the
    /// same answer.
    #[inline(always)]
    pub fn seen(&self, place: SurfacePlace) -> SeenPlace {
        match self.pixel {
            None => place.into(),
            Some([width, growth]) => {
                let distance = (place.position - self.camera.frame(place.time).position).length();
                SurfacePlace { width: 0.5 * (width + growth * distance), ..place }.into()
            }
        }
    }

    /// What radiance in a medium weighs at the camera beside the energy that a ray's weight counts: radiance over the squared
    /// index is what boundaries pass on, so the factor is `(n_camera/n)²`. `Whitted` does without, as the lectures do.
    #[inline(always)]
    pub fn radiance_scale(&self, stacks: &MediaStacks, media: MediaId, wavelength: PathWavelength) -> f32 {
        match self.scene.settings.integrator {
            Integrator::Whitted => 1.0,
            Integrator::Path => {
                let dielectrics = self.scene.materials.dielectric.view();
                let [camera, here] =
                    [self.camera_medium, stacks.filling(media)].map(|medium| medium.ior_at(wavelength, &dielectrics));
                (camera / here) * (camera / here)
            }
        }
    }
}

/// [`Context::pixel`].
fn pixel(scene: &SceneBuffers, camera: &Camera) -> Option<[f32; 2]> {
    let has_pyramid = |texture: &Texture| matches!(texture, Texture::Image(image) if image.pyramid.is_some());
    if !scene.textures.rows.iter().any(has_pyramid) {
        return None;
    }
    let rows = scene.settings.resolution.y as f32;
    Some(match camera.projection {
        Projection::Perspective(tangent) => [0.0, 2.0 * tangent / rows],
        Projection::Orthographic(half) => [2.0 * half / rows, 0.0],
    })
}
