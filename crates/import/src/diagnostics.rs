//! What an importer has to say about a file: where, what is wrong, what was expected, and the nearest valid name.
//!
//! A [`Diagnostic`] stands on its own: it carries the line it talks about, so it can be printed, sent to an editor as JSON
//! or compared in a test without the file at hand. [`std::fmt::Display`] prints it with a caret.

use std::fmt;

use serde::Serialize;

/// Characters of a line that a printed excerpt shows at most.
const EXCERPT: usize = 110;

/// One error or warning, with the place it is about.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// Whether the scene can be used all the same.
    pub severity: Severity,
    /// The kind of problem, for programs.
    pub code: Code,
    /// What is wrong, in one sentence without a period.
    pub message: String,
    /// The file, as the author would name it; `--set` for an override of the command line.
    pub file: String,
    /// Line, from 1. 0 where the file as a whole is meant.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// Line of the last character.
    pub end_line: u32,
    /// Column after the last character.
    pub end_column: u32,
    /// Byte offsets of the first character and after the last one.
    pub span: (u32, u32),
    /// The part of the line that is shown, and which characters of it are underlined.
    #[serde(skip)]
    pub excerpt: Excerpt,
    /// Where in a document that has no lines to speak of, such as `meshes[0].primitives[1].indices` in a glTF file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// What may stand here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<String>,
    /// What to do about it, with the nearest valid name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
    /// Other places that belong to it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// Whether a scene can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// It cannot.
    Error,
    /// It can, but probably shows something else than its author meant.
    Warning,
    /// It can, and this is what is made of it.
    Note,
}

/// What a printed diagnostic shows of its line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Excerpt {
    /// The line, or the part of a long line around the place.
    pub text: String,
    /// Characters of `text` before the first underlined one.
    pub indent: usize,
    /// Characters underlined, at least one.
    pub length: usize,
}

