//! `dsslam eval`: the command line of this package, included by the `dsslam` program.
#![allow(clippy::print_stdout, reason = "this module is the program's output; the rest of the package prints nothing")]

mod traj;

use anyhow::Result;
use clap::{Args, Subcommand};

/// Arguments of `dsslam eval`.
#[derive(Debug, Args)]
pub struct EvalCommand {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Compares one estimated trajectory with its ground truth: ATE, t_rel, r_rel, RPE, scale drift, coverage.
    #[command(after_help = traj::EXAMPLES)]
    Traj(traj::TrajArgs),
}

impl EvalCommand {
    /// Does what the arguments say and prints the result.
    ///
    /// # Errors
    /// Wrong input, or an output that cannot be written; the message names the file and what was expected.
    pub fn run(self) -> Result<()> {
        match self.action {
            Action::Traj(args) => traj::run(&args),
        }
    }
}
