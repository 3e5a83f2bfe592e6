//! What an author says for path tracing is what the world holds: expected components are worked out by hand.

use std::path::Path;
use std::sync::Arc;

use bevy_ecs::world::World;
use brewster_import::{Importer, LoadOptions, load_scene};
use brewster_optics::dispersion::Cauchy;
use brewster_optics::glasses::glass;
use brewster_world::components::parts::{self, DispersiveIndex, Film, FresnelModel, Integrator, SamplerKind};
use brewster_world::components::{Background, Camera, Color, Material, Reflectance, Scattering, Settings};
use glam::Vec3;

use crate::loaded::{get, load, load_with};
use brewster_random::Random;

#[test]
fn settings_of_paths() {
    let (_, world) = load(
        "Scene(
            settings: (
                integrator: Path, sampler: Independent, split_depth: 3, roulette: false, clamp: 20, noise_threshold: 0.5,
            ),
            background: 1,
        )",
    );
    let expected = parts::Settings {
        integrator: Integrator::Path,
        sampler: SamplerKind::Independent,
        split_depth: 3,
        roulette: false,
        clamp: 20.0,
        noise_threshold: Some(0.5),
        ..parts::Settings::default()
    };
    assert_eq!(world.resource::<Settings>().0, expected);
    let overrides = [("integrator", "Path"), ("split_depth", "0"), ("clamp", "5")];
    let overrides = overrides.map(|(field, value)| (format!("settings.{field}"), value.to_owned())).into();
    let (_, world) = load_with("Scene(background: 1)", LoadOptions { overrides, ..LoadOptions::default() });
    let expected =
        parts::Settings { integrator: Integrator::Path, split_depth: 0, clamp: 5.0, ..parts::Settings::default() };
    assert_eq!(world.resource::<Settings>().0, expected);
}

/// What is chosen in the scene's place is what its materials have to suit.
#[test]
fn an_integrator_may_be_chosen_for_the_scene() {
    let text = |integrator: &str, material: &str| {
        format!(
            "Scene(camera: Perspective(), background: 1, settings: (integrator: {integrator}), entities: [(shape: Sphere(), material: {material})])"
        )
    };
    let (rough, phong) = ("Metal(of: \"Au\", alpha: 0.5)", "Phong()");
    for (named, material, chosen, expected) in [
        ("Whitted", rough, Some(Integrator::Path), Ok(Integrator::Path)),
        ("Path", phong, Some(Integrator::Whitted), Ok(Integrator::Whitted)),
        ("Path", rough, None, Ok(Integrator::Path)),
        ("Path", rough, Some(Integrator::Whitted), Err("Whitted does not render rough metals")),
        ("Whitted", phong, Some(Integrator::Path), Err("Path does not render Phong materials")),
    ] {
        let options = LoadOptions { integrator: chosen, ..LoadOptions::default() };
        let found = Importer::new(options).load_text("scene.ron".as_ref(), &text(named, material));
        let found = found.map(|loaded| loaded.scene.settings.0.integrator);
        match (found, expected) {
            (Ok(found), Ok(expected)) => assert_eq!(found, expected, "{named}, {chosen:?}"),
            (Err(failure), Err(expected)) => assert!(failure.to_string().contains(expected), "{failure}"),
            (found, expected) => panic!("{named}, {chosen:?}: {found:?} instead of {expected:?}"),
        }
    }
}

