//! The `dsslam` program: arguments in, commands called, errors printed, an exit code for the shell.
//!
//! Start reading at `run.rs` (the command) and `job.rs` (a run from its first frame to its last file).

mod activation;
mod args;
mod clock;
mod config;
mod console;
mod demo;
mod doctor;
mod evaluation;
mod exit;
mod export;
mod files;
mod help;
mod job;
mod place_recognition;
mod progress;
mod render;
mod report;
mod results;
mod run;
mod selected;
mod shell;
mod show;
mod stage;
mod stop;
mod summary;
mod tables;
mod telling;
mod vocab;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use exit::{Exit, Failure, OrExit};

fn main() -> ExitCode {
    let Cli { command, voice } = Cli::parse();
    console::set_voice(voice);
    let exit = dispatch(command).unwrap_or_else(|failure| {
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
        Command::Activation(args) => activation::run(&args),
        Command::Places(args) => place_recognition::run(&args),
        Command::Config(args) => config::run(&args.action),
        Command::Vocab(args) => vocab::run(&args.action),
        Command::Export(args) => export::run(&args),
        Command::Features(args) => args.run(),
        Command::Match(args) => args.run(),
        Command::Stereo(args) => args.run(),
        Command::Doctor(args) => doctor::run(&args),
        Command::Completions(args) => shell::completions(&args),
        Command::Man(args) => shell::man(&args),
    }
}
