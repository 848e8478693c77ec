//! KITTI folders: odometry (`image_0`/`image_1` gray, `image_2`/`image_3` color), raw drives and KITTI-360, which differ in the names of
//! folders and in where times, calibration and poses lie.

use std::fs;
use std::path::{Path, PathBuf};

use geometry::{CameraModel, Distortion, SE3, SO3, Vec3};

use super::camera_file::kitti::{self as calib, KittiCalibration};
use super::cameras::Cameras;
use super::given::{Given, Own};
use super::layout::SequenceKind;
use super::numbered::NumberedImages;
use super::{
    DatasetError, FrameSource, OpenOptions, RawCamera, Sensor, Sequence, Times, folder_name, monocular, oxts,
    stamps, truth,
};
use crate::file::{FileError, counted};
use crate::images::image_size;
use crate::trajectory::{StampedPose, Trajectory, TrajectoryFormat};

/// A pair of image folders with the numbers of their cameras.
struct Pair {
    folders: [&'static str; 2],
    cameras: [usize; 2],
}

/// Gray first: no color conversion, and the ground truth is that of camera 0.
static ODOMETRY: [Pair; 2] = [
    Pair { folders: ["image_0", "image_1"], cameras: [0, 1] },
    Pair { folders: ["image_2", "image_3"], cameras: [2, 3] },
];
static RAW: [Pair; 2] = [
    Pair { folders: ["image_00/data", "image_01/data"], cameras: [0, 1] },
    Pair { folders: ["image_02/data", "image_03/data"], cameras: [2, 3] },
];
static THREE_SIXTY: [Pair; 1] =
    [Pair { folders: ["image_00/data_rect", "image_01/data_rect"], cameras: [0, 1] }];

/// One of the layouts, with the folder that holds the folders of images.
pub(super) struct Variant {
    pub(super) kind: SequenceKind,
    root: PathBuf,
    pairs: &'static [Pair],
}

/// Images of the chosen pair.
struct Images {
    pair: &'static Pair,
    sensor: Sensor,
    left: NumberedImages,
    right: NumberedImages,
}

/// What is known of the cameras, and where the left one stands in the frame of camera 0.
struct Eyes {
    sensor: Sensor,
    cameras: Cameras,
    left_in_camera0: Option<Vec3>,
}

impl Variant {
    /// The layout of a folder; of a raw drive also the folder of its date, and that of one of its cameras.
    pub(super) fn find(dir: &Path) -> Option<Self> {
        let has = |root: &Path, pairs: &[Pair]| pairs.iter().any(|pair| root.join(pair.folders[0]).is_dir());
        let lists = ["times.txt", "timestamps.txt", "calib.txt"];
        if has(dir, &ODOMETRY) && lists.iter().any(|name| dir.join(name).exists()) {
            return Some(Self { kind: SequenceKind::Kitti, root: dir.to_path_buf(), pairs: &ODOMETRY });
        }
        let around = [Some(dir.to_path_buf()), only_drive(dir), drive_around(dir)];
        around.into_iter().flatten().find_map(|root| {
            if has(&root, &RAW) {
                return Some(Self { kind: SequenceKind::KittiRaw, root, pairs: &RAW });
            }
            has(&root, &THREE_SIXTY).then_some(Self {
                kind: SequenceKind::Kitti360,
                root,
                pairs: &THREE_SIXTY,
            })
        })
    }

    /// A folder of which only a part is there.
    pub(super) fn of_remains(dir: &Path) -> Option<Self> {
        let is = ["times.txt", "calib.txt", "image_0", "image_2"].iter().any(|name| dir.join(name).exists());
        is.then(|| Self { kind: SequenceKind::Kitti, root: dir.to_path_buf(), pairs: &ODOMETRY })
    }

