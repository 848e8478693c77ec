//! The files of a run, in the order of their worth: what a full disk should hit last comes first, and a file that cannot be written
//! keeps no other from being written.

use std::path::Path;

use anyhow::{Context, Result};
use dsslam::submaps::{Submap, of_submap, submaps};
use dsslam::trajectories::{body_records, own_pose, pose_per_frame, tracked_poses};
use dsslam::{Compared, Error, Finished};
use eval::plot::{self, View, save_png};
use eval::{Evaluation, Subject};
use geometry::Vec3;
use runtime::FrameRecord;
use serde::Serialize;

use crate::job::Job;
use crate::results::ResultsFolder;
use crate::show::true_poses;
use crate::summary::{SubmapFigures, Summary};
use crate::tables::{frames_csv, loops_csv, timings_csv};

/// True poses of the left camera at the frames, in the frame of the ground truth.
pub(crate) const TRUTH_FILE: &str = "ground_truth.tum.txt";
/// True poses of the body at the frames of the run, where the body is not the left camera.
const TRUTH_OF_BODY_FILE: &str = "ground_truth_body.tum.txt";
/// How the files of one of several sub-maps begin.
const SUBMAP_FILES: &str = "trajectory_submap_";

/// Poses with their errors: those of a whole run, or of one of its sub-maps.
pub(crate) struct Part<'a> {
    frames: &'a [FrameRecord],
    compared: Option<Compared<'a>>,
    /// `None` without ground truth.
    pub(crate) evaluation: Option<Result<Evaluation, Error>>,
}

impl<'a> Part<'a> {
    pub(crate) fn new(frames: &'a [FrameRecord], job: &'a Job) -> Self {
        let compared = Compared::new(frames, job.sequence());
        let evaluation = compared.as_ref().map(|compared| compared.evaluate(&job.wishes.lengths_m));
        Self { frames, compared, evaluation }
    }

    fn errors(&self) -> Option<&Evaluation> {
        self.evaluation.as_ref()?.as_ref().ok()
    }
}

/// Name of the trajectory of one of several sub-maps.
pub(crate) fn submap_file(root: &str) -> String {
    format!("{SUBMAP_FILES}{root}.tum.txt")
}

/// Writes files one after another; what fails is remembered.
struct Files<'a> {
    folder: &'a ResultsFolder,
    /// Frees the room of what nobody needs.
    make_room: &'a dyn Fn(),
    failures: Vec<anyhow::Error>,
}

impl Files<'_> {
    /// Writes something that matters: where it fails, room is made and it is tried again.
    fn write<E: Into<anyhow::Error>>(&mut self, write: impl Fn() -> Result<(), E>) {
        let written = write().or_else(|_| {
            (self.make_room)();
            write()
        });
        self.note(written);
    }

    fn note<T, E: Into<anyhow::Error>>(&mut self, result: Result<T, E>) -> Option<T> {
        result.map_err(|error| self.failures.push(error.into())).ok()
    }

    /// Writes a text.
    fn text(&mut self, name: &str, text: &str) {
        let folder = self.folder;
        self.write(|| folder.write(name, text.as_bytes()));
    }
}

