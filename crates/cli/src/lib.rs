//! The `dsslam` program as a function: arguments in, commands called, errors printed, an exit code for the shell.
//!
//! Start reading at `run.rs` (the command) and `job.rs` (a run from its first frame to its last file).

mod activation;
mod args;
mod bag;
mod clock;
mod config;
mod console;
mod demo;
mod doctor;
mod evaluate;
mod exit;
mod export;
mod figures;
mod files;
mod help;
mod job;
mod mcap_export;
mod outputs;
mod places;
mod progress;
mod recorded_frames;
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

use std::ffi::OsString;
use std::io::ErrorKind;

use clap::Parser;
use clap::error::{ContextKind, ContextValue};

use args::{Cli, Command, Inspect, ShellCommand};
use bag::BagAction;
use exit::{Exit, Failure};

/// Runs the program with these arguments, of which the first is its name, and returns its exit code. Help, the version and wrong
/// arguments end the process.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let Cli { command, voice } = Cli::try_parse_from(arguments).unwrap_or_else(|error| refused(&error));
    console::set_voice(voice);
    let exit = dispatch(command).unwrap_or_else(|failure| {
        console::note(console::error(failure.to_string()));
        failure.exit
    });
    if let Some(reason) = console::unsaid() {
        console::note(console::error(format!("standard output cannot be written: {reason}")));
        return Exit::Output.code();
    }
    exit.code()
}

/// Whether arguments, the program's name first, are a command line; nothing is done.
///
/// # Errors
/// What is wrong with them, or the help that they ask for.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<(), clap::Error> {
    Cli::try_parse_from(arguments).map(drop)
}

fn dispatch(command: Command) -> Result<Exit, Failure> {
    match command {
        Command::Run(args) => run::run(&args),
        Command::View(args) => show::view(&args),
        Command::Demo(args) => demo::run(&args),
        Command::Synth(args) => render::run(&args),
        Command::Eval(args) => evaluate::run(args),
        Command::Config(args) => config::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Inspect(what) => match what {
            Inspect::Features(args) => args.run(),
            Inspect::Match(args) => args.run(),
            Inspect::Stereo(args) => args.run(),
            Inspect::Activation(args) => activation::run(&args),
            Inspect::Bag(args) => bag::info(&args),
            Inspect::Vocab(args) => vocab::run(&args),
        },
        Command::Bag(BagAction::Info(args)) => bag::info(&args),
        Command::Doctor(args) => doctor::run(&args),
        Command::Shell(what) => match what {
            ShellCommand::Completions(args) => shell::completions(&args),
            ShellCommand::Man(args) => shell::man(&args),
        },
    }
}

/// Ends the program with what is wrong with its arguments; of a command that has moved with its name now.
fn refused(error: &clap::Error) -> ! {
    if let Some(ContextValue::String(name)) = error.get(ContextKind::InvalidSubcommand)
        && let Some(moved) = args::moved(name)
    {
        console::note(console::error(moved));
        std::process::exit(i32::from(Exit::Input.code()));
    }
    if error.print().is_err_and(|error| error.kind() != ErrorKind::BrokenPipe) {
        console::note(console::error("standard output cannot be written: is the disk full?"));
        std::process::exit(i32::from(Exit::Output.code()));
    }
    std::process::exit(error.exit_code());
}
