//! `brewster man`: manual pages.

use std::io::Write;
use std::path::PathBuf;

use brewster::film::{FilmError, write_atomically};
use clap::{Args, CommandFactory};
use clap_mangen::Man;

use super::{CommandLine, Failure, print};

/// Prints the manual page, or writes those of all commands to a folder.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Write brewster.1, brewster-render.1 and so on to this folder.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut command = CommandLine::command().disable_help_subcommand(true);
    command.build();
    let Some(folder) = &arguments.output else {
        let mut page = Vec::new();
        Man::new(command).render(&mut page).map_err(Failure::input)?;
        return print(page);
    };
    let commands = command.get_subcommands().cloned().collect::<Vec<_>>();
    for command in std::iter::once(command).chain(commands) {
        let page = Man::new(command);
        let path = folder.join(page.get_filename());
        let io_error = |source| FilmError::Io { path: path.clone(), source };
        let mut bytes = Vec::new();
        page.render(&mut bytes).map_err(io_error)?;
        write_atomically(&path, |file| file.write_all(&bytes).map_err(io_error))?;
    }
    Ok(())
}