#[test]
fn every_rough_material_says_what_it_says() {
    let (_, mut world) = load(
        r#"Scene(camera: Perspective(), background: 1, settings: (integrator: Path), materials: {
            "dust": RoughDiffuse(albedo: 0.25, roughness: 0.75),
            "wide": Metal(r0: 0.5, alpha: 0.25),
            "rough": Metal(r0: 0.5, roughness: 0.5),
            "tinted": Metal(r0: 0.5, f82: (1, 0.5, 0.25)),
            "even": Metal(r0: 0.5, r90: (0.5, 0.25, 0.75)),
            "edged": Metal(r0: (0.25, 0.5, 0.75), edge_tint: 0.5),
            "frosted": Dielectric(ior: 1.5, roughness: 0.5),
            "oily": Metal(r0: 0.5, edge_tint: 0.5, film: (ior: 1.5, thickness: 250)),
            "bubble": Dielectric(ior: 1, film: (ior: 1.25, thickness: 500)),
            "pane": Dielectric(ior: 1.5, thin: true),
            "lamp": Emissive(radiance: 3, sides: Front),
            "prism": Dielectric(glass: "SF11", dispersion: Measured()),
            "abbe": Dielectric(ior: 1.5, dispersion: Abbe(number: 40)),
            "cauchy": Dielectric(dispersion: Cauchy(a: 1.5, b: 0.0)),
        })"#,
    );
    let gray = Color::gray;
    let metal = |reflectance, fresnel, alpha| {
        let (specular, exponent) = (gray(1.0), 100.0);
        Material::Metal { reflectance, fresnel, specular, exponent, alpha, film: None, compensated: false }
    };
    let normal = |r90, f82| Reflectance::Normal { r0: gray(0.5), r90, f82 };
    let edged = Reflectance::EdgeTint { r0: Vec3::new(0.25, 0.5, 0.75), edge_tint: Vec3::splat(0.5) };
    let oily = Material::Metal {
        reflectance: Reflectance::EdgeTint { r0: Vec3::splat(0.5), edge_tint: Vec3::splat(0.5) },
        fresnel: FresnelModel::Exact,
        specular: gray(1.0),
        exponent: 100.0,
        alpha: 0.0,
        film: Some(Film { ior: 1.5, thickness: 250.0 }),
        compensated: false,
    };
    let dielectric = |ior, dispersion, alpha, film, thin| Material::Dielectric {
        ior,
        dispersion,
        fresnel: FresnelModel::Exact,
        specular: gray(1.0),
        exponent: 100.0,
        absorption: Vec3::ZERO,
        scattering: Scattering::NONE,
        bare: false,
        priority: 0,
        alpha,
        film,
        thin,
    };
    let glass = DispersiveIndex::Glass(glass("SF11").expect("it is in the table"));
    let dispersive = |ior, index| dielectric(ior, Some(index), 0.0, None, false);
    for (name, expected) in [
        ("prism", dispersive(glass.ior(), glass)),
        ("abbe", dispersive(1.5, DispersiveIndex::Cauchy(Cauchy::from_abbe(1.5, 40.0)))),
        ("cauchy", dispersive(1.5, DispersiveIndex::Cauchy(Cauchy { a: 1.5, b: 0.0, c: 0.0 }))),
        ("dust", Material::RoughDiffuse { albedo: gray(0.25), roughness: 0.75 }),
        ("wide", metal(normal(Vec3::ONE, Vec3::ONE), FresnelModel::Schlick, 0.25)),
        ("rough", metal(normal(Vec3::ONE, Vec3::ONE), FresnelModel::Schlick, 0.25)),
        ("tinted", metal(normal(Vec3::ONE, Vec3::new(1.0, 0.5, 0.25)), FresnelModel::Schlick, 0.0)),
        ("even", metal(normal(Vec3::new(0.5, 0.25, 0.75), Vec3::ONE), FresnelModel::Schlick, 0.0)),
        ("edged", metal(edged, FresnelModel::Exact, 0.0)),
        ("frosted", dielectric(1.5, None, 0.25, None, false)),
        ("oily", oily),
        ("bubble", dielectric(1.0, None, 0.0, Some(Film { ior: 1.25, thickness: 500.0 }), false)),
        ("pane", dielectric(1.5, None, 0.0, None, true)),
        ("lamp", Material::Emissive { radiance: gray(3.0), two_sided: false }),
    ] {
        assert_eq!(get::<Material>(&mut world, name), expected, "{name}");
    }
}

#[test]
fn lenses_open_by_radius_or_by_f_stop() {
    let (_, mut world) = load(
        r#"Scene(background: 1, settings: (integrator: Path), cameras: {
            "radius": Perspective(eye: (0, 0, 5), lens: (aperture_radius: 0.5, focus_distance: 2, blades: 6)),
            "stop": Perspective(eye: (3, 0, 4), vfov: 90, lens: (f_stop: 4)),
            "flat": Orthographic(eye: (0, 7, 0), up: (0, 0, -1), lens: (aperture_radius: 0.25)),
        })"#,
    );
    for (name, radius, focus, blades) in [
        ("radius", 0.5, 2.0, 6),
        // With 90° on 24 mm the focal length is 12 mm; at f/4 the diameter is 3 mm. The target is 5 m away.
        ("stop", 0.0015, 5.0, 0),
        ("flat", 0.25, 7.0, 0),
    ] {
        let lens = get::<Camera>(&mut world, name).lens.expect("it has one");
        assert!((lens.aperture_radius - radius).abs() < 1e-6 * radius, "{name}: {lens:?}");
        assert_eq!((lens.focus_distance, lens.blades), (focus, blades), "{name}");
    }
}

/// A folder with a sky of four by two pixels as `sky.hdr`: black but for column 3 of the upper row.
fn folder_with_sky() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let black = image::Rgb([0.0; 3]);
    let mut pixels = [black; 8];
    pixels[3] = image::Rgb([4.0, 2.0, 1.0]);
    let file = std::fs::File::create(folder.path().join("sky.hdr")).expect("it can be made");
    image::codecs::hdr::HdrEncoder::new(file).encode(&pixels, 4, 2).expect("it is written");
    folder
}

