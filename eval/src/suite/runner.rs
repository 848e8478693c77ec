//! Runs a suite: one process per run, one folder per run, never ended by a run that fails.
#![allow(
    clippy::disallowed_methods,
    reason = "the runner measures and limits the time of whole processes; no result depends on its clock"
)]

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow};

use super::plan::{Plan, RunId};
use super::record::{RunRecord, RunState, RunSummary, read_json, write_json};
use crate::drift::KITTI_LENGTHS_M;

/// How often a running process is looked at when it has a time limit.
const POLL: Duration = Duration::from_millis(50);

/// How a suite is run.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// The `dsslam` program.
    pub program: PathBuf,
    /// Results folder.
    pub results: PathBuf,
    /// Number of parallel runs.
    pub jobs: usize,
    /// Repeats runs that failed.
    pub retry_failed: bool,
    /// Only the runs whose name (`sequence/configuration/repeat`) begins with this.
    pub only: Option<String>,
}

/// What happens while a suite runs.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// The run had ended before.
    Skipped(&'a RunRecord),
    /// The run starts.
    Started(&'a RunId),
    /// The run has ended.
    Ended(&'a RunRecord),
}

/// Runs what has not ended yet; returns the records of all runs in the order of the plan.
///
/// # Errors
/// The results folder cannot be written, or `only` does not name a run. A run that fails is not an error: its record says why.
pub fn run_suite(
    plan: &Plan,
    options: &RunOptions,
    observer: &(dyn Fn(Event<'_>) + Sync),
) -> Result<Vec<RunRecord>> {
    let runs = selected(plan, options.only.as_deref())?;
    std::fs::create_dir_all(&options.results)
        .with_context(|| format!("cannot create {}", options.results.display()))?;
    write_json(&options.results.join("suite.json"), plan)?;
    let next = AtomicUsize::new(0);
    let ended: Mutex<Vec<(usize, Result<RunRecord>)>> = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..options.jobs.clamp(1, runs.len()) {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(id) = runs.get(i) else { break };
                    let record = run_once(plan, id, options, observer);
                    if let Ok(mut ended) = ended.lock() {
                        ended.push((i, record));
                    }
                }
            });
        }
    });
    let mut ended = ended.into_inner().map_err(|_| anyhow!("a run's observer panicked"))?;
    ended.sort_by_key(|(i, _)| *i);
    ended.into_iter().map(|(_, record)| record).collect()
}

/// One shell command per run for GNU parallel or a Slurm array: each runs its part of the suite into the same results.
/// `evaluator` is this program, which calls `options.program` in its turn.
///
/// # Errors
/// `only` names no run.
pub fn job_lines(
    plan: &Plan,
    suite_file: &Path,
    evaluator: &Path,
    options: &RunOptions,
) -> Result<Vec<String>> {
    let quoted = |path: &Path| quote(&path.to_string_lossy());
    let (suite, results) = (quoted(suite_file), quoted(&options.results));
    let mut tail = String::new();
    if options.program != evaluator {
        tail += &format!(" --program {}", quoted(&options.program));
    }
    if options.retry_failed {
        tail += " --retry-failed";
    }
    let line =
        |id: &RunId| format!("{} eval run {suite} --out {results} --only {id}{tail}", quoted(evaluator));
    Ok(selected(plan, options.only.as_deref())?.iter().map(line).collect())
}

