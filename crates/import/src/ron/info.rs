//! What the schema says about itself: the manual is checked against it.

use std::fmt;

/// A type of the schema, for the manual.
#[derive(Debug)]
pub(crate) struct TypeInfo {
    /// Its name.
    pub name: &'static str,
    /// What it is, line by line.
    pub doc: &'static [&'static str],
    /// What it is made of.
    pub form: Form,
}

/// What a type is made of.
#[derive(Debug)]
pub(crate) enum Form {
    /// Fields in parentheses.
    Record(&'static [FieldInfo]),
    /// One of several names, each with fields of its own.
    Choice(&'static [VariantInfo]),
}

/// One name of a choice.
#[derive(Debug)]
pub(crate) struct VariantInfo {
    /// The name.
    pub name: &'static str,
    /// What it is, line by line.
    pub doc: &'static [&'static str],
    /// Its fields.
    pub fields: &'static [FieldInfo],
}

/// A field.
#[derive(Debug)]
pub(crate) struct FieldInfo {
    /// Its name.
    pub name: &'static str,
    /// What it says, line by line.
    pub doc: &'static [&'static str],
    /// What it takes.
    pub kind: fn() -> Kind,
    /// The unit, or nothing.
    pub unit: &'static str,
    /// The numbers that are allowed, if not all are.
    pub range: Option<Range>,
    /// The value that counts where the field is absent, as RON.
    pub default: Option<&'static str>,
    /// A value, as RON.
    pub example: &'static str,
    /// Whether a text is a value that the field takes.
    #[cfg(test)]
    pub takes: fn(&'static str) -> bool,
}

/// What a field takes.
#[derive(Clone, Debug)]
pub(crate) enum Kind {
    /// Something that needs no page of its own.
    Plain(&'static str),
    /// A type of the schema.
    Type(&'static TypeInfo),
    /// May be absent.
    Optional(Box<Kind>),
    /// Any number of values in brackets.
    List(Box<Kind>),
    /// So many values in parentheses.
    Tuple(Box<Kind>, usize),
    /// Names and values in braces.
    Map(Box<Kind>),
    /// One or the other.
    Either(Box<Kind>, Box<Kind>),
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Kind::Plain(name) => f.write_str(name),
            Kind::Type(info) => f.write_str(info.name),
            Kind::Optional(kind) => kind.fmt(f),
            Kind::List(kind) => write!(f, "[{kind}]"),
            Kind::Tuple(kind, count) => write!(f, "({})", vec![kind.to_string(); *count].join(", ")),
            Kind::Map(kind) => write!(f, "{{name: {kind}}}"),
            Kind::Either(one, other) => write!(f, "{one} or {other}"),
        }
    }
}

/// The numbers that a field admits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    /// As the manual and messages say it.
    pub text: &'static str,
    /// Whether a number is in it.
    pub admits: fn(f64) -> bool,
}

impl FieldInfo {
    /// Kind, unit, range and example in one line.
    pub(crate) fn expectation(&self) -> String {
        let mut text = (self.kind)().to_string();
        if !self.unit.is_empty() {
            text += &format!(" in {}", self.unit);
        }
        if let Some(range) = &self.range {
            text += &format!(", {}", range.text);
        }
        format!("{text}; for example {}: {}", self.name, self.example)
    }
}
