//! The tree into types: what fits is taken, everything that does not is reported, and reading goes on.
//!
//! [`Decode`] is implemented for numbers, vectors, strings and lists in [`super::values`]; the scene's own types are
//! declared with [`schema!`], which writes a field once: the type, its reader and its row of the manual come from one list.

use std::sync::OnceLock;

use crate::diagnostics::{Code, Diagnostic};
use crate::findings::Findings;
use crate::limits::Limits;
use crate::source::{Source, Sources, Span};

use super::info::{FieldInfo, Form, Kind, Range, TypeInfo};
use super::node::{Node, Value};
use super::parse::parse;

/// A type that can be read from a scene.
pub(crate) trait Decode: Sized {
    /// What the manual calls it.
    fn kind() -> Kind;

    /// Reads a value, or reports why not. Parts that do not fit may be left out of what is returned.
    fn decode(node: &Node, context: &mut Context) -> Option<Self>;

    /// The value of a field that is absent and has no default.
    fn absent() -> Option<Self> {
        None
    }

    /// Whether all numbers in it lie in a range.
    fn within(&self, _range: &Range) -> bool {
        true
    }
}

/// What reading a scene needs to know and what it finds out.
pub(crate) struct Context<'s> {
    pub sources: &'s Sources,
    pub found: &'s mut Findings,
    /// The field that is being read.
    field: Option<&'static FieldInfo>,
}

impl<'s> Context<'s> {
    pub(crate) fn new(sources: &'s Sources, found: &'s mut Findings) -> Context<'s> {
        Context { sources, found, field: None }
    }

    /// Reports that a value is of another type than the wanted one.
    pub(crate) fn mismatch(&mut self, node: &Node, wanted: &str) {
        let field = self.field.map_or(String::new(), |field| format!(" for `{}`", field.name));
        let found = node.describe(self.sources);
        let message = format!("expected {wanted}{field}, found {found}");
        self.report(self.sources.error(Code::Type, node.span, message));
    }

    /// Reports an error about the field that is being read.
    pub(super) fn report(&mut self, error: Diagnostic) {
        self.found.push(match self.field {
            Some(field) => error.expected(field.expectation()),
            None => error,
        });
    }
}

/// The fields of a record or a variant, taken in the order in which they are declared.
pub(crate) struct Fields<'n> {
    infos: &'static [FieldInfo],
    given: [Option<&'n Node>; Fields::MOST],
    next: usize,
    /// Where a missing field is missed.
    span: Span,
}

impl<'n> Fields<'n> {
    /// Fields that a type may have.
    const MOST: usize = 24;

    /// The fields of a node in parentheses. Unknown and repeated ones are reported.
    pub(crate) fn open(node: &'n Node, infos: &'static [FieldInfo], context: &mut Context) -> Option<Fields<'n>> {
        let span = node.name_span().unwrap_or(node.span);
        let mut fields = Fields { infos, given: [None; Fields::MOST], next: 0, span };
        match &node.value {
            Value::Name => {}
            Value::Tuple { items, .. } if items.is_empty() => {}
            Value::Record { fields: given, .. } => {
                for (name, value) in given {
                    fields.give(*name, value, context);
                }
            }
            _ => {
                let names: Vec<String> = infos.iter().map(|field| format!("{}: …", field.name)).collect();
                let message = format!("expected fields with names, found {}", node.describe(context.sources));
                let error = context.sources.error(Code::Type, node.span, message);
                context.found.push(error.expected(format!("({})", names.join(", "))));
                return None;
            }
        }
        Some(fields)
    }

    fn give(&mut self, name: Span, value: &'n Node, context: &mut Context) {
        let text = context.sources.text(name).trim_start_matches("r#");
        let error = match self.infos.iter().position(|field| field.name == text) {
            Some(index) if self.given[index].is_none() => {
                self.given[index] = Some(value);
                return;
            }
            Some(_) => context.sources.error(Code::Duplicate, name, format!("the field `{text}` is given twice")),
            None => {
                let error = context.sources.error(Code::UnknownField, name, format!("there is no field `{text}` here"));
                error.nearest_of(text, self.infos.iter().map(|field| field.name))
            }
        };
        context.found.push(error);
    }

    /// The next declared field: what is given, or its default. `None` after an error that leaves nothing to go on with.
    pub(crate) fn take<T: Decode + Clone>(
        &mut self,
        default: &OnceLock<Option<T>>,
        context: &mut Context,
    ) -> Option<T> {
        let info = &self.infos[self.next];
        let given = self.given[self.next];
        self.next += 1;
        if let Some(node) = given {
            let outer = context.field.replace(info);
            let value = T::decode(node, context);
            let refused = value.as_ref().is_some_and(|value| !info.range.is_none_or(|range| value.within(&range)));
            if refused {
                let message = format!("`{}` is out of range for `{}`", context.sources.text(node.span), info.name);
                context.report(context.sources.error(Code::Range, node.span, message));
            }
            context.field = outer;
            if let Some(value) = value.filter(|_| !refused) {
                return Some(value);
            }
        }
        let fallback = default.get_or_init(|| info.default.map_or_else(T::absent, decode_text)).clone();
        if fallback.is_none() && given.is_none() {
            let message = format!("the field `{}` is missing", info.name);
            context
                .found
                .push(context.sources.error(Code::MissingField, self.span, message).expected(info.expectation()));
        }
        fallback
    }
}

