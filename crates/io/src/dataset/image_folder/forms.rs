//! The forms that folders of images have: where left, right and depth images lie and how they are called; and what datasets of that form
//! say about their camera. [`FORMS`] is the whole table.

use std::path::{Path, PathBuf};

use geometry::Pinhole;

use super::super::layout::SequenceKind;
use super::names;
use crate::file::FileError;
use crate::images::ImageSize;
use crate::trajectory::TrajectoryFormat;

/// A folder, and how the names of its images begin and end (small letters, without what follows the last dot).
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) folder: &'static str,
    prefix: &'static str,
    suffix: &'static str,
}

/// A form of folders.
pub(super) struct Form {
    pub(super) kind: SequenceKind,
    left: Place,
    right: Option<Place>,
    depth: Option<Place>,
    /// Whether the left images alone are not of this form.
    needs_both: bool,
    /// Ground truth, if it is there.
    pub(super) truth: Option<(&'static str, TrajectoryFormat)>,
    /// Calibration files beyond the usual ones.
    pub(super) calibrations: &'static [&'static str],
    /// What the dataset's documentation says about its camera.
    pub(super) known: Option<Known>,
}

/// A dataset's camera, for images of this size.
pub(super) struct Known {
    pub(super) camera: Pinhole,
    pub(super) size: ImageSize,
    /// Of RGB-D: virtual.
    pub(super) baseline_m: f64,
    pub(super) depth_units_per_metre: Option<f64>,
    pub(super) frame_rate_hz: Option<f64>,
}

/// Lists the images of a folder.
type List = fn(&Path) -> Result<Vec<PathBuf>, FileError>;

/// A form with the images of a folder.
pub(in super::super) struct Tree {
    pub(in super::super) kind: SequenceKind,
    pub(super) form: &'static Form,
    /// Where the left images are.
    pub(super) folder: PathBuf,
    pub(super) left: Vec<PathBuf>,
    /// The folder of the right ones, with these.
    pub(super) right: Option<(PathBuf, Vec<PathBuf>)>,
    pub(super) depth: Option<(PathBuf, Vec<PathBuf>)>,
}

const fn in_folder(folder: &'static str) -> Place {
    Place { folder, prefix: "", suffix: "" }
}

const fn begins(folder: &'static str, prefix: &'static str) -> Place {
    Place { folder, prefix, suffix: "" }
}

const fn ends(suffix: &'static str) -> Place {
    Place { folder: "", prefix: "", suffix }
}

const fn plain(left: Place, right: Option<Place>, depth: Option<Place>, needs_both: bool) -> Form {
    let kind = SequenceKind::Images;
    let truth = Some(("groundtruth.txt", TrajectoryFormat::Tum));
    Form { kind, left, right, depth, needs_both, truth, calibrations: &[], known: None }
}

const fn stereo(left: &'static str, right: &'static str) -> Form {
    plain(in_folder(left), Some(in_folder(right)), None, false)
}

const fn rgbd(color: &'static str, depth: &'static str) -> Form {
    plain(in_folder(color), None, Some(in_folder(depth)), true)
}

const fn one_folder(left: Place, right: Place) -> Form {
    plain(left, Some(right), None, true)
}

const VGA: ImageSize = ImageSize { width: 640, height: 480 };

const TARTAN: Known = Known {
    camera: Pinhole { fx: 320.0, fy: 320.0, cx: 320.0, cy: 240.0 },
    size: VGA,
    baseline_m: 0.25,
    depth_units_per_metre: None,
    frame_rate_hz: None,
};