macro_rules! codes {
    ($($(#[doc = $doc:literal])+ $name:ident = $code:literal,)+) => {
        /// The kinds of problem. A name is stable: programs may match on it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
        pub enum Code {
            $($(#[doc = $doc])+ #[serde(rename = $code)] $name,)+
        }

        impl Code {
            /// All of them.
            pub const ALL: &[Code] = &[$(Code::$name),+];

            /// The name that is printed in brackets.
            pub fn name(self) -> &'static str {
                match self { $(Code::$name => $code,)+ }
            }

            /// What it means, one sentence.
            pub fn meaning(self) -> &'static str {
                match self { $(Code::$name => concat!($($doc),+).trim_ascii(),)+ }
            }
        }
    };
}

codes! {
    /// The file is missing, unreadable, or not text.
    File = "file",
    /// The file lies outside the folders that a scene may read from.
    Sandbox = "sandbox",
    /// A file, a picture, a mesh or the scene as a whole is larger than a stated limit.
    Limit = "limit",
    /// The text is not RON.
    Syntax = "syntax",
    /// A value has the wrong type.
    Type = "type",
    /// A field that does not exist.
    UnknownField = "unknown-field",
    /// A variant that does not exist.
    UnknownVariant = "unknown-variant",
    /// A field that must be given is absent.
    MissingField = "missing-field",
    /// A field or a name is given twice.
    Duplicate = "duplicate",
    /// NaN, infinity, or a number too large for the tracer.
    NotFinite = "not-finite",
    /// A number outside its range.
    Range = "range",
    /// Fields that exclude each other.
    Conflict = "conflict",
    /// A name that nothing has.
    UnknownName = "unknown-name",
    /// A file that includes itself, or an entity that is its own ancestor.
    Cycle = "cycle",
    /// A transform that flattens space and so has no inverse.
    Singular = "singular-transform",
    /// An entity that no picture can hold, as one that is too far away together with those above it.
    Invalid = "invalid-entity",
    /// Parts of an entity that do not go together.
    Composition = "composition",
    /// Something that the integrator does not render, or makes nothing of.
    Integrator = "integrator",
    /// A mesh file that cannot be used.
    Mesh = "mesh",
    /// A picture that cannot be used.
    Image = "image",
    /// An override's path that leads nowhere.
    Override = "override",
    /// A light that its own surroundings hide.
    LightInside = "light-inside",
    /// A camera that sees only the inside of a solid.
    CameraInside = "camera-inside",
    /// Triangles without area.
    Degenerate = "degenerate-triangle",
    /// Normals that are not of unit length and were scaled.
    Normal = "non-unit-normal",
    /// A surface that would send back more light than it gets.
    Albedo = "albedo",
    /// A material or a shape that no entity uses.
    Unused = "unused",
    /// Something absent without which nothing can be seen.
    Nothing = "nothing-to-see",
    /// A part of a glTF file that breaks its specification.
    Gltf = "gltf",
    /// An extension of glTF that a file uses, and what is done with it.
    Extension = "extension",
    /// What is done where a specification leaves a choice.
    Decision = "decision",
}

impl Diagnostic {
    /// A diagnostic about a file as a whole.
    pub(crate) fn about_file(
        severity: Severity,
        code: Code,
        file: impl Into<String>,
        message: impl Into<String>,
    ) -> Self {
        Diagnostic {
            severity,
            code,
            message: message.into(),
            file: file.into(),
            line: 0,
            column: 0,
            end_line: 0,
            end_column: 0,
            span: (0, 0),
            excerpt: Excerpt::default(),
            path: None,
            expected: None,
            help: None,
            notes: Vec::new(),
        }
    }

    /// A diagnostic about a part of a document, for [`Diagnostic::in_file`] to name.
    pub(crate) fn about_path(
        severity: Severity,
        code: Code,
        path: impl Into<String>,
        message: impl Into<String>,
    ) -> Self {
        let path = Some(path.into()).filter(|path| !path.is_empty());
        Diagnostic { path, ..Diagnostic::about_file(severity, code, "", message) }
    }

    /// The same, of that file.
    pub(crate) fn in_file(self, file: impl Into<String>) -> Self {
        Diagnostic { file: file.into(), ..self }
    }

    /// A diagnostic about the bytes `start..end` of a file's text.
    pub(crate) fn about_text(severity: Severity, code: Code, file: &str, text: &str, span: (u32, u32)) -> Self {
        let start = floor_char_boundary(text, span.0 as usize);
        let end = floor_char_boundary(text, span.1 as usize).max(start);
        let (line, column, line_start) = place(text, start);
        let (end_line, end_column, _) = place(text, end);
        let line_text = text[line_start..].lines().next().unwrap_or("");
        let underlined = if end_line == line { end_column - column } else { u32::MAX };
        Diagnostic {
            line,
            column,
            end_line,
            end_column,
            span: (start as u32, end as u32),
            excerpt: Excerpt::around(
                line_text.split_at((start - line_start).min(line_text.len())),
                underlined as usize,
            ),
            ..Diagnostic::about_file(severity, code, file, "")
        }
    }

    pub(crate) fn message(mut self, message: impl Into<String>) -> Self {
        self.message = message.into();
        self
    }

    pub(crate) fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    pub(crate) fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Says which of the fields or variants is nearest, and which there are.
    pub(crate) fn nearest_of<'a>(self, found: &str, valid: impl IntoIterator<Item = &'a str>) -> Self {
        let valid: Vec<&str> = valid.into_iter().collect();
        let near = nearest(found, &valid);
        let names: Vec<String> = valid.iter().map(|name| format!("`{name}`")).collect();
        let listed = self.expected(names.join(", "));
        match near {
            Some(name) => listed.help(format!("did you mean `{name}`?")),
            None => listed,
        }
    }

    /// Says which of the names that an author gave is nearest; if none is near, which there are, if they are few.
    pub(crate) fn nearest_name<'a>(self, found: &str, valid: impl IntoIterator<Item = &'a str>) -> Self {
        let valid: Vec<&str> = valid.into_iter().collect();
        match nearest(found, &valid) {
            Some(name) => self.help(format!("did you mean {name:?}?")),
            None if valid.is_empty() || valid.len() > 24 => self,
            None => {
                let names: Vec<String> = valid.iter().map(|name| format!("{name:?}")).collect();
                self.help(format!("there is {}", names.join(", ")))
            }
        }
    }
}

/// The valid name nearest to what was found: by Damerau-Levenshtein distance, at most a third of the letters (rounded), whatever
/// their case. Among equals, the first.
pub(crate) fn nearest<'a>(found: &str, valid: &[&'a str]) -> Option<&'a str> {
    let found = found.to_lowercase();
    let distance = |name: &str| strsim::damerau_levenshtein(&found, &name.to_lowercase());
    let longest = found.chars().count();
    if longest > 64 {
        return None;
    }
    valid
        .iter()
        .filter(|name| name.chars().count() <= 64)
        .map(|&name| (distance(name), name))
        .filter(|&(distance, name)| 3 * distance <= longest.max(name.chars().count()) + 1)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, name)| name)
}

/// Line and column from 1, and the offset at which the line starts.
fn place(text: &str, offset: usize) -> (u32, u32, usize) {
    let before = &text[..offset];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    let line = before.bytes().filter(|&byte| byte == b'\n').count() + 1;
    (line as u32, before[line_start..].chars().count() as u32 + 1, line_start)
}

fn floor_char_boundary(text: &str, offset: usize) -> usize {
    (0..=offset.min(text.len())).rev().find(|&offset| text.is_char_boundary(offset)).unwrap_or(0)
}

