//! Samplers that lie, and what the ledger says of them.

use std::marker::PhantomData;
use std::path::Path;

use brewster_buffers::SceneBuffers;
use brewster_film::Light;
use brewster_import::Importer;

use super::*;
use crate::policy::Policy;
use crate::queues::{
    ContributionQueue, End, HitQueue, NO_INSTANCE, OnCoated, PathRayColumns, Sample, SampleColumns, Trail,
};
use crate::random::PixelKey;
use crate::stages::{Draws, draw};

/// A weight that is NaN, in place of parts in a hundred.
const NO_NUMBER: u32 = u32::MAX;

/// Surfaces of a kind whose sampler is told to send on some parts in a hundred of what it would.
struct Off<Kind, const PERCENT: u32>(PhantomData<Kind>);

#[derive(Clone, Copy)]
struct OffSurface<S, const PERCENT: u32>(S);

impl<Kind: Scatter, const PERCENT: u32> Scatter for Off<Kind, PERCENT> {
    type Surface = OffSurface<Kind::Surface, PERCENT>;

    const TRANSMITS: bool = Kind::TRANSMITS;

    fn medium(context: &Context<'_>, row: usize) -> Option<Medium> {
        Kind::medium(context, row)
    }

    fn surface(context: &Context<'_>, hit: &SurfaceHit, sides: &Sides) -> Self::Surface {
        OffSurface(Kind::surface(context, hit, sides))
    }

    fn albedo(
        albedos: &Albedos,
        surface: &Self::Surface,
        hit: &SurfaceHit,
        sides: &Sides,
        cosine: f32,
    ) -> Option<Vec3> {
        Kind::albedo(albedos, &surface.0, hit, sides, cosine)
    }
}

impl<S: Surface, const PERCENT: u32> Surface for OffSurface<S, PERCENT> {
    fn is_smooth(&self) -> bool {
        self.0.is_smooth()
    }

    fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue {
        self.0.evaluate(view, light)
    }

    fn transmits(&self) -> bool {
        self.0.transmits()
    }

    fn estimate(&self, view: Vec3, choice: f32, u: Vec2) -> Option<Vec3> {
        self.0.estimate(view, choice, u)
    }

    fn split(&self, view: Vec3, u: Vec2, lobe: f32) -> LobeSplit {
        let LobeSplit { reflection, transmission, reflectance } = self.0.split(view, u, lobe);
        LobeSplit { reflection: off::<PERCENT>(reflection), transmission: off::<PERCENT>(transmission), reflectance }
    }

    fn choose(&self, view: Vec3, u: Vec2, lobe: f32) -> Option<LobeSample> {
        off::<PERCENT>(self.0.choose(view, u, lobe))
    }
}

fn off<const PERCENT: u32>(sample: Option<LobeSample>) -> Option<LobeSample> {
    let factor = if PERCENT == NO_NUMBER { f32::NAN } else { PERCENT as f32 / 100.0 };
    sample.map(|sample| LobeSample { weight: sample.weight * factor, ..sample })
}

/// White by theory; what samples weigh is spread about 1.
enum OnWhite {}

#[derive(Clone, Copy)]
struct White;

impl Scatter for OnWhite {
    type Surface = White;

    const TRANSMITS: bool = false;

    fn surface(_: &Context<'_>, _: &SurfaceHit, _: &Sides) -> White {
        White
    }

    fn albedo(_: &Albedos, _: &White, _: &SurfaceHit, _: &Sides, _: f32) -> Option<Vec3> {
        Some(Vec3::ONE)
    }
}

impl Surface for White {
    fn is_smooth(&self) -> bool {
        true
    }

    fn evaluate(&self, _: Vec3, _: Vec3) -> LobeValue {
        LobeValue::BLACK
    }

    fn transmits(&self) -> bool {
        false
    }

    fn split(&self, view: Vec3, u: Vec2, _: f32) -> LobeSplit {
        LobeSplit::opaque(Some(LobeSample::mirror(view, Vec3::splat(2.0 * u.x))))
    }
}

/// A scene with a quad of each material, and with one of white, seen through [`Integrator::Path`].
fn scene(materials: &[&str]) -> SceneBuffers {
    let quads: String = materials.iter().map(|material| format!("(shape: Quad(), material: {material}),")).collect();
    let text = format!(
        "Scene(settings: (integrator: Path, split_depth: 0), camera: Perspective(eye: (0, 0, 5)), entities: [{quads}])"
    );
    let loaded =
        Importer::default().load_text(Path::new("a test.ron"), &text).unwrap_or_else(|error| panic!("{error}"));
    let mut world = brewster_world::Scene::new();
    loaded.scene.apply(world.world_mut());
    let report = world.flatten();
    assert!(report.invalid.is_empty(), "{:?}", report.invalid);
    world.buffers().clone()
}

