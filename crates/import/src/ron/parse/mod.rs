//! RON text to a tree with places.
//!
//! The `ron` crate reads straight into Rust types and stops at the first value that does not fit; it keeps no places, lets
//! the last of two equal keys win and admits NaN. A scene's author wants every error of a file at once, each with its
//! place, so the text is read into a [`Node`] tree here and the tree into types in [`super::decode`].
//!
//! The language is the `ron` crate's, which has the last word on every file: what it refuses is an error, whatever was
//! understood here. A test compares the two on many texts.
//!
//! Only the first syntax error is found: after it nothing can be trusted. Depth and number of values are bounded.
//!
//! Here are values and brackets; [`words`] are what has no parts.

mod words;

use crate::diagnostics::{Code, Diagnostic};
use crate::limits::{Budget, Exceeded, Limits};
use crate::source::{SourceId, Sources, Span};

use super::node::{Node, Value};

/// Reads one value, from the byte `start` on, and nothing after it.
pub(crate) fn parse(sources: &Sources, source: SourceId, start: usize, limits: &Limits) -> Parsed<Node> {
    let text = &sources.get(source).text;
    let values = Budget::new("values", limits.values);
    let mut parser = Parser { sources, source, text, at: start, values, nesting: limits.nesting, depth: 0 };
    if start == 0 && text.starts_with('\u{feff}') {
        parser.at = '\u{feff}'.len_utf8();
    }
    parser.skip_attributes()?;
    parser.skip_space()?;
    if start == 0 && parser.at == text.len() {
        let error = parser.error("there is nothing in the file");
        return Err(error.expected("a value such as `Scene( … )`").into());
    }
    let node = parser.value()?;
    parser.skip_space()?;
    if parser.at < text.len() {
        let found = parser.found();
        return Err(parser.error(format!("expected the end of the file, found {found}")).into());
    }
    if start == 0 {
        confirm(sources, source)?;
    }
    Ok(node)
}

/// Lets the `ron` crate read the text, without a type in mind.
fn confirm(sources: &Sources, source: SourceId) -> Parsed<()> {
    let text = &sources.get(source).text;
    let bare = text.trim_start_matches('\u{feff}');
    let Err(error) = ron::from_str::<&ron::value::RawValue>(bare) else { return Ok(()) };
    let before: usize = bare.split_inclusive('\n').take(error.span.start.line.saturating_sub(1)).map(str::len).sum();
    let line = &bare[before..];
    let column = line.char_indices().nth(error.span.start.col.saturating_sub(1)).map_or(line.len(), |(at, _)| at);
    let start = (text.len() - bare.len() + before + column) as u32;
    let length = text[start as usize..].chars().next().map_or(0, char::len_utf8) as u32;
    let span = Span { source, start, end: start + length };
    Err(sources.error(Code::Syntax, span, format!("this is not RON: {}", error.code)).into())
}

struct Parser<'s> {
    sources: &'s Sources,
    source: SourceId,
    text: &'s str,
    /// Offset of the next byte, always at the start of a character.
    at: usize,
    values: Budget,
    nesting: u64,
    depth: u64,
}

type Parsed<T> = Result<T, Box<Diagnostic>>;

impl<'s> Parser<'s> {
    fn value(&mut self) -> Parsed<Node> {
        self.skip_space()?;
        let start = self.at;
        if let Err(exceeded) = self.values.take(1) {
            return Err(self.exceeded("the file holds too many values", exceeded).into());
        }
        let value = match self.peek() {
            Some('(') => self.parenthesis(0)?,
            Some('[') => self.list()?,
            Some('{') => self.map()?,
            Some('"') => Value::Text(self.string()?.into()),
            Some('r') if self.rest().starts_with("r\"") || self.rest().starts_with("r#\"") => self.raw_string()?,
            Some('r') if self.rest().starts_with("r##") => self.raw_string()?,
            Some('0'..='9' | '.') => self.number()?,
            Some('+' | '-') => self.signed()?,
            Some(c) if c == '_' || c.is_alphabetic() => self.named()?,
            Some('\'') => {
                return Err(self
                    .error("expected a value, found `'`")
                    .help("strings stand in double quotes: \"…\"")
                    .into());
            }
            _ => {
                let found = self.found();
                return Err(self.error(format!("expected a value, found {found}")).into());
            }
        };
        Ok(Node { value, span: self.span(start, self.at) })
    }

    /// `true`, `Name`, `Name(…)`.
    fn named(&mut self) -> Parsed<Value> {
        let start = self.at;
        self.identifier()?;
        let name = self.at - start;
        let value = match &self.text[start..self.at] {
            "true" => return Ok(Value::Bool(true)),
            "false" => return Ok(Value::Bool(false)),
            _ => Value::Name,
        };
        let after_name = self.at;
        self.skip_space()?;
        if self.peek() == Some('(') {
            return self.parenthesis(name as u32);
        }
        self.at = after_name;
        Ok(value)
    }

