//! The scene format, field by field. What stands here is the manual, too: `README.md` is checked against it.
//!
//! These types mirror what an author writes; `spawn.rs` turns them into components.

use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use crate::source::Span;

mod material;
pub(crate) mod study;
mod texture;

pub(crate) use material::{Anisotropy, Dispersion, Film, Fresnel, Iridescence, Material, Opacity, Sides};
pub(crate) use texture::{Axis, Channel, Filter, Map, Number, Paint, Texture, UvSet, Wrap};

use super::decode::{Context, Decode, Fields, check_name, schema, variant};
use super::info::{FieldInfo, Form, Kind, Range, TypeInfo, VariantInfo};
use super::node::Node;
use super::values::{Either, Named, Reference, Rgb, Scale, Spanned};

const LENGTH: Range = Range { text: "above 0 (1e-15 to 1e15)", admits: |x| (1e-15..=1e15).contains(&x) };
const HOLE: Range = Range { text: "0 or more", admits: |x| (0.0..=1e15).contains(&x) };
const PLACE: Range = Range { text: "-1e15 to 1e15", admits: |x| x.abs() <= 1e15 };
const ABOVE_ZERO: Range = Range { text: "above 0", admits: |x| x > 0.0 };
const ZERO_OR_MORE: Range = Range { text: "0 or more", admits: |x| x >= 0.0 };
const ONE_OR_MORE: Range = Range { text: "1 or more", admits: |x| x >= 1.0 };
const GROWTH: Range = Range { text: "0.01 to 100", admits: |x| (0.01..=100.0).contains(&x) };
const VIEW_ANGLE: Range = Range { text: "above 0, below 180", admits: |x| x > 0.0 && x < 180.0 };
const CONE_ANGLE: Range = Range { text: "above 0, at most 90", admits: |x| x > 0.0 && x <= 90.0 };
const INNER_ANGLE: Range = Range { text: "0 to 90", admits: |x| (0.0..=90.0).contains(&x) };
const PIXELS: Range = Range { text: "1 to 65536", admits: |x| (1.0..=65536.0).contains(&x) };
const SAMPLES: Range = Range { text: "1 to 1048576", admits: |x| (1.0..=1048576.0).contains(&x) };
const BLADES: Range = Range { text: "0, or 3 to 100", admits: |x| x == 0.0 || (3.0..=100.0).contains(&x) };
const DEPTH: Range = Range { text: "0 to 1000", admits: |x| (0.0..=1000.0).contains(&x) };
const STOPS: Range = Range { text: "-100 to 100", admits: |x| (-100.0..=100.0).contains(&x) };

