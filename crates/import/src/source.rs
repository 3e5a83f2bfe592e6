//! The texts that a scene is made of, and places in them.

use std::cell::Cell;
use std::path::{Path, PathBuf};

use crate::diagnostics::{Code, Diagnostic, Severity};
use crate::limits::Limits;

/// The bytes `start..end` of a source's text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Span {
    pub source: SourceId,
    pub start: u32,
    pub end: u32,
}

/// Row of [`Sources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SourceId(pub(crate) u16);

/// One text: a file, or the value of an override.
#[derive(Debug)]
pub(crate) struct Source {
    /// What a message calls it.
    pub name: String,
    /// The folder that its file names are relative to, canonical.
    pub folder: PathBuf,
    pub text: String,
}

/// All texts of a scene, in the order in which they were read.
#[derive(Debug)]
pub(crate) struct Sources {
    rows: Vec<Source>,
    /// Problems whose lines are still looked for, which takes as long as the text does: far more than are shown. Without an end, a large
    /// file of errors would take hours.
    looked_for: Cell<u64>,
}

impl Sources {
    pub(crate) fn new(limits: &Limits) -> Sources {
        Sources { rows: Vec::new(), looked_for: Cell::new(limits.diagnostics.saturating_mul(10)) }
    }

    /// Adds a text of less than 4 GiB. There may be 65,535; `None` says that there are.
    pub(crate) fn add(&mut self, source: Source) -> Option<SourceId> {
        let id = u16::try_from(self.rows.len()).ok()?;
        u32::try_from(source.text.len()).ok()?;
        self.rows.push(source);
        Some(SourceId(id))
    }

    pub(crate) fn get(&self, id: SourceId) -> &Source {
        &self.rows[usize::from(id.0)]
    }

    /// All of them, by their ids.
    pub(crate) fn into_rows(self) -> Vec<Source> {
        self.rows
    }

    /// The text of a place.
    pub(crate) fn text(&self, span: Span) -> &str {
        &self.get(span.source).text[span.start as usize..span.end as usize]
    }

    pub(crate) fn error(&self, code: Code, span: Span, message: impl Into<String>) -> Diagnostic {
        self.diagnostic(Severity::Error, code, span).message(message)
    }

    pub(crate) fn warning(&self, code: Code, span: Span, message: impl Into<String>) -> Diagnostic {
        self.diagnostic(Severity::Warning, code, span).message(message)
    }

    fn diagnostic(&self, severity: Severity, code: Code, span: Span) -> Diagnostic {
        let source = self.get(span.source);
        let Some(left) = self.looked_for.get().checked_sub(1) else {
            return Diagnostic::about_file(severity, code, &source.name, "");
        };
        self.looked_for.set(left);
        Diagnostic::about_text(severity, code, &source.name, &source.text, (span.start, span.end))
    }

    /// `file:line:column` of a place.
    pub(crate) fn describe(&self, span: Span) -> String {
        let place = self.diagnostic(Severity::Error, Code::File, span);
        format!("{}:{}:{}", place.file, place.line, place.column)
    }

    /// What a message calls the file that `source` refers to by `name`.
    pub(crate) fn name_beside(&self, source: SourceId, name: &str) -> String {
        let beside = Path::new(&self.get(source).name).parent().unwrap_or(Path::new("")).join(name);
        beside.to_string_lossy().replace('\\', "/")
    }
}