    /// `( … )`, a record or a tuple.
    fn parenthesis(&mut self, name: u32) -> Parsed<Value> {
        let open = self.enter()?;
        let mut fields = Vec::new();
        let mut items = Vec::new();
        while !self.closes(')', open)? {
            match self.field_name()? {
                Some(field) if items.is_empty() => {
                    self.at = field.end as usize;
                    self.skip_space()?;
                    self.at += 1;
                    fields.push((field, self.value()?));
                }
                None if fields.is_empty() => items.push(self.value()?),
                Some(field) => return Err(self.mixed(field).into()),
                None => {
                    let value = self.value()?;
                    return Err(self.mixed(value.span).into());
                }
            }
            self.comma(')', open)?;
        }
        self.depth -= 1;
        Ok(if fields.is_empty() {
            Value::Tuple { name, items: items.into() }
        } else {
            Value::Record { name, fields: fields.into() }
        })
    }

    /// The place of an identifier that a colon follows, without moving.
    fn field_name(&mut self) -> Parsed<Option<Span>> {
        let start = self.at;
        let is_name = self.peek().is_some_and(|c| c == '_' || c.is_alphabetic());
        if !is_name || self.identifier().is_err() {
            self.at = start;
            return Ok(None);
        }
        let span = self.span(start, self.at);
        self.skip_space()?;
        let next = self.peek();
        if next == Some('=') {
            return Err(self.error("expected `:`, found `=`").help("fields are written `name: value`").into());
        }
        self.at = start;
        Ok((next == Some(':')).then_some(span))
    }

    fn mixed(&self, span: Span) -> Diagnostic {
        let message = "fields with and without names in one pair of parentheses";
        self.sources.error(Code::Syntax, span, message).expected("either `name: value` for each, or values alone")
    }

    fn list(&mut self) -> Parsed<Value> {
        let open = self.enter()?;
        let mut items = Vec::new();
        while !self.closes(']', open)? {
            items.push(self.value()?);
            self.comma(']', open)?;
        }
        self.depth -= 1;
        Ok(Value::List(items.into()))
    }

    fn map(&mut self) -> Parsed<Value> {
        let open = self.enter()?;
        let mut entries = Vec::new();
        while !self.closes('}', open)? {
            let key = self.value()?;
            self.skip_space()?;
            if self.peek() != Some(':') {
                let found = self.found();
                return Err(self.error(format!("expected `:` after the key, found {found}")).into());
            }
            self.at += 1;
            entries.push((key, self.value()?));
            self.comma('}', open)?;
        }
        self.depth -= 1;
        Ok(Value::Map(entries.into()))
    }

    /// Steps over an opening bracket and returns its place.
    fn enter(&mut self) -> Parsed<Span> {
        self.depth += 1;
        if self.depth > self.nesting {
            let exceeded = Exceeded { name: "nesting", bound: self.nesting };
            return Err(self.exceeded("too many brackets within brackets", exceeded).into());
        }
        self.at += 1;
        Ok(self.span(self.at - 1, self.at))
    }

    /// Whether the bracket that was opened at `open` closes here; steps over it if so.
    fn closes(&mut self, close: char, open: Span) -> Parsed<bool> {
        self.skip_space()?;
        match self.peek() {
            Some(c) if c == close => {
                self.at += 1;
                Ok(true)
            }
            None => Err(self.unclosed(close, open).into()),
            Some(')' | ']' | '}') => {
                let found = self.found();
                let error = self.error(format!("expected a value or `{close}`, found {found}"));
                Err(error.note(self.opened(open)).into())
            }
            Some(_) => Ok(false),
        }
    }

    /// Steps over a comma, or finds that the closing bracket follows.
    fn comma(&mut self, close: char, open: Span) -> Parsed<()> {
        self.skip_space()?;
        match self.peek() {
            Some(',') => {
                self.at += 1;
                Ok(())
            }
            Some(c) if c == close => Ok(()),
            None => Err(self.unclosed(close, open).into()),
            Some(c) => {
                let found = self.found();
                let error = self.error(format!("expected `,` or `{close}`, found {found}")).note(self.opened(open));
                Err(match self.instead_of_comma(c) {
                    Some(help) => error.help(help).into(),
                    None => error.into(),
                })
            }
        }
    }

