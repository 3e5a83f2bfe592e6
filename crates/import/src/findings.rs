//! The errors and warnings of one load.

use crate::diagnostics::{Code, Diagnostic, Severity};
use crate::limits::Limits;

/// The errors and warnings so far. Past the limit they are counted only.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    rows: Vec<Diagnostic>,
    errors: usize,
    dropped: usize,
    limit: usize,
}

impl Findings {
    pub(crate) fn new(limits: &Limits) -> Findings {
        Findings { limit: limits.diagnostics as usize, ..Findings::default() }
    }

    pub(crate) fn push(&mut self, diagnostic: Diagnostic) {
        self.errors += usize::from(diagnostic.severity == Severity::Error);
        if self.rows.len() < self.limit {
            self.rows.push(diagnostic);
        } else {
            self.dropped += 1;
        }
    }

    /// The number of errors so far.
    pub(crate) fn errors(&self) -> usize {
        self.errors
    }

    /// All of them: file by file in the order of appearance, each from its top to its bottom.
    pub(crate) fn finish(mut self) -> Vec<Diagnostic> {
        let mut files: Vec<String> = Vec::new();
        for row in &self.rows {
            if !files.contains(&row.file) {
                files.push(row.file.clone());
            }
        }
        let file = |row: &Diagnostic| files.iter().position(|file| *file == row.file);
        self.rows.sort_by_key(|row| (file(row), row.line, row.column));
        if let (Some(last), true) = (self.rows.last().map(|row| row.file.clone()), self.dropped > 0) {
            let severity = if self.errors > 0 { Severity::Error } else { Severity::Warning };
            let message = format!("{} more are not shown: limit `diagnostics` is {}", self.dropped, self.limit);
            self.rows.push(Diagnostic::about_file(severity, Code::Limit, last, message));
        }
        self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn about(file: &str, text: &str, at: u32) -> Diagnostic {
        Diagnostic::about_text(Severity::Error, Code::Type, file, text, (at, at + 1))
    }

    #[test]
    fn diagnostics_come_file_by_file_from_the_top() {
        let mut found = Findings::new(&Limits::DEFAULT);
        for (file, at) in [("b", 5), ("a", 3), ("b", 0), ("a", 1)] {
            found.push(about(file, "one\ntwo\n", at));
        }
        let order: Vec<_> = found.finish().into_iter().map(|row| (row.file, row.line, row.column)).collect();
        let expected = [("b", 1, 1), ("b", 2, 2), ("a", 1, 2), ("a", 1, 4)];
        assert_eq!(order, expected.map(|(file, line, column)| (file.to_string(), line, column)));
    }

    #[test]
    fn past_the_limit_they_are_counted() {
        let mut found = Findings::new(&Limits { diagnostics: 2, ..Limits::DEFAULT });
        (0..5).for_each(|at| found.push(about("a", "12345", at)));
        assert_eq!(found.errors(), 5);
        let rows = found.finish();
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[2].message, "3 more are not shown: limit `diagnostics` is 2");
    }
}
