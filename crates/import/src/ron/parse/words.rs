//! Numbers, strings, names, and what stands between them: blanks, comments, attributes.

use super::{Parsed, Parser};
use crate::diagnostics::Code;
use crate::ron::node::Value;

impl Parser<'_> {
    pub(super) fn signed(&mut self) -> Parsed<Value> {
        let after_sign = self.rest()[1..].chars().next();
        if after_sign.is_some_and(|c| c.is_alphabetic()) {
            self.at += 1;
            self.identifier()?;
            return Ok(Value::Name);
        }
        self.number()
    }

    pub(super) fn number(&mut self) -> Parsed<Value> {
        let start = self.at;
        if matches!(self.peek(), Some('+' | '-')) {
            self.at += 1;
        }
        let digits = self.rest();
        let radix = match digits.get(..2) {
            Some("0x") => 16,
            Some("0o") => 8,
            Some("0b") => 2,
            _ => 10,
        };
        if radix != 10 {
            self.at += 2;
        }
        let mut before = ' ';
        while let Some(c) = self.peek() {
            let sign_of_exponent = radix == 10 && matches!(c, '+' | '-') && matches!(before, 'e' | 'E');
            if !(c.is_alphanumeric() || matches!(c, '_' | '.') || sign_of_exponent) {
                break;
            }
            before = c;
            self.at += c.len_utf8();
        }
        let text = &self.text[start..self.at];
        self.number_from(text, radix).ok_or_else(|| {
            let span = self.span(start, self.at.max(start + 1));
            let error = self.sources.error(Code::Syntax, span, format!("`{text}` is not a number"));
            error.help("numbers are written like 1, -0.5 or 2e-3, without units").into()
        })
    }

    fn number_from(&self, text: &str, radix: u32) -> Option<Value> {
        let digits = text.replace('_', "");
        if radix != 10 {
            let (sign, digits) = digits.split_at(digits.find('0')?);
            let digits = digits.get(2..)?;
            return i64::from_str_radix(&format!("{sign}{digits}"), radix).ok().map(Value::Integer);
        }
        let unsigned = digits.trim_start_matches(['+', '-']);
        let starts_well = unsigned.starts_with(|c: char| c.is_ascii_digit() || c == '.');
        if !starts_well || digits.contains(|c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E')) {
            return None;
        }
        match digits.parse() {
            Ok(integer) => Some(Value::Integer(integer)),
            Err(_) => digits.parse().ok().map(Value::Real),
        }
    }

    pub(super) fn string(&mut self) -> Parsed<String> {
        let start = self.at;
        self.at += 1;
        let mut string = String::new();
        loop {
            let rest = self.rest();
            let Some(plain) = rest.find(['"', '\\']) else {
                let span = self.span(start, start + 1);
                return Err(self
                    .sources
                    .error(Code::Syntax, span, "this string is never closed")
                    .expected("`\"`")
                    .into());
            };
            string.push_str(&rest[..plain]);
            self.at += plain + 1;
            if rest[plain..].starts_with('"') {
                return Ok(string);
            }
            string.extend(self.escape()?);
        }
    }

    /// The character that an escape means; `None` for an escaped line break.
    fn escape(&mut self) -> Parsed<Option<char>> {
        let start = self.at - 1;
        let kind = self.peek();
        self.at += kind.map_or(0, char::len_utf8);
        let character = match kind {
            Some('n') => Some('\n'),
            Some('t') => Some('\t'),
            Some('r') => Some('\r'),
            Some('0') => Some('\0'),
            Some(c @ ('\\' | '"' | '\'')) => Some(c),
            Some('x') => self.hexadecimal(2, 2),
            Some('u') if self.peek() == Some('{') => {
                self.at += 1;
                let character = self.hexadecimal(1, 6);
                let closed = self.peek() == Some('}');
                self.at += usize::from(closed);
                character.filter(|_| closed)
            }
            Some('\n') => {
                let rest = self.rest();
                self.at += rest.len() - rest.trim_start_matches([' ', '\t', '\n', '\r']).len();
                return Ok(None);
            }
            _ => None,
        };
        character.map(Some).ok_or_else(|| {
            let span = self.span(start, self.at);
            let error = self.sources.error(Code::Syntax, span, format!("`{}` is no escape", self.sources.text(span)));
            error.expected("\\n, \\t, \\r, \\0, \\\\, \\\", \\', \\x41 or \\u{e9}").into()
        })
    }

    fn hexadecimal(&mut self, at_least: usize, at_most: usize) -> Option<char> {
        let digits = self.rest().bytes().take(at_most).take_while(u8::is_ascii_hexdigit).count();
        let code = u32::from_str_radix(&self.rest()[..digits], 16).ok()?;
        self.at += digits;
        char::from_u32(code).filter(|_| digits >= at_least)
    }

    /// `r"…"`, `r#"…"#`, or with more signs.
    pub(super) fn raw_string(&mut self) -> Parsed<Value> {
        let start = self.at;
        let signs = self.rest()[1..].bytes().take_while(|&byte| byte == b'#').count();
        self.at += 1 + signs;
        let close = format!("\"{}", "#".repeat(signs));
        let body = self.rest().strip_prefix('"').and_then(|body| body.find(&close).map(|end| &body[..end]));
        let Some(body) = body else {
            let span = self.span(start, self.at);
            return Err(self.sources.error(Code::Syntax, span, "this string is never closed").expected(close).into());
        };
        self.at += 1 + body.len() + close.len();
        Ok(Value::Text(body.into()))
    }

    pub(super) fn identifier(&mut self) -> Parsed<()> {
        let raw = usize::from(self.rest().starts_with("r#")) * 2;
        let rest = &self.rest()[raw..];
        let length = rest.find(|c: char| !(c == '_' || c.is_alphanumeric())).unwrap_or(rest.len());
        if length == 0 {
            let found = self.found();
            return Err(self.error(format!("expected a name, found {found}")).into());
        }
        self.at += raw + length;
        Ok(())
    }

    /// Steps over `#![enable(…)]`: what these turn on is on already.
    pub(super) fn skip_attributes(&mut self) -> Parsed<()> {
        self.skip_space()?;
        while self.rest().starts_with('#') {
            let start = self.at;
            let Some(end) = self.rest().starts_with("#![enable(").then(|| self.rest().find(']')).flatten() else {
                let span = self.span(start, start + 1);
                return Err(self
                    .sources
                    .error(Code::Syntax, span, "expected a value, found `#`")
                    .expected("`#![enable(…)]`")
                    .into());
            };
            self.at += end + 1;
            self.skip_space()?;
        }
        Ok(())
    }

    /// Steps over blanks and comments.
    pub(super) fn skip_space(&mut self) -> Parsed<()> {
        loop {
            let rest = self.rest();
            let blanks = rest.len() - rest.trim_start().len();
            self.at += blanks;
            let rest = &rest[blanks..];
            if rest.starts_with("//") {
                self.at += rest.find('\n').unwrap_or(rest.len());
            } else if rest.starts_with("/*") {
                self.block_comment()?;
            } else {
                return Ok(());
            }
        }
    }

    /// Comments in `/* */` nest.
    fn block_comment(&mut self) -> Parsed<()> {
        let start = self.at;
        let mut open = 0u32;
        loop {
            let rest = self.rest();
            if rest.starts_with("/*") {
                open += 1;
                self.at += 2;
            } else if rest.starts_with("*/") {
                open -= 1;
                self.at += 2;
                if open == 0 {
                    return Ok(());
                }
            } else if let Some(c) = rest.chars().next() {
                self.at += c.len_utf8();
            } else {
                let span = self.span(start, start + 2);
                return Err(self
                    .sources
                    .error(Code::Syntax, span, "this comment is never closed")
                    .expected("`*/`")
                    .into());
            }
        }
    }
}