fn sky(importer: &mut Importer, folder: &Path, fields: &str) -> Arc<parts::EnvironmentMap> {
    let text = format!("Scene(camera: Perspective(), background: Environment({fields}))");
    let loaded = importer.load_text(&folder.join("scene.ron"), &text).unwrap_or_else(|failure| panic!("{failure}"));
    let mut world = World::new();
    loaded.scene.apply(&mut world);
    match &world.resource::<Background>().0 {
        parts::Background::Environment(map) => Arc::clone(map),
        other => panic!("{other:?}"),
    }
}

/// Of four columns the last is a quarter turn around the middle of u = ⅞, halfway from +Z to -X; a turn by 90° about +Y takes it
/// to halfway from +X to +Z, and with rows at the poles it is the zenith's.
#[test]
fn a_sky_is_turned_and_scaled_as_told() {
    let folder = folder_with_sky();
    let mut importer = Importer::new(LoadOptions::default());
    let mut check = |fields: &str, direction: Vec3, expected: Vec3| {
        let found = sky(&mut importer, folder.path(), fields).radiance(direction.normalize());
        assert!((found - expected).length() < 1e-5 * (1.0 + expected.length()), "{fields}: {found}, not {expected}");
    };
    let color = Vec3::new(4.0, 2.0, 1.0);
    let (height, file) = (std::f32::consts::SQRT_2, "file: \"sky.hdr\"");
    check(file, Vec3::new(-1.0, height, 1.0), color);
    check(file, Vec3::new(1.0, height, 1.0), Vec3::ZERO);
    check(&format!("{file}, rotation: 90"), Vec3::new(1.0, height, 1.0), color);
    check(&format!("{file}, rotation: 90"), Vec3::new(-1.0, height, 1.0), Vec3::ZERO);
    check(&format!("{file}, intensity: 2.5"), Vec3::new(-1.0, height, 1.0), 2.5 * color);
    check(&format!("{file}, rows: Poles"), Vec3::new(-1e-6, 1.0, 1e-6), color);
    check(&format!("{file}, rows: Poles"), Vec3::new(-1.0, 0.0, 1.0), 0.5 * color);
}

#[test]
fn a_sky_that_did_not_change_is_the_same_one() {
    let folder = folder_with_sky();
    let mut importer = Importer::new(LoadOptions::default());
    let mut load = |fields: &str| sky(&mut importer, folder.path(), fields);
    let first = load("file: \"sky.hdr\"");
    assert!(Arc::ptr_eq(&first, &load("file: \"sky.hdr\"")));
    assert!(!Arc::ptr_eq(&first, &load("file: \"sky.hdr\", intensity: 2")));
    let again = load("file: \"sky.hdr\"");
    assert_eq!(first, again);
    std::fs::remove_file(folder.path().join("sky.hdr")).expect("it is there");
    let folder = folder_with_sky();
    let file = folder.path().join("sky.hdr");
    let bytes = std::fs::read(&file).expect("it is there");
    std::fs::write(&file, &bytes[..bytes.len() - 4]).expect("it can be written");
    assert!(
        importer
            .load_text(&folder.path().join("scene.ron"), "Scene(background: Environment(file: \"sky.hdr\"))")
            .is_err()
    );
}

/// The picture that `tests/broken` keeps for its skies: written by hand, three pixels by two.
#[test]
fn open_exr_is_read_as_it_is_and_no_spoiled_file_brings_the_importer_down() {
    let good = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/broken/parts/sky.exr");
    let good = std::fs::read(good).expect("it is there");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("scene.ron");
    std::fs::write(&scene, "Scene(camera: Perspective(), background: Environment(file: \"sky.exr\"))")
        .expect("written");
    let load = |bytes: &[u8]| {
        std::fs::write(folder.path().join("sky.exr"), bytes).expect("it can be written");
        load_scene(&scene, &LoadOptions::default())
    };
    let parts::Background::Environment(map) = load(&good).expect("it is right").scene.background.0 else {
        panic!("it is a picture")
    };
    let image = map.image();
    assert_eq!((image.width, image.height), (3, 2));
    let expected = [[0.5, 1.0, 2.0], [1.0; 3], [0.0, 0.25, 4.0], [0.1; 3], [0.1; 3], [0.1; 3]];
    assert_eq!(image.floats(), expected);

    let mut random = Random::new(11);
    let mut refused = 0;
    for _ in 0..200 {
        let mut bytes = good.clone();
        for _ in 0..=random.below(3) {
            let at = random.below(bytes.len());
            bytes[at] = random.below(256) as u8;
        }
        bytes.truncate(bytes.len() - if random.below(4) == 0 { random.below(bytes.len()) } else { 0 });
        refused += usize::from(load(&bytes).is_err());
    }
    assert!(refused > 40, "{refused} of 200 were refused");
}
