//! `brewster render --watch`: a preview that follows every edit.
//!
//! Files are looked at a few times a second (their time of change and their length) rather than asked to report: that works on
//! every file system, sees files that editors replace or that are not there yet, and costs nothing beside a render.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use brewster::{Session, SessionError};

use super::Failure;
use super::render::{Arguments, trace};
use super::scene::say_warnings;
use crate::interrupt::Interrupt;
use crate::terminal::{Terminal, complain, duration, plural};

/// Between two looks at the files.
const LOOK: Duration = Duration::from_millis(50);
/// About how long a pass takes: a running render stops for an edit at the end of one.
const PASS: Duration = Duration::from_millis(250);
/// Between two writings of a preview that grows better.
const WRITE: Duration = Duration::from_secs(1);

/// Renders, waits for an edit, and renders again, until Ctrl-C. A file that was written again as it was makes no new picture.
pub(crate) fn run(
    arguments: &Arguments,
    session: &mut Session,
    outputs: &[PathBuf],
    terminal: Terminal,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    // The hash of the scene whose picture is complete.
    let mut shown = None;
    while !interrupt.asked() {
        let begin = Instant::now();
        let files = Watched::before_load(session.dependencies());
        let result = update(session, terminal);
        let files = files.after_load(session.dependencies());
        let result = result.and_then(|()| {
            if shown == Some(session.hash()) {
                terminal.say("nothing else than before");
                return Ok(());
            }
            shown = None;
            let stop = || interrupt.asked() || files.changed();
            if preview(arguments, session, outputs, terminal, begin, stop)? {
                shown = Some(session.hash());
            }
            Ok(())
        });
        if let Err(error) = result {
            // What is wrong now may be right after the next edit.
            complain(&error);
        }
        if !files.changed() && !interrupt.asked() {
            terminal.say("waiting for an edit; Ctrl-C ends");
        }
        while !files.changed() && !interrupt.asked() {
            thread::sleep(LOOK);
        }
        files.settle();
    }
    Ok(())
}

/// Brings the scene up to date with its files.
fn update(session: &mut Session, terminal: Terminal) -> Result<(), SessionError> {
    let applied = session.load()?;
    say_warnings(session, terminal);
    let report = session.flatten()?;
    let edits = [(applied.spawned, "new"), (applied.changed, "changed"), (applied.despawned, "gone")];
    let edits = edits.map(|(entities, how)| format!("{entities} {how}")).join(", ");
    let rows = plural(report.rows_written() as u64, "row");
    terminal.say(format_args!("entities {edits}; {rows} written"));
    Ok(())
}

/// Renders until the picture is complete or `stop` says so, and writes it whenever there is more to see. Tells whether it is
/// complete.
fn preview(
    arguments: &Arguments,
    session: &Session,
    outputs: &[PathBuf],
    terminal: Terminal,
    begin: Instant,
    stop: impl Fn() -> bool + Sync,
) -> Result<bool, SessionError> {
    let mut options = arguments.options();
    options.pass_time = PASS;
    let png = arguments.png(&session.buffers().settings);
    let mut render = session.render(options)?;
    let mut written = None;
    let mut result = Ok(());
    let complete = trace(&mut render, terminal, stop, |render, progress| {
        let due = written.is_none_or(|time: Instant| time.elapsed() >= WRITE) || render.remaining() == 0;
        // A first pass that was stopped shows a part of the picture: the last whole one stays.
        if due && render.samples().least > 0 {
            result = render.write(outputs, &png);
            if written.is_none() {
                progress.say(format_args!("preview  after {}", duration(begin.elapsed())));
            }
            written = Some(Instant::now());
        }
        result.is_ok()
    });
    result?;
    Ok(complete)
}

/// What tells one state of a file from another; `None` for a file that is not there.
type Stamp = Option<(SystemTime, u64)>;

/// Files, and how they were when the scene was read.
struct Watched(Vec<(PathBuf, Stamp)>);

impl Watched {
    /// Notes how the known files are before they are read: an edit during the load counts.
    fn before_load(files: &[PathBuf]) -> Watched {
        Watched(files.iter().map(|path| (path.clone(), stamp(path))).collect())
    }

    /// Goes on with the files that the load asked for.
    fn after_load(self, files: &[PathBuf]) -> Watched {
        let before = |path: &Path| self.0.iter().find(|(known, _)| known == path).map(|(_, stamp)| *stamp);
        Watched(files.iter().map(|path| (path.clone(), before(path).unwrap_or_else(|| stamp(path)))).collect())
    }

    fn changed(&self) -> bool {
        self.0.iter().any(|(path, before)| stamp(path) != *before)
    }

    /// Waits until nothing changes from one look to the next: an editor may write in several steps.
    fn settle(&self) {
        let look = || self.0.iter().map(|(path, _)| stamp(path)).collect::<Vec<_>>();
        let mut last = look();
        loop {
            thread::sleep(LOOK);
            let now = look();
            if now == last {
                return;
            }
            last = now;
        }
    }
}

fn stamp(path: &Path) -> Stamp {
    let metadata = fs::metadata(path).ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_new_files_and_removals_are_seen() {
        let folder = tempfile::tempdir().unwrap();
        let [scene, mesh] = ["scene.ron", "mesh.obj"].map(|name| folder.path().join(name));
        fs::write(&scene, "a").unwrap();
        let watched = || Watched::before_load(&[]).after_load(&[scene.clone(), mesh.clone()]);

        let files = watched();
        assert!(!files.changed());
        fs::write(&scene, "ab").unwrap();
        assert!(files.changed(), "an edit");

        let files = watched();
        fs::write(&mesh, "v 0 0 0").unwrap();
        assert!(files.changed(), "a file that was missing");

        let files = Watched::before_load(std::slice::from_ref(&scene));
        fs::write(&scene, "abc").unwrap();
        assert!(files.after_load(&[scene.clone(), mesh.clone()]).changed(), "an edit during the load");

        let files = watched();
        fs::remove_file(&mesh).unwrap();
        assert!(files.changed(), "a removal");
    }
}
