//! A stream made out of the files of a finished run.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use dsslam::Config;
use eval::frames_table::{FrameRow, read_frames};
use events::{
    Camera, Counts, DeltaOptions, DeltaTracker, End, FinalPose, FramePose, FrameRecord, FrameState, Pose,
    Record, StageTime, Start, Trust,
};
use geometry::SE3;
use io::{StampedPose, TrajectoryFormat};
use serde_json::Value;

use super::start::position;
use crate::export;
use crate::outputs::{TRUTH_FILE, submap_file};

/// What a results folder and a map's file tell.
///
/// # Errors
/// A file that is missing or does not hold what a run writes.
pub(super) fn records(folder: &Path, map: Option<&Path>) -> Result<Vec<Record>> {
    let summary: Value = serde_json::from_str(&read(folder, "summary.json")?)
        .with_context(|| folder.join("summary.json").display().to_string())?;
    let file = folder.join("frames.csv");
    let rows = read_frames(&file)?;
    let state = |(i, row): (usize, &FrameRow)| {
        state(row).with_context(|| format!("{} line {}", file.display(), i + 2))
    };
    let states = rows.iter().enumerate().map(state).collect::<Result<Vec<_>>>()?;
    let trajectory = folder.join("trajectory.kitti.txt");
    let mut poses = io::read_trajectory(&trajectory, Some(TrajectoryFormat::Kitti))?.trajectory.poses;
    ensure!(
        poses.len() == rows.len(),
        "{}: {} rows, expected one for each of the {} frames in frames.csv",
        trajectory.display(),
        poses.len(),
        rows.len()
    );
    place_submaps(folder, &rows, &mut poses)?;
    let mut records = vec![Record::Start(start(folder, &summary, &rows)?)];
    if let Some(file) = map {
        let (map, _) = export::read(file)?;
        let first = rows.first().map_or(0, |row| row.frame);
        records.push(Record::Map(DeltaTracker::new(DeltaOptions::default()).finish(&map, first)));
    }
    let mut stages = stages(folder)?;
    let mut trajectory = Vec::new();
    for ((row, &state), pose) in rows.iter().zip(&states).zip(&poses) {
        let world_from_cam = Pose::from(&pose.world_from_cam);
        if state == FrameState::Tracked {
            trajectory.push(FinalPose { frame: row.frame, world_from_cam, submap: submap(row) });
        }
        let stages = stages.remove(&row.frame).unwrap_or_default();
        records.push(Record::Frame(frame(row, state, world_from_cam, stages)));
    }
    records.push(Record::End(End { trajectory, summary: table(&summary), left_out: 0 }));
    Ok(records)
}

/// Where a run has several sub-maps, each frame gets its pose from the file of its own.
fn place_submaps(folder: &Path, rows: &[FrameRow], poses: &mut [StampedPose]) -> Result<()> {
    let roots: BTreeSet<&str> = rows.iter().map(|row| row.submap.as_str()).collect();
    for root in roots.into_iter().filter(|root| !root.is_empty()) {
        let file = folder.join(submap_file(root));
        if !file.is_file() {
            continue;
        }
        let own = io::read_trajectory(&file, Some(TrajectoryFormat::Tum))?.trajectory.poses;
        let own: BTreeMap<u64, &StampedPose> =
            own.iter().map(|pose| (micros(pose.timestamp_s), pose)).collect();
        for (row, pose) in rows.iter().zip(poses.iter_mut()).filter(|(row, _)| row.submap == root) {
            if let Some(found) = own.get(&micros(row.timestamp_s)) {
                pose.world_from_cam = found.world_from_cam;
            }
        }
    }
    Ok(())
}

