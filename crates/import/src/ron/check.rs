//! A placed scene, looked over for what is legal and probably not meant: lights and cameras inside opaque solids, and
//! scenes in which nothing can be seen. Places that f32 cannot hold are errors.

use std::collections::HashSet;

use brewster_world::components as world;
use brewster_world::components::parts::{Affine, TriangleMesh};
use glam::{Affine3A, DVec3, Vec2, Vec3, Vec3A};

use crate::diagnostics::{Code, Diagnostic, Severity};
use crate::limits::Exceeded;
use crate::scene::{Part, Row, Scene, world_transforms};
use crate::session::Session;
use crate::source::Span;

/// Pairs of a point and a solid that are looked at; a scene with more is not checked further.
const MOST_PAIRS: usize = 50_000_000;

/// Triangles that are looked at for one point; larger meshes are taken for open.
const MOST_TRIANGLES: usize = 1 << 20;

/// Reports what is suspicious in a scene that was read from a file of that name.
pub(crate) fn check(session: &mut Session, scene: &Scene, file: &str) {
    let (places, depths) = world_transforms(&scene.rows);
    check_depths(session, scene, &depths);
    check_places(session, scene, &places);
    check_visibility(session, scene, file);
    let solids: Vec<Solid> =
        (scene.rows.iter().zip(&places)).filter_map(|(row, place)| Solid::of(scene, row, place)).collect();
    let mut pairs = 0;
    let mut reported: HashSet<Span> = HashSet::new();
    for (row, place) in scene.rows.iter().zip(&places) {
        let (code, what) = match (&row.camera, row.light.as_deref()) {
            (Some(_), _) => (Code::CameraInside, "the camera"),
            (None, Some(world::Light::Point { .. } | world::Light::Spot { .. })) => (Code::LightInside, "the light"),
            _ => continue,
        };
        pairs += solids.len();
        if pairs > MOST_PAIRS {
            return;
        }
        let point = Vec3::from(place.translation);
        if let Some(solid) = solids.iter().find(|solid| solid.holds(point))
            && reported.insert(row.span)
        {
            let warning = session.sources.warning(code, row.span, format!("{what} is inside an opaque solid"));
            let solid = session.sources.describe(solid.span);
            session.found.push(warning.note(format!("the solid stands at {solid}")));
        }
    }
}

/// Reports the first row that is too deep in others' spaces.
fn check_depths(session: &mut Session, scene: &Scene, depths: &[u64]) {
    let bound = session.limits.hierarchy;
    if let Some(row) = depths.iter().position(|&depth| depth > bound) {
        let exceeded = Exceeded { name: "hierarchy", bound };
        session.error(Code::Limit, scene.rows[row].span, format!("too many parents of parents: {exceeded}"));
    }
}

/// Reports shapes whose transforms, together with those above them, cannot be undone.
fn check_places(session: &mut Session, scene: &Scene, places: &[Affine3A]) {
    let mut reported: HashSet<Span> = HashSet::new();
    for (row, place) in scene.rows.iter().zip(places) {
        if row.transform.is_none() || matches!(row.shape, Part::None) {
            continue;
        }
        let inverse = Affine::from_affine3a(*place).and_then(|place| place.inverse());
        if let Err(error) = inverse
            && reported.insert(row.span)
        {
            let message = format!("together with those above it, {error}");
            session.error(Code::Singular, row.span, message);
        }
    }
}

fn check_visibility(session: &mut Session, scene: &Scene, file: &str) {
    let mut warn = |message: &str, help: &str| {
        let warning = Diagnostic::about_file(Severity::Warning, Code::Nothing, file, message);
        session.found.push(warning.help(help));
    };
    if !scene.rows.iter().any(|row| row.camera.is_some()) {
        warn("the scene has no camera", "it can be included, but no picture can be taken of it");
    }
    let shines =
        |row: &Row| row.light.is_some() || scene.part(row, |row| &row.material).is_some_and(world::Material::shines);
    if scene.background.0.is_black() && !scene.rows.iter().any(shines) {
        warn("nothing in the scene sends out light", "a light, an Emissive material or a background does");
    }
}

/// An opaque solid, placed.
struct Solid<'s> {
    shape: &'s world::Shape,
    place: Affine3A,
    span: Span,
    /// A sphere around it in the world.
    center: Vec3A,
    radius: f32,
}

