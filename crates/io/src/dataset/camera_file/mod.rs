//! Calibration files of cameras in the formats that people have: each is read into one value, then its fields are taken.
//!
//! A format is a file in this folder with `is` (does the file have it?) and `read`; [`FORMATS`] lists them.

mod boofcv;
mod colmap;
mod euroc;
mod folder;
mod kalibr;
pub(super) mod kitti;
mod lens;
mod nerf;
mod opencv;
mod orbslam;
mod own;
mod part;
mod ros;
mod vslamlab;
mod written;

use std::path::{Path, PathBuf};

use geometry::{CameraModel, Pinhole, SE3, Vec3};

use super::cameras::{Cameras, Origin};
use super::{DatasetError, RawCamera, Sensor};
use crate::document::{Field, Node, Value, parse};
use crate::file::{FileError, TextFile};
use crate::images::ImageSize;

const EXPECTED: &str = "the calibration of a camera";

/// Files that a folder of images may hold its calibration in, in the order of preference.
const NAMES: [&str; 4] = ["calibration.yaml", "calibration.yml", "stereo_params.xml", "transforms.json"];

/// How a format of structured files is known and read.
struct Format {
    name: &'static str,
    is: fn(&Field<'_>) -> bool,
    read: fn(&Field<'_>) -> Result<CameraFile, DatasetError>,
}

/// The formats, the most telling first.
const FORMATS: [Format; 11] = [
    Format { name: "BoofCV (XML)", is: boofcv::is, read: boofcv::read },
    Format { name: "VSLAM-LAB", is: vslamlab::is, read: vslamlab::read },
    Format { name: "our YAML (cameras)", is: own::is, read: own::read },
    Format { name: "Kalibr camchain (cam0)", is: kalibr::is, read: kalibr::read },
    Format {
        name: "ORB-SLAM2 or ORB-SLAM3 settings (Camera.fx, Camera1.fx)",
        is: orbslam::is,
        read: orbslam::read,
    },
    Format { name: "ROS camera_info (camera_matrix, image_width)", is: ros::is, read: ros::read },
    Format { name: "OpenCV FileStorage, YAML, XML or JSON (K, D, R, T)", is: opencv::is, read: opencv::read },
    Format { name: "EuRoC sensor.yaml (camera_model, intrinsics)", is: euroc::is, read: euroc::read },
    Format { name: "nerfstudio transforms.json (fl_x)", is: nerf::is, read: nerf::read },
    Format { name: "Replica cam_params.json (camera.fx)", is: nerf::is_replica, read: nerf::read_replica },
    Format { name: "RealSense intrinsics (fx, fy, ppx, ppy)", is: nerf::is_flat, read: nerf::read_flat },
];

/// The formats of plain text.
const TEXT_FORMATS: [&str; 2] = ["COLMAP cameras.txt", "KITTI calib.txt or calib_cam_to_cam.txt"];

/// A camera of a calibration file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FileCamera {
    pub(super) model: CameraModel,
    /// Size of its images, where the file tells.
    pub(super) size: Option<ImageSize>,
    /// Pose of the camera in the body; the body is the left camera where the file knows no other.
    pub(super) body_from_cam: SE3,
}

/// What a calibration file tells.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraFile {
    /// The file that errors and notices name.
    path: PathBuf,
    /// What its format is called.
    pub format: &'static str,
    /// One camera, or the left and the right one.
    pub(super) cameras: Vec<FileCamera>,
    /// Images per second.
    pub frame_rate_hz: Option<f64>,
    /// Value of a depth image at one meter.
    pub depth_units_per_metre: Option<f64>,
    /// Distance of two cameras with one and the same lens, of which the file gives one; virtual for RGB-D. Meters.
    pub baseline_m: Option<f64>,
    /// Whether fy was negative: its coordinates have y up, and so has its ground truth (ICL-NUIM).
    pub(super) y_up: bool,
    /// How the file was understood where it could be understood otherwise.
    pub notes: Vec<String>,
    /// Names of the fields with the right camera's image size and place.
    right_fields: (&'static str, &'static str),
}

/// The calibration file of a folder, if it holds one.
pub(super) fn find(folder: &Path) -> Option<PathBuf> {
    NAMES.iter().map(|name| folder.join(name)).find(|path| path.is_file())
}

/// Reads a calibration file; its content tells the format. Of a folder, its cameras' files in EuRoC's layout are read.
///
/// # Errors
/// [`DatasetError`] naming the field, what was found and what was expected; for an unknown format all that are read.
pub fn read_calibration(path: &Path) -> Result<CameraFile, DatasetError> {
    if path.is_dir() {
        return folder::read(path);
    }
    let unknown = |found: String| {
        let formats: Vec<&str> = FORMATS.iter().map(|format| format.name).chain(TEXT_FORMATS).collect();
        let expected = format!("one of these calibrations: {}", formats.join(", "));
        DatasetError::unexpected(path, found, expected)
    };
    let file = TextFile::read(path, EXPECTED).map_err(|error| match error {
        FileError::NotText { .. } => unknown("a file that is not text".to_owned()),
        other => other.into(),
    })?;
    let Some(first) = file.data_lines().next() else { return Err(file.empty(EXPECTED).into()) };
    if kitti::is(&first) {
        return kitti::read(&file);
    }
    if colmap::is(&first) {
        return colmap::read(&file);
    }
    let document = parse(&file).map_err(|error| DatasetError::syntax(path, error))?;
    of_document(path, &document)?.ok_or_else(|| unknown(outline(&document)))
}

