//! Which layout a folder has, from what lies in it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::image_folder::Tree;
use super::kitti::Variant;
use super::tum::Lists;
use super::{DatasetError, euroc, image_folder};

/// The layout of a dataset's folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SequenceKind {
    /// KITTI odometry: `times.txt`, `calib.txt`, `image_0` and `image_1`, or `image_2` and `image_3`.
    Kitti,
    /// A KITTI raw drive: `image_00/data` with `timestamps.txt`.
    KittiRaw,
    /// KITTI-360: `image_00/data_rect`.
    Kitti360,
    /// TUM RGB-D and OpenLORIS: lists of color and of depth images, or of both.
    TumRgbd,
    /// EuRoC (ASL) and TUM-VI: `mav0/cam0`, `mav0/cam1`.
    Euroc,
    /// TartanAir: `image_left`, `pose_left.txt`.
    TartanAir,
    /// 7-Scenes: `frame-000000.color.png`, `.depth.png`, `.pose.txt`.
    SevenScenes,
    /// Replica as NICE-SLAM renders it: `results/frame*`, `results/depth*`, `traj.txt`.
    Replica,
    /// VSLAM-LAB: `rgb.csv`.
    VslamLab,
    /// A bag: rosbag2, MCAP, ROS 1.
    Bag,
    /// A video or a camera.
    Video,
    /// A rendered world: its frames are not files.
    Rendered,
    /// Images in the folder itself, in sub-folders for left and right, or for color and depth.
    Images,
}

impl SequenceKind {
    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Kitti => "KITTI odometry",
            Self::KittiRaw => "KITTI raw",
            Self::Kitti360 => "KITTI-360",
            Self::TumRgbd => "TUM RGB-D",
            Self::Euroc => "EuRoC",
            Self::TartanAir => "TartanAir",
            Self::SevenScenes => "7-Scenes",
            Self::Replica => "Replica",
            Self::VslamLab => "VSLAM-LAB",
            Self::Bag => "a ROS bag",
            Self::Video => "a video or a camera",
            Self::Rendered => "rendered",
            Self::Images => "a folder of images",
        }
    }
}

/// A layout with what was found of it.
pub(super) enum Layout {
    Kitti(Variant),
    Tum(Lists),
    /// The folder with the cameras' folders.
    Euroc(PathBuf),
    VslamLab,
    Images(Tree),
}

/// The layout of a folder, from what lies in it.
pub fn layout_of(dir: &Path) -> Option<SequenceKind> {
    Some(match find(dir)? {
        Layout::Kitti(variant) => variant.kind,
        Layout::Tum(_) => SequenceKind::TumRgbd,
        Layout::Euroc(_) => SequenceKind::Euroc,
        Layout::VslamLab => SequenceKind::VslamLab,
        Layout::Images(tree) => tree.kind,
    })
}

/// The layout of a folder with its parts; a folder with one drive of KITTI raw in it is left to [`unknown`].
pub(super) fn find(dir: &Path) -> Option<Layout> {
    if dir.join("rgb.csv").is_file() {
        return Some(Layout::VslamLab);
    }
    if let Some(lists) = Lists::find(dir) {
        return Some(Layout::Tum(lists));
    }
    if let Some(variant) = Variant::find(dir) {
        return Some(Layout::Kitti(variant));
    }
    if let Some(root) = euroc::find_root(dir) {
        return Some(Layout::Euroc(root));
    }
    if let Some(tree) = image_folder::find(dir) {
        return Some(Layout::Images(tree));
    }
    // Only a part is there: its error says what is missing.
    Variant::of_remains(dir).map(Layout::Kitti)
}

/// The error of a folder whose layout is not known: what lies in it.
pub(super) fn unknown(dir: &Path) -> DatasetError {
    DatasetError::UnknownLayout { path: dir.to_path_buf(), found: contents(dir) }
}

/// `the folders a, b; 15 files end in .pgm, 1 in .txt`.
pub(super) fn contents(dir: &Path) -> String {
    const SHOWN: usize = 8;
    let mut endings: BTreeMap<String, usize> = BTreeMap::new();
    let mut folders = Vec::new();
    for entry in fs::read_dir(dir).into_iter().flatten().flatten() {
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        if path.is_dir() {
            folders.push(name);
        } else {
            let ending =
                path.extension().map_or("no dot".to_owned(), |e| format!(".{}", e.to_string_lossy()));
            *endings.entry(ending).or_default() += 1;
        }
    }
    folders.sort();
    let mut parts = Vec::new();
    if !folders.is_empty() {
        let more = if folders.len() > SHOWN { ", ..." } else { "" };
        folders.truncate(SHOWN);
        parts.push(format!("the folders {}{more}", folders.join(", ")));
    }
    let mut counts: Vec<(usize, String)> = endings.into_iter().map(|(ending, n)| (n, ending)).collect();
    counts.sort_by(|a, b| b.0.cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    let counts: Vec<String> =
        counts.iter().take(SHOWN).map(|(n, ending)| format!("{n} in {ending}")).collect();
    if let Some((first, rest)) = counts.split_first() {
        let first = first.replacen(
            " in ",
            if first.starts_with("1 ") { " file ends in " } else { " files end in " },
            1,
        );
        parts.push([std::slice::from_ref(&first), rest].concat().join(", "));
    }
    if parts.is_empty() { "nothing".to_owned() } else { parts.join("; ") }
}

/// What a file is that holds whole recordings but is not read, by its ending.
pub(super) fn container(path: &Path) -> Option<&'static str> {
    let text = path.to_string_lossy();
    if text.starts_with("http://") || text.starts_with("https://") {
        return Some("a web address; download and unpack it first");
    }
    if path.is_dir() {
        return None;
    }
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    Some(match ending.as_str() {
        "zip" | "tar" | "gz" | "tgz" | "bz2" | "xz" | "zst" | "7z" | "rar" => {
            "an archive, which is not read; unpack it first"
        }
        "svo" | "svo2" => "a ZED recording, which is not read; export its images into a folder first",
        "klg" => "a Kinect log, which is not read; export its images into a folder first",
        _ => return None,
    })
}