impl<'s> Solid<'s> {
    fn of(scene: &'s Scene, row: &'s Row, place: &Affine3A) -> Option<Solid<'s>> {
        row.transform?;
        let material = scene.part(row, |row| &row.material)?;
        if matches!(material, world::Material::Dielectric { .. }) {
            return None;
        }
        let shape = scene.part(row, |row| &row.shape)?;
        let (center, radius) = match shape {
            world::Shape::Sphere { radius } => (Vec3::ZERO, *radius),
            world::Shape::Cuboid { size } => (Vec3::ZERO, 0.5 * size.length()),
            world::Shape::Cylinder { radius, height } | world::Shape::Cone { radius, height } => {
                (Vec3::ZERO, Vec2::new(*radius, 0.5 * height).length())
            }
            world::Shape::Torus { major_radius, minor_radius } => (Vec3::ZERO, major_radius + minor_radius),
            world::Shape::Mesh(mesh) => {
                let bounds = mesh.bounds();
                (0.5 * (bounds.min + bounds.max), 0.5 * (bounds.max - bounds.min).length())
            }
            world::Shape::Plane | world::Shape::Quad { .. } | world::Shape::Disk { .. } => return None,
        };
        // The lengths of the columns bound what the linear part does to a length.
        let linear = place.matrix3;
        let stretch =
            (linear.x_axis.length_squared() + linear.y_axis.length_squared() + linear.z_axis.length_squared()).sqrt();
        let center = place.transform_point3a(center.into());
        Some(Solid { shape, place: *place, span: row.span, center, radius: radius * stretch })
    }

    /// Whether a point of the world is inside.
    fn holds(&self, point: Vec3) -> bool {
        let near = self.center.distance_squared(point.into()) < self.radius * self.radius;
        near && is_inside(self.shape, self.place.inverse().transform_point3(point))
    }
}

/// Whether a point of a shape's own space is inside it.
fn is_inside(shape: &world::Shape, p: Vec3) -> bool {
    let around = Vec2::new(p.x, p.z).length();
    match shape {
        world::Shape::Sphere { radius } => p.length() < *radius,
        world::Shape::Cuboid { size } => (2.0 * p.abs()).cmplt(*size).all(),
        world::Shape::Cylinder { radius, height } => 2.0 * p.y.abs() < *height && around < *radius,
        world::Shape::Cone { radius, height } => {
            2.0 * p.y.abs() < *height && around * height < radius * (0.5 * height - p.y)
        }
        world::Shape::Torus { major_radius, minor_radius } => {
            Vec2::new(around - major_radius, p.y).length() < *minor_radius
        }
        world::Shape::Mesh(mesh) => {
            mesh.triangles.len() <= MOST_TRIANGLES && winding_number(mesh, p).abs() > 0.5 && mesh.is_closed()
        }
        world::Shape::Plane | world::Shape::Quad { .. } | world::Shape::Disk { .. } => false,
    }
}

/// How often the triangles surround a point: the sum of their solid angles over 4π (van Oosterom and Strackee, 1983).
fn winding_number(mesh: &TriangleMesh, point: Vec3) -> f64 {
    let solid_angle = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner.as_dvec3() - point.as_dvec3());
        let lengths = DVec3::new(a.length(), b.length(), c.length());
        let below = lengths.element_product() + a.dot(b) * lengths.z + b.dot(c) * lengths.x + c.dot(a) * lengths.y;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    (0..mesh.triangles.len()).map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn points_are_inside_or_not() {
        let tetrahedron = TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
            ..Default::default()
        };
        let open = TriangleMesh { triangles: tetrahedron.triangles[..3].to_vec(), ..tetrahedron.clone() };
        let cone = world::Shape::Cone { radius: 1.0, height: 2.0 };
        let torus = world::Shape::Torus { major_radius: 2.0, minor_radius: 0.5 };
        for (shape, [x, y, z], expected) in [
            (world::Shape::Sphere { radius: 1.0 }, [0.5, 0.5, 0.5], true),
            (world::Shape::Sphere { radius: 1.0 }, [0.6, 0.6, 0.6], false),
            (world::Shape::Cuboid { size: Vec3::new(2.0, 4.0, 1.0) }, [0.9, -1.9, 0.4], true),
            (world::Shape::Cuboid { size: Vec3::new(2.0, 4.0, 1.0) }, [0.9, -1.9, 0.6], false),
            (world::Shape::Cylinder { radius: 1.0, height: 2.0 }, [0.7, 0.9, 0.7], true),
            (world::Shape::Cylinder { radius: 1.0, height: 2.0 }, [0.7, 1.1, 0.7], false),
            // Halfway up, where the cone is half as wide as at its base, at -1.
            (cone.clone(), [0.45, 0.0, 0.0], true),
            (cone.clone(), [0.55, 0.0, 0.0], false),
            (cone, [0.0, -1.1, 0.0], false),
            (torus.clone(), [0.0, 0.0, -1.7], true),
            (torus, [0.0, 0.0, 0.0], false),
            (world::Shape::Mesh(Arc::new(tetrahedron.clone())), [0.2, 0.2, 0.2], true),
            (world::Shape::Mesh(Arc::new(tetrahedron)), [0.5, 0.5, 0.5], false),
            (world::Shape::Mesh(Arc::new(open)), [0.1, 0.1, 0.1], false),
            (world::Shape::Plane, [0.0, -1.0, 0.0], false),
        ] {
            assert_eq!(is_inside(&shape, Vec3::new(x, y, z)), expected, "{shape:?} at ({x}, {y}, {z})");
        }
    }
}
