//! Folders of images: of one camera, left and right, color and depth, or two images side by side in each file. [`forms`] has the names.

mod forms;
pub(super) mod names;

use std::path::{Path, PathBuf};

use geometry::{CameraModel, Distortion, Mat3, SE3, SO3, StereoRig, Vec3};

use super::associate::associate;
use super::camera_file::{CameraFile, read_calibration};
use super::cameras::Cameras;
use super::given::Given;
use super::layout::SequenceKind;
use super::stamps::{self, nanoseconds, seconds};
use super::{
    Calibration, DatasetError, FrameSource, OpenOptions, Packing, RawCalibration, RawCamera, Sensor,
    Sequence, Times, folder_name, truth,
};
use crate::file::counted;
use crate::images::{ImageSize, half_size, image_size};
use crate::trajectory::TrajectoryFormat;

use forms::Known;
pub(super) use forms::{Tree, find};

/// Opens a folder of images.
pub(super) fn open(
    dir: &Path,
    tree: &Tree,
    options: &OpenOptions,
    given: &Given,
) -> Result<Sequence, DatasetError> {
    let mut warnings = Vec::new();
    let own = match &given.file {
        Some(_) => None,
        None => tree.form.calibrations.iter().map(|name| dir.join(name)).find(|path| path.is_file()),
    };
    let own = own.map(|path| read_calibration(&path)).transpose()?;
    let file = given.file.as_ref().or(own.as_ref());
    let size = usual_size(&tree.left, file.and_then(CameraFile::size));
    let known = tree.form.known.as_ref().filter(|known| file.is_none() && size == Some(known.size));
    if file.is_none() && known.is_none() {
        warnings.push(format!(
            "{}: no calibration file, so the configuration must give the camera",
            dir.display()
        ));
    }
    let pictures =
        Pictures { place: dir, size, in_two_folders: tree.right.is_some(), has_depth: tree.depth.is_some() };
    let (sensor, packing) = choose(&pictures, file, options.sensor, &mut warnings)?;
    let rate = file.and_then(|file| file.frame_rate_hz).or(known.and_then(|known| known.frame_rate_hz));
    let (times_ns, times) = times(dir, tree, rate, options.frame_rate_hz, &mut warnings)?;
    let others = match sensor {
        Sensor::Stereo => tree.right.as_ref(),
        Sensor::Rgbd => tree.depth.as_ref(),
        Sensor::Mono => None,
    };
    let frames: Vec<FrameSource> = match others {
        Some(others) => pair_frames(tree, others, sensor, &times_ns, options, &mut warnings)?,
        None => {
            let all = tree.left.iter().zip(&times_ns).enumerate();
            all.map(|(i, (path, &ns))| FrameSource { packing, ..FrameSource::of(i, ns, path.clone()) })
                .collect()
        }
    };
    let of_one = match packing {
        Packing::Whole => size,
        Packing::LeftHalf | Packing::BothHalves => size.and_then(|size| half_size(dir, size).ok()),
    };
    let cameras = match (file, known) {
        (Some(file), _) => file.cameras(sensor, of_one)?,
        (None, Some(known)) => documented(known, tree.kind, sensor),
        (None, None) => Cameras::default(),
    };
    let ground_truth = match tree.kind {
        SequenceKind::SevenScenes if options.ground_truth.is_none() => {
            truth::of_files(&frames, &mut warnings)
        }
        _ => {
            let usual: Vec<PathBuf> = tree.form.truth.iter().map(|(name, _)| dir.join(name)).collect();
            let format = tree.form.truth.map_or(TrajectoryFormat::Tum, |(_, format)| format);
            truth::read(options, &usual, format, &frames, &mut warnings)?
        }
    };
    Ok(Sequence {
        frames,
        ground_truth,
        body_from_left: if tree.kind == SequenceKind::TartanAir {
            ned_from_cam()
        } else {
            cameras.body_from_left
        },
        frame_rate_hz: rate,
        depth_units_per_metre: file
            .and_then(|file| file.depth_units_per_metre)
            .or(known.and_then(|known| known.depth_units_per_metre)),
        times,
        warnings,
        ..Sequence::new(folder_name(dir), tree.kind, sensor).seen_by(cameras)
    })
}

