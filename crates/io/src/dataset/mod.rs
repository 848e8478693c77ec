//! Datasets: which frames there are, their files and times, the camera, the ground truth. No pixel is read here.

mod associate;
mod camera_file;
mod cameras;
mod error;
mod euroc;
mod given;
mod image_folder;
mod kitti;
mod layout;
mod numbered;
mod oxts;
mod raw;
pub(crate) mod stamps;
mod truth;
mod tum;
mod variant;
mod video;
mod vslamlab;

use std::path::{Path, PathBuf};

use geometry::{Distortion, SE3, Sensor, StereoRig};

use crate::file::FileError;
use crate::images::{ImageError, ImageSize, half_size, image_size, inspect};
use crate::trajectory::Trajectory;

pub use associate::associate;
pub use camera_file::{CameraFile, read_calibration};
pub use error::DatasetError;
pub use layout::{SequenceKind, layout_of};
pub use raw::{RawCalibration, RawCamera, RectifiedView};
pub use stamps::{nanoseconds_of, seconds};
pub use variant::{Variant, VariantError};
pub use video::{Video, open_cameras, open_video};

/// A camera as a dataset describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Intrinsics in pixels and baseline in meters; the baseline is 0 where a monocular dataset gives none.
    pub rig: StereoRig,
    /// Lens distortion; zero for rectified images.
    pub distortion: Distortion,
    /// Where it was read: a path, or the configuration.
    pub source: String,
}

/// What an image file holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Packing {
    /// One image.
    #[default]
    Whole,
    /// The left and the right image side by side, of which the left one is used.
    LeftHalf,
    /// The left and the right image side by side.
    BothHalves,
}

/// The files of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameSource {
    /// KITTI: the number in the file name; a number whose file is missing is kept, so that no frame is renumbered.
    /// TUM, EuRoC: the position among the frames, from 0.
    pub index: u32,
    /// Nanoseconds.
    pub timestamp_ns: i64,
    /// Left or only image.
    pub left: PathBuf,
    /// Right image (stereo).
    pub right: Option<PathBuf>,
    /// Depth image (RGB-D).
    pub depth: Option<PathBuf>,
    /// What the file `left` holds.
    pub packing: Packing,
}

/// Where the times of frames come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Times {
    /// The data give them: a list, or the stream of a camera.
    #[default]
    Given,
    /// The names of the images are times.
    Names,
    /// Nobody gives them: the frames are taken to come at an even rate.
    Invented,
}

/// A dataset, checked as far as that is possible without reading its images.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// The folder's name.
    pub name: String,
    /// Its layout.
    pub kind: SequenceKind,
    /// What is taken from it.
    pub sensor: Sensor,
    /// At least one frame, in order of time; none of a video or a camera, whose frames come from a stream.
    pub frames: Vec<FrameSource>,
    /// The camera, where the dataset has a calibration file.
    pub calibration: Option<Calibration>,
    /// The cameras before rectification, where the dataset describes such.
    pub raw_calibration: Option<RawCalibration>,
    /// What must be done to the images of each camera, the left one first, before `calibration` holds for them; empty where they
    /// are used as they are.
    pub rectification: Vec<RectifiedView>,
    /// Poses of the body in the world, where the dataset has them; the body is the left camera unless `body_from_left` says
    /// otherwise.
    pub ground_truth: Option<Trajectory>,
    /// Pose of the left camera, after rectification, in the body: `world_from_body = world_from_cam * body_from_left^-1`.
    pub body_from_left: SE3,
    /// Images per second, where a calibration file says so.
    pub frame_rate_hz: Option<f64>,
    /// Value of a depth image at one meter, where the dataset or its calibration says so.
    pub depth_units_per_metre: Option<f64>,
    /// Where the times come from.
    pub times: Times,
    /// What the user should know about the dataset before the run.
    pub warnings: Vec<String>,
}

