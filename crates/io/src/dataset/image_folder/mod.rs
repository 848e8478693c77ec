//! Folders of images with a calibration file: one camera, `left` and `right`, or two images side by side in each file.

mod names;

use std::path::{Path, PathBuf};

use super::camera_file::{self, CameraFile};
use super::cameras::Cameras;
use super::kitti::read_times;
use super::truth;
use super::{DatasetError, FrameSource, OpenOptions, Packing, Sensor, Sequence, SequenceKind, folder_name};
use crate::file::{FileError, counted};
use crate::images::{ImageSize, image_size};
use crate::trajectory::TrajectoryFormat;

/// Names of the sub-folders for the left and the right camera.
const PAIRS: [[&str; 2]; 3] = [["left", "right"], ["image_0", "image_1"], ["cam0", "cam1"]];

/// The images of a folder.
struct Images {
    /// Where the left ones are.
    folder: PathBuf,
    left: Vec<PathBuf>,
    /// The sub-folder of the right ones, with these.
    right: Option<(PathBuf, Vec<PathBuf>)>,
}

/// Whether a folder can be opened as one of images.
pub(super) fn has_images(dir: &Path) -> bool {
    Images::find(dir).is_ok_and(|images| !images.left.is_empty())
}

/// Opens a folder of images.
pub(super) fn open(
    dir: &Path,
    calibration: Option<&Path>,
    options: &OpenOptions,
) -> Result<Sequence, DatasetError> {
    let mut warnings = Vec::new();
    let images = Images::find(dir)?;
    if images.left.is_empty() {
        let expected = "images (PNG or JPEG) in the folder itself, or in left and right".to_string();
        return Err(DatasetError::NoImages { path: dir.to_path_buf(), expected });
    }
    let file = calibration.map(camera_file::read).transpose()?;
    if file.is_none() {
        warnings.push(format!(
            "{}: no calibration file, so the configuration must give the camera",
            dir.display()
        ));
    }
    let pictures = Pictures {
        place: dir,
        size: images.left.iter().find_map(|path| image_size(path).ok()),
        in_two_folders: images.right.is_some(),
    };
    let (sensor, packing) = choose(&pictures, file.as_ref(), options.sensor, &mut warnings)?;
    let rate = file.as_ref().and_then(|file| file.frame_rate_hz);
    let times_s = times(dir, images.left.len(), rate.unwrap_or(options.frame_rate_hz))?;
    let frames: Vec<FrameSource> = match (&images.right, sensor) {
        (Some(right), Sensor::Stereo) => pair_frames(&images, right, &times_s, &mut warnings)?,
        _ => images
            .left
            .iter()
            .enumerate()
            .map(|(i, path)| frame(i, times_s[i], path, None, packing))
            .collect(),
    };
    let cameras = file.as_ref().map_or(Ok(Cameras::default()), |file| file.cameras(sensor))?;
    let usual = [dir.join("groundtruth.txt")];
    let ground_truth = truth::read(options, &usual, TrajectoryFormat::Tum, &frames, &mut warnings)?;
    Ok(Sequence {
        name: folder_name(dir),
        kind: SequenceKind::Images,
        sensor,
        frames,
        calibration: cameras.calibration,
        raw_calibration: cameras.raw,
        rectification: cameras.views,
        ground_truth,
        body_from_left: cameras.body_from_left,
        frame_rate_hz: rate,
        warnings,
    })
}

impl Images {
    /// Sub-folders for left and right come before images in the folder itself.
    fn find(dir: &Path) -> Result<Self, FileError> {
        for [left, right] in PAIRS.map(|pair| pair.map(|name| dir.join(name))) {
            let images = names::list(&left)?;
            if !images.is_empty() {
                let right_images = names::list(&right)?;
                let right = Some((right, right_images)).filter(|(_, images)| !images.is_empty());
                return Ok(Self { folder: left, left: images, right });
            }
        }
        Ok(Self { folder: dir.to_path_buf(), left: names::list(dir)?, right: None })
    }
}

fn frame(index: usize, timestamp_s: f64, left: &Path, right: Option<&Path>, packing: Packing) -> FrameSource {
    FrameSource {
        index: u32::try_from(index).unwrap_or(u32::MAX),
        timestamp_s,
        left: left.to_path_buf(),
        right: right.map(Path::to_path_buf),
        depth: None,
        packing,
    }
}

/// What there is to choose from.
pub(super) struct Pictures<'a> {
    /// A folder or a video.
    pub(super) place: &'a Path,
    /// Size of the first one that can be read.
    pub(super) size: Option<ImageSize>,
    /// Whether there are right images in a folder of their own.
    pub(super) in_two_folders: bool,
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
    let unavailable =
        |sensor, reason| Err(DatasetError::SensorUnavailable { path: place.to_path_buf(), sensor, reason });
    if wanted == Some(Sensor::Rgbd) {
        return unavailable(Sensor::Rgbd, "image folders contain no depth".to_string());
    }
    let one_camera = file.filter(|file| file.cameras.len() == 1);
    if let (Some(Sensor::Stereo), Some(file)) = (wanted, one_camera) {
        return unavailable(Sensor::Stereo, format!("{} describes a single camera", file.source()));
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
        (None, Some(file)) if file.cameras.len() == 2 => {
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
    let [left, _] = &file.cameras[..] else { return false };
    size.is_some_and(|size| size.width == 2 * left.size.width && size.height == left.size.height)
}

/// `times.txt` if it is there, a line per left image; otherwise images come at the frame rate.
fn times(dir: &Path, n_images: usize, frame_rate_hz: f64) -> Result<Vec<f64>, DatasetError> {
    let path = dir.join("times.txt");
    if !path.exists() {
        return Ok((0..n_images).map(|i| i as f64 / frame_rate_hz).collect());
    }
    let times_s = read_times(&path)?;
    if times_s.len() == n_images {
        return Ok(times_s);
    }
    Err(DatasetError::TimesOfImages { path, found: counted(times_s.len(), "time"), n_images })
}

/// Frames out of the left images that have a right one.
fn pair_frames(
    images: &Images,
    (right_folder, right): &(PathBuf, Vec<PathBuf>),
    times_s: &[f64],
    warnings: &mut Vec<String>,
) -> Result<Vec<FrameSource>, DatasetError> {
    let pairs = names::pair(&images.left, right);
    if pairs.is_empty() {
        return Err(DatasetError::SensorUnavailable {
            path: images.folder.clone(),
            sensor: Sensor::Stereo,
            reason: format!(
                "no image number matches one in {} (first: {} and {})",
                right_folder.display(),
                images.left[0].display(),
                right[0].display()
            ),
        });
    }
    for (folder, n_images) in [(&images.folder, images.left.len()), (right_folder, right.len())] {
        let n_single = n_images - pairs.len();
        if n_single > 0 {
            warnings.push(format!(
                "{}: {n_single} of {} have no partner and are skipped",
                folder.display(),
                counted(n_images, "image")
            ));
        }
    }
    let made = pairs.iter().enumerate();
    Ok(made.map(|(i, (at, left, right))| frame(i, times_s[*at], left, Some(right), Packing::Whole)).collect())
}
