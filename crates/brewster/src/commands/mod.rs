//! The commands, one file each: its arguments and what it does with them.

mod check;
mod compare;
mod completions;
mod convert;
mod explain;
mod frames;
mod fresnel;
mod man;
mod models;
mod render;
mod replay;
mod scene;
mod study;
mod values;
mod watch;

use std::io::{self, Write};
use std::process::ExitCode;

use brewster::SessionError;
use brewster::film::FilmError;
use clap::{Parser, Subcommand};

use crate::terminal::complain;

/// Renders scenes, and tells what light does at surfaces.
#[derive(Debug, Parser)]
#[command(name = "brewster", version, propagate_version = true, after_help = EXIT_CODES)]
pub(crate) struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 done; 1 the input cannot be used or the output cannot be written; \
    2 the command line is wrong; 130 interrupted, and what was finished is saved.";

#[derive(Debug, Subcommand)]
enum Command {
    Render(Box<render::Arguments>),
    Replay(Box<replay::Arguments>),
    Check(Box<check::Arguments>),
    Convert(Box<convert::Arguments>),
    Explain(Box<explain::Arguments>),
    Fresnel(fresnel::Arguments),
    Compare(compare::Arguments),
    Study(Box<study::Arguments>),
    Completions(completions::Arguments),
    Man(man::Arguments),
}

/// How a command ended short of its aim.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The input cannot be used, or the output cannot be written: a sentence.
    Input(String),
    /// The input cannot be used: diagnostics, ready to be printed.
    Diagnostics(String),
    /// The input cannot be used, and it has been said why.
    Told,
    /// The command line asks for what does not exist or does not go together.
    Usage(String),
    /// Interrupted; what was finished is saved, and it has been said.
    Interrupted,
}

impl Failure {
    /// The exit code of an interrupted command.
    pub(crate) const INTERRUPTED: u8 = 130;

    /// A failure whose error says it all.
    pub(crate) fn input(error: impl std::fmt::Display) -> Failure {
        Failure::Input(error.to_string())
    }

    /// Says what there is to say; the exit code.
    fn tell(self) -> ExitCode {
        let code = match self {
            Failure::Input(message) => {
                complain(format_args!("error: {message}"));
                1
            }
            Failure::Diagnostics(text) => {
                complain(text);
                1
            }
            Failure::Usage(message) => {
                complain(format_args!("error: {message}"));
                2
            }
            Failure::Told => 1,
            Failure::Interrupted => Failure::INTERRUPTED,
        };
        ExitCode::from(code)
    }
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Failure {
        match error {
            SessionError::Import(_) | SessionError::Invalid(_) => Failure::Diagnostics(error.to_string()),
            _ => Failure::input(error),
        }
    }
}

impl From<FilmError> for Failure {
    fn from(error: FilmError) -> Failure {
        Failure::input(error)
    }
}

/// Prints what a command makes. A reader that has seen enough is no failure.
pub(crate) fn print(text: impl AsRef<[u8]>) -> Result<(), Failure> {
    match io::stdout().write_all(text.as_ref()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::input(error)),
        _ => Ok(()),
    }
}

/// Runs the command; says why if it fails.
pub(crate) fn run(line: CommandLine) -> ExitCode {
    let result = match line.command {
        Command::Render(arguments) => render::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Explain(arguments) => explain::run(&arguments),
        Command::Fresnel(arguments) => fresnel::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Study(arguments) => study::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments),
        Command::Man(arguments) => man::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.tell(),
    }
}