/// How a dataset is opened.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenOptions {
    /// The sensor to use; `None`: the richest that the folder offers.
    pub sensor: Option<Sensor>,
    /// RGB-D: largest time between an image and its depth, seconds (exclusive).
    pub association_tolerance_s: f64,
    /// Calibration file that replaces the camera of the dataset; `None`: the one in the folder, if there is one.
    pub calibration: Option<PathBuf>,
    /// Images per second of a folder of images whose calibration does not tell.
    pub frame_rate_hz: f64,
    /// Ground truth, in any format of [`crate::read_trajectory`] and of the same body as the dataset's own (KITTI: camera 0);
    /// `None`: the dataset's own, if there is one.
    pub ground_truth: Option<PathBuf>,
}

impl Default for OpenOptions {
    fn default() -> Self {
        Self {
            sensor: None,
            association_tolerance_s: 0.02,
            calibration: None,
            frame_rate_hz: 10.0,
            ground_truth: None,
        }
    }
}

impl FrameSource {
    /// Size of the left image, from the header of its file.
    ///
    /// # Errors
    /// [`ImageError`] as far as the header shows it.
    pub fn image_size(&self) -> Result<ImageSize, ImageError> {
        let size = image_size(&self.left)?;
        match self.packing {
            Packing::Whole => Ok(size),
            Packing::LeftHalf | Packing::BothHalves => half_size(&self.left, size),
        }
    }

    /// A frame of one image.
    pub(crate) fn of(index: usize, timestamp_ns: i64, left: PathBuf) -> Self {
        Self {
            index: u32::try_from(index).unwrap_or(u32::MAX),
            timestamp_ns,
            left,
            right: None,
            depth: None,
            packing: Packing::Whole,
        }
    }

    /// The time in seconds.
    pub fn timestamp_s(&self) -> f64 {
        stamps::seconds(self.timestamp_ns)
    }
}

impl Sequence {
    /// A sequence of which nothing more is known: without frames, camera and ground truth.
    pub fn new(name: impl Into<String>, kind: SequenceKind, sensor: Sensor) -> Self {
        Self {
            name: name.into(),
            kind,
            sensor,
            frames: Vec::new(),
            calibration: None,
            raw_calibration: None,
            rectification: Vec::new(),
            ground_truth: None,
            body_from_left: SE3::identity(),
            frame_rate_hz: None,
            depth_units_per_metre: None,
            times: Times::Given,
            warnings: Vec::new(),
        }
    }

    /// One image file as a sequence of one frame, without a camera.
    pub fn of_image(file: &Path) -> Self {
        let frames = vec![FrameSource::of(0, 0, file.to_path_buf())];
        Self { frames, ..Self::new(file.display().to_string(), SequenceKind::Images, Sensor::Mono) }
    }

    /// Size of the sequence's images: that of the first frame whose header can be read, with its frame's position.
    ///
    /// # Errors
    /// The [`ImageError`] of the first frame when no frame has a readable header.
    pub fn image_size(&self) -> Result<(usize, ImageSize), ImageError> {
        let mut first_error = None;
        for (position, frame) in self.frames.iter().enumerate() {
            match frame.image_size() {
                Ok(size) => return Ok((position, size)),
                Err(error) => first_error = first_error.or(Some(error)),
            }
        }
        Err(first_error.unwrap_or_else(|| ImageError::Missing { path: PathBuf::from(&self.name) }))
    }
}

/// Opens a dataset with the default association tolerance (20 ms); see [`open_sequence_with`].
///
/// # Errors
/// [`DatasetError`].
pub fn open_sequence(dir: &Path, sensor: Option<Sensor>) -> Result<Sequence, DatasetError> {
    open_sequence_with(dir, &OpenOptions { sensor, ..OpenOptions::default() })
}

