//! Where single contributions to a picture came from, in words and names.

use std::fmt;

use brewster_wavefront::attribution::Origin;
use brewster_wavefront::queues::{End, NO_INSTANCE};
use brewster_world::components::SceneKey;
use serde::Serialize;

use crate::Session;

/// A contribution with the names of what it came from.
#[derive(Clone, Debug, Serialize)]
pub struct NamedOrigin {
    /// Column and row in the picture.
    pixel: [u32; 2],
    /// The number of the sample.
    sample: u32,
    /// The depth of the ray that brought it, or from whose hit it was sent.
    depth: u32,
    /// The path's events: see [`Trail`](brewster_wavefront::queues::Trail).
    path: String,
    /// The stage that made it.
    stage: &'static str,
    /// The last surface's entity, by its name, its place in the scene file, or its key.
    entity: Option<String>,
    /// That entity's material, by its name or its kind.
    material: Option<String>,
    /// What it brought; a channel that is not finite is null in JSON.
    radiance: [f32; 3],
}

impl NamedOrigin {
    pub(crate) fn new(session: &Session, origin: &Origin) -> NamedOrigin {
        let (x, y) = origin.pixel.place();
        let instance = (origin.instance != NO_INSTANCE).then_some(origin.instance);
        NamedOrigin {
            pixel: [x, y],
            sample: origin.sample,
            depth: origin.depth,
            path: origin.trail.to_string(),
            stage: match origin.trail.ended() {
                Some(End::Light) => "shadow",
                Some(End::Emitter) => "shade_emissive",
                Some(End::Background) => "escape",
                Some(End::Surface) | None => "scatter",
            },
            entity: instance.map(|instance| entity_name(session, instance)),
            material: instance.map(|instance| material_name(session, instance)),
            radiance: origin.radiance.to_array(),
        }
    }
}

/// A name in the scene file, or what it is and its place there, or its key.
pub(crate) fn key_name(session: &Session, key: u64, what: &str) -> String {
    let place = || session.places().describe(SceneKey(key)).map(|place| format!("{what} at {place}"));
    let name = session.scene().name_of(SceneKey(key)).map(str::to_owned);
    name.or_else(place).unwrap_or_else(|| format!("{what} {key}"))
}

/// The name of an instance's entity, or its place in the scene file, or its key.
pub(crate) fn entity_name(session: &Session, instance: u32) -> String {
    key_name(session, session.buffers().instances.view().key[instance as usize], "entity")
}

/// The name and kind of an instance's material, or its kind.
pub(crate) fn material_name(session: &Session, instance: u32) -> String {
    let scene = session.buffers();
    let material = scene.instances.view().material[instance as usize];
    let material = scene.materials.rows.get(material.0 as usize);
    let (kind, name) = (material.kind.name(), session.scene().name_of(SceneKey(material.key)));
    name.map_or(kind.to_owned(), |name| format!("{name} ({kind})"))
}

impl fmt::Display for NamedOrigin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let NamedOrigin { pixel: [x, y], sample, depth, path, stage, entity, material, radiance } = self;
        let [r, g, b] = radiance;
        write!(f, "{r:.4} {g:.4} {b:.4} in pixel {x},{y}, sample {sample}: {path} in {stage} at depth {depth}")?;
        match (entity, material) {
            (Some(entity), Some(material)) => write!(f, ", by {entity} of {material}"),
            _ => Ok(()),
        }
    }
}