/// Writes all files of a run, `whole` being its poses in the largest sub-map. The trajectories come first; plots and the journal, which
/// a run can do without, last. Returns the summary, and why files were not written.
pub(crate) fn write(
    job: &Job,
    notices: Vec<String>,
    finished: &Finished,
    whole: &Part<'_>,
    make_room: &dyn Fn(),
) -> (Summary, Vec<anyhow::Error>) {
    let (folder, outcome) = (&job.folder, &finished.outcome);
    let mut files = Files { folder, make_room, failures: Vec::new() };
    remove_old(folder);
    let (kitti, tum) = (folder.file("trajectory.kitti.txt"), folder.file("trajectory.tum.txt"));
    files.write(|| io::write_kitti(&kitti, &pose_per_frame(whole.frames)));
    let clock = job.session.input().clock();
    files.write(|| io::write_tum_at(&tum, &tracked_poses(whole.frames), clock));
    if job.sequence().kind == io::SequenceKind::VslamLab {
        let csv = folder.file("trajectory.vslamlab.csv");
        files.write(|| io::write_vslamlab(&csv, &tracked_poses(whole.frames), clock));
    }
    write_body(&mut files, job, "trajectory_body.tum.txt", whole.frames);
    let several = several_submaps(outcome.frames.as_slice());
    let parts: Vec<(String, Part<'_>)> =
        several.iter().map(|(root, frames)| (root.clone(), Part::new(frames, job))).collect();
    for (root, part) in &parts {
        files
            .write(|| io::write_tum_at(&folder.file(&submap_file(root)), &tracked_poses(part.frames), clock));
        write_body(&mut files, job, &format!("trajectory_body_submap_{root}.tum.txt"), part.frames);
    }
    let map = job.wishes.save_map.as_ref().and_then(|file| files.note(finished.save_map(file)));
    files.text("frames.csv", &frames_csv(&outcome.frames, clock));
    files.text("config.yaml", &job.session.input().config().to_yaml());
    let trajectory = std::fs::read(&kitti).ok().map(|bytes| dsslam::sha256(&bytes));
    let figures =
        parts.iter().map(|(root, part)| SubmapFigures::new(root, part.frames, part.evaluation.as_ref()));
    let (evaluation, checksums) = (whole.evaluation.as_ref(), [trajectory, map]);
    let summary = Summary::new(job, notices, outcome, evaluation, figures.collect(), checksums);
    write_json(&mut files, "summary.json", &summary);
    if let Some(errors) = whole.errors() {
        write_json(&mut files, "evaluation.json", errors);
    }
    files.text("loops.csv", &loops_csv(&outcome.loops));
    write_truth(&mut files, job, whole);
    files.text("timings.csv", &timings_csv(&outcome.timings));
    draw(&mut files, "trajectory.png", job, whole);
    for (root, part) in &parts {
        draw(&mut files, &format!("{SUBMAP_FILES}{root}.png"), job, part);
    }
    if let Some(file) = &job.wishes.journal {
        files.note(io::write_atomic(file, &outcome.journal.to_json()));
    }
    files.note(folder.link_latest());
    (summary, files.failures)
}

/// The frames of each sub-map by its name, where there are several.
fn several_submaps(frames: &[FrameRecord]) -> Vec<(String, Vec<FrameRecord>)> {
    let found = submaps(frames);
    if found.len() < 2 {
        return Vec::new();
    }
    let name = |submap: &Submap| submap.root.map_or("unknown".to_owned(), |root| root.to_string());
    found.into_iter().map(|submap| (name(&submap), of_submap(frames, submap))).collect()
}

/// Removes what an older run wrote into the folder and this one may not; there may be nothing.
fn remove_old(folder: &ResultsFolder) {
    let names =
        ["trajectory_body.tum.txt", "evaluation.json", TRUTH_FILE, TRUTH_OF_BODY_FILE, "trajectory.png"];
    for name in names {
        let _ = std::fs::remove_file(folder.file(name));
    }
    for entry in std::fs::read_dir(folder.path()).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(SUBMAP_FILES) || name.starts_with("trajectory_body_submap_") {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

fn write_json(files: &mut Files<'_>, name: &str, value: &impl Serialize) {
    let text = serde_json::to_string_pretty(value);
    if let Some(text) = files.note(text) {
        files.text(name, &(text + "\n"));
    }
}

/// The poses of the body, where it is not the left camera.
fn write_body(files: &mut Files<'_>, job: &Job, name: &str, frames: &[FrameRecord]) {
    let sequence = job.sequence();
    if let Some(body) = body_records(frames, sequence.sensor, &sequence.body_from_left) {
        let path = files.folder.file(name);
        let clock = job.session.input().clock();
        files.write(|| io::write_tum_at(&path, &tracked_poses(&body), clock));
    }
}

/// Writes the true poses of the left camera at all frames, and those of the body at the frames of the run, if there are any.
fn write_truth(files: &mut Files<'_>, job: &Job, whole: &Part<'_>) {
    let body = whole.compared.as_ref().filter(|compared| compared.subject == Subject::Body);
    let body = body.map(Compared::truth_at_frames).unwrap_or_default();
    for (name, truth) in [(TRUTH_FILE, true_poses(job)), (TRUTH_OF_BODY_FILE, body)] {
        if !truth.poses.is_empty() {
            let path = files.folder.file(name);
            files.write(|| io::write_tum_at(&path, &truth, job.session.input().clock()));
        }
    }
}

/// Draws the estimate, if there is one, aligned where that is possible, over the true path; frames without a pose are gaps.
fn draw(files: &mut Files<'_>, name: &str, job: &Job, part: &Part<'_>) {
    let sequence = &job.sequence().name;
    let mut title = sequence.clone();
    let (mut estimate, mut truth) = (positions(part.frames), Vec::new());
    if let Some((compared, errors)) = part.compared.as_ref().zip(part.errors()) {
        title = format!("{sequence}: ATE {:.3} m over {:.0} m", errors.ate_m.rmse, errors.path_m);
        estimate = positions(&compared.frames);
        estimate.iter_mut().flatten().for_each(|position| *position = errors.aligned(position));
        let last_time = part.frames.last().map_or(f64::INFINITY, |record| record.timestamp_s) + 0.5;
        let driven = compared.truth.poses.iter().filter(|pose| pose.timestamp_s <= last_time);
        truth = driven.map(|pose| pose.world_from_cam.translation).collect();
    }
    if estimate.iter().any(Option::is_some) {
        let draw = |path: &Path| save_png(path, &plot::trajectory(&title, &estimate, &truth, View::Top)?);
        let drawn = files.folder.write_with(name, draw).context("a plot");
        files.note(drawn);
    }
}

/// Where the frames are; `None` for those without a pose.
fn positions(frames: &[FrameRecord]) -> Vec<Option<Vec3>> {
    frames.iter().map(|record| Some(own_pose(record)?.translation)).collect()
}
