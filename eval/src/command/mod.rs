//! `dsslam eval`: the command line of this package, included by the `dsslam` program.

mod consistency;
mod hints;
mod loops;
mod out;
mod suite;
mod traj;

use anyhow::Result;
use clap::Subcommand;

/// What `dsslam eval` does with files of trajectories, loops and results.
#[derive(Debug, Subcommand)]
pub enum EvalCommand {
    /// Compares one estimated trajectory with its ground truth: ATE, t_rel, r_rel, RPE, scale drift, coverage.
    #[command(after_help = include_str!("../../help/traj.txt"))]
    Traj(traj::TrajArgs),
    /// Runs a suite: sequences x configurations x repeats, resumable.
    #[command(after_help = include_str!("../../help/run.txt"))]
    Run(suite::RunArgs),
    /// Prints and writes tables of a suite's results beside published baselines.
    #[command(after_help = include_str!("../../help/table.txt"))]
    Table(suite::ResultsArgs),
    /// Compares the cases of a suite with references, configurations with one another, and a suite with an earlier one.
    #[command(after_help = include_str!("../../help/compare.txt"))]
    Compare(suite::CompareArgs),
    /// Draws a suite's results (PNG, SVG) and writes a self-contained HTML report.
    #[command(after_help = include_str!("../../help/plot.txt"))]
    Plot(suite::ResultsArgs),
    /// Scores detected loops: precision, recall, precision-recall curve.
    #[command(after_help = include_str!("../../help/loops.txt"))]
    Loops(loops::LoopsArgs),
    /// Compares covariances with true errors: NEES of motions over 10 frames, share within the 95 % bounds.
    #[command(after_help = include_str!("../../help/consistency.txt"))]
    Consistency(consistency::ConsistencyArgs),
}

impl EvalCommand {
    /// Does what the arguments say and prints the result.
    ///
    /// # Errors
    /// Wrong input, or an output that cannot be written; the message names the file and what was expected.
    pub fn run(self) -> Result<()> {
        match self {
            EvalCommand::Traj(args) => traj::run(&args),
            EvalCommand::Run(args) => suite::run(&args),
            EvalCommand::Table(args) => suite::table(&args),
            EvalCommand::Compare(args) => suite::compare(&args),
            EvalCommand::Plot(args) => suite::plot(&args),
            EvalCommand::Loops(args) => loops::run(&args),
            EvalCommand::Consistency(args) => consistency::run(&args),
        }
    }
}