impl Excerpt {
    /// The part of a line around `length` characters, given what is before them and from them on. Tabs become spaces so that the caret
    /// stands right.
    fn around((before, after): (&str, &str), length: usize) -> Excerpt {
        // A line may be as long as a file: no more of it is looked at than can be shown, and whether there is more.
        let near = before.char_indices().rev().take(EXCERPT + 1).last().map_or(before.len(), |(start, _)| start);
        let indent = before[near..].chars().count();
        let characters = before[near..].chars().chain(after.chars().take(EXCERPT + 1));
        let characters: Vec<char> = characters.map(|c| if c.is_control() { ' ' } else { c }).collect();
        let length = length.min(characters.len().saturating_sub(indent)).max(1);
        if characters.len() <= EXCERPT {
            return Excerpt { text: characters.into_iter().collect(), indent, length };
        }
        let first = indent.saturating_sub(EXCERPT / 3).min(characters.len() - EXCERPT);
        let mut text: String = characters[first..first + EXCERPT].iter().collect();
        let mut indent = indent - first;
        if first > 0 {
            text.insert(0, '…');
            indent += 1;
        }
        if first + EXCERPT < characters.len() {
            text.push('…');
        }
        let shown = text.chars().count();
        Excerpt { text, indent, length: length.min(shown.saturating_sub(indent)).max(1) }
    }
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        })
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}[{}]: {}", self.severity, self.code.name(), self.message)?;
        let number = if self.line == 0 { String::new() } else { self.line.to_string() };
        let margin = " ".repeat(number.len());
        if self.line == 0 {
            match &self.path {
                None => writeln!(f, "{margin}--> {}", self.file)?,
                Some(path) => writeln!(f, "{margin}--> {}: {path}", self.file)?,
            }
        } else {
            let Excerpt { text, indent, length } = &self.excerpt;
            writeln!(f, "{margin}--> {}:{}:{}", self.file, self.line, self.column)?;
            writeln!(f, "{margin} |")?;
            writeln!(f, "{number} | {text}")?;
            writeln!(f, "{margin} | {}{}", " ".repeat(*indent), "^".repeat(*length))?;
        }
        let remarks = self.expected.iter().map(|text| ("expected", text));
        let remarks = remarks.chain(self.help.iter().map(|text| ("help", text)));
        for (kind, text) in remarks.chain(self.notes.iter().map(|text| ("note", text))) {
            writeln!(f, "{margin} = {kind}: {text}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn about(text: &str, part: &str) -> Diagnostic {
        let start = text.find(part).expect("the part is in the text");
        let span = (start as u32, (start + part.len()) as u32);
        Diagnostic::about_text(Severity::Error, Code::Type, "a.ron", text, span).message("wrong")
    }

    #[test]
    fn a_caret_stands_under_the_place() {
        let printed = about("one\n\ttwo é three\n", "three").expected("a number").help("say 3").to_string();
        let expected = "error[type]: wrong\n --> a.ron:2:8\n  |\n2 |  two é three\n  |        ^^^^^\n  = expected: a number\n  = help: say 3\n";
        assert_eq!(printed, expected);
    }

    #[test]
    fn columns_count_characters_and_lines_end_at_either_newline() {
        for (text, part, line, column, end_line, end_column) in [
            ("abc", "abc", 1, 1, 1, 4),
            ("é é", "é", 1, 1, 1, 2),
            ("a\r\nbc", "bc", 2, 1, 2, 3),
            ("a\n(b\n c)", "(b\n c)", 2, 1, 3, 4),
        ] {
            let found = about(text, part);
            assert_eq!(
                (found.line, found.column, found.end_line, found.end_column),
                (line, column, end_line, end_column),
                "{text:?}"
            );
        }
    }

    #[test]
    fn a_long_line_is_cut_around_the_place() {
        let text = format!("{}HERE{}", "x".repeat(1000), "y".repeat(1000));
        let Excerpt { text, indent, length } = about(&text, "HERE").excerpt;
        assert!(text.chars().count() <= EXCERPT + 2, "{text}");
        let shown: String = text.chars().skip(indent).take(length).collect();
        assert_eq!(shown, "HERE");
    }

    #[test]
    fn as_json_it_has_what_an_editor_needs() {
        let diagnostic = about("one\ntwo", "two").help("say 2").note("see one");
        let expected = serde_json::json!({
            "severity": "error", "code": "type", "message": "wrong", "file": "a.ron", "line": 2, "column": 1, "end_line": 2,
            "end_column": 4, "span": [4, 7], "help": "say 2", "notes": ["see one"],
        });
        assert_eq!(serde_json::to_value(diagnostic).expect("it is plain data"), expected);
    }

    #[test]
    fn a_place_past_the_end_is_the_end() {
        let found = Diagnostic::about_text(Severity::Error, Code::Syntax, "a.ron", "ab", (2, 99));
        assert_eq!((found.line, found.column, found.excerpt.indent, found.excerpt.length), (1, 3, 2, 1));
    }

    #[test]
    fn the_nearest_name_is_near_or_none() {
        for (found, expected) in [
            ("golf", Some("gold")),
            ("GLASS", Some("glass")),
            ("gals", Some("glass")),
            ("water", None),
            ("", None),
            ("blue metl", Some("blue metal")),
        ] {
            assert_eq!(nearest(found, &["glass", "gold", "blue metal"]), expected, "{found}");
        }
    }

    #[test]
    fn codes_have_names_of_their_own() {
        let mut names: Vec<_> = Code::ALL.iter().map(|code| code.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Code::ALL.len());
    }
}
