//! Pictures of the whole sky.

use std::sync::Arc;

use brewster_world::components::parts::{EnvironmentMap, Image, MapError, MapRows, Texels};

use crate::diagnostics::Code;
use crate::image;
use crate::session::Session;
use crate::source::Span;

/// How a picture is taken for the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct View {
    pub rows: MapRows,
    /// Radians about +Y.
    pub rotation: f32,
    /// Factor of its pixels.
    pub intensity: f32,
}

impl View {
    /// As it is.
    pub(crate) const PLAIN: View = View { rows: MapRows::Centers, rotation: 0.0, intensity: 1.0 };
}

/// The sky in a file that is named at `span`.
pub(crate) fn load(session: &mut Session, name: &str, span: Span, view: View) -> Option<Arc<EnvironmentMap>> {
    let picture = image::load(session, name, span)?;
    let sky = sky(session, picture, view);
    sky.map_err(|error| session.error(Code::Image, span, format!("the picture {name:?} is no sky: {error}"))).ok()
}

/// A picture as a sky. One that was made of the same picture before is given again.
pub(crate) fn sky(session: &mut Session, picture: Arc<Image>, view: View) -> Result<Arc<EnvironmentMap>, MapError> {
    if let Some((of, as_seen, sky)) = &session.assets.sky
        && Arc::ptr_eq(of, &picture)
        && *as_seen == view
    {
        return Ok(Arc::clone(sky));
    }
    let sky = Arc::new(EnvironmentMap::new(scaled(&picture, view.intensity), view.rows, view.rotation)?);
    session.assets.sky = Some((picture, view, Arc::clone(&sky)));
    Ok(sky)
}

fn scaled(picture: &Arc<Image>, factor: f32) -> Arc<Image> {
    if factor == 1.0 {
        return Arc::clone(picture);
    }
    let pixels = picture.to_floats().floats().iter().map(|pixel| pixel.map(|channel| channel * factor)).collect();
    Arc::new(Image { width: picture.width, height: picture.height, texels: Texels::Floats(pixels) })
}
