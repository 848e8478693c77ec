//! A stream made out of the files of a finished run.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use dsslam::Config;
use eval::frames_table::cells;
use events::{
    Camera, Counts, DeltaOptions, DeltaTracker, End, FinalPose, FramePose, FrameRecord, FrameState, Pose,
    Record, StageTime, Start, Trust,
};
use geometry::{PoseCovariance, SE3};
use io::{StampedPose, TrajectoryFormat};
use map::KeyframeId;
use serde_json::Value;

use super::start::position;
use crate::outputs::{TRUTH_FILE, submap_file};

/// A row of `frames.csv`.
struct Row {
    index: u32,
    timestamp_s: f64,
    state: FrameState,
    submap: Option<u32>,
    inliers: u32,
    reason: String,
    trust: Option<Trust>,
}

/// What a results folder and a map's file tell.
///
/// # Errors
/// A file that is missing or does not hold what a run writes.
pub(super) fn records(folder: &Path, map: Option<&Path>) -> Result<Vec<Record>> {
    let summary: Value = serde_json::from_str(&read(folder, "summary.json")?)
        .with_context(|| folder.join("summary.json").display().to_string())?;
    let rows = rows(folder)?;
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
        let bytes = io::read_file(file).with_context(|| format!("{}: cannot be read", file.display()))?;
        let (map, _) = map::file::decode(&bytes).with_context(|| file.display().to_string())?;
        let first = rows.first().map_or(0, |row| row.index);
        records.push(Record::Map(DeltaTracker::new(DeltaOptions::default()).finish(&map, first)));
    }
    let mut stages = stages(folder)?;
    let mut trajectory = Vec::new();
    for (row, pose) in rows.iter().zip(&poses) {
        let world_from_cam = Pose::from(&pose.world_from_cam);
        if row.state == FrameState::Tracked {
            trajectory.push(FinalPose { frame: row.index, world_from_cam, submap: row.submap });
        }
        records.push(Record::Frame(frame(
            row,
            world_from_cam,
            stages.remove(&row.index).unwrap_or_default(),
        )));
    }
    records.push(Record::End(End { trajectory, summary: table(&summary), left_out: 0 }));
    Ok(records)
}

/// Where a run has several sub-maps, each frame gets its pose from the file of its own.
fn place_submaps(folder: &Path, rows: &[Row], poses: &mut [StampedPose]) -> Result<()> {
    let roots: BTreeSet<u32> = rows.iter().filter_map(|row| row.submap).collect();
    for root in roots {
        let file = folder.join(submap_file(&KeyframeId(root).to_string()));
        if !file.is_file() {
            continue;
        }
        let own = io::read_trajectory(&file, Some(TrajectoryFormat::Tum))?.trajectory.poses;
        let own: BTreeMap<u64, &StampedPose> =
            own.iter().map(|pose| (micros(pose.timestamp_s), pose)).collect();
        for (row, pose) in rows.iter().zip(poses.iter_mut()).filter(|(row, _)| row.submap == Some(root)) {
            if let Some(found) = own.get(&micros(row.timestamp_s)) {
                pose.world_from_cam = found.world_from_cam;
            }
        }
    }
    Ok(())
}

fn start(folder: &Path, summary: &Value, rows: &[Row]) -> Result<Start> {
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
    let by_time: BTreeMap<u64, u32> = rows.iter().map(|row| (micros(row.timestamp_s), row.index)).collect();
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

fn frame(row: &Row, world_from_cam: Pose, stages: Vec<StageTime>) -> FrameRecord {
    let cam_from_keyframe = Pose::from(&SE3::identity());
    let pose = FramePose { keyframe: None, cam_from_keyframe, scale: 1.0, world_from_cam };
    FrameRecord {
        index: row.index,
        timestamp_s: row.timestamp_s,
        state: row.state,
        reason: row.reason.clone(),
        pose: (row.state == FrameState::Tracked).then_some(pose),
        trust: row.trust,
        counts: Counts { inliers: row.inliers, ..Counts::default() },
        stages,
    }
}

/// `frames.csv`.
fn rows(folder: &Path) -> Result<Vec<Row>> {
    let name = "frames.csv";
    let row = |line: &str| -> Result<Row> {
        let cells = cells(line);
        let [index, time, state, submap, inliers, reason, ..] = &cells[..] else {
            bail!("{} cells, expected at least 6", cells.len())
        };
        let state = match state.as_str() {
            "tracked" => FrameState::Tracked,
            "not_ready" => FrameState::NotReady,
            "lost" => FrameState::Lost,
            "dropped" => FrameState::Dropped,
            other => bail!("state `{other}`, expected tracked, not_ready, lost or dropped"),
        };
        Ok(Row {
            index: index.parse().with_context(|| format!("frame `{index}`"))?,
            timestamp_s: time.parse().with_context(|| format!("time `{time}`"))?,
            state,
            submap: submap.strip_prefix('K').and_then(|id| id.parse().ok()),
            inliers: inliers.parse().unwrap_or(0),
            reason: reason.clone(),
            trust: trust(&cells).filter(|_| state == FrameState::Tracked),
        })
    };
    let text = read(folder, name)?;
    let lines = text.lines().enumerate().skip(1);
    lines
        .map(|(i, line)| row(line).with_context(|| format!("{} line {}", folder.join(name).display(), i + 1)))
        .collect()
}

/// Of the cells behind the reason; tables of older versions have none.
fn trust(cells: &[String]) -> Option<Trust> {
    let quality = cells.get(6)?.parse().ok()?;
    let numbers = cells.get(9..9 + PoseCovariance::N)?;
    let numbers: Option<Vec<f64>> = numbers.iter().map(|cell| cell.parse().ok()).collect();
    let triangle = numbers.and_then(|numbers| <[f64; PoseCovariance::N]>::try_from(numbers).ok());
    let covariance = triangle.and_then(|triangle| PoseCovariance::of_triangle(&triangle));
    let sigma = covariance.map(|c| [c.sigma_m().max() as f32, c.sigma_deg().max() as f32]);
    Some(Trust { quality, sigma })
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