fn quote(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=".contains(c);
    if text.chars().all(is_plain) { text.to_owned() } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

/// Runs named by `only`: the whole name, or a prefix that ends at a slash.
fn selected(plan: &Plan, only: Option<&str>) -> Result<Vec<RunId>> {
    let runs = plan.runs();
    let Some(only) = only else { return Ok(runs) };
    let prefix = format!("{}/", only.trim_end_matches('/'));
    let chosen: Vec<RunId> = runs.into_iter().filter(|id| format!("{id}/").starts_with(&prefix)).collect();
    anyhow::ensure!(
        !chosen.is_empty(),
        "'{only}' is not a run of the suite {}; runs are <sequence>/<configuration>/<repeat>",
        plan.name
    );
    Ok(chosen)
}

fn run_once(
    plan: &Plan,
    id: &RunId,
    options: &RunOptions,
    observer: &dyn Fn(Event<'_>),
) -> Result<RunRecord> {
    let folder = id.folder(&options.results);
    let arguments = arguments(plan, id, &folder);
    if let Ok(record) = read_json::<RunRecord>(&folder.join("run.json")) {
        let is_current = record.arguments == arguments;
        let has_ended = record.state == RunState::Done || !options.retry_failed;
        if is_current && has_ended {
            observer(Event::Skipped(&record));
            return Ok(record);
        }
    }
    observer(Event::Started(id));
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    for stale in ["run.json", "summary.json", "evaluation.json"] {
        let _ = std::fs::remove_file(folder.join(stale));
    }
    let start = Instant::now();
    let outcome = execute(&options.program, &arguments, &folder, plan.timeout_s);
    let wall_s = start.elapsed().as_secs_f64();
    let summary = outcome.and_then(|()| read_json::<RunSummary>(&folder.join("summary.json")));
    let (state, evaluation_problem) = match summary {
        Ok(summary) => (RunState::Done, summary.evaluation_problem),
        Err(error) => (RunState::Failed { reason: format!("{error:#}") }, None),
    };
    let record = RunRecord { id: id.clone(), state, arguments, wall_s, evaluation_problem };
    write_json(&folder.join("run.json"), &record)?;
    observer(Event::Ended(&record));
    Ok(record)
}

/// Arguments of `dsslam run` for one run.
fn arguments(plan: &Plan, id: &RunId, folder: &Path) -> Vec<String> {
    let text = |path: &PathBuf| path.to_string_lossy().into_owned();
    let (sequence, configuration) = (plan.sequence(&id.sequence), plan.configuration(&id.configuration));
    let mut list = vec!["run".to_owned()];
    list.extend(sequence.map(|sequence| text(&sequence.path)));
    let sensor = sequence.and_then(|s| s.sensor).or_else(|| configuration?.sensor);
    let given = [
        ("--max-frames", sequence.and_then(|s| s.max_frames).map(|n| n.to_string())),
        ("--ground-truth", sequence.and_then(|s| s.ground_truth.as_ref()).map(text)),
        ("--variant", sequence.and_then(|s| s.variant.clone())),
        ("--config", configuration.and_then(|c| c.config.as_ref()).map(text)),
        ("--sensor", sensor.map(|sensor| sensor.to_string())),
    ];
    let sets = configuration.iter().flat_map(|c| &c.set).map(|set| ("--set", Some(set.clone())));
    for (name, value) in given.into_iter().chain(sets) {
        list.extend(value.into_iter().flat_map(|value| [name.to_owned(), value]));
    }
    if plan.lengths_m != KITTI_LENGTHS_M {
        let lengths: Vec<String> = plan.lengths_m.iter().map(f64::to_string).collect();
        list.extend(["--lengths".to_owned(), lengths.join(",")]);
    }
    list.extend(["--out".to_owned(), folder.to_string_lossy().into_owned()]);
    list
}

/// Runs the program; its output goes to `log.txt` in the run's folder.
fn execute(program: &Path, arguments: &[String], folder: &Path, timeout_s: Option<f64>) -> Result<()> {
    let log_path = folder.join("log.txt");
    let log = File::create(&log_path).with_context(|| format!("cannot write {}", log_path.display()))?;
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(log.try_clone()?)
        .stderr(log)
        .spawn()
        .with_context(|| format!("cannot start {}", program.display()))?;
    let status = match timeout_s {
        None => child.wait()?,
        Some(limit) => {
            let start = Instant::now();
            loop {
                if let Some(status) = child.try_wait()? {
                    break status;
                }
                if start.elapsed().as_secs_f64() > limit {
                    child.kill()?;
                    child.wait()?;
                    return Err(anyhow!("stopped after the time limit of {limit} s"));
                }
                std::thread::sleep(POLL);
            }
        }
    };
    if status.success() { Ok(()) } else { Err(failure(status, &log_path)) }
}

/// The exit status with the last line of the log.
fn failure(status: ExitStatus, log: &Path) -> anyhow::Error {
    let text =
        std::fs::read(log).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default();
    match text.lines().rfind(|line| !line.trim().is_empty()) {
        Some(last) => anyhow!("{status}: {}", last.trim()),
        None => anyhow!("{status}, no output"),
    }
}
