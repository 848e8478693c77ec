//! KITTI odometry folders: `times.txt`, `calib.txt`, `image_0`/`image_1` (gray) or `image_2`/`image_3` (color), poses.

use std::path::Path;

use geometry::{SE3, SO3};

use super::calib::{self, KittiCalibration};
use super::numbered::NumberedImages;
use super::truth;
use super::{DatasetError, FrameSource, OpenOptions, Packing, Sensor, Sequence, SequenceKind, folder_name};
use crate::file::{FileError, TextFile, counted};
use crate::trajectory::{StampedPose, Trajectory, TrajectoryFormat, check_increasing};

/// A pair of image folders with the names of their cameras in `calib.txt`.
struct Pair {
    left_folder: &'static str,
    right_folder: &'static str,
    left_camera: &'static str,
    right_camera: &'static str,
}

/// Gray first: no color conversion, and the ground truth is that of camera 0.
const PAIRS: [Pair; 2] = [
    Pair { left_folder: "image_0", right_folder: "image_1", left_camera: "P0", right_camera: "P1" },
    Pair { left_folder: "image_2", right_folder: "image_3", left_camera: "P2", right_camera: "P3" },
];

/// Images of the chosen pair.
struct Images {
    pair: &'static Pair,
    sensor: Sensor,
    left: NumberedImages,
    right: NumberedImages,
}

/// Whether a folder looks like a KITTI sequence.
pub(super) fn is_kitti(dir: &Path) -> bool {
    ["times.txt", "calib.txt", "image_0", "image_2"].iter().any(|name| dir.join(name).exists())
}

/// Opens a KITTI sequence.
pub(super) fn open(dir: &Path, options: &OpenOptions) -> Result<Sequence, DatasetError> {
    let mut warnings = Vec::new();
    let images = choose_images(dir, options.sensor, &mut warnings)?;
    let times_s = read_times(&dir.join("times.txt"))?;
    let n_frames = count_frames(dir, &images, times_s.len(), &mut warnings)?;
    let camera = read_camera(dir, &images, &mut warnings)?;
    let frames: Vec<FrameSource> = times_s[..n_frames]
        .iter()
        .zip(0..)
        .map(|(&timestamp_s, index)| FrameSource {
            index,
            timestamp_s,
            left: images.left.path(index),
            right: (images.sensor == Sensor::Stereo).then(|| images.right.path(index)),
            depth: None,
            packing: Packing::Whole,
        })
        .collect();
    let ground_truth = read_ground_truth(dir, options, &frames, camera.as_ref(), &mut warnings)?;
    Ok(Sequence {
        name: folder_name(dir),
        kind: SequenceKind::Kitti,
        sensor: images.sensor,
        frames,
        calibration: camera.map(|camera| camera.calibration),
        raw_calibration: None,
        rectification: Vec::new(),
        ground_truth,
        body_from_left: SE3::identity(),
        frame_rate_hz: None,
        warnings,
    })
}

/// The first pair that gives what is wanted; without a wish, stereo before mono.
fn choose_images(
    dir: &Path,
    wanted: Option<Sensor>,
    warnings: &mut Vec<String>,
) -> Result<Images, DatasetError> {
    let unavailable = |sensor, reason: String| {
        Err(DatasetError::SensorUnavailable { path: dir.to_path_buf(), sensor, reason })
    };
    if wanted == Some(Sensor::Rgbd) {
        return unavailable(Sensor::Rgbd, "KITTI folders contain no depth images".to_string());
    }
    let mut listed = Vec::new();
    for pair in &PAIRS {
        let left = NumberedImages::list(&dir.join(pair.left_folder))?;
        let right = NumberedImages::list(&dir.join(pair.right_folder))?;
        listed.push(Images { pair, sensor: Sensor::Stereo, left, right });
    }
    if wanted != Some(Sensor::Mono)
        && let Some(stereo) =
            listed.iter().position(|images| !images.left.is_empty() && !images.right.is_empty())
    {
        return Ok(listed.swap_remove(stereo));
    }
    let Some(mono) = listed.iter().position(|images| !images.left.is_empty()) else {
        let expected = "images such as 000000.png in image_0 or image_2".to_string();
        return Err(DatasetError::NoImages { path: dir.to_path_buf(), expected });
    };
    let images = Images { sensor: Sensor::Mono, ..listed.swap_remove(mono) };
    match wanted {
        Some(Sensor::Stereo) => {
            unavailable(Sensor::Stereo, format!("found no image in {}", images.pair.right_folder))
        }
        None => {
            warnings.push(format!(
                "{}: found no image, so the run is monocular",
                dir.join(images.pair.right_folder).display()
            ));
            Ok(images)
        }
        _ => Ok(images),
    }
}

