//! What every stage of a render reads.

use brewster_buffers::{Camera, SceneBuffers};
use brewster_geometry::SceneGeometry;
use glam::Vec2;

use crate::media::Medium;
use crate::policy::Policy;

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
    /// Where the samples lie around the center of every pixel, in pixels, by number of the sample.
    pub pattern: Vec<Vec2>,
    /// How batches are scheduled.
    pub policy: Policy,
}
