//! The target of folders: the text files of a dataset, with a tiny image wherever one is expected.

use std::fs;
use std::path::Path;

use geometry::{DepthImage, GrayImage};

use super::files::in_folder;
use super::{cameras, said};

/// What separates the files of an input.
pub const SEPARATOR: u8 = 0x1e;

/// A layout: its folder, its text files with what they usually hold, its images. The first byte of an input chooses.
pub struct Layout {
    folder: &'static str,
    texts: &'static [&'static str],
    images: &'static [&'static str],
}

const fn layout(
    folder: &'static str,
    texts: &'static [&'static str],
    images: &'static [&'static str],
) -> Layout {
    Layout { folder, texts, images }
}

/// Names with `depth` in them are depth images.
pub const LAYOUTS: &[Layout] = &[
    layout(
        "kitti",
        &["times.txt", "calib.txt", "poses.txt"],
        &["image_0/000000.png", "image_1/000000.png", "image_0/000001.png", "image_1/000001.png"],
    ),
    layout(
        "raw/2011_09_30_drive_0020_sync",
        &[
            "image_00/timestamps.txt",
            "../calib_cam_to_cam.txt",
            "oxts/data/0000000000.txt",
            "../calib_imu_to_velo.txt",
            "../calib_velo_to_cam.txt",
        ],
        &["image_00/data/0000000000.png", "image_01/data/0000000000.png"],
    ),
    layout(
        "k360/data_2d_raw/drive",
        &[
            "image_00/timestamps.txt",
            "../../calibration/perspective.txt",
            "../../data_poses/drive/cam0_to_world.txt",
        ],
        &["image_00/data_rect/0000000003.png", "image_01/data_rect/0000000003.png"],
    ),
    layout("tum", &["rgb.txt", "depth.txt", "groundtruth.txt"], &["rgb/0.png", "depth/0.png"]),
    layout(
        "icl",
        &["associations.txt", "groundtruth.txt", "calibration.yaml"],
        &["rgb/0.png", "depth/0.png"],
    ),
    layout(
        "loris",
        &["color.txt", "aligned_depth.txt", "groundtruth.txt"],
        &["color/0.png", "aligned_depth/0.png"],
    ),
    layout(
        "euroc",
        &[
            "mav0/cam0/data.csv",
            "mav0/cam0/sensor.yaml",
            "mav0/cam1/data.csv",
            "mav0/cam1/sensor.yaml",
            "mav0/state_groundtruth_estimate0/data.csv",
        ],
        &["mav0/cam0/data/1000000000.png", "mav0/cam1/data/1000000000.png"],
    ),
    layout(
        "tumvi",
        &["mav0/cam0/data.csv", "mav0/cam1/data.csv", "dso/camchain.yaml", "mav0/mocap0/data.csv"],
        &["mav0/cam0/data/1000000000.png", "mav0/cam1/data/1000000000.png"],
    ),
    layout(
        "tartan",
        &["pose_left.txt", "calibration.yaml"],
        &["image_left/000000_left.png", "image_right/000000_right.png"],
    ),
    layout(
        "scenes",
        &["frame-000000.pose.txt", "calibration.yaml"],
        &["frame-000000.color.png", "frame-000000.depth.png"],
    ),
    layout(
        "replica",
        &["traj.txt", "cam_params.json"],
        &["results/frame000000.png", "results/depth000000.png"],
    ),
    layout("lab", &["rgb.csv", "calibration.yaml", "groundtruth.csv"], &["rgb_0/0.png", "depth_0/0.png"]),
    layout(
        "pairs",
        &["times.txt", "calibration.yaml", "groundtruth.txt"],
        &["left_000000.png", "right_000000.png", "left_000001.png", "right_000001.png"],
    ),
    layout("images", &["times.txt", "calibration.yaml", "groundtruth.txt"], &["left/0.png", "right/0.png"]),
];

/// Two rows of a TUM trajectory.
const TUM: &str = "1.0 0.5 0.5 0.5 0 0 0 1\n1.1 0.5 0.6 0.5 0 0 0 1\n";
const CSV: &str =
    "#timestamp, p_x\n1000000000,0.1,0.2,0.3,1,0,0,0,0,0,0\n1100000000,0.1,0.2,0.3,1,0,0,0,0,0,0\n";