    /// What an author may have meant who wrote another character than a comma behind a value.
    fn instead_of_comma(&self, found: char) -> Option<String> {
        let before = self.text[..self.at].trim_end();
        let string = before.strip_suffix('"').and_then(|before| before.rfind('"'));
        match (found, string) {
            (')' | ']' | '}', _) => None,
            (_, Some(start)) if before[start..].contains('\n') => {
                let start = self.sources.describe(self.span(start, start + 1));
                Some(format!("the string from {start} ends in another line: is its closing `\"` missing?"))
            }
            (':', Some(_)) => Some("fields are written `name: value`, their names without quotes".into()),
            (';', _) => Some("values are parted by commas".into()),
            _ => Some("is a comma missing before it?".into()),
        }
    }

    fn opened(&self, open: Span) -> String {
        format!("the bracket was opened at {}", self.sources.describe(open))
    }

    fn unclosed(&self, close: char, open: Span) -> Diagnostic {
        let bracket = self.sources.text(open);
        self.sources
            .error(Code::Syntax, open, format!("this `{bracket}` is never closed"))
            .expected(format!("`{close}` before the end of the file"))
    }

    fn rest(&self) -> &'s str {
        &self.text[self.at..]
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn span(&self, start: usize, end: usize) -> Span {
        Span { source: self.source, start: start as u32, end: end as u32 }
    }

    /// What stands here, as a message calls it.
    fn found(&self) -> String {
        let rest = self.rest();
        let length = rest.find(|c: char| !(c == '_' || c.is_alphanumeric())).unwrap_or(rest.len());
        match rest.chars().next() {
            None => "the end of the file".into(),
            Some(first) if length == 0 => format!("`{first}`"),
            Some(_) => format!("`{}`", rest[..length].chars().take(32).collect::<String>()),
        }
    }

    /// An error about the word or the character that stands here.
    fn error(&self, message: impl Into<String>) -> Diagnostic {
        let rest = self.rest();
        let word = rest.find(|c: char| !(c == '_' || c.is_alphanumeric())).unwrap_or(rest.len());
        let length = if word == 0 { rest.chars().next().map_or(0, char::len_utf8) } else { word };
        self.sources.error(Code::Syntax, self.span(self.at, self.at + length), message)
    }

