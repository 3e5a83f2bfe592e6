//! The command line: reads the arguments, runs one command, and turns how it ended into an exit code.
//!
//! Nothing else in the workspace prints. What a command makes goes to standard output, what it says on the way to standard
//! error.

mod commands;
mod interrupt;
mod plot;
mod study;
mod terminal;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    commands::run(commands::CommandLine::parse())
}