/// The camera that a dataset's documentation gives.
fn documented(known: &Known, kind: SequenceKind, sensor: Sensor) -> Cameras {
    let source = format!("the documentation of {}", kind.name());
    let baseline_m = if sensor == Sensor::Mono { 0.0 } else { known.baseline_m };
    let model = CameraModel::Pinhole { camera: known.camera, distortion: Distortion::default() };
    let camera = RawCamera { model, size: known.size, body_from_cam: SE3::identity() };
    Cameras {
        calibration: Some(Calibration {
            rig: StereoRig { camera: known.camera, baseline_m },
            distortion: Distortion::default(),
            source: source.clone(),
        }),
        raw: Some(RawCalibration { cameras: vec![camera], source }),
        ..Cameras::default()
    }
}

/// TartanAir's poses are of a body with x forward, y right, z down, in which the camera (x right, y down, z forward) sits.
fn ned_from_cam() -> SE3 {
    let turn = Mat3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    SE3::new(SO3::from_matrix(&turn), Vec3::zeros())
}

/// The size that images have: that of the calibration where the first, middle or last one has it (also twice as wide), else that
/// of most of them.
fn usual_size(images: &[PathBuf], calibrated: Option<ImageSize>) -> Option<ImageSize> {
    /// Headers that are read.
    const LOOKED_AT: usize = 9;
    let step = images.len().div_ceil(LOOKED_AT).max(1);
    let sizes: Vec<ImageSize> =
        images.iter().step_by(step).filter_map(|path| image_size(path).ok()).collect();
    let fits = |size: &&ImageSize| calibrated.is_some_and(|calibrated| **size == calibrated);
    if let Some(size) = sizes.iter().find(fits) {
        return Some(*size);
    }
    let count = |size: &ImageSize| sizes.iter().filter(|other| *other == size).count();
    // The earliest of equally frequent ones.
    sizes.iter().rev().max_by_key(|size| count(size)).copied()
}

/// What there is to choose from.
pub(super) struct Pictures<'a> {
    /// A folder or a video.
    pub(super) place: &'a Path,
    /// Size of the images.
    pub(super) size: Option<ImageSize>,
    /// Whether there are right images as files of their own.
    pub(super) in_two_folders: bool,
    /// Whether there are depth images.
    pub(super) has_depth: bool,
}

/// What is used of the images, and what each of them holds.
///
/// # Errors
/// [`DatasetError::SensorUnavailable`].
pub(super) fn choose(
    pictures: &Pictures<'_>,
    file: Option<&CameraFile>,
    wanted: Option<Sensor>,
    warnings: &mut Vec<String>,
) -> Result<(Sensor, Packing), DatasetError> {
    let place = pictures.place;
    match (wanted, pictures.has_depth) {
        (Some(Sensor::Rgbd), true) => return Ok((Sensor::Rgbd, Packing::Whole)),
        // Of three, the two cameras are taken.
        (None, true) if !pictures.in_two_folders => return Ok((Sensor::Rgbd, Packing::Whole)),
        (Some(Sensor::Rgbd), false) => {
            return Err(DatasetError::unavailable(place, Sensor::Rgbd, "found no depth images"));
        }
        _ => {}
    }
    let one_camera = file.filter(|file| !file.has_pair());
    if let (Some(Sensor::Stereo), Some(file)) = (wanted, one_camera) {
        let reason = format!("{} describes a single camera", file.source());
        return Err(DatasetError::unavailable(place, Sensor::Stereo, reason));
    }
    if pictures.in_two_folders {
        if let (None, Some(file)) = (wanted, one_camera) {
            warnings.push(format!("{}: describes a single camera, so the run is monocular", file.source()));
        }
        let stereo = one_camera.is_none() && wanted != Some(Sensor::Mono);
        return Ok((if stereo { Sensor::Stereo } else { Sensor::Mono }, Packing::Whole));
    }
    let is_double = file.is_some_and(|file| holds_two(pictures.size, file));
    match (wanted, file) {
        (Some(Sensor::Mono), _) if is_double => Ok((Sensor::Mono, Packing::LeftHalf)),
        (None, Some(_)) if is_double => Ok((Sensor::Stereo, Packing::BothHalves)),
        // Without calibration the images are halved as wished; with one their size will be compared with it.
        (Some(Sensor::Stereo), _) => Ok((Sensor::Stereo, Packing::BothHalves)),
        (None, Some(file)) if file.has_pair() => {
            warnings.push(format!(
                "{}: found images of one camera although {} describes two, so the run is monocular",
                place.display(),
                file.source()
            ));
            Ok((Sensor::Mono, Packing::Whole))
        }
        _ => Ok((Sensor::Mono, Packing::Whole)),
    }
}

