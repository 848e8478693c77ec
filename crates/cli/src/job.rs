//! A run from its first frame to its last file: what `run` and `demo` have in common.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};
use eval::plot::{TrajectoryFigure, View, save_png};
use geometry::SE3;
use io::Trajectory;
use map::MapFileInfo;
use runtime::{FrameFeed, FrameRecord, Journal, RunOutcome, Schedule, Setup};
use sha2::{Digest, Sha256};

use crate::args::ShowArgs;
use crate::clock::StopWatch;
use crate::console;
use crate::evaluation::{Compared, Evaluation};
use crate::exit::{Exit, Failure, OrExit};
use crate::places::{self, Extras};
use crate::report;
use crate::results::ResultsFolder;
use crate::show::{Audience, true_poses};
use crate::summary::{self, Checksums, Summary};
use crate::tables::{frames_csv, loops_csv, timings_csv};
use crate::trajectories::{body_records, body_text, own_pose, pose_per_frame, tracked_poses};

/// True poses of the left camera at the frames, in the frame of the ground truth.
pub(crate) const TRUTH_FILE: &str = "ground_truth.tum.txt";

/// Everything that a run needs.
pub(crate) struct Job<'a> {
    /// Where the frames come from.
    pub(crate) feed: &'a dyn FrameFeed,
    /// Camera and parameters.
    pub(crate) setup: Setup,
    /// The run to do again, instead of one by the setup's schedule.
    pub(crate) replay: Option<Journal>,
    /// The complete configuration in force, as YAML.
    pub(crate) config_yaml: String,
    /// What the errors are measured against: poses of the body.
    pub(crate) ground_truth: Option<&'a Trajectory>,
    /// Pose of the left camera in the body; the identity where the camera is the body.
    pub(crate) body_from_left: SE3,
    /// What goes into the summary beside the outcome.
    pub(crate) context: summary::Context,
    /// Where the files go.
    pub(crate) folder: ResultsFolder,
    /// Where else to.
    pub(crate) extras: Extras,
    /// Who watches.
    pub(crate) show: ShowArgs,
    /// The viewer's program, if one watches.
    pub(crate) viewer: Option<PathBuf>,
    /// Whether standard output is for scripts.
    pub(crate) json: bool,
    /// Started with the command.
    pub(crate) watch: StopWatch,
}

/// How tracking and mapping are interleaved, in one word.
pub(crate) fn schedule_name(setup: &Setup, is_replay: bool) -> &'static str {
    match setup.schedule {
        _ if is_replay => "replay",
        Schedule::Sequential => "sequential",
        Schedule::Lockstep => "lockstep",
        Schedule::Live { .. } => "live",
    }
}

/// Runs, writes the results folder and prints the report.
///
/// # Errors
/// A run that cannot begin is a fault of the input, a file that cannot be written one of the output.
pub(crate) fn execute(mut job: Job<'_>, stop: &AtomicBool) -> Result<(Summary, Exit), Failure> {
    let mut audience = Audience::gather(&job)?;
    let outcome = match &job.replay {
        None => runtime::run(job.feed, &job.setup, &mut audience, stop).or_input()?,
        Some(journal) => runtime::replay(job.feed, &job.setup, journal, &mut audience, stop).or_input()?,
    };
    audience.progress.finish();
    for remark in job.feed.remarks() {
        console::note(console::warning(&remark));
        job.context.notices.push(remark);
    }
    let sensor = job.context.sensor;
    let compared =
        job.ground_truth.map(|truth| Compared::new(&outcome.frames, truth, sensor, &job.body_from_left));
    let evaluation = compared.as_ref().map(|compared| compared.evaluate(sensor));
    let truth = compared.as_ref().zip(evaluation.as_ref());
    let written = write_results(&job, &outcome, truth).or_output();
    audience.leave(&outcome, written.as_ref().ok(), job.folder.path());
    let summary = written?;
    if job.json {
        console::say(json(&summary).or_output()?);
    } else {
        console::say(report::text(&summary, job.folder.path()).trim_end());
    }
    if !summary.is_usable() {
        let reason = summary.without_pose.first().map_or("there was no frame", |frame| &frame.reason);
        console::note(console::error(format!("no frame has a pose ({sensor}): {reason}")));
    }
    if let Some(failure) = &outcome.failure {
        console::note(console::error(format!("{failure}; what there was has been written")));
    }
    let exit = match (&outcome.failure, outcome.interrupted, summary.is_usable()) {
        (Some(_), ..) => Exit::Failed,
        (None, true, _) => Exit::Interrupted,
        (None, false, true) => Exit::Done,
        (None, false, false) => Exit::Unusable,
    };
    Ok((summary, exit))
}