/// Reads a text of the schema itself: a default or an example.
pub(crate) fn decode_text<T: Decode>(text: &'static str) -> Option<T> {
    let mut sources = Sources::new(&Limits::DEFAULT);
    let name = "schema".into();
    let source = sources.add(Source { name, folder: Default::default(), text: text.into() })?;
    let node = parse(&sources, source, 0, &Limits::DEFAULT).ok()?;
    let mut found = Findings::default();
    let value = T::decode(&node, &mut Context::new(&sources, &mut found));
    value.filter(|_| found.errors() == 0)
}

/// Reads the variant of a choice: its place in the list, or an error.
pub(crate) fn variant(node: &Node, info: &'static TypeInfo, context: &mut Context) -> Option<usize> {
    let Form::Choice(variants) = info.form else { return None };
    let Some(span) = node.name_span() else {
        let names: Vec<&str> = variants.iter().map(|variant| variant.name).collect();
        context.mismatch(node, &format!("one of {}", names.join(", ")));
        return None;
    };
    let name = context.sources.text(span);
    let found = variants.iter().position(|variant| variant.name == name);
    if found.is_none() {
        let error = context.sources.error(Code::UnknownVariant, span, format!("`{name}` is no {}", info.name));
        context.found.push(error.nearest_of(name, variants.iter().map(|variant| variant.name)));
    }
    found
}

/// Reports a record that bears another type's name.
pub(crate) fn check_name(node: &Node, info: &'static TypeInfo, context: &mut Context) {
    if let Some(span) = node.name_span().filter(|&span| context.sources.text(span) != info.name) {
        let message = format!("expected `{}(…)`, found `{}`", info.name, context.sources.text(span));
        context.found.push(context.sources.error(Code::UnknownVariant, span, message));
    }
}

