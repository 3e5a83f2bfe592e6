//! RON as a tree in which every value knows its place.

use crate::source::{Sources, Span};

/// A value and its place.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub value: Value,
    pub span: Span,
}

/// What RON can say. Identifiers are not copied: their text is read from the source.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    /// `true` or `false`.
    Bool(bool),
    /// A number without point and exponent that fits.
    Integer(i64),
    /// Any other number; infinite where it is too large even for this type.
    Real(f64),
    /// A string.
    Text(Box<str>),
    /// An identifier alone. NaN and inf are identifiers here: no field takes them.
    Name,
    /// `[a, b]`.
    List(Box<[Node]>),
    /// `{a: b}`.
    Map(Box<[(Node, Node)]>),
    /// `(a, b)` or `Name(a, b)`; the name is the first `name` bytes of the node.
    Tuple {
        /// Length of the name in bytes, or 0.
        name: u32,
        /// The values.
        items: Box<[Node]>,
    },
    /// `(a: b)` or `Name(a: b)`; the name as above. Never empty: `()` is a tuple.
    Record {
        /// Length of the name in bytes, or 0.
        name: u32,
        /// Places of the field names, and the values.
        fields: Box<[(Span, Node)]>,
    },
}

impl PartialEq for Node {
    /// Places do not count.
    fn eq(&self, other: &Node) -> bool {
        self.value == other.value
    }
}

impl Node {
    /// The place of the name before the parenthesis, or of the identifier itself.
    pub(crate) fn name_span(&self) -> Option<Span> {
        match self.value {
            Value::Name => Some(self.span),
            Value::Tuple { name, .. } | Value::Record { name, .. } if name > 0 => {
                Some(Span { end: self.span.start + name, ..self.span })
            }
            _ => None,
        }
    }

    /// The name before the parenthesis, or the identifier itself.
    pub(crate) fn name<'s>(&self, sources: &'s Sources) -> Option<&'s str> {
        self.name_span().map(|span| sources.text(span).trim_start_matches("r#"))
    }

    /// What a message calls the value, with its article.
    pub(crate) fn describe(&self, sources: &Sources) -> String {
        match &self.value {
            Value::Bool(value) => format!("`{value}`"),
            Value::Integer(_) | Value::Real(_) => format!("the number {}", sources.text(self.span)),
            Value::Text(text) if text.chars().count() <= 32 => format!("the string {text:?}"),
            Value::Text(_) => "a string".into(),
            Value::Name => format!("`{}`", sources.text(self.span)),
            Value::List(_) => "a list in [ ]".into(),
            Value::Map(_) => "a map in { }".into(),
            Value::Tuple { .. } | Value::Record { .. } if self.name(sources).is_some() => {
                format!("`{}(…)`", self.name(sources).unwrap_or_default())
            }
            Value::Tuple { items, .. } if items.is_empty() => "an empty ( )".into(),
            Value::Tuple { items, .. } if items.len() == 1 => "one value in ( )".into(),
            Value::Tuple { items, .. } => format!("{} values in ( )", items.len()),
            Value::Record { .. } => "fields in ( )".into(),
        }
    }
}