/// Whether images are twice as wide as the left one of two cameras.
fn holds_two(size: Option<ImageSize>, file: &CameraFile) -> bool {
    let (Some(size), Some(left)) = (size, file.size().filter(|_| file.has_pair())) else { return false };
    size.width == 2 * left.width && size.height == left.height
}

/// The times of the left images: those of `times.txt` or `timestamps.txt`, a line per image; else those in the names; else images come
/// at an even rate.
fn times(
    dir: &Path,
    tree: &Tree,
    known_rate_hz: Option<f64>,
    usual_rate_hz: f64,
    warnings: &mut Vec<String>,
) -> Result<(Vec<i64>, Times), DatasetError> {
    let n_images = tree.left.len();
    let lists = [dir.join("times.txt"), dir.join("timestamps.txt"), tree.folder.join("timestamps.txt")];
    if let Some(path) = lists.into_iter().find(|path| path.exists()) {
        let times_ns = stamps::read_list(&path)?;
        if times_ns.len() == n_images {
            return Ok((times_ns, Times::Given));
        }
        let expected = format!("{n_images} (one per image)");
        return Err(DatasetError::unexpected(&path, counted(times_ns.len(), "time"), expected));
    }
    let stems: Vec<String> = tree.left.iter().map(|path| names::stem(path)).collect();
    if let Some(times_ns) = stamps::of_names(stems.iter().map(String::as_str)) {
        warnings.push(format!("{}: the names of the images are taken as their times", tree.folder.display()));
        return Ok((times_ns, Times::Names));
    }
    let rate_hz = known_rate_hz.unwrap_or(usual_rate_hz);
    let times_ns = (0..n_images).map(|i| nanoseconds(i as f64 / rate_hz)).collect();
    Ok((times_ns, if known_rate_hz.is_some() { Times::Given } else { Times::Invented }))
}

/// Frames out of the left images that have a right one, or out of those of color that have one of depth.
fn pair_frames(
    tree: &Tree,
    (folder, others): &(PathBuf, Vec<PathBuf>),
    sensor: Sensor,
    times_ns: &[i64],
    options: &OpenOptions,
    warnings: &mut Vec<String>,
) -> Result<Vec<FrameSource>, DatasetError> {
    let by_time =
        (sensor == Sensor::Rgbd).then(|| pair_by_time(tree, others, options.association_tolerance_s));
    let pairs = by_time.flatten().unwrap_or_else(|| names::pair(&tree.left, others));
    if pairs.is_empty() {
        let [folder, left, other] = [folder, &tree.left[0], &others[0]].map(|path| path.display());
        let reason = format!("no image number matches one in {folder} (first: {left} and {other})");
        return Err(DatasetError::unavailable(&tree.folder, sensor, reason));
    }
    for (folder, n_images) in [(&tree.folder, tree.left.len()), (folder, others.len())] {
        let n_single = n_images - pairs.len();
        if n_single > 0 {
            warnings.push(format!(
                "{}: {n_single} of {} have no partner and are skipped",
                folder.display(),
                counted(n_images, "image")
            ));
        }
    }
    let frame = |(i, (at, left, other)): (usize, (usize, PathBuf, PathBuf))| {
        let frame = FrameSource::of(i, times_ns[at], left);
        match sensor {
            Sensor::Rgbd => FrameSource { depth: Some(other), ..frame },
            _ => FrameSource { right: Some(other), ..frame },
        }
    };
    Ok(pairs.into_iter().enumerate().map(frame).collect())
}

/// Pairs by the times in the names of both, which need not be equal.
fn pair_by_time(tree: &Tree, others: &[PathBuf], tolerance_s: f64) -> Option<Vec<(usize, PathBuf, PathBuf)>> {
    let times = |paths: &[PathBuf]| {
        let stems: Vec<String> = paths.iter().map(|path| names::stem(path)).collect();
        let times = stamps::of_names(stems.iter().map(String::as_str))?;
        Some(times.into_iter().map(seconds).collect::<Vec<f64>>())
    };
    let partners = associate(&times(&tree.left)?, &times(others)?, tolerance_s);
    let pair =
        |(i, partner): (usize, Option<usize>)| Some((i, tree.left[i].clone(), others[partner?].clone()));
    Some(partners.into_iter().enumerate().filter_map(pair).collect())
}
