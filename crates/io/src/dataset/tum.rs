//! TUM RGB-D folders: `rgb.txt` and `depth.txt` list images with their times; `groundtruth.txt` if there.

use std::path::{Path, PathBuf};

use geometry::SE3;

use super::associate::associate;
use super::truth;
use super::{DatasetError, FrameSource, OpenOptions, Packing, Sensor, Sequence, SequenceKind, folder_name};
use crate::file::{FileError, TextFile, counted};
use crate::trajectory::{TrajectoryFormat, check_increasing};

const EXPECTED: &str = "a time in seconds and a file name per line";

/// One entry of a list.
struct Entry {
    timestamp_s: f64,
    path: PathBuf,
}

/// Opens a TUM RGB-D sequence.
pub(super) fn open(dir: &Path, options: &OpenOptions) -> Result<Sequence, DatasetError> {
    let mut warnings = Vec::new();
    let sensor = choose_sensor(dir, options.sensor, &mut warnings)?;
    let color = read_list(dir, "rgb.txt")?;
    let frames: Vec<FrameSource> = match sensor {
        Sensor::Rgbd => {
            let depth = read_list(dir, "depth.txt")?;
            pair_frames(dir, color, depth, options.association_tolerance_s, &mut warnings)?
        }
        _ => color
            .into_iter()
            .zip(0..)
            .map(|(entry, index)| FrameSource {
                index,
                timestamp_s: entry.timestamp_s,
                left: entry.path,
                right: None,
                depth: None,
                packing: Packing::Whole,
            })
            .collect(),
    };
    let usual = [dir.join("groundtruth.txt")];
    let ground_truth = truth::read(options, &usual, TrajectoryFormat::Tum, &frames, &mut warnings)?;
    Ok(Sequence {
        name: folder_name(dir),
        kind: SequenceKind::TumRgbd,
        sensor,
        frames,
        calibration: None,
        raw_calibration: None,
        rectification: Vec::new(),
        ground_truth,
        body_from_left: SE3::identity(),
        frame_rate_hz: None,
        warnings,
    })
}

fn choose_sensor(
    dir: &Path,
    wanted: Option<Sensor>,
    warnings: &mut Vec<String>,
) -> Result<Sensor, DatasetError> {
    let list = dir.join("depth.txt");
    match wanted {
        Some(Sensor::Stereo) => Err(DatasetError::SensorUnavailable {
            path: dir.to_path_buf(),
            sensor: Sensor::Stereo,
            reason: "TUM RGB-D folders contain no right images".to_string(),
        }),
        Some(sensor) => Ok(sensor),
        None if list.is_file() => Ok(Sensor::Rgbd),
        None => {
            warnings.push(format!("{}: no such file, so the run is monocular", list.display()));
            Ok(Sensor::Mono)
        }
    }
}

/// Reads a list of images: strictly increasing times and paths relative to the folder.
fn read_list(dir: &Path, name: &str) -> Result<Vec<Entry>, FileError> {
    let file = TextFile::read(&dir.join(name), EXPECTED)?;
    let mut entries: Vec<Entry> = Vec::new();
    for line in file.data_lines() {
        let mut fields = line.text.split_whitespace();
        let (Some(time), Some(image), None) = (fields.next(), fields.next(), fields.next()) else {
            let n_fields = line.text.split_whitespace().count();
            return Err(line.error(counted(n_fields, "field"), EXPECTED));
        };
        let timestamp_s = line.number(time)?;
        check_increasing(&line, entries.last().map(|entry| entry.timestamp_s), timestamp_s)?;
        entries.push(Entry { timestamp_s, path: dir.join(image) });
    }
    if entries.is_empty() { Err(file.empty(EXPECTED)) } else { Ok(entries) }
}

/// Frames out of the color images that have a depth image near in time.
fn pair_frames(
    dir: &Path,
    color: Vec<Entry>,
    depth: Vec<Entry>,
    tolerance_s: f64,
    warnings: &mut Vec<String>,
) -> Result<Vec<FrameSource>, DatasetError> {
    let times = |entries: &[Entry]| entries.iter().map(|entry| entry.timestamp_s).collect::<Vec<_>>();
    let partners = associate(&times(&color), &times(&depth), tolerance_s);
    let n_single = partners.iter().filter(|partner| partner.is_none()).count();
    let tolerance_ms = tolerance_s * 1e3;
    if n_single == color.len() {
        return Err(DatasetError::SensorUnavailable {
            path: dir.to_path_buf(),
            sensor: Sensor::Rgbd,
            reason: format!("no color image has a depth image within {tolerance_ms} ms"),
        });
    }
    if n_single > 0 {
        warnings.push(format!(
            "{}: {n_single} of {} have no depth image within {tolerance_ms} ms and are skipped",
            dir.join("rgb.txt").display(),
            counted(color.len(), "color image"),
        ));
    }
    let pairs = color.into_iter().zip(partners).filter_map(|(entry, partner)| Some((entry, partner?)));
    Ok(pairs
        .zip(0..)
        .map(|((entry, partner), index)| FrameSource {
            index,
            timestamp_s: entry.timestamp_s,
            left: entry.path,
            right: None,
            depth: Some(depth[partner].path.clone()),
            packing: Packing::Whole,
        })
        .collect())
}
