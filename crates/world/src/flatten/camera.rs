//! Cameras: one row each, in the order of keys. When one is edited all are gone through, and what differs is written.

use std::collections::BTreeMap;

use bevy_ecs::entity::Entity;
use bevy_ecs::lifecycle::RemovedComponents;
use bevy_ecs::name::Name;
use bevy_ecs::query::With;
use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Query, Res, ResMut};
use brewster_buffers as buffers;
use brewster_buffers::CameraFrame;
use brewster_lanes::math;
use glam::Affine3A;

use super::Buffers;
use super::directory::Owner;
use super::report::{FlattenReport, Problem};
use super::rows::overwrite;
use crate::components::{Camera, Lens, Projection, SceneKey, WorldTransform};
use crate::systems::{Moved, Watch, WorldMotions, for_each_changed};

/// Which cameras were left out.
#[derive(Resource, Default)]
pub(super) struct CameraIndex {
    pub(super) invalid: BTreeMap<Entity, Problem>,
}

/// Writes cameras if any of them changed, moved, came or went, or has another name.
pub(super) fn flatten_cameras(
    (watch, moved, motions): (Watch<Camera>, Res<Moved>, Res<WorldMotions>),
    (keys, names): (Watch<SceneKey, With<Camera>>, Watch<Name, With<Camera>>),
    (mut removed, mut unnamed): (RemovedComponents<Camera>, RemovedComponents<Name>),
    cameras: Query<(Entity, &SceneKey, &WorldTransform, &Camera, Option<&Name>)>,
    mut index: ResMut<CameraIndex>,
    mut buffers: ResMut<Buffers>,
    mut report: ResMut<FlattenReport>,
) {
    let mut stale = removed.read().count() + unnamed.read().filter(|&entity| cameras.contains(entity)).count() > 0;
    for_each_changed(&watch, |_, _| stale = true);
    for_each_changed(&keys, |_, _| stale = true);
    for_each_changed(&names, |_, _| stale = true);
    if !stale && !moved.0.iter().any(|&entity| cameras.contains(entity)) {
        return;
    }
    let mut sorted: Vec<_> = cameras
        .iter()
        .map(|(entity, key, place, camera, name)| (Owner { key: key.0, entity }, place.0, camera, name))
        .collect();
    sorted.sort_unstable_by_key(|(owner, ..)| owner.rank());

    index.invalid.clear();
    let mut rows: Vec<buffers::Camera> = Vec::with_capacity(sorted.len());
    let mut last: Option<Owner> = None;
    for (owner, place, camera, name) in sorted {
        let name = name.map_or("", |name| name.as_str());
        let row = owner.check_after(last.as_ref());
        let keys = motions.of(owner.entity).map_or(&[][..], |keys| keys);
        match row.and_then(|()| flatten(camera, (place, keys), name, owner.key).map_err(Problem::Camera)) {
            Ok(row) => rows.push(row),
            Err(problem) => {
                index.invalid.insert(owner.entity, problem);
                continue;
            }
        }
        last = Some(owner);
    }
    report.cameras = overwrite(&mut buffers.0.cameras, rows);
}

