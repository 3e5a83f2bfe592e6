//! The values that fields take: numbers, vectors, colors, names, lists, and things given by name or in place.

use brewster_optics::color::linear_from_hex;
use glam::{Vec2, Vec3};

use crate::diagnostics::Code;
use crate::source::Span;

use super::decode::{Context, Decode};
use super::info::{Kind, Range};
use super::node::{Node, Value};

/// A value with its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spanned<T> {
    pub value: T,
    pub span: Span,
}

impl<T: Decode> Decode for Spanned<T> {
    fn kind() -> Kind {
        T::kind()
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        Some(Spanned { value: T::decode(node, context)?, span: node.span })
    }

    fn within(&self, range: &Range) -> bool {
        self.value.within(range)
    }
}

impl<T: Decode> Decode for Box<T> {
    fn kind() -> Kind {
        T::kind()
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        T::decode(node, context).map(Box::new)
    }
}

impl<T: Decode> Decode for Option<T> {
    fn kind() -> Kind {
        Kind::Optional(Box::new(T::kind()))
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        T::decode(node, context).map(Some)
    }

    fn absent() -> Option<Self> {
        Some(None)
    }

    fn within(&self, range: &Range) -> bool {
        self.as_ref().is_none_or(|value| value.within(range))
    }
}

impl<T: Decode> Decode for Vec<T> {
    fn kind() -> Kind {
        Kind::List(Box::new(T::kind()))
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        let Value::List(items) = &node.value else {
            context.mismatch(node, "a list in [ ]");
            return None;
        };
        Some(items.iter().filter_map(|item| T::decode(item, context)).collect())
    }

    fn within(&self, range: &Range) -> bool {
        self.iter().all(|value| value.within(range))
    }
}

impl<T: Decode, const N: usize> Decode for [T; N] {
    fn kind() -> Kind {
        Kind::Tuple(Box::new(T::kind()), N)
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        match &node.value {
            Value::Tuple { name: 0, items } if items.len() == N => {
                let values: Vec<T> = items.iter().filter_map(|item| T::decode(item, context)).collect();
                values.try_into().ok()
            }
            _ => {
                context.mismatch(node, &format!("{N} values in ( )"));
                None
            }
        }
    }

    fn within(&self, range: &Range) -> bool {
        self.iter().all(|value| value.within(range))
    }
}

/// Values by name, in the order in which they are written.
#[derive(Clone, Debug, Default)]
pub(crate) struct Named<T> {
    /// `None` where the value was reported.
    pub rows: Vec<(Spanned<String>, Option<Spanned<T>>)>,
}

impl<T: Decode> Decode for Named<T> {
    fn kind() -> Kind {
        Kind::Map(Box::new(T::kind()))
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        let entries: &[(Node, Node)] = match &node.value {
            Value::Map(entries) => entries,
            _ => {
                context.mismatch(node, "a map in { }");
                return None;
            }
        };
        let mut rows = Vec::with_capacity(entries.len());
        for (key, value) in entries {
            let value = Spanned::decode(value, context);
            if let Some(name) = Spanned::<String>::decode(key, context) {
                rows.push((name, value));
            }
        }
        Some(Named { rows })
    }
}

/// A name, or the thing itself in place.
#[derive(Clone, Debug)]
pub(crate) enum Reference<T> {
    Name(Spanned<String>),
    InPlace(Spanned<T>),
}

impl<T> Reference<T> {
    /// Where it stands.
    pub(crate) fn span(&self) -> Span {
        match self {
            Reference::Name(name) => name.span,
            Reference::InPlace(value) => value.span,
        }
    }
}

impl<T: Decode> Decode for Reference<T> {
    fn kind() -> Kind {
        Kind::Either(Box::new(Kind::Plain("name")), Box::new(T::kind()))
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        match node.value {
            Value::Text(_) => Spanned::decode(node, context).map(Reference::Name),
            _ => Spanned::decode(node, context).map(Reference::InPlace),
        }
    }
}

/// A choice, or a value that bears no name.
#[derive(Clone, Debug)]
pub(crate) enum Either<P, C> {
    Plain(P),
    Choice(C),
}

impl<P: Decode, C: Decode> Decode for Either<P, C> {
    fn kind() -> Kind {
        Kind::Either(Box::new(P::kind()), Box::new(C::kind()))
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        if node.name_span().is_some_and(|span| !is_no_number(context.sources.text(span))) {
            C::decode(node, context).map(Either::Choice)
        } else {
            P::decode(node, context).map(Either::Plain)
        }
    }

    fn within(&self, range: &Range) -> bool {
        match self {
            Either::Plain(value) => value.within(range),
            Either::Choice(value) => value.within(range),
        }
    }
}

/// A linear color.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rgb(pub Vec3);

