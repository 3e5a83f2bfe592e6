//! Lights: one row for each light but ambient ones, in the order of keys; ambient light is summed.
//!
//! Lights are few: when one is edited all are gone through, and what differs is written.

use std::collections::BTreeMap;

use bevy_ecs::entity::Entity;
use bevy_ecs::lifecycle::RemovedComponents;
use bevy_ecs::query::With;
use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Query, Res, ResMut};
use brewster_buffers as buffers;
use brewster_buffers::{LightKind, LightMotion};
use brewster_lanes::math;
use glam::{Affine3A, Vec3};

use super::Buffers;
use super::directory::Owner;
use super::report::{FlattenReport, Problem};
use super::rows::overwrite;
use super::textures::is_color;
use crate::components::{Falloff, Light, SceneKey, WorldTransform};
use crate::systems::{Moved, Watch, WorldMotions, for_each_changed};

/// Which lights were left out.
#[derive(Resource, Default)]
pub(super) struct LightIndex {
    pub(super) invalid: BTreeMap<Entity, Problem>,
}

/// Writes lights if any of them changed, moved, came or went.
pub(super) fn flatten_lights(
    (watch, keys): (Watch<Light>, Watch<SceneKey, With<Light>>),
    (moved, motions): (Res<Moved>, Res<WorldMotions>),
    mut removed: RemovedComponents<Light>,
    lights: Query<(Entity, &SceneKey, &WorldTransform, &Light)>,
    mut index: ResMut<LightIndex>,
    mut buffers: ResMut<Buffers>,
    mut report: ResMut<FlattenReport>,
) {
    let mut stale = removed.read().count() > 0;
    for_each_changed(&watch, |_, _| stale = true);
    for_each_changed(&keys, |_, _| stale = true);
    if !stale && !moved.0.iter().any(|&entity| lights.contains(entity)) {
        return;
    }
    let mut sorted: Vec<_> =
        lights.iter().map(|(entity, key, place, light)| (Owner { key: key.0, entity }, place.0, light)).collect();
    sorted.sort_unstable_by_key(|(owner, ..)| owner.rank());

    index.invalid.clear();
    let mut ambient = Vec3::ZERO;
    let mut rows: Vec<buffers::Light> = Vec::with_capacity(sorted.len());
    let mut last: Option<Owner> = None;
    let mut light_motions = Vec::new();
    for (owner, place, light) in sorted {
        let row =
            owner.check_after(last.as_ref()).and_then(|()| flatten(light, place, owner.key).map_err(Problem::Light));
        let keys = motions.of(owner.entity).map_or(&[][..], |keys| keys);
        let motion = keys.iter().map(|&place| flatten(light, place, owner.key).map_err(Problem::Light));
        match row.and_then(|row| Ok((row, motion.collect::<Result<Vec<_>, _>>()?))) {
            Ok((Flattened::Ambient(radiance), _)) => ambient += radiance,
            Ok((Flattened::Row(row), keys)) => {
                light_motions.extend(motion_of(rows.len() as u32, &keys));
                rows.push(row);
            }
            Err(problem) => {
                index.invalid.insert(owner.entity, problem);
                continue;
            }
        }
        last = Some(owner);
    }
    buffers.0.ambient = ambient;
    report.lights = overwrite(&mut buffers.0.lights, rows);
    report.lights.rewritten += usize::from(buffers.0.light_motions != light_motions);
    buffers.0.light_motions = light_motions;
}

/// How a light of a row moves through what it is at some steps; none if that is always the same.
fn motion_of(light: u32, keys: &[Flattened]) -> Option<LightMotion> {
    let place = |key: &Flattened| match key {
        Flattened::Ambient(_) => None,
        Flattened::Row(row) => Some([row.position, row.direction]),
    };
    let keys: Vec<_> = keys.iter().filter_map(place).collect();
    keys.iter().any(|key| *key != keys[0]).then_some(LightMotion { light, keys })
}

/// What becomes of a light.
enum Flattened {
    Ambient(Vec3),
    Row(buffers::Light),
}

