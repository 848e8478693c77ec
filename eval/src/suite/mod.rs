//! Suites: many runs of the program (sequences x configurations x repeats), resumable, and their results read back.
//!
//! A run's folder is `RESULTS/<sequence>/<configuration>/<repeat>`; its `run.json` says how it ended.

mod paths;
mod plan;
mod record;
mod results;
mod runner;

pub use paths::RunPaths;
pub use plan::{Configuration, Plan, RunId, SequencePlan, read_plan};
pub use record::{RunRecord, RunState, RunSummary};
pub use results::{Results, RunResult};
pub use runner::{Event, RunOptions, job_lines, run_suite};