    fn exceeded(&self, message: &str, exceeded: Exceeded) -> Diagnostic {
        let end = self.at + self.peek().map_or(0, char::len_utf8);
        self.sources.error(Code::Limit, self.span(self.at, end), format!("{message}: {exceeded}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Source;

    fn parsed(text: &str) -> Parsed<(Node, Sources)> {
        let mut sources = Sources::new(&Limits::DEFAULT);
        let source = Source { name: "a.ron".into(), folder: Default::default(), text: text.into() };
        let source = sources.add(source).expect("there is room");
        parse(&sources, source, 0, &Limits::DEFAULT).map(|node| (node, sources))
    }

    /// The tree in the words of the `ron` crate, where these suffice.
    fn as_ron(node: &Node, sources: &Sources) -> ron::Value {
        use ron::value::{F64, Map, Number};
        let text = |span| ron::Value::String(sources.text(span).into());
        match &node.value {
            Value::Bool(value) => ron::Value::Bool(*value),
            Value::Integer(value) => match u64::try_from(*value) {
                Ok(value) => ron::Value::Number(Number::U64(value)),
                Err(_) => ron::Value::Number(Number::I64(*value)),
            },
            Value::Real(value) => ron::Value::Number(Number::F64(F64(*value))),
            Value::Text(text) => ron::Value::String(text.to_string()),
            Value::List(items) => ron::Value::Seq(items.iter().map(|item| as_ron(item, sources)).collect()),
            Value::Tuple { items, .. } if items.is_empty() => ron::Value::Unit,
            Value::Tuple { items, .. } => ron::Value::Seq(items.iter().map(|item| as_ron(item, sources)).collect()),
            Value::Record { fields, .. } => {
                let fields = fields.iter().map(|(name, value)| (text(*name), as_ron(value, sources)));
                ron::Value::Map(fields.collect::<Map>())
            }
            Value::Map(entries) => {
                let entries = entries.iter().map(|(key, value)| (as_ron(key, sources), as_ron(value, sources)));
                ron::Value::Map(entries.collect::<Map>())
            }
            Value::Name => ron::Value::Unit,
        }
    }

    /// Numbers by their value: the `ron` crate keeps small types apart.
    fn same(a: &ron::Value, b: &ron::Value) -> bool {
        match (a, b) {
            (ron::Value::Number(a), ron::Value::Number(b)) => a.into_f64().to_bits() == b.into_f64().to_bits(),
            (ron::Value::Seq(a), ron::Value::Seq(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
            (ron::Value::Map(a), ron::Value::Map(b)) => {
                a.len() == b.len() && a.iter().zip(b.iter()).all(|((k, v), (l, w))| same(k, l) && same(v, w))
            }
            _ => a == b,
        }
    }

    #[test]
    fn what_the_ron_crate_reads_is_read_alike() {
        for text in [
            "()",
            "1",
            "-1",
            "+1",
            "1_000",
            "0x1F",
            "-0b101",
            "0o17",
            "1.5",
            ".5",
            "1.",
            "-1e-3",
            "2E+3",
            "1e300",
            "0.1",
            "3.4e38",
            "123456789012345678901234567890",
            "true",
            "false",
            "\"\"",
            r#""a\n\t\\\"\'\x41\u{e9}\0\r""#,
            "r\"\\\"",
            "r#\"a\"b\"#",
            "r##\"a\"#b\"##",
            "[]",
            "[1, 2,]",
            "[ /* a /* b */ c */ 1 // d\n , 2]",
            "{}",
            "{1: 2, \"a\": [3]}",
            "{\"a\": (b: 1,)}",
            "(1, 2)",
            "(1,)",
            "(a: 1, b_2: (c: \"d\"))",
            "Name(a: 1)",
            "Name (a : 1)",
            "\u{feff}(a: 1)",
            "#![enable(implicit_some)]\n(a: 1)",
            "#![enable(implicit_some, unwrap_newtypes)] [1]",
            "(é: 1)",
            "(a: (), b: [()])",
            "(_a: 1)",
            "\"\\\n   a\"",
        ] {
            let (node, sources) = parsed(text).unwrap_or_else(|error| panic!("{text:?}: {error}"));
            let expected = ron::Options::default().from_str::<ron::Value>(text.trim_start_matches('\u{feff}'));
            let expected = expected.unwrap_or_else(|error| panic!("the ron crate on {text:?}: {error}"));
            let found = as_ron(&node, &sources);
            assert!(same(&found, &expected), "{text:?}: {found:?} instead of {expected:?}");
        }
    }

    #[test]
    fn what_the_ron_crate_refuses_is_refused() {
        for text in [
            "",
            "(",
            ")",
            "[1",
            "[1 2]",
            "{1}",
            "{1: }",
            "(a:)",
            "(a: 1 b: 2)",
            "(a = 1)",
            "\"abc",
            "\"\\q\"",
            "1x",
            "0xG",
            "--1",
            "'",
            "1 2",
            "(a: 1))",
            "/* a",
            "\"\\u{110000}\"",
            "\"\\x4\"",
            "#",
            "[,]",
            "(,)",
            "1e",
            "0x",
            "(1: 2)",
            "@",
            "-",
            "\"\\u{e9\"",
        ] {
            assert!(ron::from_str::<ron::Value>(text).is_err(), "the ron crate takes {text:?}");
            assert!(parsed(text).is_err(), "{text:?} was read");
        }
        // Here the `ron` crate stops short: it reads a list of 1. and .2.
        assert!(parsed("[1..2]").is_err());
    }

    #[test]
    fn places_are_exact() {
        let text = "( a : Name( 1.5 ), b: [\"x\", yes])";
        let (root, sources) = parsed(text).expect("it reads");
        let Value::Record { name: 0, fields } = &root.value else { panic!("{root:?}") };
        let Value::Tuple { items, .. } = &fields[0].1.value else { panic!("{root:?}") };
        let Value::List(list) = &fields[1].1.value else { panic!("{root:?}") };
        let spans = [root.span, fields[0].0, fields[0].1.span, items[0].span, fields[1].0, list[0].span, list[1].span];
        let texts = spans.map(|span| sources.text(span));
        assert_eq!(texts, [text, "a", "Name( 1.5 )", "1.5", "b", "\"x\"", "yes"]);
        assert_eq!((fields[0].1.name(&sources), list[1].name(&sources)), (Some("Name"), Some("yes")));
    }

    #[test]
    fn depth_and_number_of_values_are_bounded() {
        let mut sources = Sources::new(&Limits::DEFAULT);
        let mut refused = |text: String, limits: Limits| {
            let source = Source { name: "a.ron".into(), folder: Default::default(), text };
            let source = sources.add(source).expect("there is room");
            parse(&sources, source, 0, &limits).map_err(|error| error.message)
        };
        let deep = format!("{}{}", "[".repeat(100_000), "]".repeat(100_000));
        let message = refused(deep, Limits::DEFAULT).expect_err("it is too deep");
        assert_eq!(message, "too many brackets within brackets: limit `nesting` is 64");
        assert!(refused("[".repeat(64) + &"]".repeat(64), Limits::DEFAULT).is_ok());
        let few = Limits { values: 4, ..Limits::DEFAULT };
        assert!(refused("[1, 2, 3]".into(), few).is_ok());
        let message = refused("[1, 2, 3, 4]".into(), few).expect_err("these are five");
        assert_eq!(message, "the file holds too many values: limit `values` is 4");
    }
}
