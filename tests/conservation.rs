//! No ray is lost or made up: what enters a queue leaves it, at every depth and from every source.

use brewster_buffers::{MaterialKind, SceneBuffers};
use brewster_wavefront::queues::RaySource;
use brewster_wavefront::{Counts, Stage, Stats};

use crate::scene::{SCENES, load, render};

fn into(counts: &Counts, stage: Stage) -> u64 {
    counts.stages[stage as usize]
}

/// Sums of one count over all sources at a depth.
fn at(stats: &Stats, depth: usize, count: impl Fn(&Counts) -> u64) -> u64 {
    stats.depths.get(depth).map_or(0, |depth| depth.counts.iter().map(count).sum())
}

fn scene(name: &str) -> SceneBuffers {
    let mut scene = load(name);
    scene.settings.samples = 2;
    scene
}

fn each(run: impl Fn(&str, &SceneBuffers, &Stats)) {
    for name in SCENES {
        let scene = scene(name);
        run(name, &scene, &render(&scene).1);
    }
}

#[test]
fn every_traced_ray_hits_crosses_or_escapes_and_every_hit_is_shaded_once() {
    each(|name, _, stats| {
        for (depth, source) in stats.depths.iter().enumerate().flat_map(|(d, at)| at.counts.iter().map(move |c| (d, c)))
        {
            let context = format!("{name}, depth {depth}: {source:?}");
            assert_eq!(source.traced(), source.hits + source.crossings + source.escaped, "{context}");
            for stage in [Stage::Order, Stage::Absorb, Stage::Sort] {
                assert_eq!(into(source, stage), source.traced(), "{context}");
            }
            let shaded = [
                Stage::ShadePhong,
                Stage::ShadeLambert,
                Stage::ShadeMetal,
                Stage::ShadeDielectric,
                Stage::ShadeEmissive,
            ];
            // The lecture has no rough diffuse, principled or coated surfaces, and a mix is one of its parts by then.
            assert_eq!(shaded.len(), MaterialKind::ALL.len() - 4);
            assert_eq!(shaded.map(|stage| into(source, stage)).iter().sum::<u64>(), source.hits, "{context}");
            assert_eq!(into(source, Stage::Cross), source.crossings, "{context}");
            assert_eq!(into(source, Stage::Escape), source.escaped, "{context}");
            assert_eq!(into(source, Stage::Record), if depth == 0 { source.hits } else { 0 }, "{context}");
        }
    });
}

#[test]
fn rays_of_a_depth_are_those_that_the_depth_before_sent() {
    each(|name, scene, stats| {
        let traced = |depth: usize, source: RaySource| stats.depths[depth].counts[source as usize].traced();
        let pixels = u64::from(scene.settings.resolution.element_product());
        assert_eq!(traced(0, RaySource::Primary), pixels * u64::from(scene.settings.samples), "{name}");
        assert_eq!(traced(0, RaySource::Reflection), 0, "{name}");
        assert_eq!(traced(0, RaySource::Transmission), at(stats, 0, |c| c.crossings), "{name}");
        for depth in 1..stats.depths.len() {
            let context = format!("{name}, depth {depth}");
            let (reflections, transmissions) =
                (at(stats, depth - 1, |c| c.reflections), at(stats, depth - 1, |c| c.transmissions));
            assert_eq!(traced(depth, RaySource::Primary), 0, "{context}");
            assert_eq!(traced(depth, RaySource::Reflection), reflections, "{context}");
            let crossings = at(stats, depth, |c| c.crossings);
            assert_eq!(traced(depth, RaySource::Transmission), transmissions + crossings, "{context}");
        }
    });
}

/// Metal reflects once; glass reflects once and transmits once, unless it reflects totally.
#[test]
fn every_hit_on_metal_and_glass_scatters_on_or_is_counted_as_cut() {
    each(|name, scene, stats| {
        let deepest = scene.settings.max_depth as usize;
        for depth in 0..=deepest {
            let context = format!("{name}, depth {depth}");
            let sum = |count: fn(&Counts) -> u64| at(stats, depth, count);
            let metal = sum(|c| into(c, Stage::ShadeMetal));
            let glass = sum(|c| into(c, Stage::ShadeDielectric));
            let transmitting = glass - sum(|c| c.totally_reflected);
            let (reflections, transmissions) = (sum(|c| c.reflections), sum(|c| c.transmissions));
            let (cut, below) = (sum(|c| c.cut_by_depth), sum(|c| c.below_threshold));
            if depth == deepest {
                assert_eq!((reflections, transmissions, below), (0, 0, 0), "{context}");
                assert_eq!(cut, metal + glass + transmitting, "{context}");
            } else if scene.settings.contribution_threshold > 0.0 {
                assert_eq!(reflections + transmissions + below, metal + glass + transmitting, "{context}");
                assert_eq!(cut, 0, "{context}");
            } else {
                assert_eq!((reflections, transmissions), (metal + glass, transmitting), "{context}");
                assert_eq!((cut, below), (0, 0), "{context}");
            }
        }
    });
}

/// What the laws above are about happens a thousand times and more.
#[test]
fn the_scenes_show_every_end_of_a_ray() {
    let total = |name, samples| {
        let mut scene = load(name);
        scene.settings.samples = samples;
        render(&scene).1.total()
    };
    let (inside_glass, nested, threshold) = (total("inside_glass", 2), total("nested", 1), total("threshold", 4));
    for (count, rays) in [
        ("totally reflected", inside_glass.totally_reflected),
        ("escaped", inside_glass.escaped),
        ("crossings", nested.crossings),
        ("cut by depth", nested.cut_by_depth),
        ("shadowed", nested.shadowed),
        ("below the threshold", threshold.below_threshold),
    ] {
        assert!(rays > 1000, "only {rays} {count}");
    }
}

#[test]
fn every_ray_toward_a_light_arrives_or_is_shadowed() {
    each(|name, scene, stats| {
        for depth in 0..stats.depths.len() {
            let context = format!("{name}, depth {depth}");
            let sum = |count: fn(&Counts) -> u64| at(stats, depth, count);
            let (rays, shadowed, segments) = (sum(|c| c.shadow_rays), sum(|c| c.shadowed), sum(|c| c.shadow_segments));
            assert_eq!(sum(|c| into(c, Stage::Shadow)), rays, "{context}");
            assert!(shadowed <= rays && rays <= segments, "{context}: {shadowed}, {rays}, {segments}");
            if !scene.settings.transparent_shadows {
                assert_eq!(segments, rays, "{context}");
            }
            // Light comes from lights, from the background, from surfaces and, on Phong's, from all around.
            let of_itself = sum(|c| c.escaped + into(c, Stage::ShadeEmissive) + into(c, Stage::ShadePhong));
            assert_eq!(sum(|c| into(c, Stage::Gather)), rays - shadowed + of_itself, "{context}");
        }
        assert!(stats.total().shadow_rays > 0, "{name} has no shadows");
    });
}

#[test]
fn the_film_and_the_counts_know_the_same_rays() {
    for name in SCENES {
        let (film, stats) = render(&scene(name));
        assert_eq!(film.pixels().rays.iter().map(|&rays| u64::from(rays)).sum::<u64>(), stats.rays(), "{name}");
    }
}