/// Reads `times.txt`: a line per frame, seconds, strictly increasing.
pub(super) fn read_times(path: &Path) -> Result<Vec<f64>, FileError> {
    const EXPECTED: &str = "a time in seconds per line";
    let file = TextFile::read(path, EXPECTED)?;
    let mut times_s: Vec<f64> = Vec::new();
    for line in file.data_lines() {
        let [time_s] = line.numbers(line.text.split_whitespace(), EXPECTED)?;
        check_increasing(&line, times_s.last().copied(), time_s)?;
        times_s.push(time_s);
    }
    if times_s.is_empty() { Err(file.empty(EXPECTED)) } else { Ok(times_s) }
}

/// How many frames there are: up to the last image (pair), at most as many as times.
fn count_frames(
    dir: &Path,
    images: &Images,
    n_times: usize,
    warnings: &mut Vec<String>,
) -> Result<usize, DatasetError> {
    let left_folder = dir.join(images.pair.left_folder);
    let last_left = images.left.last().unwrap_or(0) as usize;
    let mut n_frames = last_left + 1;
    if n_times > n_frames {
        warnings.push(format!(
            "{}: {} but images only up to number {last_left} in {}; stopping there",
            dir.join("times.txt").display(),
            counted(n_times, "time"),
            images.pair.left_folder,
        ));
    } else if n_times < n_frames {
        warnings.push(format!(
            "{}: images up to number {last_left} but only {} in times.txt; stopping there",
            left_folder.display(),
            counted(n_times, "time"),
        ));
        n_frames = n_times;
    }
    if images.sensor == Sensor::Stereo {
        n_frames = end_at_last_pair(dir, images, n_frames, warnings)?;
    }
    Ok(n_frames)
}

/// A stereo run ends at the last number that both folders have.
fn end_at_last_pair(
    dir: &Path,
    images: &Images,
    n_frames: usize,
    warnings: &mut Vec<String>,
) -> Result<usize, DatasetError> {
    let end = u32::try_from(n_frames).unwrap_or(u32::MAX);
    let last_pair = (0..end).rev().find(|&number| images.left.has(number) && images.right.has(number));
    let Some(last_pair) = last_pair else {
        return Err(DatasetError::SensorUnavailable {
            path: dir.to_path_buf(),
            sensor: Sensor::Stereo,
            reason: format!(
                "no image number occurs in both {} and {}",
                images.pair.left_folder, images.pair.right_folder
            ),
        });
    };
    let n_pairs = last_pair as usize + 1;
    if n_pairs < n_frames {
        warnings.push(format!(
            "{}: {} for {} left ones; the stereo run ends at the last complete pair, number {last_pair}",
            dir.join(images.pair.right_folder).display(),
            counted(images.right.len(), "right image"),
            images.left.len(),
        ));
    }
    Ok(n_pairs)
}

/// The camera out of `calib.txt`; without the file the configuration must give it.
fn read_camera(
    dir: &Path,
    images: &Images,
    warnings: &mut Vec<String>,
) -> Result<Option<KittiCalibration>, DatasetError> {
    let path = dir.join("calib.txt");
    if !path.exists() {
        warnings.push(format!("{}: no such file, so the configuration must give the camera", path.display()));
        return Ok(None);
    }
    let right = (images.sensor == Sensor::Stereo).then_some(images.pair.right_camera);
    calib::read(&path, images.pair.left_camera, right).map(Some)
}

/// Poses of the left camera: those of camera 0, which the pose file holds, are moved where color is used.
fn read_ground_truth(
    dir: &Path,
    options: &OpenOptions,
    frames: &[FrameSource],
    camera: Option<&KittiCalibration>,
    warnings: &mut Vec<String>,
) -> Result<Option<Trajectory>, FileError> {
    let own = format!("{}.txt", folder_name(dir));
    let usual = [dir.join("poses.txt"), dir.join("../poses").join(&own), dir.join("../../poses").join(&own)];
    let mut ground_truth = truth::read(options, &usual, TrajectoryFormat::Kitti, frames, warnings)?;
    if let (Some(trajectory), Some(camera)) = (&mut ground_truth, camera) {
        let camera0_from_left = SE3::new(SO3::identity(), camera.left_in_camera0);
        for StampedPose { world_from_cam, .. } in &mut trajectory.poses {
            *world_from_cam = *world_from_cam * camera0_from_left;
        }
    }
    Ok(ground_truth)
}
