//! A run from its first frame to its last file: what `run` and `demo` have in common.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};
use dsslam::trajectories::{body_records, own_pose, pose_per_frame, tracked_poses};
use dsslam::{Compared, Error, Figures, Finished, Session, Verdict, scale_against_truth};
use eval::plot::{TrajectoryFigure, View, save_png};
use eval::{Evaluation, Subject};
use io::Sequence;
use runtime::{FrameRecord, Journal, Schedule};
use serde::Serialize;

use crate::args::ShowArgs;
use crate::clock::StopWatch;
use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::report;
use crate::results::ResultsFolder;
use crate::show::{Audience, true_poses};
use crate::summary::{self, Checksums, Summary};
use crate::tables::{frames_csv, loops_csv, timings_csv};

/// True poses of the left camera at the frames, in the frame of the ground truth.
pub(crate) const TRUTH_FILE: &str = "ground_truth.tum.txt";
/// True poses of the body at the frames of the run, where the body is not the left camera.
const TRUTH_OF_BODY_FILE: &str = "ground_truth_body.tum.txt";

/// Estimated over true lengths that need no word.
const SCALE: RangeInclusive<f64> = 0.95..=1.05;

/// Everything that a run needs.
pub(crate) struct Job {
    /// The frames, the camera and the parameters.
    pub(crate) session: Session,
    /// What the run rests on.
    pub(crate) figures: Figures,
    /// Whether a doubt refuses a result.
    pub(crate) is_strict: bool,
    /// Name of the built-in configuration that the layout of the sequence has chosen.
    pub(crate) preset: Option<&'static str>,
    /// What the user should know of that choice.
    pub(crate) notices: Vec<String>,
    /// The run to do again, instead of one by the setup's schedule.
    pub(crate) replay: Option<Journal>,
    /// Segment lengths of t_rel and r_rel, meters.
    pub(crate) lengths_m: Vec<f64>,
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

/// What a run writes beside its results folder.
#[derive(Clone, Debug, Default)]
pub(crate) struct Extras {
    /// The map at its end.
    pub(crate) save_map: Option<PathBuf>,
    /// Its journal.
    pub(crate) journal: Option<PathBuf>,
}

impl Job {
    /// What is run on.
    pub(crate) fn sequence(&self) -> &Sequence {
        self.session.input().sequence()
    }