fn start(folder: &Path, summary: &Value, rows: &[FrameRow]) -> Result<Start> {
    let text = |key: &str| summary[key].as_str().unwrap_or("?").to_owned();
    let config = Config::load(Some(&folder.join("config.yaml")), &[])?.camera;
    let value = |number: Option<f64>| number.unwrap_or(1.0);
    let center = [value(config.cx), value(config.cy)];
    // Where the size is that of the images, the principal point lies near their middle.
    let size = |given: Option<usize>, center: f64| given.map_or(2.0 * center, |n| n as f64) as u32;
    let truth = folder.join(TRUTH_FILE);
    let truth = if truth.is_file() {
        io::read_trajectory(&truth, Some(TrajectoryFormat::Tum))?.trajectory.poses
    } else {
        Vec::new()
    };
    let by_time: BTreeMap<u64, u32> = rows.iter().map(|row| (micros(row.timestamp_s), row.frame)).collect();
    let of_frame = |pose: &io::StampedPose| Some(position(*by_time.get(&micros(pose.timestamp_s))?, pose));
    Ok(Start {
        program_version: text("version"),
        sequence: text("sequence"),
        sensor: text("sensor").parse().context("sensor in the summary")?,
        camera: Camera {
            focal: [value(config.fx), value(config.fy)],
            center,
            size: [size(config.width, center[0]), size(config.height, center[1])],
        },
        n_frames: u32::try_from(rows.len()).unwrap_or(u32::MAX),
        truth: truth.iter().filter_map(of_frame).collect(),
    })
}

/// A time that is the same in files with more and fewer decimals.
fn micros(seconds: f64) -> u64 {
    (seconds * 1e6).round().max(0.0) as u64
}

fn frame(row: &FrameRow, state: FrameState, world_from_cam: Pose, stages: Vec<StageTime>) -> FrameRecord {
    let cam_from_keyframe = Pose::from(&SE3::identity());
    let pose = FramePose { keyframe: None, cam_from_keyframe, scale: 1.0, world_from_cam };
    let is_tracked = state == FrameState::Tracked;
    FrameRecord {
        index: row.frame,
        timestamp_s: row.timestamp_s,
        state,
        reason: row.reason.clone(),
        pose: is_tracked.then_some(pose),
        trust: row.quality.filter(|_| is_tracked).map(|quality| Trust::new(quality, row.covariance.as_ref())),
        counts: Counts { inliers: row.inliers, ..Counts::default() },
        stages,
    }
}

fn state(row: &FrameRow) -> Result<FrameState> {
    let expected = || format!("state `{}`, expected tracked, not_ready, lost or dropped", row.state);
    FrameState::of_key(&row.state).with_context(expected)
}

fn submap(row: &FrameRow) -> Option<u32> {
    row.submap.strip_prefix('K')?.parse().ok()
}

/// `timings.csv` by frame.
fn stages(folder: &Path) -> Result<BTreeMap<u32, Vec<StageTime>>> {
    let text = read(folder, "timings.csv")?;
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').skip(1).collect();
    let row = |line: &str| {
        let mut cells = line.split(',');
        let index = cells.next()?.parse().ok()?;
        let times = names
            .iter()
            .zip(cells)
            .filter_map(|(name, cell)| Some(StageTime { name: (*name).to_owned(), ms: cell.parse().ok()? }));
        Some((index, times.collect()))
    };
    Ok(lines.filter_map(row).collect())
}

fn read(folder: &Path, name: &str) -> Result<String> {
    let path = folder.join(name);
    io::check_file(&path)
        .and_then(|_| fs::read_to_string(&path))
        .with_context(|| format!("{}: cannot be read; `dsslam run` writes it", path.display()))
}

/// The numbers of the summary as Markdown.
fn table(summary: &Value) -> String {
    let mut text = String::from("| | |\n|---|---|\n");
    for (key, value) in summary.as_object().into_iter().flatten() {
        match value {
            Value::Null | Value::Array(_) | Value::Object(_) => {}
            Value::String(value) => text.push_str(&format!("| {key} | {value} |\n")),
            value => text.push_str(&format!("| {key} | {value} |\n")),
        }
    }
    text
}
