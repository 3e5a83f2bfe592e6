//! What an entity looks like to a ray.

use std::sync::Arc;

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use brewster_geometry::TriangleMesh;
use glam::{Vec2, Vec3};

use super::{SceneKey, Transform};

/// A shape in its entity's object space. Lengths are in meters, positive and finite.
///
/// Which way a normal points decides what is inside: a closed shape's normals point out of it.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(Transform, SceneKey)]
#[component(summary_tick)]
pub enum Shape {
    /// A sphere around the origin.
    Sphere {
        /// The radius.
        radius: f32,
    },
    /// The plane y = 0 without end, normal +Y. Its texture coordinates are x and z in meters.
    Plane,
    /// A rectangle around the origin in the plane z = 0, normal +Z.
    Quad {
        /// Lengths along x and y.
        size: Vec2,
    },
    /// A disk around the origin in the plane z = 0, normal +Z.
    Disk {
        /// The radius.
        radius: f32,
        /// The radius of the hole in its middle: zero or more, less than `radius`.
        inner_radius: f32,
    },
    /// A box around the origin.
    Cuboid {
        /// Lengths along x, y and z.
        size: Vec3,
    },
    /// A closed cylinder around the origin and the y axis.
    Cylinder {
        /// The radius.
        radius: f32,
        /// The length along y.
        height: f32,
    },
    /// A closed cone around the y axis: its base at -height/2, its apex at +height/2.
    Cone {
        /// The radius of the base.
        radius: f32,
        /// The length along y.
        height: f32,
    },
    /// A torus around the origin and the y axis.
    Torus {
        /// The radius of the circle in the middle of the tube.
        major_radius: f32,
        /// The radius of the tube, less than `major_radius`.
        minor_radius: f32,
    },
    /// Triangles. Entities that hold the same `Arc` share one tree.
    Mesh(Arc<TriangleMesh>),
}

/// The entity wears the [`Shape`] of another entity, which need not be placed itself.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Transform, SceneKey)]
#[component(summary_tick)]
pub struct UsesShape(pub Entity);