/// The row of a camera at a place that may move on; the error says what must hold.
fn flatten(
    camera: &Camera,
    (place, keys): (Affine3A, &[Affine3A]),
    name: &str,
    key: u64,
) -> Result<buffers::Camera, &'static str> {
    let CameraFrame { position, right, up, forward } = frame(place)?;
    let motion = keys.iter().map(|&key| frame(key)).collect::<Result<Vec<_>, _>>()?;
    if motion.windows(2).any(|pair| pair[0].forward.dot(pair[1].forward) < 0.5 || pair[0].up.dot(pair[1].up) < 0.5) {
        return Err("a camera must turn by less than 60 degrees in one step of its motion");
    }
    let projection = match camera.projection {
        Projection::Perspective { vfov } if vfov > 0.0 && vfov < std::f32::consts::PI => {
            buffers::Projection::Perspective(math::tan(0.5 * vfov))
        }
        Projection::Perspective { .. } => return Err("a camera's angle of view must be between 0 and 180 degrees"),
        Projection::Orthographic { height } if height > 0.0 && height.is_finite() => {
            buffers::Projection::Orthographic(0.5 * height)
        }
        Projection::Orthographic { .. } => return Err("a camera's height must be above 0"),
    };
    let pinhole = Lens { aperture_radius: 0.0, focus_distance: 1.0, blades: 0 };
    let Lens { aperture_radius, focus_distance, blades } = camera.lens.unwrap_or(pinhole);
    if !(aperture_radius >= 0.0 && aperture_radius.is_finite() && focus_distance > 0.0 && focus_distance.is_finite()) {
        return Err("a lens must have a radius of at least 0 and a focus distance above 0");
    }
    if matches!(blades, 1 | 2) {
        return Err("a lens must have 3 blades or more, or none");
    }
    Ok(buffers::Camera {
        name: name.to_owned(),
        position,
        right,
        up,
        forward,
        projection,
        aperture_radius,
        focus_distance,
        blades,
        key,
        motion: if motion.iter().all(|frame| *frame == motion[0]) { Vec::new() } else { motion },
    })
}

/// The frame at a place: unit vectors at right angles and right-handed, forward along -Z and up as near +Y as can be.
fn frame(place: Affine3A) -> Result<CameraFrame, &'static str> {
    let forward = -place.matrix3.z_axis.as_dvec3();
    let forward = forward / forward.length();
    let right = forward.cross(place.matrix3.y_axis.as_dvec3());
    let right = right / right.length();
    let up = right.cross(forward);
    let is_sound = place.is_finite() && right.is_finite() && up.is_finite();
    let [right, up, forward] = [right, up, forward].map(|axis| axis.as_vec3());
    let frame = CameraFrame { position: place.translation.into(), right, up, forward };
    if is_sound { Ok(frame) } else { Err("a camera's transform must not flatten its view, nor be infinite") }
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec3};

    use super::*;

    #[test]
    fn a_frame_forgets_scale_and_shear() {
        let axes = |place| frame(place).map(|frame| [frame.right, frame.up, frame.forward]);
        assert_eq!(axes(Affine3A::IDENTITY), Ok([Vec3::X, Vec3::Y, Vec3::NEG_Z]));
        let turn = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-0.2);
        let turned = Affine3A::from_quat(turn);
        let scaled = turned * Affine3A::from_scale(Vec3::new(3.0, 0.1, 40.0));
        let expected = [turn * Vec3::X, turn * Vec3::Y, turn * Vec3::NEG_Z];
        for place in [turned, scaled] {
            for (axis, expected) in axes(place).unwrap().into_iter().zip(expected) {
                assert!((axis - expected).length() < 1e-6 && (axis.length() - 1.0).abs() < 1e-6, "{place} {axis}");
            }
        }
        for flat in [Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 1.0, 0.0), Vec3::NAN] {
            assert!(frame(Affine3A::from_scale(flat)).is_err());
        }
    }

    #[test]
    fn views_that_see_nothing_are_refused() {
        let flatten = |projection| flatten(&Camera { projection, lens: None }, (Affine3A::IDENTITY, &[]), "", 0);
        let half_pi = std::f32::consts::FRAC_PI_2;
        let buffers::Projection::Perspective(tangent) =
            flatten(Projection::Perspective { vfov: half_pi }).unwrap().projection
        else {
            panic!()
        };
        assert!((tangent - 1.0).abs() < 1e-6, "tan 45°: {tangent}");
        for vfov in [0.0, -1.0, 3.2, f32::NAN] {
            assert!(flatten(Projection::Perspective { vfov }).is_err(), "{vfov}");
        }
        for height in [0.0, -1.0, f32::INFINITY, f32::NAN] {
            assert!(flatten(Projection::Orthographic { height }).is_err(), "{height}");
        }
    }
}