/// Declares types of the scene format: the type itself, how it is read, and what the manual says of it.
///
/// A field is written `/// What it says.` `name: Type as "unit" where RANGE = "default" => "example",`, of which unit,
/// range and default may be absent. A field without default must be given unless its type is an `Option`.
macro_rules! schema {
    () => {};
    (
        $(#[doc = $doc:literal])+
        record $name:ident {
            $(
                $(#[doc = $field_doc:literal])+
                $field:ident: $type:ty $(as $unit:literal)? $(where $range:ident)? $(= $default:literal)? => $example:literal,
            )+
        }
        $($rest:tt)*
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Debug)]
        #[allow(dead_code, reason = "not every record's place and health is asked for")]
        pub(crate) struct $name {
            /// Its place.
            pub span: Span,
            /// Whether nothing in it was reported.
            pub intact: bool,
            $($(#[doc = $field_doc])+ pub $field: $type,)+
        }

        impl $name {
            pub(crate) const INFO: &TypeInfo = &TypeInfo {
                name: stringify!($name),
                doc: &[$($doc),+],
                form: Form::Record(&[$(schema!(@field
                    $field, [$($field_doc)+], $type, [$($unit)?], [$($range)?], [$($default)?], $example
                )),+]),
            };
        }

        impl Decode for $name {
            fn kind() -> Kind {
                Kind::Type(Self::INFO)
            }

            fn decode(node: &Node, context: &mut Context) -> Option<Self> {
                let Form::Record(infos) = Self::INFO.form else { return None };
                let errors = context.found.errors();
                check_name(node, Self::INFO, context);
                let mut fields = Fields::open(node, infos, context)?;
                $(let $field = {
                    static DEFAULT: OnceLock<Option<$type>> = OnceLock::new();
                    fields.take(&DEFAULT, context)
                };)+
                let intact = context.found.errors() == errors;
                Some($name { span: node.span, intact, $($field: $field?,)+ })
            }
        }

        schema!($($rest)*);
    };
    (
        $(#[doc = $doc:literal])+
        choice $name:ident {
            $(
                $(#[doc = $variant_doc:literal])+
                $variant:ident {
                    $(
                        $(#[doc = $field_doc:literal])+
                        $field:ident: $type:ty $(as $unit:literal)? $(where $range:ident)? $(= $default:literal)? => $example:literal,
                    )*
                },
            )+
        }
        $($rest:tt)*
    ) => {
        $(#[doc = $doc])+
        #[allow(clippy::large_enum_variant, reason = "variants are as the manual has them, and there are few values")]
        #[derive(Clone, Debug)]
        pub(crate) enum $name {
            $($(#[doc = $variant_doc])+ $variant { $($(#[doc = $field_doc])+ $field: $type,)* },)+
        }

        impl $name {
            pub(crate) const INFO: &TypeInfo = &TypeInfo {
                name: stringify!($name),
                doc: &[$($doc),+],
                form: Form::Choice(&[$(VariantInfo {
                    name: stringify!($variant),
                    doc: &[$($variant_doc),+],
                    fields: &[$(schema!(@field
                        $field, [$($field_doc)+], $type, [$($unit)?], [$($range)?], [$($default)?], $example
                    )),*],
                }),+]),
            };
        }

        impl Decode for $name {
            fn kind() -> Kind {
                Kind::Type(Self::INFO)
            }

            fn decode(node: &Node, context: &mut Context) -> Option<Self> {
                let Form::Choice(variants) = Self::INFO.form else { return None };
                let errors = context.found.errors();
                let info = &variants[variant(node, Self::INFO, context)?];
                #[allow(unused_mut, unused_variables, reason = "a variant without fields takes none")]
                let mut fields = Fields::open(node, info.fields, context)?;
                let value = match info.name {
                    $(stringify!($variant) => {
                        $(let $field = {
                            static DEFAULT: OnceLock<Option<$type>> = OnceLock::new();
                            fields.take(&DEFAULT, context)
                        };)*
                        $name::$variant { $($field: $field?,)* }
                    })+
                    _ => return None,
                };
                (context.found.errors() == errors).then_some(value)
            }
        }

        schema!($($rest)*);
    };
    (@field $field:ident, [$($doc:literal)+], $type:ty, [$($unit:literal)?], [$($range:ident)?], [$($default:literal)?], $example:literal) => {
        FieldInfo {
            name: stringify!($field),
            doc: &[$($doc),+],
            kind: <$type as Decode>::kind,
            unit: concat!($($unit)?),
            range: schema!(@option $($range)?),
            default: schema!(@option $($default)?),
            example: $example,
            #[cfg(test)]
            takes: |text| {
                let range: Option<$crate::ron::info::Range> = schema!(@option $($range)?);
                $crate::ron::decode::decode_text::<$type>(text).is_some_and(|value| range.is_none_or(|range| value.within(&range)))
            },
        }
    };
    (@option) => { None };
    (@option $value:expr) => { Some($value) };
}
pub(crate) use schema;
