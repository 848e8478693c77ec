//! The target of folders: the text files of a dataset, with a tiny image wherever one is expected.

use std::fs;
use std::path::Path;

use geometry::GrayImage;

use super::files::in_folder;
use super::said;

/// What separates the files of an input.
pub const SEPARATOR: u8 = 0x1e;

/// Layouts with their text files; the first byte of an input chooses.
pub const LAYOUTS: &[(&str, &[&str])] = &[
    ("kitti", &["times.txt", "calib.txt", "poses.txt"]),
    ("tum", &["rgb.txt", "depth.txt", "groundtruth.txt"]),
    ("euroc", &["mav0/cam0/data.csv", "mav0/cam0/sensor.yaml", "mav0/state_groundtruth_estimate0/data.csv"]),
    ("images", &["times.txt", "calibration.yaml", "groundtruth.txt"]),
];

/// Images that a layout finds.
const IMAGES: [&str; 8] = [
    "kitti/image_0/000000.png",
    "kitti/image_1/000000.png",
    "tum/rgb/0.png",
    "tum/depth/0.png",
    "euroc/mav0/cam0/data/1000000000.png",
    "euroc/mav0/cam1/data/1000000000.png",
    "images/left/0.png",
    "images/right/0.png",
];

pub(super) fn layouts(bytes: &[u8]) -> String {
    let (kind, bytes) = bytes.split_first().unwrap_or((&0, &[]));
    let (name, texts) = LAYOUTS[usize::from(*kind) % LAYOUTS.len()];
    in_folder(|folder| {
        prepare(folder);
        let folder = folder.join(name);
        let mut parts = bytes.split(|byte| *byte == SEPARATOR);
        for text in texts {
            match parts.next() {
                Some(content) => fs::write(folder.join(text), content).expect("an input is written"),
                // An input may leave a file out.
                None => drop(fs::remove_file(folder.join(text))),
            }
        }
        said(io::open_sequence(&folder, None))
    })
}

/// Makes the images of all layouts, once.
fn prepare(folder: &Path) {
    if folder.join("kitti").exists() {
        return;
    }
    let image = GrayImage::new(40, 40, 9);
    for name in IMAGES {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder for images");
        io::save_png_gray(&path, &image).expect("an image is written");
    }
    fs::create_dir_all(folder.join("euroc/mav0/state_groundtruth_estimate0")).expect("a folder");
}
