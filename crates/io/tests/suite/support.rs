//! Small datasets in temporary folders; tests change one thing and look at the answer.

use std::fs;
use std::path::{Path, PathBuf};

use geometry::{DepthImage, GrayImage};
use tempfile::TempDir;

/// Projection matrices of a rectified pair: f 700, center (20, 10), baseline 0.54 m, exact in binary.
pub(super) const P0: &str = "P0: 7.0e+02 0 20 0 0 7.0e+02 10 0 0 0 1 0";
pub(super) const P1: &str = "P1: 7.0e+02 0 20 -378 0 7.0e+02 10 0 0 0 1 0";

/// Nanoseconds of the `i`-th frame of [`Folder::euroc`].
pub(super) fn euroc_stamp(i: u64) -> u64 {
    1_403_636_589_763_555_584 + i * 50_000_000
}

/// An EuRoC camera of 40x20 pixels, `x_m` meters along x of the body; one field a line.
pub(super) fn sensor_yaml(x_m: f64) -> String {
    format!(
        "# a camera\n\
         sensor_type: camera\n\
         T_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0, 0.0, {x_m},\n         0.0, 1.0, 0.0, 0.5,\n         \
         0.0, 0.0, 1.0, 0.0,\n         0.0, 0.0, 0.0, 1.0]\n\
         rate_hz: 20\n\
         resolution: [40, 20]\n\
         camera_model: pinhole\n\
         intrinsics: [30.0, 31.0, 19.0, 9.5] #fu, fv, cu, cv\n\
         distortion_model: radial-tangential\n\
         distortion_coefficients: [-0.1, 0.01, 0.001, 0.002]\n"
    )
}

/// Our calibration file of one or two cameras of 40x20 pixels, 0.25 m apart; one field a line.
pub(super) fn calibration_yaml(n_cameras: usize) -> String {
    let camera = "  - model: pinhole-radtan\n    resolution: [40, 20]\n    intrinsics: [30.0, 31.0, 19.0, 9.5]\n    \
                  distortion: [-0.1, 0.01, 0.001, 0.002]\n";
    let motion = "right_from_left:\n  - [1, 0, 0, -0.25]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n";
    let motion = if n_cameras == 2 { motion } else { "" };
    format!("fps: 25\ncameras:\n{}{motion}", camera.repeat(n_cameras))
}

/// A folder that vanishes with the test.
pub(super) struct Folder(TempDir);

impl Folder {
    pub(super) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// A KITTI folder with `n` gray pairs of 40x20 pixels, ten frames a second.
    pub(super) fn kitti(n: u32) -> Self {
        let folder = Self::new();
        folder.write("calib.txt", format!("{P0}\n{P1}\n"));
        let times: Vec<String> = (0..n).map(|i| format!("{:e}\n", f64::from(i) / 10.0)).collect();
        folder.write("times.txt", times.concat());
        for i in 0..n {
            folder.gray(&format!("image_0/{i:06}.png"), 40, 20);
            folder.gray(&format!("image_1/{i:06}.png"), 40, 20);
        }
        folder
    }

    /// A TUM folder with three color and three depth images, 5 ms apart.
    pub(super) fn tum() -> Self {
        let folder = Self::new();
        folder.write("rgb.txt", "# color\n1.000 rgb/a.png\n1.100 rgb/b.png\n1.200 rgb/c.png\n");
        folder.write("depth.txt", "# depth\n1.005 depth/a.png\n1.105 depth/b.png\n1.205 depth/c.png\n");
        for name in ["a", "b", "c"] {
            folder.gray(&format!("rgb/{name}.png"), 40, 20);
            let depth = DepthImage::new(40, 20, 5000);
            dsslam_io::save_png_depth(&folder.prepare(&format!("depth/{name}.png")), &depth).unwrap();
        }
        folder
    }

    /// An EuRoC folder with `n` pairs of 40x20 pixels, twenty a second, and the cameras of [`sensor_yaml`].
    pub(super) fn euroc(n: u64) -> Self {
        let folder = Self::new();
        for (camera, x_m) in [("cam0", 0.0), ("cam1", 0.25)] {
            let mut list = "#timestamp [ns],filename\n".to_string();
            for i in 0..n {
                let stamp = euroc_stamp(i);
                list += &format!("{stamp},{stamp}.png\r\n");
                folder.gray(&format!("mav0/{camera}/data/{stamp}.png"), 40, 20);
            }
            folder.write(&format!("mav0/{camera}/data.csv"), list);
            folder.write(&format!("mav0/{camera}/sensor.yaml"), sensor_yaml(x_m));
        }
        folder
    }

    pub(super) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(super) fn file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    /// The path of a file whose folder exists.
    pub(super) fn prepare(&self, name: &str) -> PathBuf {
        let path = self.file(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        path
    }

    pub(super) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.prepare(name);
        fs::write(&path, content).unwrap();
        path
    }

    pub(super) fn gray(&self, name: &str, width: usize, height: usize) -> PathBuf {
        let path = self.prepare(name);
        let image = GrayImage::from_fn(width, height, |x, y| ((x * 7 + y * 13) % 256) as u8);
        dsslam_io::save_png_gray(&path, &image).unwrap();
        path
    }

    pub(super) fn remove(&self, name: &str) {
        fs::remove_file(self.file(name)).unwrap();
    }

    /// A message with this folder's path written as `DIR`.
    pub(super) fn hide(&self, message: impl std::fmt::Display) -> String {
        message.to_string().replace(&self.path().display().to_string(), "DIR")
    }

    /// The names in the folder, sorted.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}