    /// The first of these files that exists, else the first one; the names are those in the folder.
    fn file(&self, names: &[&str]) -> PathBuf {
        let mut paths = names.iter().map(|name| self.root.join(name));
        paths.clone().find(|path| path.exists()).or(paths.next()).unwrap_or_else(|| self.root.clone())
    }
}

/// The only drive in the folder of a date.
fn only_drive(dir: &Path) -> Option<PathBuf> {
    let is_drive = |path: &PathBuf| RAW.iter().any(|pair| path.join(pair.folders[0]).is_dir());
    let mut drives: Vec<PathBuf> =
        fs::read_dir(dir).ok()?.flatten().map(|entry| entry.path()).filter(is_drive).collect();
    (drives.len() == 1).then(|| drives.remove(0))
}

/// The drive whose camera's folder this is.
fn drive_around(dir: &Path) -> Option<PathBuf> {
    let dir = dir.canonicalize().ok()?;
    let name = dir.file_name()?.to_str()?;
    let camera = if name == "data" || name == "data_rect" { dir.parent()? } else { &dir };
    camera.file_name()?.to_str()?.starts_with("image_0").then(|| camera.parent().map(Path::to_path_buf))?
}

/// Opens a KITTI sequence.
pub(super) fn open(
    dir: &Path,
    variant: &Variant,
    options: &OpenOptions,
    given: &Given,
) -> Result<Sequence, DatasetError> {
    let mut warnings = Vec::new();
    let root = &variant.root;
    let images = choose_images(variant, options.sensor, &mut warnings)?;
    let (folder, _) = images.pair.folders[0].split_once('/').unwrap_or((".", ""));
    let times_file = variant.file(&["times.txt", "timestamps.txt", &format!("{folder}/timestamps.txt")]);
    let are_invented = variant.kind != SequenceKind::Kitti && !times_file.exists();
    let times_ns = if are_invented {
        invented_times(&images, options.frame_rate_hz)
    } else {
        stamps::read_list(&times_file)?
    };
    let first = first_number(&images, times_ns.len());
    let n_frames = count_frames(root, &times_file, &images, first as usize + times_ns.len(), &mut warnings)?;
    let eyes = read_cameras(variant, &images, (options.sensor, given), &mut warnings)?;
    let numbers = first..u32::try_from(n_frames).unwrap_or(u32::MAX);
    let frames: Vec<FrameSource> = times_ns
        .iter()
        .zip(numbers)
        .map(|(&timestamp_ns, number)| FrameSource {
            right: (eyes.sensor == Sensor::Stereo).then(|| images.right.path(number)),
            ..FrameSource::of(number as usize, timestamp_ns, images.left.path(number))
        })
        .collect();
    let (ground_truth, body_from_camera0) = read_ground_truth(dir, variant, options, &frames, &mut warnings)?;
    let camera0_from_left = SE3::new(SO3::identity(), eyes.left_in_camera0.unwrap_or_default());
    let (ground_truth, body_from_left) = match body_from_camera0 {
        Some(body_from_camera0) => (ground_truth, body_from_camera0 * camera0_from_left),
        None => (ground_truth.map(|truth| moved(truth, &camera0_from_left)), SE3::identity()),
    };
    Ok(Sequence {
        frames,
        ground_truth,
        body_from_left,
        times: if are_invented { Times::Invented } else { Times::Given },
        warnings,
        ..Sequence::new(folder_name(root), variant.kind, eyes.sensor).seen_by(eyes.cameras)
    })
}

/// Times at an even rate for all numbers of the left images, of a raw drive that was laid out without its lists.
fn invented_times(images: &Images, rate_hz: f64) -> Vec<i64> {
    let (first, last) = (images.left.first().unwrap_or(0), images.left.last().unwrap_or(0));
    (0..=last - first).map(|i| stamps::nanoseconds(f64::from(i) / rate_hz)).collect()
}

/// The number of the first image, where there are as many times as numbers from it on; else 0.
fn first_number(images: &Images, n_times: usize) -> u32 {
    let first = images.left.first().unwrap_or(0);
    let n_numbers = images.left.last().map_or(0, |last| (last - first) as usize + 1);
    if n_numbers == n_times { first } else { 0 }
}

/// The first pair that gives what is wanted; without a wish, stereo before mono.
fn choose_images(
    variant: &Variant,
    wanted: Option<Sensor>,
    warnings: &mut Vec<String>,
) -> Result<Images, DatasetError> {
    let root = &variant.root;
    if wanted == Some(Sensor::Rgbd) {
        return Err(DatasetError::unavailable(root, Sensor::Rgbd, "KITTI folders contain no depth images"));
    }
    let mut listed = Vec::new();
    for pair in variant.pairs {
        let [left, right] = pair.folders.map(|folder| NumberedImages::list(&root.join(folder)));
        listed.push(Images { pair, sensor: Sensor::Stereo, left: left?, right: right? });
    }
    if wanted != Some(Sensor::Mono)
        && let Some(stereo) =
            listed.iter().position(|images| !images.left.is_empty() && !images.right.is_empty())
    {
        return Ok(listed.swap_remove(stereo));
    }
    let Some(mono) = listed.iter().position(|images| !images.left.is_empty()) else {
        let folders: Vec<&str> = variant.pairs.iter().map(|pair| pair.folders[0]).collect();
        let expected = format!("images such as 000000.png in {}", folders.join(" or "));
        return Err(DatasetError::unexpected(root, "no image", expected));
    };
    let images = Images { sensor: Sensor::Mono, ..listed.swap_remove(mono) };
    let right_folder = images.pair.folders[1];
    if wanted == Some(Sensor::Stereo) {
        let reason = format!("found no image in {right_folder}");
        return Err(DatasetError::unavailable(root, Sensor::Stereo, reason));
    }
    warnings.extend(monocular(&root.join(right_folder), wanted, Sensor::Mono, "found no image"));
    Ok(images)
}

/// How many frames there are: up to the last image (pair), at most as many as times.
fn count_frames(
    dir: &Path,
    times_file: &Path,
    images: &Images,
    n_times: usize,
    warnings: &mut Vec<String>,
) -> Result<usize, DatasetError> {
    let left_folder = dir.join(images.pair.folders[0]);
    let last_left = images.left.last().unwrap_or(0) as usize;
    let mut n_frames = last_left + 1;
    if n_times > n_frames {
        warnings.push(format!(
            "{}: {} but images only up to number {last_left} in {}; stopping there",
            times_file.display(),
            counted(n_times, "time"),
            images.pair.folders[0],
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
        let [left, right] = images.pair.folders;
        let reason = format!("no image number occurs in both {left} and {right}");
        return Err(DatasetError::unavailable(dir, Sensor::Stereo, reason));
    };
    let n_pairs = last_pair as usize + 1;
    if n_pairs < n_frames {
        warnings.push(format!(
            "{}: {} for {} left ones; the stereo run ends at the last complete pair, number {last_pair}",
            dir.join(images.pair.folders[1]).display(),
            counted(images.right.len(), "right image"),
            images.left.len(),
        ));
    }
    Ok(n_pairs)
}

/// The cameras of a given calibration file, else those of the layout's own; without either the configuration must give the camera.
fn read_cameras(
    variant: &Variant,
    images: &Images,
    (wanted, given): (Option<Sensor>, &Given),
    warnings: &mut Vec<String>,
) -> Result<Eyes, DatasetError> {
    let [left, right] = images.pair.cameras;
    let right = (images.sensor == Sensor::Stereo).then_some(right);
    let own_path = variant.file(&[
        "calib.txt",
        "calib_cam_to_cam.txt",
        "../calib_cam_to_cam.txt",
        "perspective.txt",
        "../calibration/perspective.txt",
        "../../calibration/perspective.txt",
    ]);
    // A file in KITTI's own form has a camera for each folder.
    let path =
        given.file.as_ref().filter(|file| file.is_kitti()).map_or(own_path, |file| file.path().to_path_buf());
    let own = if path.exists() { Some(calib::read_file(&path, left, right)?) } else { None };
    let of_images = image_size(&images.left.path(images.left.first().unwrap_or(0))).ok();
    let raw = own.as_ref().and_then(|own| pair_of(own, of_images?));
    let known = raw.as_ref().zip(own.as_ref());
    let known = known.map(|(pair, own)| Own { cameras: pair, source: &own.calibration.source });
    let left_in_camera0 = own.as_ref().map(|own| own.left_in_camera0);
    if !given.file.as_ref().is_some_and(|file| file.is_kitti())
        && let Some((sensor, cameras)) =
            given.replace((wanted, images.sensor), known, of_images, &variant.root, warnings)?
    {
        return Ok(Eyes { sensor, cameras, left_in_camera0 });
    }
    if own.is_none() {
        warnings.push(format!("{}: no such file, so the configuration must give the camera", path.display()));
    }
    let cameras = Cameras { calibration: own.map(|own| own.calibration), ..Cameras::default() };
    Ok(Eyes { sensor: images.sensor, cameras, left_in_camera0 })
}

/// The two rectified cameras of a calibration with a baseline.
fn pair_of(own: &KittiCalibration, size: crate::images::ImageSize) -> Option<Vec<RawCamera>> {
    let rig = own.calibration.rig;
    let model = CameraModel::Pinhole { camera: rig.camera, distortion: Distortion::default() };
    let at = |x: f64| SE3::new(SO3::identity(), Vec3::new(x, 0.0, 0.0));
    let camera = |x| RawCamera { model, size, body_from_cam: at(x) };
    (rig.baseline_m > 0.0).then(|| vec![camera(0.0), camera(rig.baseline_m)])
}

/// Poses of camera 0, or, with camera 0 in it, of the body of the inertial unit.
fn read_ground_truth(
    dir: &Path,
    variant: &Variant,
    options: &OpenOptions,
    frames: &[FrameSource],
    warnings: &mut Vec<String>,
) -> Result<(Option<Trajectory>, Option<SE3>), FileError> {
    let name = folder_name(&variant.root);
    let own = format!("{}.txt", folder_name(dir));
    let at = |path: &str| variant.root.join(path);
    let usual = match variant.kind {
        SequenceKind::Kitti360 => {
            let file = format!("data_poses/{name}/cam0_to_world.txt");
            vec![at("cam0_to_world.txt"), at(&format!("../{file}")), at(&format!("../../{file}"))]
        }
        _ => vec![at("poses.txt"), dir.join("../poses").join(&own), dir.join("../../poses").join(&own)],
    };
    let poses = truth::read(options, &usual, TrajectoryFormat::Kitti, frames, warnings)?;
    if poses.is_some() || variant.kind != SequenceKind::KittiRaw {
        return Ok((poses, None));
    }
    Ok(oxts::read(&variant.root, frames, warnings)
        .map_or((None, None), |(poses, body)| (Some(poses), Some(body))))
}

/// Poses of a place that moves with the camera.
fn moved(mut truth: Trajectory, camera0_from_left: &SE3) -> Trajectory {
    for StampedPose { world_from_cam, .. } in &mut truth.poses {
        *world_from_cam = *world_from_cam * *camera0_from_left;
    }
    truth
}
