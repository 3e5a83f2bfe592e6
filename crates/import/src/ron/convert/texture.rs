//! Textures: names of files into pixels, and how they lie.

use brewster_lanes::math;
use brewster_world::components as world;
use brewster_world::components::parts::{self, Encoding, ImageTexture, UvTransform};
use glam::{Vec2, Vec3};

use crate::diagnostics::Code;
use crate::image;
use crate::ron::schema::{self, Number, Paint, Texture};
use crate::ron::values::{Either, Rgb};
use crate::session::Session;
use crate::source::Span;

/// A color that should not pass 1.
pub(super) fn albedo(session: &mut Session, color: &Paint, field: &str, span: Span) -> Option<world::Color> {
    let largest = match color {
        Either::Plain(Rgb(color)) => color.max_element(),
        Either::Choice(Texture::Checker { a, b, .. }) => a.0.max(b.0).max_element(),
        Either::Choice(Texture::Gradient { from, to, .. }) => from.0.max(to.0).max_element(),
        Either::Choice(Texture::Image { factor, .. }) => factor.0.max_element(),
        Either::Choice(Texture::VertexColors { factor }) => factor.0.max_element(),
    };
    if largest > 1.0 {
        let message = format!("`{field}` of {largest}: the surface sends back more light than it gets");
        let warning = session.sources.warning(Code::Albedo, span, message);
        session.found.push(match largest {
            2.0.. => warning.help("colors go from 0 to 1; those of 0 to 255 are written \"#rrggbb\""),
            _ => warning,
        });
    }
    paint(session, color)
}

/// A color, or a texture of colors.
pub(super) fn paint(session: &mut Session, paint: &Paint) -> Option<world::Color> {
    match paint {
        Either::Plain(color) => Some(world::Color::Constant(color.0)),
        Either::Choice(texture) => match self::texture(session, texture, Encoding::Srgb)? {
            (Vec3::ONE, texture) => Some(world::Color::Texture(texture)),
            (factor, texture) => Some(world::Color::Tinted { factor, texture }),
        },
    }
}

/// A number from 0 to 1, or a texture of such.
pub(super) fn part(session: &mut Session, number: &Number) -> Option<world::Scalar> {
    match number {
        Either::Choice(map) if map.factor > 1.0 => {
            session.error(Code::Range, map.span, format!("a factor of {}: the number must be 0 to 1", map.factor));
            None
        }
        _ => self::number(session, number),
    }
}

/// A number, or a texture of numbers.
pub(super) fn number(session: &mut Session, number: &Number) -> Option<world::Scalar> {
    match number {
        Either::Plain(number) => Some(world::Scalar::constant(*number)),
        Either::Choice(map) => self::map(session, map),
    }
}

/// A number from a texture.
pub(super) fn map(session: &mut Session, map: &schema::Map) -> Option<world::Scalar> {
    let channel = match map.channel {
        schema::Channel::R {} => parts::Channel::R,
        schema::Channel::G {} => parts::Channel::G,
        schema::Channel::B {} => parts::Channel::B,
        schema::Channel::A {} => parts::Channel::A,
    };
    let (factor, texture) = self::texture(session, &map.texture, Encoding::Linear)?;
    let of_channel = match map.channel {
        schema::Channel::A {} => 1.0,
        _ => factor[channel as usize],
    };
    Some(world::Scalar { factor: map.factor * of_channel, texture: Some((texture, channel)) })
}

/// A texture of numbers in several channels.
pub(super) fn data(session: &mut Session, texture: &Texture) -> Option<parts::Texture> {
    Some(self::texture(session, texture, Encoding::Linear)?.1)
}

/// A texture, and the factor of its colors.
fn texture(session: &mut Session, texture: &Texture, encoding: Encoding) -> Option<(Vec3, parts::Texture)> {
    match texture {
        Texture::Checker { a, b, size } => Some((Vec3::ONE, parts::Texture::Checker { a: a.0, b: b.0, size: *size })),
        Texture::Gradient { from, to, axis } => {
            let axis = match axis {
                schema::Axis::U {} => parts::Axis::U,
                schema::Axis::V {} => parts::Axis::V,
            };
            Some((Vec3::ONE, parts::Texture::Gradient { from: from.0, to: to.0, axis }))
        }
        Texture::Image {
            file,
            factor,
            repeat,
            rotate,
            offset,
            transform,
            wrap_u,
            wrap_v,
            filter,
            uv_set,
            vertex_colors,
            mipmaps,
        } => {
            let image = image::load(session, &file.value, file.span)?;
            let texture = ImageTexture {
                pyramid: mipmaps.then(|| session.assets.pyramid(&image, encoding)),
                image,
                encoding,
                wrap: [wrap_u, wrap_v].map(wrap),
                filter: match filter {
                    schema::Filter::Nearest {} => parts::Filter::Nearest,
                    schema::Filter::Linear {} => parts::Filter::Linear,
                },
                uv_set: match uv_set {
                    schema::UvSet::First {} => parts::UvSet::First,
                    schema::UvSet::Second {} => parts::UvSet::Second,
                },
                transform: transform.map_or_else(|| placed(*repeat, *rotate, *offset), |rows| UvTransform { rows }),
                vertex_colors: *vertex_colors,
            };
            Some((factor.0, parts::Texture::Image(texture)))
        }
        Texture::VertexColors { factor } => Some((factor.0, parts::Texture::VertexColors)),
    }
}

fn wrap(wrap: &schema::Wrap) -> parts::Wrap {
    match wrap {
        schema::Wrap::Repeat {} => parts::Wrap::Repeat,
        schema::Wrap::Mirror {} => parts::Wrap::Mirror,
        schema::Wrap::Clamp {} => parts::Wrap::Clamp,
    }
}

/// Scales, turns by degrees, and moves.
fn placed(scale: f32, degrees: f32, offset: Vec2) -> UvTransform {
    let (sin, cos) = math::sin_cos(degrees.to_radians());
    let (sin, cos) = (scale * sin, scale * cos);
    UvTransform { rows: [[cos, -sin, offset.x], [sin, cos, offset.y]] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_scaled_turned_and_moved() {
        let place = placed(2.0, 90.0, Vec2::new(0.5, 0.25));
        // (1, 0) is (2, 0) scaled, (0, 2) turned by a quarter.
        assert!(place.apply(Vec2::X).abs_diff_eq(Vec2::new(0.5, 2.25), 1e-6), "{place:?}");
        assert_eq!(placed(3.0, 0.0, Vec2::ZERO).apply(Vec2::new(0.3, 0.7)), Vec2::new(0.3 * 3.0, 0.7 * 3.0));
    }
}
