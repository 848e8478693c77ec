//! Fuzz targets: every parser of bytes from outside, as functions of bytes. Each returns what the parser said, so that a driver
//! without coverage still sees when an input reaches something new.
//!
//! `fuzz_targets/` hands them to libFuzzer (`cargo fuzz run images`); `tests/tests/suite/fuzzing.rs` mutates the seeds on a stable
//! compiler, briefly in every test run and for as long as `run.sh` says.

mod bags;
mod cameras;
mod files;
mod folders;
pub mod seeds;

use std::fmt::Display;

/// A parser with the seeds that it begins with.
pub struct Target {
    /// Its name, that of the file in `fuzz_targets`.
    pub name: &'static str,
    /// Parses, and says in words how that ended.
    pub run: fn(&[u8]) -> String,
    /// Small inputs that are right.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

/// All targets.
pub const TARGETS: &[Target] = &[
    Target { name: "images", run: files::images, seeds: seeds::images },
    Target { name: "calibrations", run: files::calibrations, seeds: seeds::calibrations },
    Target { name: "layouts", run: folders::layouts, seeds: folders::seeds },
    Target { name: "trajectories", run: files::trajectories, seeds: seeds::trajectories },
    Target { name: "configurations", run: files::configurations, seeds: seeds::configurations },
    Target { name: "overrides", run: overrides, seeds: seeds::overrides },
    Target { name: "maps", run: files::maps, seeds: seeds::maps },
    Target { name: "map_records", run: files::map_records, seeds: seeds::map_records },
    Target { name: "vocabularies", run: files::vocabularies, seeds: seeds::vocabularies },
    Target { name: "events", run: files::events, seeds: seeds::events },
    Target { name: "event_records", run: files::event_records, seeds: seeds::event_records },
    Target { name: "journals", run: files::journals, seeds: seeds::journals },
    Target { name: "videos", run: files::videos, seeds: seeds::videos },
    Target { name: "bags", run: bags::bags, seeds: bags::seeds },
    Target { name: "command_lines", run: command_lines, seeds: seeds::command_lines },
];

/// Runs a target by its name.
pub fn run(name: &str, bytes: &[u8]) {
    let target = TARGETS.iter().find(|target| target.name == name).expect("a target");
    (target.run)(bytes);
}

/// How a parser ended, in words.
pub(crate) fn said<T, E: Display>(result: Result<T, E>) -> String {
    result.map_or_else(|error| error.to_string(), |_| "accepted".to_owned())
}

/// `--set` arguments, one a line.
fn overrides(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let values: Vec<String> = text.lines().map(str::to_owned).collect();
    said(dsslam::Config::load(None, &values))
}

/// Arguments of the program, one a line.
fn command_lines(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    said(cli::parse(std::iter::once("dsslam").chain(text.lines()).map(Into::into)))
}
