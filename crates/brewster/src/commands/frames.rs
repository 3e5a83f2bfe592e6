//! `brewster render --frames`: the pictures of an animation, one after the other. What does not move is flattened once.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use brewster::Session;

use super::Failure;
use super::render::{Arguments, load, trace};
use crate::interrupt::Interrupt;
use crate::terminal::{Terminal, duration, plural};

/// Renders every frame; an interrupt ends after the one that runs, which is saved with the samples that it has.
pub(crate) fn run(
    arguments: &Arguments,
    frames: RangeInclusive<u32>,
    session: &mut Session,
    outputs: &[PathBuf],
    terminal: Terminal,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let digits = frames.end().to_string().len().max(4);
    for frame in frames {
        session.set_time(frame as f32 / arguments.fps);
        if session.report().total().is_zero() {
            load(session, terminal)?;
        } else {
            session.load()?;
            session.flatten()?;
            let report = session.report();
            let rows = plural(report.rows_written() as u64, "row");
            terminal.say(format_args!("flatten  {}, {rows}", duration(report.total())));
            if report.rows_written() == 0 {
                terminal.say("nothing has moved since the frame before");
            }
        }
        let mut render = session.render(arguments.options())?;
        let complete = trace(&mut render, terminal, || interrupt.asked(), |_, _| true);
        if render.samples().most > 0 {
            let paths: Vec<PathBuf> = outputs.iter().map(|path| numbered(path, frame, digits)).collect();
            render.write(&paths, &arguments.png(&session.buffers().settings))?;
            paths.iter().for_each(|path| terminal.say(format_args!("wrote    {}", path.display())));
        }
        if !complete {
            return Err(Failure::Interrupted);
        }
    }
    Ok(())
}

/// `picture.png` as `picture-0007.png`.
fn numbered(path: &Path, frame: u32, digits: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{frame:0digits$}.{extension}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered_before_the_extension() {
        assert_eq!(numbered("a/b.png".as_ref(), 7, 4), PathBuf::from("a/b-0007.png"));
        assert_eq!(numbered("b.c.exr".as_ref(), 12345, 5), PathBuf::from("b.c-12345.exr"));
    }
}