const ROWS: &str = "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n";
const DATES: &str = "2013-05-28 08:46:03.100000000\n";
const LIST: &str = "#timestamp [ns],filename\n1000000000,1000000000.png\n";
const NEGATIVE_FY: &str =
    "Camera.fx: 30\nCamera.fy: -31\nCamera.cx: 19\nCamera.cy: 9.5\nCamera.bf: 2.4\nDepthMapFactor: 5000\n";

/// A byte for the layout, then its texts, of all layouts.
pub fn seeds() -> Vec<Vec<u8>> {
    let chain = cameras::tum_vi();
    let right = cameras::SENSOR.replace("0.0, 0.1, 0.0", "0.0, 0.35, 0.0");
    let matrix = "1 0 0 0.5\n0 1 0 0.25\n0 0 1 0\n0 0 0 1\n";
    let contents: [&[&str]; 14] = [
        &["0.0\n0.1\n", cameras::KITTI, "0 1 0 0 0 0 1 0 0 0 0 1 0\n1 1 0 0 0 0 1 0 0 0 0 1 1\n"],
        &[
            DATES,
            cameras::KITTI_RAW,
            "49.0 8.4 112.8 0 0 1.57 0 0 0\n",
            "R: 1 0 0 0 1 0 0 0 1\nT: 0.5 0 0\n",
            "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 0 -0.25\n",
        ],
        &[DATES, cameras::KITTI_RAW, "3 1 0 0 7 0 1 0 0 0 0 1 0 0 0 0 1\n"],
        &["# color\n1.0 rgb/0.png\n", "1.01 depth/0.png\n", TUM],
        &["1.0 depth/0.png 1.01 rgb/0.png\n", TUM, NEGATIVE_FY],
        &["1.0 color/0.png\n", "1.01 aligned_depth/0.png\n", TUM],
        &[LIST, cameras::SENSOR, LIST, &right, CSV],
        &[LIST, LIST, &chain, CSV],
        &["1 2 3 0 0 0 1\n", cameras::REALSENSE],
        &[matrix, cameras::REALSENSE],
        &[ROWS, cameras::REPLICA],
        &[
            "ts_rgb_0 (ns),path_rgb_0,ts_depth_0 (ns),path_depth_0\n1000000000,rgb_0/0.png,1000000000,depth_0/0.png\n",
            cameras::LAB,
            "ts (ns),tx,ty,tz,qx,qy,qz,qw\n1000000000,0.1,0.2,0.3,0,0,0,1\n",
        ],
        &["0.5\n1.5\n", cameras::OWN, TUM],
        &["0.5\n", cameras::OWN, TUM],
    ];
    assert_eq!(contents.len(), LAYOUTS.len());
    let join = |(kind, texts): (u8, &&[&str])| {
        let texts: Vec<&[u8]> = texts.iter().map(|text| text.as_bytes()).collect();
        [&[kind], &texts.join(&SEPARATOR)[..]].concat()
    };
    (0..).zip(&contents).map(join).collect()
}

pub(super) fn layouts(bytes: &[u8]) -> String {
    let (kind, bytes) = bytes.split_first().unwrap_or((&0, &[]));
    let layout = &LAYOUTS[usize::from(*kind) % LAYOUTS.len()];
    in_folder(|folder| {
        prepare(folder);
        let folder = folder.join(layout.folder);
        let mut parts = bytes.split(|byte| *byte == SEPARATOR);
        for text in layout.texts {
            match parts.next() {
                Some(content) => fs::write(folder.join(text), content).expect("an input is written"),
                // An input may leave a file out.
                None => drop(fs::remove_file(folder.join(text))),
            }
        }
        said(io::open_sequence(&folder, None))
    })
}

/// Makes the images of all layouts, and the folders of their texts, once.
fn prepare(folder: &Path) {
    if folder.join(LAYOUTS[0].folder).exists() {
        return;
    }
    let (image, depth) = (GrayImage::new(40, 40, 9), DepthImage::new(40, 40, 1500));
    for layout in LAYOUTS {
        let root = folder.join(layout.folder);
        for name in layout.images.iter().chain(layout.texts) {
            let path = root.join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder for images");
        }
        for name in layout.images {
            let (path, has_depth) = (root.join(name), name.contains("depth"));
            let written =
                if has_depth { io::save_png_depth(&path, &depth) } else { io::save_png_gray(&path, &image) };
            written.expect("an image is written");
        }
    }
}