/// Writes all files. The trajectories come first: they are what a full disk should hit last.
fn write_results(
    job: &Job<'_>,
    outcome: &RunOutcome,
    truth: Option<(&Compared<'_>, &Result<Evaluation>)>,
) -> Result<Summary> {
    let folder = &job.folder;
    let kitti = folder.file("trajectory.kitti.txt");
    io::write_kitti(&kitti, &pose_per_frame(&outcome.frames))?;
    io::write_tum(&folder.file("trajectory.tum.txt"), &tracked_poses(&outcome.frames))?;
    if let Some(body) = body_records(&outcome.frames, job.context.sensor, &job.body_from_left) {
        io::write_tum(&folder.file("trajectory_body.tum.txt"), &tracked_poses(&body))?;
    }
    write_truth(job)?;
    let map_sha256 = write_extras(job, outcome)?;
    folder.write("frames.csv", frames_csv(&outcome.frames).as_bytes())?;
    folder.write("loops.csv", loops_csv(&outcome.loops).as_bytes())?;
    folder.write("config.yaml", job.config_yaml.as_bytes())?;
    folder.write("timings.csv", timings_csv(&outcome.timings).as_bytes())?;
    let figure = figure(&job.context.sequence, &outcome.frames, truth);
    if figure.estimate.iter().any(Option::is_some) {
        folder.write_with("trajectory.png", |path| save_png(path, &figure))?;
    }
    let bytes = std::fs::read(&kitti).with_context(|| format!("{}: cannot be read back", kitti.display()))?;
    let checksums = Checksums { trajectory: sha256(&bytes), map: map_sha256 };
    let evaluation = truth.map(|(_, evaluation)| evaluation);
    let summary = Summary::new(job.context.clone(), outcome, evaluation, checksums, job.watch.seconds());
    folder.write("summary.json", (json(&summary)? + "\n").as_bytes())?;
    folder.link_latest()?;
    Ok(summary)
}

/// Writes the true poses of the left camera, if there are any; that of an older run in the folder does not stay.
fn write_truth(job: &Job<'_>) -> Result<()> {
    let (file, truth) = (job.folder.file(TRUTH_FILE), true_poses(job));
    if truth.poses.is_empty() {
        // There may be none.
        let _ = std::fs::remove_file(file);
        return Ok(());
    }
    Ok(io::write_tum(&file, &truth)?)
}

fn json(summary: &Summary) -> Result<String> {
    Ok(serde_json::to_string_pretty(summary)?)
}

/// Writes map and journal where that is wanted; returns the checksum of the map's file.
fn write_extras(job: &Job<'_>, outcome: &RunOutcome) -> Result<Option<String>> {
    if let Some(file) = &job.extras.journal {
        io::write_atomic(file, &outcome.journal.to_json())?;
    }
    let Some(file) = &job.extras.save_map else { return Ok(None) };
    let vocabulary = job.setup.vocabulary.as_ref();
    let info = MapFileInfo {
        sensor: Some(job.context.sensor),
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        sequence: job.context.sequence.clone(),
        configuration: job.config_yaml.clone(),
        vocabulary_sha256: vocabulary.map_or(String::new(), |vocabulary| sha256(vocabulary.as_bytes())),
        body_from_left: body_text(job.context.sensor, &job.body_from_left),
    };
    Ok(Some(sha256(&places::save_map(file, &outcome.map, &info)?)))
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The estimate, aligned where that is possible, over the true path; frames without a pose are gaps.
fn figure(
    name: &str,
    records: &[FrameRecord],
    truth: Option<(&Compared<'_>, &Result<Evaluation>)>,
) -> TrajectoryFigure {
    let Some((compared, errors)) = truth.and_then(|(c, evaluation)| Some((c, evaluation.as_ref().ok()?)))
    else {
        let estimate = records.iter().map(|record| Some(own_pose(record)?.translation)).collect();
        return TrajectoryFigure {
            title: name.to_owned(),
            estimate,
            ground_truth: Vec::new(),
            view: View::Top,
        };
    };
    let position = |record: &FrameRecord| {
        let aligned = errors.ate.aligned(&[own_pose(record)?]);
        aligned.first().map(|pose| pose.translation)
    };
    let last_time = records.last().map_or(f64::INFINITY, |record| record.timestamp_s) + 0.5;
    let driven = compared.truth.poses.iter().filter(|pose| pose.timestamp_s <= last_time);
    TrajectoryFigure {
        title: format!("{name}: ATE {:.3} m over {:.0} m", errors.ate.rmse, errors.path_m),
        estimate: compared.records.iter().map(position).collect(),
        ground_truth: driven.map(|pose| pose.world_from_cam.translation).collect(),
        view: View::Top,
    }
}
