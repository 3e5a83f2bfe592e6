//! What belongs to the scene as a whole.

use bevy_ecs::resource::Resource;
use brewster_buffers as buffers;

/// The scene's settings, see [`buffers::Settings`].
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Settings(pub buffers::Settings);

/// What rays see that meet nothing, see [`buffers::Background`].
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Background(pub buffers::Background);
