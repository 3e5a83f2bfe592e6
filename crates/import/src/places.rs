//! Where the entities of a scene stand in its files: for what is found out about them after they were read.

use brewster_world::components::SceneKey;

use crate::diagnostics::{Code, Diagnostic, Severity};
use crate::scene::Row;
use crate::source::{Source, Sources, Span};

/// Where the entities of a scene stand in its files.
///
/// It holds the files' texts, and 32 bytes for each run of entities that come from one place: what is repeated by a pattern takes
/// as many bytes as what stands once, unless several entities are repeated in turn. It is of one load, and stale after the next.
#[derive(Debug, Default)]
pub struct Places {
    sources: Vec<Source>,
    /// In the order of their keys.
    runs: Vec<Run>,
}

/// Entities whose keys follow one another and that come from one place.
#[derive(Clone, Copy, Debug)]
struct Run {
    first: u64,
    last: u64,
    span: Span,
}

impl Places {
    pub(crate) fn new(rows: &[Row], sources: Sources) -> Places {
        let mut runs: Vec<Run> = Vec::new();
        for &Row { key, span, .. } in rows {
            match runs.last_mut() {
                Some(run) if run.span == span && run.last + 1 == key => run.last = key,
                _ => runs.push(Run { first: key, last: key, span }),
            }
        }
        runs.sort_unstable_by_key(|run| run.first);
        Places { sources: sources.into_rows(), runs }
    }

    /// An error about the entity, camera or material of a key, at its place; about the scene's file as a whole where there is none: for what a program
    /// made, and for what glTF files hold that are no part of a scene in RON.
    pub fn error(&self, key: SceneKey, code: Code, message: impl Into<String>) -> Diagnostic {
        match self.find(key) {
            Some((source, span)) => {
                let place = (span.start, span.end);
                Diagnostic::about_text(Severity::Error, code, &source.name, &source.text, place).message(message)
            }
            None => {
                let file = self.sources.first().map_or("", |source| &source.name);
                Diagnostic::about_file(Severity::Error, code, file, message)
            }
        }
    }

    /// The place of the entity, camera or material of a key, as `file:line:column`; none where [`Places::error`] has none.
    pub fn describe(&self, key: SceneKey) -> Option<String> {
        self.find(key)?;
        let Diagnostic { file, line, column, .. } = self.error(key, Code::File, "");
        Some(format!("{file}:{line}:{column}"))
    }

    fn find(&self, key: SceneKey) -> Option<(&Source, Span)> {
        let after = self.runs.partition_point(|run| run.first <= key.0);
        let run = self.runs[..after].last().filter(|run| key.0 <= run.last && run.span.start < run.span.end)?;
        Some((self.sources.get(usize::from(run.span.source.0))?, run.span))
    }
}
