//! Datasets: which frames there are, their files and times, the camera, the ground truth. No pixel is read here.

mod associate;
mod calib;
mod camera_file;
mod cameras;
mod error;
mod euroc;
mod fields;
mod image_folder;
mod kitti;
mod numbered;
mod raw;
mod truth;
mod tum;
mod video;

use std::path::{Path, PathBuf};

use geometry::{Distortion, SE3, Sensor, StereoRig};

use crate::images::{ImageError, ImageSize, half_size, image_size};
use crate::trajectory::Trajectory;

pub use error::DatasetError;
pub use raw::{RawCalibration, RawCamera, RectifiedView};
pub use video::{Video, open_cameras, open_video};

/// The layout of a dataset's folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SequenceKind {
    /// KITTI odometry: `times.txt`, `calib.txt`, `image_0` and `image_1`, or `image_2` and `image_3`.
    Kitti,
    /// TUM RGB-D: `rgb.txt`, `depth.txt`.
    TumRgbd,
    /// EuRoC (ASL): `mav0/cam0`, `mav0/cam1`.
    Euroc,
    /// A video or a camera.
    Video,
    /// A rendered world: its frames are not files.
    Rendered,
    /// Images in the folder itself or in sub-folders for left and right, with a calibration file.
    Images,
}

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
    /// Seconds.
    pub timestamp_s: f64,
    /// Left or only image.
    pub left: PathBuf,
    /// Right image (stereo).
    pub right: Option<PathBuf>,
    /// Depth image (RGB-D).
    pub depth: Option<PathBuf>,
    /// What the file `left` holds.
    pub packing: Packing,
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
    /// Calibration file for a folder of images; `None`: the one in the folder, if there is one.
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
}

impl Sequence {
    /// One image file as a sequence of one frame, without a camera.
    pub fn of_image(file: &Path) -> Self {
        let (left, packing) = (file.to_path_buf(), Packing::Whole);
        Self {
            name: file.display().to_string(),
            kind: SequenceKind::Images,
            sensor: Sensor::Mono,
            frames: vec![FrameSource { index: 0, timestamp_s: 0.0, left, right: None, depth: None, packing }],
            calibration: None,
            raw_calibration: None,
            rectification: Vec::new(),
            ground_truth: None,
            body_from_left: SE3::identity(),
            frame_rate_hz: None,
            warnings: Vec::new(),
        }
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

/// Opens a dataset: recognizes its layout, lists its frames, reads calibration, times and ground truth.
///
/// # Errors
/// [`DatasetError`] for a missing or unknown folder, broken text files, or a sensor that the folder does not have.
pub fn open_sequence_with(dir: &Path, options: &OpenOptions) -> Result<Sequence, DatasetError> {
    if !dir.exists() {
        return Err(DatasetError::MissingFolder { path: dir.to_path_buf() });
    }
    if !dir.is_dir() {
        return Err(DatasetError::NotAFolder { path: dir.to_path_buf() });
    }
    if let Some(file) = options.calibration.clone().or_else(|| camera_file::find(dir)) {
        return image_folder::open(dir, Some(&file), options);
    }
    match layout_of(dir) {
        Some(SequenceKind::TumRgbd) => tum::open(dir, options),
        Some(SequenceKind::Kitti) => kitti::open(dir, options),
        Some(SequenceKind::Euroc) => {
            euroc::open(dir, &euroc::find_root(dir).unwrap_or_else(|| dir.to_path_buf()), options)
        }
        Some(_) => image_folder::open(dir, None, options),
        None => Err(DatasetError::UnknownLayout { path: dir.to_path_buf() }),
    }
}

/// The layout of a folder, from what lies in it; a calibration file in it makes it one of images, whatever else there is.
pub fn layout_of(dir: &Path) -> Option<SequenceKind> {
    if camera_file::find(dir).is_some() {
        Some(SequenceKind::Images)
    } else if dir.join("rgb.txt").exists() {
        Some(SequenceKind::TumRgbd)
    } else if kitti::is_kitti(dir) {
        Some(SequenceKind::Kitti)
    } else if euroc::find_root(dir).is_some() {
        Some(SequenceKind::Euroc)
    } else {
        image_folder::has_images(dir).then_some(SequenceKind::Images)
    }
}

/// The last part of a folder's path, also when it is given as `.` or ends in `..`.
fn folder_name(dir: &Path) -> String {
    let resolved = if dir.file_name().is_some() { Some(dir.to_path_buf()) } else { dir.canonicalize().ok() };
    resolved
        .as_deref()
        .and_then(Path::file_name)
        .map_or_else(|| "sequence".to_string(), |name| name.to_string_lossy().into_owned())
}