impl Decode for Rgb {
    fn kind() -> Kind {
        Kind::Plain("color")
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        match &node.value {
            Value::Integer(_) | Value::Real(_) => f32::decode(node, context).map(|gray| Rgb(Vec3::splat(gray))),
            Value::Tuple { name: 0, items } if items.len() == 3 => Vec3::decode(node, context).map(Rgb),
            Value::Text(text) => {
                let color = linear_from_hex(text);
                if let Err(reason) = &color {
                    let shown: String = text.chars().take(32).collect();
                    let error =
                        context.sources.error(Code::Type, node.span, format!("{shown:?} is no color: {reason}"));
                    context.report(error.help("sRGB colors are written \"#rrggbb\" or \"#rgb\""));
                }
                color.ok().map(Rgb)
            }
            Value::Name if is_no_number(context.sources.text(node.span)) => {
                f32::decode(node, context).map(|_| Rgb(Vec3::ZERO))
            }
            _ => {
                context.mismatch(node, "a color: a number, (red, green, blue) or \"#rrggbb\"");
                None
            }
        }
    }

    fn within(&self, range: &Range) -> bool {
        self.0.within(range)
    }
}

/// The identifiers that stand for no number in floating point.
fn is_no_number(text: &str) -> bool {
    matches!(text.trim_start_matches(['+', '-']), "NaN" | "inf")
}

impl Decode for f32 {
    fn kind() -> Kind {
        Kind::Plain("number")
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        let value = match node.value {
            Value::Integer(value) => value as f32,
            Value::Real(value) => value as f32,
            Value::Name if is_no_number(context.sources.text(node.span)) => f32::NAN,
            _ => {
                context.mismatch(node, "a number");
                return None;
            }
        };
        if value.is_finite() {
            return Some(value);
        }
        let text = context.sources.text(node.span);
        let message = match node.value {
            Value::Name => format!("`{text}` is not a finite number"),
            _ => format!("{text} is too large: numbers reach to 3.4e38"),
        };
        context.report(context.sources.error(Code::NotFinite, node.span, message));
        None
    }

    fn within(&self, range: &Range) -> bool {
        (range.admits)(f64::from(*self))
    }
}

macro_rules! decode_integer {
    ($($type:ty: $low:literal, $high:literal;)+) => {$(
        impl Decode for $type {
            fn kind() -> Kind {
                Kind::Plain("whole number")
            }

            fn decode(node: &Node, context: &mut Context) -> Option<Self> {
                let value = match node.value {
                    Value::Integer(value) => <$type>::try_from(value).ok(),
                    Value::Real(value) if value.fract() != 0.0 => None,
                    Value::Real(_) => None,
                    _ => {
                        context.mismatch(node, "a whole number");
                        return None;
                    }
                };
                if value.is_none() {
                    let text = context.sources.text(node.span);
                    let message = format!(concat!("{} is no whole number from ", $low, " to ", $high), text);
                    context.report(context.sources.error(Code::Range, node.span, message));
                }
                value
            }

            fn within(&self, range: &Range) -> bool {
                (range.admits)(*self as f64)
            }
        }
    )+};
}

decode_integer! {
    u32: "0", "4294967295";
    i32: "-2147483648", "2147483647";
    u64: "0", "9223372036854775807";
}

impl Decode for bool {
    fn kind() -> Kind {
        Kind::Plain("bool")
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        match node.value {
            Value::Bool(value) => Some(value),
            _ => {
                context.mismatch(node, "true or false");
                None
            }
        }
    }
}

impl Decode for String {
    fn kind() -> Kind {
        Kind::Plain("string")
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        match &node.value {
            Value::Text(text) => Some(text.to_string()),
            _ => {
                context.mismatch(node, "a string in double quotes");
                None
            }
        }
    }
}

macro_rules! decode_vector {
    ($($type:ty, $count:literal;)+) => {$(
        impl Decode for $type {
            fn kind() -> Kind {
                <[f32; $count]>::kind()
            }

            fn decode(node: &Node, context: &mut Context) -> Option<Self> {
                <[f32; $count]>::decode(node, context).map(<$type>::from)
            }

            fn within(&self, range: &Range) -> bool {
                self.to_array().within(range)
            }
        }
    )+};
}

decode_vector! {
    Vec2, 2;
    Vec3, 3;
}

/// Factors along three axes, or one for all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale(pub Vec3);

impl Decode for Scale {
    fn kind() -> Kind {
        Kind::Either(Box::new(f32::kind()), Box::new(Vec3::kind()))
    }

    fn decode(node: &Node, context: &mut Context) -> Option<Self> {
        match node.value {
            Value::Tuple { .. } => Vec3::decode(node, context).map(Scale),
            _ => f32::decode(node, context).map(|factor| Scale(Vec3::splat(factor))),
        }
    }
}
