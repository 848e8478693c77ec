//! The `dsslam` program: arguments in, commands called, errors printed, an exit code for the shell.
//!
//! Start reading at `run.rs` (the command) and `job.rs` (a run from its first frame to its last file).

mod args;
mod clock;
mod config;
mod console;
mod demo;
mod evaluation;
mod exit;
mod help;
mod job;
mod places;
mod progress;
mod render;
mod report;
mod results;
mod run;
mod setup;
mod show;
mod stop;
mod summary;
mod tables;
mod trajectories;
mod vocab;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use exit::{Exit, Failure, OrExit};

fn main() -> ExitCode {
    let exit = dispatch(Cli::parse().command).unwrap_or_else(|failure| {
        console::note(console::error(failure.to_string()));
        failure.exit
    });
    ExitCode::from(exit.code())
}

fn dispatch(command: Command) -> Result<Exit, Failure> {
    match command {
        Command::Run(args) => run::run(&args),
        Command::View(args) => show::view(&args),
        Command::Demo(args) => demo::run(&args),
        Command::Synth(args) => render::run(&args),
        Command::Eval(command) => command.run().or_input().map(|()| Exit::Done),
        Command::Config(args) => config::run(&args.action),
        Command::Vocab(args) => vocab::run(&args.action),
    }
}