/// What hits on the surface of an instance come to, at an angle whose cosine is 0.6.
fn hits_on<Kind: Scatter>(scene: &SceneBuffers, instance: u32, count: u32) -> (Counts, ContributionQueue) {
    let context = Context::new(scene, &scene.cameras[0], Policy { ledger: true, ..Policy::default() });
    let material = scene.materials.rows.get(scene.instances.view().material[instance as usize].0 as usize).row;
    let (mut rays, mut samples) = (PathRayColumns::new(), SampleColumns::new());
    let mut hits = HitQueue::<Kind>::default();
    for sample in 0..count {
        let key = PixelKey::new(sample % 200, sample / 200);
        samples.push(Sample { pixel: sample, key, number: 0, light: Light::NONE, rays: 0, rejected: 0 });
        rays.push(PathRay {
            origin_x: -0.8,
            origin_y: 0.0,
            origin_z: 0.6,
            direction_x: 0.8,
            direction_y: 0.0,
            direction_z: -0.6,
            weight: Vec3::ONE,
            pdf: 1.0,
            sample,
            trail: Trail::CAMERA,
            instance: NO_INSTANCE,
            media: MediaId::VACUUM,
            wavelength: PathWavelength::NONE,
            branch: 1,
        });
        let point = SurfacePoint {
            position: Vec3::ZERO,
            geometric_normal: Vec3::Z,
            shading_normal: Vec3::Z,
            uv: Vec2::ZERO,
            error: 1e-6,
        };
        hits.push(SurfaceHit { ray: sample, instance, primitive: 0, material, point, time: 0.0 });
    }
    let (mut next, mut shadows, mut contributions, mut stacks) = Default::default();
    let mut onward = Onward {
        depth: 0,
        queues: Queues { next: Some(&mut next), shadows: &mut shadows, contributions: &mut contributions },
        stacks: &mut stacks,
    };
    let mut counts = Counts::default();
    let mut draws = Draws::default();
    draw(&context, rays.view(), (hits.view().columns().rays(), None), samples.view(), 0, &mut draws);
    scatter(&context, rays.view(), &hits.view(), draws.view(), samples.view(), &mut onward, &mut counts);
    (counts, contributions)
}

/// The z of hits on the surface of an instance.
fn z<Kind: Scatter>(scene: &SceneBuffers, instance: u32, count: u32) -> [f64; 3] {
    let (counts, contributions) = hits_on::<Kind>(scene, instance, count);
    assert!(contributions.is_empty());
    counts.ledger.z()
}

#[test]
fn what_is_no_number_is_told_where_it_arises() {
    let (counts, contributions) = hits_on::<Off<OnWhite, NO_NUMBER>>(&scene(&["Lambert()"]), 0, 40_000);
    assert_eq!((counts.absorbed, counts.reflections, contributions.len()), (40_000, 0, 40_000));
    let found = contributions.get(7);
    assert!(found.radiance.is_nan());
    assert_eq!((found.sample, found.instance, found.trail), (7, 0, Trail::CAMERA.end(End::Surface)));
}

#[test]
fn a_sampler_that_loses_or_makes_energy_shows_in_the_ledger() {
    let scene = scene(&["Lambert()"]);
    let [honest, lossy, greedy] = [
        z::<Off<OnWhite, 100>>(&scene, 0, 40_000),
        z::<Off<OnWhite, 97>>(&scene, 0, 40_000),
        z::<Off<OnWhite, 103>>(&scene, 0, 40_000),
    ];
    assert!(honest.iter().all(|z| z.abs() < 4.0), "{honest:?}");
    assert!(lossy.iter().all(|&z| z > 4.0), "{lossy:?}");
    assert!(greedy.iter().all(|&z| z < -4.0), "{greedy:?}");
}

/// Every kind of surface that no table knows: an honest sampler passes, and one that loses a fifth does not.
#[test]
fn surfaces_without_tables_are_held_to_their_values() {
    const HITS: u32 = 60_000;
    let check = |material: &str, honest: [f64; 3], lossy: [f64; 3]| {
        assert!(honest.iter().all(|z| z.abs() < 4.0), "{material}: {honest:?}");
        assert!(lossy.iter().any(|&z| z > 4.0), "{material}: {lossy:?}");
    };
    let coats = [
        "Coated(base: Metal(of: \"Cu\", alpha: 0.2))",
        "Coated(base: Metal(of: \"Cu\", alpha: 0.2), roughness: 0.3)",
        "Coated(base: Metal(of: \"Cu\"), roughness: 0.5, absorption: (10, 200, 900))",
        "Coated(base: Lambert(albedo: 0.8), absorption: (10, 200, 900))",
        "Coated(base: Lambert(albedo: 0.8), roughness: 0.4, absorption: (10, 200, 900))",
    ];
    let principled = [
        "Principled(base_color: (0.9, 0.5, 0.7), roughness: 0.5, metallic: 0.5)",
        "Principled(base_color: 0.8, roughness: 0.4, metallic: 0, clearcoat: 1, clearcoat_roughness: 0.2)",
        "Principled(base_color: 0.8, roughness: 0.6, metallic: 0, sheen_color: (0.9, 0.8, 0.7), sheen_roughness: 0.5)",
        "Principled(base_color: 0.9, roughness: 0.3, metallic: 1, anisotropy: (strength: 0.7))",
        "Principled(base_color: 0.9, roughness: 0.3, metallic: 0, iridescence: ())",
        "Principled(base_color: (0.9, 0.8, 0.7), roughness: 0.4, metallic: 0, transmission: 1)",
        "Principled(base_color: (0.9, 0.8, 0.7), roughness: 0.4, metallic: 0, transmission: 1, volume: ())",
        "Principled(base_color: (0.9, 0.8, 0.7), roughness: 0, metallic: 0, transmission: 0.9, clearcoat: 0.5)",
        "Principled(base_color: 0.8, roughness: 0.5, metallic: 0, diffuse_transmission: 0.5)",
    ];
    let scene = scene(&[&coats[..], &principled].concat());
    for (instance, material) in (0..).zip(coats) {
        let honest = z::<Off<OnCoated, 100>>(&scene, instance, HITS);
        check(material, honest, z::<Off<OnCoated, 80>>(&scene, instance, HITS));
    }
    for (instance, material) in (coats.len() as u32..).zip(principled) {
        let honest = z::<Off<OnPrincipled, 100>>(&scene, instance, HITS);
        check(material, honest, z::<Off<OnPrincipled, 80>>(&scene, instance, HITS));
    }
}
