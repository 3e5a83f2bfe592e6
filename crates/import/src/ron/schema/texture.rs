//! Textures: colors that vary over a surface.

use std::sync::OnceLock;

use glam::Vec2;

use super::{ABOVE_ZERO, ZERO_OR_MORE};
use crate::ron::decode::{Context, Decode, Fields, check_name, schema, variant};
use crate::ron::info::{FieldInfo, Form, Kind, TypeInfo, VariantInfo};
use crate::ron::node::Node;
use crate::ron::values::{Either, Rgb, Spanned};
use crate::source::Span;

/// A color, or a texture in its place.
pub(crate) type Paint = Either<Rgb, Texture>;

/// A number, or one from a texture.
pub(crate) type Number = Either<f32, Map>;

schema! {
    /// A number from a texture.
    record Map {
        /// The texture; a picture's values are taken as they are stored.
        texture: Texture => "Image(file: \"wood.png\")",
        /// Its channel.
        channel: Channel = "R" => "G",
        /// What it is multiplied by.
        factor: f32 where ZERO_OR_MORE = "1" => "0.5",
    }

    /// A channel of a texture.
    choice Channel {
        /// Red.
        R {},
        /// Green.
        G {},
        /// Blue.
        B {},
        /// Opacity.
        A {},
    }

    /// A color that varies over a surface.
    choice Texture {
        /// Squares in turn.
        Checker {
            /// Color of the square at the origin of the texture coordinates.
            a: Rgb where ZERO_OR_MORE = "0.2" => "(0.1, 0.1, 0.3)",
            /// Color of its neighbors.
            b: Rgb where ZERO_OR_MORE = "0.8" => "\"#ffeecc\"",
            /// Side of a square in texture coordinates; on a plane these are meters.
            size: f32 where ABOVE_ZERO = "1" => "0.5",
        },
        /// From one color to another as a texture coordinate goes from 0 to 1.
        Gradient {
            /// Color at 0.
            from: Rgb where ZERO_OR_MORE = "0" => "(0.1, 0.1, 0.3)",
            /// Color at 1.
            to: Rgb where ZERO_OR_MORE = "1" => "(0.9, 0.8, 0.6)",
            /// Which coordinate.
            axis: Axis = "V" => "U",
        },
        /// A picture file: PNG, JPEG, WebP, KTX2, Radiance HDR or OpenEXR.
        Image {
            /// The file, seen from the folder of the scene file.
            file: Spanned<String> => "\"wood.png\"",
            /// Factor of its colors.
            factor: Rgb where ZERO_OR_MORE = "1" => "(1, 0.9, 0.8)",
            /// Times the picture repeats over texture coordinates 0 to 1.
            repeat: f32 where ABOVE_ZERO = "1" => "4",
            /// By how much the texture coordinates are turned after that, counterclockwise: the picture turns the other way.
            rotate: f32 as "degrees" = "0" => "90",
            /// What is added to them then.
            offset: Vec2 = "(0, 0)" => "(0.5, 0)",
            /// Two rows of a matrix that makes (u, v, 1) the place in the picture, in place of `repeat`, `rotate` and `offset`.
            transform: Option<[[f32; 3]; 2]> => "((2, 0, 0), (0, -1, 1))",
            /// What lies beyond its edges along u.
            wrap_u: Wrap = "Repeat" => "Clamp",
            /// What lies beyond its edges along v.
            wrap_v: Wrap = "Repeat" => "Mirror",
            /// What lies between its pixels.
            filter: Filter = "Linear" => "Nearest",
            /// The texture coordinates that it is placed by.
            uv_set: UvSet = "First" => "Second",
            /// Whether the colors of a mesh's vertices multiply it.
            vertex_colors: bool = "false" => "true",
            /// Whether it is smoothed where it is seen from so far that many of its pixels fall into one of the picture's: less noise at few samples.
            mipmaps: bool = "false" => "true",
        },
        /// The colors of a mesh's vertices; white on other shapes.
        VertexColors {
            /// Factor of them.
            factor: Rgb where ZERO_OR_MORE = "1" => "(1, 0.9, 0.8)",
        },
    }

    /// What lies beyond the edges of a picture.
    choice Wrap {
        /// The picture again.
        Repeat {},
        /// The picture in a mirror, then the picture again, and so on.
        Mirror {},
        /// The pixels at its edge.
        Clamp {},
    }

    /// What lies between the centers of pixels.
    choice Filter {
        /// The nearest pixel.
        Nearest {},
        /// A bilinear mean of the nearest four.
        Linear {},
    }

    /// A set of texture coordinates.
    choice UvSet {
        /// The one that every shape has.
        First {},
        /// The second one of a mesh; the first where there is none.
        Second {},
    }

    /// A texture coordinate.
    choice Axis {
        /// The first.
        U {},
        /// The second.
        V {},
    }
}