    /// What goes into the summary beside the outcome.
    fn context(&self) -> summary::Context {
        let (sequence, setup) = (self.sequence(), self.session.setup());
        summary::Context {
            sequence: sequence.name.clone(),
            sensor: sequence.sensor,
            seed: setup.slam.seed,
            schedule: schedule_name(setup.schedule, self.replay.is_some()),
            preset: self.preset,
            notices: [&self.notices[..], self.session.notices()].concat(),
            figures: self.figures.clone(),
            scale_against_truth: None,
        }
    }
}

/// How tracking and mapping are interleaved, in one word.
fn schedule_name(schedule: Schedule, is_replay: bool) -> &'static str {
    match schedule {
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
pub(crate) fn execute(job: &Job, stop: &AtomicBool) -> Result<(Summary, Exit), Failure> {
    let (session, sequence, mut context) = (&job.session, job.sequence(), job.context());
    for notice in &context.notices {
        console::note(console::warning(notice));
    }
    context.notices.extend(job.figures.doubts.iter().map(|doubt| doubt.text.clone()));
    let mut audience = Audience::gather(job)?;
    let finished = match &job.replay {
        None => session.run_until(&mut audience, stop).or_input()?,
        Some(journal) => session.replay(journal, &mut audience, stop).or_input()?,
    };
    let outcome = &finished.outcome;
    audience.progress.finish();
    for remark in session.input().feed().remarks() {
        console::note(console::warning(&remark));
        context.notices.push(remark);
    }
    let compared = Compared::new(&outcome.frames, sequence);
    let evaluation = compared.as_ref().map(|compared| compared.evaluate(&job.lengths_m));
    let truth = compared.as_ref().zip(evaluation.as_ref());
    let scale = evaluation.as_ref().and_then(|evaluation| scale_against_truth(evaluation.as_ref().ok()?));
    let off_scale = scale.filter(|scale| !SCALE.contains(scale)).map(|scale| {
        format!("estimated lengths are {scale:.3} times the true ones: baseline, unit of depth or unit of the ground truth is wrong")
    });
    if let Some(text) = &off_scale {
        console::note(console::warning(text).event("doubt").with("rule", "scale"));
        context.notices.push(text.clone());
    }
    context.scale_against_truth = scale;
    let written = write_results(job, context, &finished, truth).or_output();
    audience.leave(outcome, written.as_ref().ok(), job.folder.path());
    let summary = written?;
    if job.json {
        console::say(json(&summary).or_output()?);
    } else {
        console::say(report::text(&summary, job.folder.path()).trim_end());
    }
    let verdict = Verdict::of(&outcome.frames);
    if !verdict.is_success() {
        let doubts: Vec<&str> = job.figures.doubts.iter().map(|doubt| doubt.text.as_str()).collect();
        let why = if doubts.is_empty() { String::new() } else { format!(" ({})", doubts.join("; ")) };
        console::note(console::error(format!("{verdict}{why}")));
    }
    if job.is_strict && off_scale.is_some() {
        console::note(console::error("refused by --strict, since the scale is doubtful"));
    }
    let is_useful = verdict.is_success() && !(job.is_strict && off_scale.is_some());
    if let Some(failure) = &outcome.failure {
        console::note(console::error(format!("{failure}; results so far have been written")));
    }
    let exit = match (&outcome.failure, outcome.interrupted, is_useful) {
        (Some(_), ..) => Exit::Failed,
        (None, true, _) => Exit::Interrupted,
        (None, false, true) => Exit::Done,
        (None, false, false) => Exit::Unusable,
    };
    Ok((summary, exit))
}

/// Writes all files. The trajectories come first: they are what a full disk should hit last.
fn write_results(
    job: &Job,
    context: summary::Context,
    finished: &Finished,
    truth: Option<(&Compared<'_>, &Result<Evaluation, Error>)>,
) -> Result<Summary> {
    let (folder, sequence, outcome) = (&job.folder, job.sequence(), &finished.outcome);
    let kitti = folder.file("trajectory.kitti.txt");
    io::write_kitti(&kitti, &pose_per_frame(&outcome.frames))?;
    io::write_tum(&folder.file("trajectory.tum.txt"), &tracked_poses(&outcome.frames))?;
    if let Some(body) = body_records(&outcome.frames, sequence.sensor, &sequence.body_from_left) {
        io::write_tum(&folder.file("trajectory_body.tum.txt"), &tracked_poses(&body))?;
    } else {
        remove(folder, "trajectory_body.tum.txt");
    }
    write_truth(job, truth.map(|(compared, _)| compared))?;
    let map_sha256 = write_extras(job, finished)?;
    folder.write("frames.csv", frames_csv(&outcome.frames).as_bytes())?;
    folder.write("loops.csv", loops_csv(&outcome.loops).as_bytes())?;
    folder.write("config.yaml", job.session.input().config().to_yaml().as_bytes())?;
    folder.write("timings.csv", timings_csv(&outcome.timings).as_bytes())?;
    let figure = figure(&sequence.name, &outcome.frames, truth);
    if figure.estimate.iter().any(Option::is_some) {
        folder.write_with("trajectory.png", |path| save_png(path, &figure))?;
    }
    let bytes = std::fs::read(&kitti).with_context(|| format!("{}: cannot be read back", kitti.display()))?;
    let checksums = Checksums { trajectory: dsslam::sha256(&bytes), map: map_sha256 };
    let evaluation = truth.map(|(_, evaluation)| evaluation);
    match evaluation.and_then(|evaluation| evaluation.as_ref().ok()) {
        Some(errors) => folder.write("evaluation.json", (json(errors)? + "\n").as_bytes())?,
        None => remove(folder, "evaluation.json"),
    }
    let summary = Summary::new(context, outcome, evaluation, checksums, job.watch.seconds());
    folder.write("summary.json", (json(&summary)? + "\n").as_bytes())?;
    folder.link_latest()?;
    Ok(summary)
}

/// Writes the true poses of the left camera at all frames, and those of the body at the frames of the run, if there are any.
fn write_truth(job: &Job, compared: Option<&Compared<'_>>) -> Result<()> {
    let body = compared.filter(|compared| compared.subject == Subject::Body).map(Compared::truth_at_frames);
    for (name, truth) in [(TRUTH_FILE, true_poses(job)), (TRUTH_OF_BODY_FILE, body.unwrap_or_default())] {
        if truth.poses.is_empty() {
            remove(&job.folder, name);
        } else {
            io::write_tum(&job.folder.file(name), &truth)?;
        }
    }
    Ok(())
}

/// Removes what an older run wrote into the folder and this one does not; there may be nothing.
fn remove(folder: &ResultsFolder, name: &str) {
    let _ = std::fs::remove_file(folder.file(name));
}

fn json(value: &impl Serialize) -> Result<String> {
    Ok(serde_json::to_string_pretty(value)?)
}

/// Writes map and journal where that is wanted; returns the checksum of the map's file.
fn write_extras(job: &Job, finished: &Finished) -> Result<Option<String>> {
    if let Some(file) = &job.extras.journal {
        io::write_atomic(file, &finished.outcome.journal.to_json())?;
    }
    let Some(file) = &job.extras.save_map else { return Ok(None) };
    Ok(Some(finished.save_map(file)?))
}

/// The estimate, aligned where that is possible, over the true path; frames without a pose are gaps.
fn figure(
    name: &str,
    records: &[FrameRecord],
    truth: Option<(&Compared<'_>, &Result<Evaluation, Error>)>,
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
    let position = |record: &FrameRecord| Some(errors.aligned(&own_pose(record)?.translation));
    let last_time = records.last().map_or(f64::INFINITY, |record| record.timestamp_s) + 0.5;
    let driven = compared.truth.poses.iter().filter(|pose| pose.timestamp_s <= last_time);
    TrajectoryFigure {
        title: format!("{name}: ATE {:.3} m over {:.0} m", errors.ate_m.rmse, errors.path_m),
        estimate: compared.frames.iter().map(position).collect(),
        ground_truth: driven.map(|pose| pose.world_from_cam.translation).collect(),
        view: View::Top,
    }
}
