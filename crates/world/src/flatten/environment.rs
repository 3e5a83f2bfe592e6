//! The background and the settings: copied when they change.

use bevy_ecs::change_detection::DetectChanges;
use bevy_ecs::system::{Res, ResMut};

use super::Buffers;
use crate::components::{Background, Settings};

/// Copies the background.
pub(super) fn flatten_background(background: Res<Background>, mut buffers: ResMut<Buffers>) {
    if background.is_changed() {
        buffers.0.background = background.0.clone();
    }
}

/// Copies the settings.
pub(super) fn flatten_settings(settings: Res<Settings>, mut buffers: ResMut<Buffers>) {
    if settings.is_changed() {
        buffers.0.settings = settings.0.clone();
    }
}