/// Opens a dataset: recognizes its layout, lists its frames, reads calibration, times and ground truth. A calibration file that
/// is given, or that lies in the folder under one of the usual names, replaces the camera and nothing else.
///
/// # Errors
/// [`DatasetError`] for a missing or unknown folder, broken text files, or a sensor that the folder does not have.
pub fn open_sequence_with(dir: &Path, options: &OpenOptions) -> Result<Sequence, DatasetError> {
    check_folder(dir)?;
    let mut warnings = Vec::new();
    let layout = layout::find(dir);
    let given = given::Given::find(dir, options, layout.as_ref(), &mut warnings)?;
    let mut sequence = match layout.ok_or_else(|| layout::unknown(dir))? {
        layout::Layout::Kitti(variant) => kitti::open(dir, &variant, options, &given)?,
        layout::Layout::Tum(lists) => tum::open(dir, &lists, options, &given)?,
        layout::Layout::Euroc(root) => euroc::open(dir, &root, options, &given)?,
        layout::Layout::VslamLab => vslamlab::open(dir, options, &given)?,
        layout::Layout::Images(tree) => image_folder::open(dir, &tree, options, &given)?,
    };
    stamps::drop_repeated(&mut sequence.frames, &mut sequence.warnings);
    given.finish(&mut sequence);
    inspect(&mut sequence)?;
    warnings.append(&mut sequence.warnings);
    Ok(Sequence { warnings, ..sequence })
}

/// The sensor asked for, or the richest that is possible. `no_right` and `no_depth` say why there are no right or depth images, `None`
/// where there are.
fn choose_sensor(
    place: &Path,
    wanted: Option<Sensor>,
    no_right: Option<String>,
    no_depth: Option<String>,
) -> Result<Sensor, DatasetError> {
    match (wanted, no_right, no_depth) {
        (Some(sensor @ Sensor::Stereo), Some(reason), _) | (Some(sensor @ Sensor::Rgbd), _, Some(reason)) => {
            Err(DatasetError::unavailable(place, sensor, reason))
        }
        (Some(sensor), ..) => Ok(sensor),
        (None, None, _) => Ok(Sensor::Stereo),
        (None, Some(_), None) => Ok(Sensor::Rgbd),
        (None, Some(_), Some(_)) => Ok(Sensor::Mono),
    }
}

/// What is said of a sequence that is monocular for want of a file or folder.
fn monocular(path: &Path, wanted: Option<Sensor>, sensor: Sensor, what: &str) -> Option<String> {
    let is_poorer = wanted.is_none() && sensor == Sensor::Mono;
    is_poorer.then(|| format!("{}: {what}, so the run is monocular", path.display()))
}

/// Whether there is a folder that may be read.
fn check_folder(dir: &Path) -> Result<(), DatasetError> {
    let path = dir.to_path_buf();
    if let Some(what) = layout::container(dir) {
        return Err(DatasetError::NotAFolder { path, what });
    }
    let unreadable = |reason: std::io::Error| FileError::Unreadable {
        path: dir.to_path_buf(),
        reason: reason.to_string(),
    };
    match std::fs::metadata(dir) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Err(missing(path)),
        Err(error) => Err(unreadable(error).into()),
        Ok(data) if !data.is_dir() => Err(DatasetError::NotAFolder { path, what: "not a folder" }),
        Ok(_) => std::fs::read_dir(dir).map(|_| ()).map_err(|error| unreadable(error).into()),
    }
}

/// The error of a path where nothing is: a file, if its name ends as one.
fn missing(path: PathBuf) -> DatasetError {
    if path.extension().is_none() {
        return DatasetError::NotAFolder { path, what: "no such folder" };
    }
    let expected = "a folder of images, a video or a bag".to_owned();
    FileError::Missing { path, expected }.into()
}

/// The last part of a folder's path, also when it is given as `.` or ends in `..`.
fn folder_name(dir: &Path) -> String {
    let resolved = if dir.file_name().is_some() { Some(dir.to_path_buf()) } else { dir.canonicalize().ok() };
    resolved
        .as_deref()
        .and_then(Path::file_name)
        .map_or_else(|| "sequence".to_string(), |name| name.to_string_lossy().into_owned())
}