/// A picture whose y axis points up (fy below 0, as renderers have it) is that of a camera whose y axis points down.
fn upright(mut file: CameraFile) -> CameraFile {
    for camera in &mut file.cameras {
        let pinhole = *camera.model.pinhole();
        if pinhole.fy < 0.0 {
            camera.model = camera.model.with_pinhole(Pinhole { fy: -pinhole.fy, ..pinhole });
            file.y_up = true;
        }
    }
    if file.y_up {
        file.notes.push(format!(
            "{}: fy is negative, so y points up there; the camera is used with y down, and the ground truth is turned accordingly",
            file.path.display()
        ));
    }
    file
}

/// The calibration in a document, if its format is known.
fn of_document(path: &Path, document: &Node) -> Result<Option<CameraFile>, DatasetError> {
    let root = Field::root(path, document);
    // What OpenCV writes as XML stands in one outermost element.
    let root = root.inner("opencv_storage").there().unwrap_or(root);
    let Some(format) = FORMATS.iter().find(|format| (format.is)(&root)) else { return Ok(None) };
    (format.read)(&root).map(|file| Some(upright(file)))
}

/// The names at the top of a document.
fn outline(document: &Node) -> String {
    const SHOWN: usize = 12;
    match &document.value {
        Value::Section(entries) => {
            let names: Vec<&str> = entries.iter().map(|(name, _)| name.as_str()).take(SHOWN).collect();
            let more = if entries.len() > SHOWN { ", ..." } else { "" };
            format!("the fields {}{more}", names.join(", "))
        }
        Value::List(items) => format!("a list of {}", items.len()),
        _ => "text without fields".to_owned(),
    }
}

impl CameraFile {
    /// A file that gives cameras and nothing else.
    fn new(path: &Path, format: &'static str, cameras: Vec<FileCamera>) -> Self {
        Self {
            path: path.to_path_buf(),
            format,
            cameras,
            frame_rate_hz: None,
            depth_units_per_metre: None,
            baseline_m: None,
            y_up: false,
            notes: Vec::new(),
            right_fields: ("resolution", "the place of the right camera"),
        }
    }

    /// Whether it has KITTI's form, with cameras for gray and for color.
    pub(super) fn is_kitti(&self) -> bool {
        self.format == kitti::FORMAT
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether two cameras are known.
    pub(super) fn has_pair(&self) -> bool {
        self.cameras.len() > 1 || self.baseline_m.is_some()
    }

    /// Size of the left camera's images, where the file tells.
    pub(super) fn size(&self) -> Option<ImageSize> {
        self.cameras.first()?.size
    }

    /// The left camera, or it and the right one; `images`: the size of the images where the file does not tell it.
    ///
    /// # Errors
    /// [`DatasetError`] where nobody knows the size.
    pub(super) fn raw(
        &self,
        sensor: Sensor,
        images: Option<ImageSize>,
    ) -> Result<Vec<RawCamera>, DatasetError> {
        let raw = |camera: &FileCamera| {
            let size = camera.size.or(images).ok_or_else(|| {
                let found = "nothing, nor an image that can be read";
                DatasetError::in_field(&self.path, "resolution", found, "width and height in pixels")
            })?;
            Ok(RawCamera { model: camera.model, size, body_from_cam: camera.body_from_cam })
        };
        let mut cameras = self.cameras.iter().take(2).map(raw).collect::<Result<Vec<_>, DatasetError>>()?;
        if sensor != Sensor::Stereo {
            cameras.truncate(1);
        } else if let ([left], Some(baseline_m)) = (&cameras[..], self.baseline_m) {
            let right_in_left = SE3::new(Default::default(), Vec3::new(baseline_m, 0.0, 0.0));
            cameras.push(RawCamera { body_from_cam: left.body_from_cam * right_in_left, ..left.clone() });
        }
        Ok(cameras)
    }

    /// What becomes of the cameras that a sensor uses; the body is the left camera.
    ///
    /// # Errors
    /// [`DatasetError`] for stereo with one camera, and for cameras that cannot be rectified.
    pub(super) fn cameras(&self, sensor: Sensor, images: Option<ImageSize>) -> Result<Cameras, DatasetError> {
        let mut cameras = self.in_body(sensor, images)?;
        cameras.body_from_left = SE3::identity();
        Ok(cameras)
    }

    /// As [`CameraFile::cameras`], with the body of the file.
    pub(super) fn in_body(&self, sensor: Sensor, images: Option<ImageSize>) -> Result<Cameras, DatasetError> {
        self.rectified(self.raw(sensor, images)?, sensor)
    }

    /// What becomes of these cameras; errors name this file.
    pub(super) fn rectified(&self, cameras: Vec<RawCamera>, sensor: Sensor) -> Result<Cameras, DatasetError> {
        let (size_field, pose_field) = self.right_fields;
        let origin = Origin { left: &self.path, right: &self.path, size_field, pose_field };
        let mut cameras = match (sensor, &cameras[..]) {
            (Sensor::Stereo, [left, right, ..]) => Cameras::of_pair(left.clone(), right.clone(), &origin)?,
            (_, [left, ..]) => Cameras::of_one(left.clone(), &self.path)?,
            (_, []) => Cameras::default(),
        };
        if let (Sensor::Rgbd, Some(baseline_m), Some(calibration)) =
            (sensor, self.baseline_m, &mut cameras.calibration)
        {
            calibration.rig.baseline_m = baseline_m;
        }
        Ok(cameras)
    }

    /// The file, as messages name it.
    pub(super) fn source(&self) -> String {
        self.path.display().to_string()
    }
}