const fn tartan([left, right, depth]: [&'static str; 3], truth: &'static str) -> Form {
    Form {
        kind: SequenceKind::TartanAir,
        truth: Some((truth, TrajectoryFormat::Tum)),
        known: Some(TARTAN),
        ..plain(in_folder(left), Some(in_folder(right)), Some(in_folder(depth)), false)
    }
}

/// All forms, the most telling first.
static FORMS: [Form; 29] = [
    tartan(["image_left", "image_right", "depth_left"], "pose_left.txt"),
    tartan(["image_lcam_front", "image_rcam_front", "depth_lcam_front"], "pose_lcam_front.txt"),
    // The color camera of a Kinect as the dataset's page gives it; its depth is in millimeters.
    Form {
        kind: SequenceKind::SevenScenes,
        truth: None,
        known: Some(Known {
            camera: Pinhole { fx: 585.0, fy: 585.0, cx: 320.0, cy: 240.0 },
            size: VGA,
            baseline_m: 0.08,
            depth_units_per_metre: Some(1000.0),
            frame_rate_hz: Some(30.0),
        }),
        ..plain(ends(".color"), None, Some(ends(".depth")), true)
    },
    Form {
        kind: SequenceKind::Replica,
        truth: Some(("traj.txt", TrajectoryFormat::Kitti)),
        calibrations: &["cam_params.json", "../cam_params.json"],
        known: Some(Known {
            camera: Pinhole { fx: 600.0, fy: 600.0, cx: 599.5, cy: 339.5 },
            size: ImageSize { width: 1200, height: 680 },
            baseline_m: 0.08,
            depth_units_per_metre: Some(6553.5),
            frame_rate_hz: Some(30.0),
        }),
        ..plain(begins("results", "frame"), None, Some(begins("results", "depth")), true)
    },
    // The same with depth in the names of both, as 7-Scenes has them.
    Form {
        kind: SequenceKind::Replica,
        truth: Some(("traj.txt", TrajectoryFormat::Kitti)),
        calibrations: &["cam_params.json", "../cam_params.json"],
        ..plain(
            Place { folder: "results", prefix: "", suffix: ".color" },
            None,
            Some(Place { folder: "results", prefix: "", suffix: ".depth" }),
            true,
        )
    },
    rgbd("rgb", "depth"),
    rgbd("color", "depth"),
    rgbd("color", "aligned_depth"),
    rgbd("rgb", "aligned_depth"),
    rgbd("rgb_0", "depth_0"),
    rgbd("image", "depth"),
    stereo("left", "right"),
    stereo("image_0", "image_1"),
    stereo("cam0", "cam1"),
    stereo("infra1", "infra2"),
    stereo("infra_left", "infra_right"),
    stereo("left_images", "right_images"),
    stereo("images_left", "images_right"),
    stereo("left_image", "right_image"),
    stereo("rgb_0", "rgb_1"),
    stereo("cam_left", "cam_right"),
    stereo("Left", "Right"),
    one_folder(begins("", "left"), begins("", "right")),
    one_folder(begins("", "l_"), begins("", "r_")),
    one_folder(begins("", "infra1"), begins("", "infra2")),
    one_folder(ends("_left"), ends("_right")),
    one_folder(ends("-left"), ends("-right")),
    one_folder(ends("_l"), ends("_r")),
    plain(in_folder(""), None, None, false),
];

/// The form of a folder with its images, if it has any.
pub(in super::super) fn find(dir: &Path) -> Option<Tree> {
    let here = names::list(dir).unwrap_or_default();
    FORMS.iter().find_map(|form| form.of(dir, &here))
}

impl Form {
    /// This form's images of a folder in which `here` lies.
    fn of(&'static self, dir: &Path, here: &[PathBuf]) -> Option<Tree> {
        let left = self.left.list(dir, here, names::list).filter(|left| !left.is_empty())?;
        let other = |place: Option<Place>, list: List| {
            let place = place?;
            let images = place.list(dir, here, list).filter(|images| !images.is_empty())?;
            Some((place.path(dir), images))
        };
        let (right, depth) = (other(self.right, names::list), other(self.depth, names::list_depth));
        if self.needs_both && right.is_none() && depth.is_none() {
            return None;
        }
        Some(Tree { kind: self.kind, form: self, folder: self.left.path(dir), left, right, depth })
    }
}

impl Place {
    fn path(self, dir: &Path) -> PathBuf {
        if self.folder.is_empty() { dir.to_path_buf() } else { dir.join(self.folder) }
    }

    fn list(self, dir: &Path, here: &[PathBuf], list: List) -> Option<Vec<PathBuf>> {
        let all = if self.folder.is_empty() { here.to_vec() } else { list(&self.path(dir)).ok()? };
        let fits = |path: &PathBuf| {
            let stem = names::stem(path).to_ascii_lowercase();
            stem.starts_with(self.prefix) && stem.ends_with(self.suffix)
        };
        Some(all.into_iter().filter(fits).collect())
    }
}