/// The row of a light at a place; the error says what must hold.
fn flatten(light: &Light, place: Affine3A, key: u64) -> Result<Flattened, &'static str> {
    let (intensity, falloff, angles) = match *light {
        Light::Ambient { radiance } => return color(radiance).map(Flattened::Ambient),
        Light::Directional { irradiance } => {
            let (intensity, direction) = (color(irradiance)?, axis(place)?);
            return Ok(Flattened::Row(buffers::Light {
                kind: LightKind::Directional,
                position: Vec3::ZERO,
                direction,
                intensity,
                cone_scale: 0.0,
                cone_offset: 1.0,
                range: f32::INFINITY,
                key,
            }));
        }
        Light::Point { intensity, falloff } => (intensity, falloff, None),
        Light::Spot { intensity, inner_angle, outer_angle, falloff } => {
            (intensity, falloff, Some((inner_angle, outer_angle)))
        }
    };
    let position = Vec3::from(place.translation);
    if !position.is_finite() {
        return Err("a light must have a finite place");
    }
    let (direction, (cone_scale, cone_offset)) = match angles {
        None => (Vec3::NEG_Z, (0.0, 1.0)),
        Some((inner, outer)) => (axis(place)?, cone(inner, outer)?),
    };
    let (kind, range) = match falloff {
        Falloff::InverseSquare => (LightKind::Point, f32::INFINITY),
        Falloff::Within(range) if range > 0.0 => (LightKind::Point, range),
        Falloff::Within(_) => return Err("a light's range must be above 0"),
        Falloff::None => (LightKind::PointWithoutFalloff, f32::INFINITY),
    };
    let intensity = color(intensity)?;
    Ok(Flattened::Row(buffers::Light { kind, position, direction, intensity, cone_scale, cone_offset, range, key }))
}

fn color(color: Vec3) -> Result<Vec3, &'static str> {
    if is_color(color) { Ok(color) } else { Err("light must be finite and at least 0") }
}

/// The unit direction of -Z at a place, in f64.
fn axis(place: Affine3A) -> Result<Vec3, &'static str> {
    let axis = place.matrix3.z_axis.as_dvec3();
    let length = axis.length();
    if length > 0.0 && length.is_finite() {
        Ok((-axis / length).as_vec3())
    } else {
        Err("a light must have a direction")
    }
}

/// The ramp of a cone as a factor and an offset on the cosine: KHR_lights_punctual, section "Inner and Outer Cone Angles".
fn cone(inner: f32, outer: f32) -> Result<(f32, f32), &'static str> {
    if !(0.0 <= inner && inner <= outer && 0.0 < outer && outer <= std::f32::consts::FRAC_PI_2) {
        return Err("a cone's angles must be 0 <= inner <= outer <= 90 degrees and outer above 0");
    }
    let (cos_inner, cos_outer) = (math::cos(inner), math::cos(outer));
    let scale = 1.0 / (cos_inner - cos_outer).max(0.001);
    Ok((scale, -cos_outer * scale))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worked out by hand from the definition of the ramp: 1 at the inner angle, 0 at the outer one.
    #[test]
    fn a_cone_goes_from_one_to_zero() {
        for (inner, outer) in [(0.0f32, 0.5f32), (0.3, 0.7), (0.0, std::f32::consts::FRAC_PI_2), (0.2, 0.9)] {
            let (scale, offset) = cone(inner, outer).unwrap();
            let at = |angle: f32| angle.cos() * scale + offset;
            assert!((at(inner) - 1.0).abs() < 1e-4 && at(outer).abs() < 1e-4, "{inner} to {outer}");
        }
        let (scale, offset) = cone(0.4, 0.4).unwrap();
        assert!((scale - 1000.0).abs() < 0.1 && (0.4f32.cos() * scale + offset).abs() < 1e-3, "{scale} {offset}");
        for (inner, outer) in [(-0.1, 0.5), (0.6, 0.5), (0.0, 0.0), (0.0, 1.6), (f32::NAN, 0.5), (0.1, f32::NAN)] {
            assert!(cone(inner, outer).is_err(), "{inner} to {outer}");
        }
    }

    #[test]
    fn light_travels_along_minus_z_whatever_the_scale() {
        let turned = Affine3A::from_mat3(glam::Mat3::from_cols(Vec3::Y * 3.0, Vec3::Z * 0.5, Vec3::X * 7.0));
        let sun = Light::Directional { irradiance: Vec3::ONE };
        let Ok(Flattened::Row(row)) = flatten(&sun, turned, 4) else { panic!() };
        assert_eq!((row.direction, row.key), (Vec3::NEG_X, 4));
        assert!(flatten(&sun, Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0)), 4).is_err());
    }
}