schema! {
    /// The whole file.
    record Scene {
        /// Resolution, depth, sampling and output.
        settings: Settings = "()" => "(resolution: (960, 540), max_depth: 5)",
        /// The camera, if there is one.
        camera: Option<Spanned<Camera>> => "Perspective(eye: (0, 1, 6), target: (0, 1, 0), vfov: 36)",
        /// Cameras by name. Without a choice on the command line, `camera` takes the picture, or else the first of these.
        cameras: Named<Camera> = "{}" => "{\"top\": Orthographic(eye: (0, 9, 0), target: (0, 0, 0), up: (0, 0, -1), height: 8)}",
        /// What rays see that meet nothing.
        background: Either<Rgb, Sky> as "nit" where ZERO_OR_MORE = "0" => "Gradient(horizon: 0.9, zenith: (0.2, 0.4, 0.9))",
        /// Materials by name.
        materials: Named<Material> = "{}" => "{\"red\": Lambert(albedo: (0.6, 0.1, 0.1))}",
        /// Shapes by name. A mesh that many entities use is built once.
        shapes: Named<Shape> = "{}" => "{\"bead\": Sphere(radius: 0.05)}",
        /// What is in the scene.
        entities: Vec<Entity> = "[]" => "[(shape: Sphere(), material: \"red\")]",
    }

    /// What belongs to the scene as a whole; options of the command line overrule it.
    record Settings {
        /// Width and height of the picture.
        resolution: Spanned<[u32; 2]> as "pixels" where PIXELS = "(960, 540)" => "(480, 270)",
        /// How light is carried. Materials that are not the lectures' need `Path`.
        integrator: Integrator = "Whitted" => "Path",
        /// The number of interactions on a path that may scatter on. 0 shows direct light alone, and with `Path`
        /// only what shines itself.
        max_depth: u32 where DEPTH = "2" => "5",
        /// Samples per pixel.
        samples: u32 where SAMPLES = "16" => "64",
        /// Blocks of 8 by 8 pixels whose noise, as estimated after 16, 32, 64 and so on samples, is below this part of the
        /// display's range get no more samples. Without it all pixels get as many.
        noise_threshold: Option<f32> where ABOVE_ZERO => "0.01",
        /// Chooses the pattern of samples.
        seed: u64 = "0" => "7",
        /// Where the numbers come from that decide what a sample does.
        sampler: Sampler = "Sobol" => "Independent",
        /// `Path`: a dielectric sends a ray to either side while the number of interactions before it is below this, later
        /// one of them by chance.
        split_depth: u32 where DEPTH = "1" => "3",
        /// `Path`: whether rays of little weight are ended by chance, and the others carry what they would have brought.
        roulette: bool = "true" => "false",
        /// `Path`: whether diffuse surfaces look for the light that mirrors and glass throw on them: photons that are sent before
        /// the first sample say from where it comes. It pays where a small lamp shines on smooth glass or metal; elsewhere it takes time.
        guiding: bool = "false" => "true",
        /// `Path`: the largest radiance that one contribution may bring: less noise, and light is missing. Without it nothing
        /// is held back.
        clamp: Option<f32> as "nit" where ABOVE_ZERO => "20",
        /// How samples lie around their pixel.
        filter: PixelFilter = "BlackmanHarris" => "Box",
        /// `Whitted`: whether light passes dielectrics on its way to a surface, weakened by transmittance and absorption.
        /// Otherwise they cast full shadows.
        transparent_shadows: Spanned<bool> = "false" => "true",
        /// Rays whose largest weight falls below it are not followed. 0 follows all.
        contribution_threshold: f32 where ZERO_OR_MORE = "0" => "0.001",
        /// The picture is scaled by 2 to this power before tone mapping.
        exposure: f32 as "stops" where STOPS = "0" => "-1",
        /// How radiance becomes display values.
        tone_mapping: ToneMapping = "Srgb" => "Filmic",
    }

    /// How light is carried.
    choice Integrator {
        /// The deterministic algorithm of the lectures: every dielectric hit sends a ray to either side.
        Whitted {},
        /// Path tracing, unbiased: light from everywhere, by chance. It takes every material but Phong's.
        Path {},
    }

    /// Where numbers come from.
    choice Sampler {
        /// Owen-scrambled Sobol points: even over every pixel and over its neighbors.
        Sobol {},
        /// Without any relation to each other.
        Independent {},
    }

    /// How samples lie around their pixel.
    choice PixelFilter {
        /// Evenly over the pixel.
        Box {},
        /// A pyramid two pixels wide.
        Tent {},
        /// A bell curve three pixels wide.
        Gaussian {},
        /// A window four pixels wide, close to a bell curve of finite width.
        BlackmanHarris {},
    }

    /// How radiance becomes display values.
    choice ToneMapping {
        /// Clamped, without any curve.
        None {},
        /// Clamped, then the sRGB curve.
        Srgb {},
        /// A filmic curve that rolls highlights off, then the sRGB curve.
        Filmic {},
        /// A fit of the ACES reference transforms.
        Aces {},
        /// AgX without a look.
        Agx {},
        /// Khronos PBR Neutral, which keeps base colors.
        PbrNeutral {},
    }

    /// Where a picture is taken from.
    choice Camera {
        /// Things farther away are smaller.
        Perspective {
            /// Where the camera is.
            eye: Vec3 as "m" where PLACE = "(0, 0, 5)" => "(0, 1.5, 6)",
            /// A point in the middle of the picture.
            target: Vec3 as "m" where PLACE = "(0, 0, 0)" => "(0, 1, 0)",
            /// A direction that points up in the picture.
            up: Vec3 = "(0, 1, 0)" => "(0, 1, 0)",
            /// The full vertical angle of view.
            vfov: f32 as "degrees" where VIEW_ANGLE = "45" => "36",
            /// The lens; a pinhole without one.
            lens: Option<Lens> => "(aperture_radius: 0.02, focus_distance: 6)",
            /// Where it goes while the shutter is open.
            motion: Option<Pan> => "(eye: (0.3, 1.5, 6))",
        },
        /// Things are of one size at every distance.
        Orthographic {
            /// Where the camera is; what lies behind it is not seen.
            eye: Vec3 as "m" where PLACE = "(0, 0, 5)" => "(0, 9, 0)",
            /// A point in the middle of the picture.
            target: Vec3 as "m" where PLACE = "(0, 0, 0)" => "(0, 0, 0)",
            /// A direction that points up in the picture.
            up: Vec3 = "(0, 1, 0)" => "(0, 0, -1)",
            /// The height of what the picture shows.
            height: f32 as "m" where LENGTH = "2" => "8",
            /// The lens; everything is sharp without one.
            lens: Option<Lens> => "(aperture_radius: 0.02, focus_distance: 6)",
            /// Where it goes while the shutter is open.
            motion: Option<Pan> => "(eye: (0.3, 9, 0), target: (0.3, 0, 0))",
        },
    }

    /// Where a camera is when the shutter closes; what is not told stays. On the way it goes evenly.
    record Pan {
        /// Where the camera is.
        eye: Option<Vec3> as "m" where PLACE => "(0.3, 1.5, 6)",
        /// A point in the middle of the picture.
        target: Option<Vec3> as "m" where PLACE => "(0.3, 1, 0)",
        /// A direction that points up in the picture.
        up: Option<Vec3> => "(0.1, 1, 0)",
    }

    /// A thin lens, for the integrator `Path`. It takes `aperture_radius` or `f_stop`.
    record Lens {
        /// Radius of the aperture.
        aperture_radius: Option<f32> as "m" where HOLE => "0.02",
        /// Focal length over the aperture's diameter, for the focal length that has the camera's angle of view on full-frame
        /// film, 24 mm high. For perspective cameras.
        f_stop: Option<f32> where ABOVE_ZERO => "2.8",
        /// Distance along the view axis that is sharp; as far as `target` where absent.
        focus_distance: Option<f32> as "m" where LENGTH => "6",
        /// Blades of the aperture, a regular polygon with a corner at the top; 0 is round.
        blades: u32 where BLADES = "0" => "6",
    }

    /// A background that is not one color.
    choice Sky {
        /// From the horizon up to the zenith and down to the ground, linear in the sine of the elevation.
        Gradient {
            /// At the horizon.
            horizon: Rgb as "nit" where ZERO_OR_MORE => "(0.8, 0.9, 1)",
            /// Straight up.
            zenith: Rgb as "nit" where ZERO_OR_MORE => "(0.2, 0.4, 0.9)",
            /// Straight down; as the horizon where absent.
            ground: Option<Rgb> as "nit" where ZERO_OR_MORE => "0.1",
        },
        /// A picture of the whole sky: longitude across, from the zenith at the top down to the nadir. Its middle column is
        /// seen toward +X and the one a quarter before it toward -Z, as in glTF.
        Environment {
            /// The file, seen from the folder of the scene file: Radiance HDR or OpenEXR, or any other picture.
            file: Spanned<String> => "\"sky.exr\"",
            /// The picture is turned about the y axis, counterclockwise as seen from above.
            rotation: f32 as "degrees" = "0" => "-90",
            /// Where its rows lie.
            rows: Rows = "Centers" => "Poles",
            /// Factor of what the picture shows.
            intensity: f32 where ZERO_OR_MORE = "1" => "2.5",
        },
    }

    /// Where the rows of a picture of the sky lie.
    choice Rows {
        /// In the middle of bands of equal height: the usual.
        Centers {},
        /// The first at the zenith, the last at the nadir, as in Mitsuba.
        Poles {},
    }

    /// What an entity looks like, in its own space.
    choice Shape {
        /// A sphere around the origin.
        Sphere {
            /// Its radius.
            radius: f32 as "m" where LENGTH = "1" => "0.5",
        },
        /// A plane without end.
        Plane {
            /// The side that it shows, any length but 0.
            normal: Spanned<Vec3> = "(0, 1, 0)" => "(0, 0, 1)",
            /// A point on it.
            point: Vec3 as "m" where PLACE = "(0, 0, 0)" => "(0, -1, 0)",
        },
        /// A rectangle around the origin that faces +Z.
        Quad {
            /// Lengths along x and y.
            size: Vec2 as "m" where LENGTH = "(1, 1)" => "(2, 1.5)",
        },
        /// A disk around the origin that faces +Z.
        Disk {
            /// Its radius.
            radius: f32 as "m" where LENGTH = "1" => "0.5",
            /// Radius of the hole in its middle, less than `radius`.
            inner_radius: f32 as "m" where HOLE = "0" => "0.2",
        },
        /// A box around the origin.
        Box {
            /// Lengths along x, y and z.
            size: Vec3 as "m" where LENGTH = "(1, 1, 1)" => "(1.6, 2, 0.1)",
        },
        /// A closed cylinder around the origin and the y axis.
        Cylinder {
            /// Its radius.
            radius: f32 as "m" where LENGTH = "1" => "0.5",
            /// Its length along y.
            height: f32 as "m" where LENGTH = "1" => "2",
        },
        /// A closed cone around the y axis; the origin is halfway up.
        Cone {
            /// Radius of the base.
            radius: f32 as "m" where LENGTH = "1" => "0.5",
            /// Its length along y.
            height: f32 as "m" where LENGTH = "1" => "2",
        },
        /// A torus around the origin and the y axis.
        Torus {
            /// Radius of the circle in the middle of the tube.
            major_radius: f32 as "m" where LENGTH = "1" => "0.8",
            /// Radius of the tube, less than `major_radius`.
            minor_radius: f32 as "m" where LENGTH = "0.25" => "0.1",
        },
        /// Triangles, from a file or in place.
        Mesh {
            /// An OBJ or PLY file, seen from the folder of the scene file.
            file: Option<Spanned<String>> => "\"bunny.ply\"",
            /// Positions of the vertices.
            positions: Option<Spanned<Vec<Vec3>>> as "m" where PLACE => "[(0, 0, 0), (1, 0, 0), (0, 1, 0)]",
            /// The three vertices of each triangle, from 0, counterclockwise as seen from the front.
            triangles: Option<Spanned<Vec<[u32; 3]>>> => "[(0, 1, 2)]",
            /// A normal for each vertex; a flat surface without.
            normals: Option<Spanned<Vec<Vec3>>> => "[(0, 0, 1), (0, 0, 1), (0, 0, 1)]",
            /// Texture coordinates for each vertex.
            uvs: Option<Spanned<Vec<Vec2>>> => "[(0, 0), (1, 0), (0, 1)]",
            /// Second texture coordinates for each vertex.
            second_uvs: Option<Spanned<Vec<Vec2>>> => "[(0, 0), (1, 0), (0, 1)]",
            /// A color for each vertex, for textures that ask for it: linear red, green, blue, and alpha.
            colors: Option<Spanned<Vec<[f32; 4]>>> where ZERO_OR_MORE => "[(1, 0, 0, 1), (0, 1, 0, 1), (0, 0, 1, 1)]",
            /// A tangent for each vertex, the direction in which u grows, and the sign of the side on which v does: 1 where that is the
            /// cross product of normal and tangent, or -1. Without them texture coordinates tell.
            tangents: Option<Spanned<Vec<[f32; 4]>>> => "[(1, 0, 0, 1), (1, 0, 0, 1), (1, 0, 0, 1)]",
        },
        /// What is in a glTF file, or a part of it: its nodes with their meshes, materials and lights. It stands in an entity, not
        /// among `shapes`. A `material` beside it is worn by all of it. For `Path`, unless all materials are others.
        Gltf {
            /// A file whose name ends in .gltf or .glb, seen from the folder of the scene file.
            file: Spanned<String> => "\"helmet.glb\"",
            /// The name of a node: it and what is below it, where they stand in the file.
            node: Option<Spanned<String>> => "\"Visor\"",
            /// Materials in the place of those of the file, by the names that they have there.
            materials: Named<Reference<Material>> = "{}" => "{\"Paint\": Lambert(albedo: (0.6, 0.1, 0.1)), \"Glass\": \"green glass\"}",
            /// The file's scene, by name or number; its default one where absent.
            scene: Option<String> => "\"Garage\"",
            /// The variant of its materials, by name or number.
            variant: Option<String> => "\"Midnight\"",
            /// The animation, by name or number, or \"all\"; the first where absent.
            animation: Option<String> => "\"Drive\"",
            /// The moment of the animation; without it nodes stand as they do without any.
            time: Option<f32> as "s" => "1.5",
            /// How long the shutter is open from that moment on. Nodes move on; skins and morph targets stay as they are.
            shutter: Option<f32> as "s" where ZERO_OR_MORE => "0.02",
        },
    }

    /// Something in the scene: it is what its fields make it.
    record Entity {
        /// Its name, for `parent` and for overrides. Unique in the file.
        name: Option<Spanned<String>> => "\"ball\"",
        /// What it looks like; it needs a material, too.
        shape: Option<Reference<Shape>> => "Sphere(radius: 0.5)",
        /// What its surface does to light.
        material: Option<Reference<Material>> => "\"red\"",
        /// The light it sends out.
        light: Option<Spanned<Light>> => "Point(intensity: 40)",
        /// Where it is in its parent's space.
        at: Option<Vec3> as "m" where PLACE => "(0, 1, 0)",
        /// How it is turned.
        rotate: Option<Rotation> => "(y: 25)",
        /// How it is scaled: one factor, or one along each of its axes.
        scale: Option<Spanned<Scale>> => "(1, 2, 1)",
        /// A point, in its parent's space, toward which it turns its -Z, where lights shine. In place of `rotate`.
        look_at: Option<Spanned<Vec3>> as "m" where PLACE => "(0, 1, 0)",
        /// The three upper rows of its matrix, in place of `at`, `rotate`, `scale` and `look_at`.
        transform: Option<Spanned<[[f32; 4]; 3]>> => "((1, 0, 0, 0), (0, 1, 0, 2), (0, 0, 1, 0))",
        /// What happens to it, and to all that is in its space, while the shutter is open.
        motion: Option<Motion> => "(by: (0.5, 0, 0), rotate: (z: -90))",
        /// The name of the entity whose space it is placed in; the world's without one.
        parent: Option<Spanned<String>> => "\"table\"",
        /// Entities that are placed in its space.
        children: Vec<Entity> = "[]" => "[(shape: Sphere(), material: \"red\")]",
        /// Another scene file, whose entities are placed in its space.
        include: Option<Spanned<String>> => "\"chair.ron\"",
        /// Places, in its space, at which everything in it is repeated.
        instances: Option<Spanned<Either<Vec<Placement>, Pattern>>> => "Grid(count: (10, 1, 10), spacing: (0.4, 0, 0.4))",
    }

    /// A rotation: about x first, then y, then z, counterclockwise as seen from the axis' end; or about one axis.
    record Rotation {
        /// About the x axis.
        x: f32 as "degrees" = "0" => "-90",
        /// About the y axis.
        y: f32 as "degrees" = "0" => "25",
        /// About the z axis.
        z: f32 as "degrees" = "0" => "5",
        /// Any axis, any length but 0.
        axis: Option<Spanned<Vec3>> => "(1, 1, 0)",
        /// About `axis`.
        angle: Option<f32> as "degrees" => "30",
    }

    /// What happens to an entity while the shutter is open, evenly: when it opens the entity is where its place says. A moment of that
    /// is drawn for every sample.
    record Motion {
        /// How far it goes, straight, along the axes of its parent's space.
        by: Vec3 as "m" where PLACE = "(0, 0, 0)" => "(0.5, 0, 0)",
        /// How it turns about its own axes, by 5000 degrees in all at most.
        rotate: Option<Rotation> => "(z: -90)",
        /// The factor by which it has grown in the end.
        scale: f32 where GROWTH = "1" => "1.2",
    }

    /// Light without extent. It shines from its entity's place; spots and directional lights shine along -Z.
    choice Light {
        /// From a point to all sides.
        Point {
            /// The light.
            intensity: Rgb as "cd" where ZERO_OR_MORE = "1" => "40",
            /// How it weakens with distance.
            falloff: Falloff = "InverseSquare" => "None",
        },
        /// Parallel, from infinitely far.
        Directional {
            /// The light on a surface that faces it.
            irradiance: Rgb as "lux" where ZERO_OR_MORE = "1" => "(3, 2.9, 2.7)",
        },
        /// From a point into a cone.
        Spot {
            /// The light on the axis.
            intensity: Rgb as "cd" where ZERO_OR_MORE = "1" => "40",
            /// Half the angle of the cone that is lit in full.
            inner_angle: f32 as "degrees" where INNER_ANGLE = "0" => "20",
            /// Half the angle of the cone beyond which it is dark.
            outer_angle: f32 as "degrees" where CONE_ANGLE = "30" => "30",
            /// How it weakens with distance.
            falloff: Falloff = "InverseSquare" => "None",
        },
        /// The lectures' constant term: the same everywhere, times a Phong material's `ambient`.
        Ambient {
            /// The light.
            radiance: Rgb as "nit" where ZERO_OR_MORE = "0.1" => "(0.1, 0.1, 0.12)",
        },
    }

    /// How a point's light weakens with distance.
    choice Falloff {
        /// By the squared distance.
        InverseSquare {
            /// Where it has come to nothing, softly, as glTF has it.
            range: Option<f32> as "m" where LENGTH => "10",
        },
        /// Not at all.
        None {},
    }

    /// Places that follow a rule.
    choice Pattern {
        /// Rows, layers and columns around the origin.
        Grid {
            /// How many along x, y and z.
            count: [u32; 3] where ONE_OR_MORE => "(10, 1, 10)",
            /// How far apart along x, y and z.
            spacing: Vec3 as "m" where PLACE = "(1, 1, 1)" => "(0.4, 0, 0.4)",
        },
        /// Anywhere in a box around the origin, evenly distributed. The same seed gives the same places everywhere.
        Scatter {
            /// How many.
            count: u32 where ONE_OR_MORE => "500",
            /// Chooses the places.
            seed: u64 = "0" => "7",
            /// Lengths of the box.
            size: Vec3 as "m" where ZERO_OR_MORE = "(10, 0, 10)" => "(4, 0, 4)",
            /// Each place is turned about the y axis by up to this angle.
            turn: f32 as "degrees" where ZERO_OR_MORE = "0" => "360",
            /// Each place is scaled by a factor between these.
            scale: [f32; 2] where ABOVE_ZERO = "(1, 1)" => "(0.8, 1.2)",
        },
    }

    /// One place.
    record Placement {
        /// Where.
        at: Option<Vec3> as "m" where PLACE => "(0, 1, 0)",
        /// How it is turned.
        rotate: Option<Rotation> => "(y: 25)",
        /// How it is scaled.
        scale: Option<Spanned<Scale>> => "0.5",
        /// The three upper rows of a matrix, in place of the others.
        transform: Option<Spanned<[[f32; 4]; 3]>> => "((1, 0, 0, 0), (0, 1, 0, 2), (0, 0, 1, 0))",
    }
}

impl Entity {
    /// The glTF file that is its shape, if one is, and the materials in the place of that file's.
    pub(crate) fn model(&self) -> Option<(&Spanned<Shape>, &Named<Reference<Material>>)> {
        match &self.shape {
            Some(Reference::InPlace(shape)) => match &shape.value {
                Shape::Gltf { materials, .. } => Some((shape, materials)),
                _ => None,
            },
            _ => None,
        }
    }
}
