//! Broken EuRoC folders through the program: refused with the exact message, or the frame dropped and named.

use std::fs;
use std::path::PathBuf;

use image::GrayImage;
use tempfile::TempDir;

use crate::program::{Call, dsslam, summary, text};

/// Pairs of images in each folder.
const N: u64 = 3;
const WIDTH: u32 = 160;
const HEIGHT: u32 = 120;

/// Nanoseconds of the `i`-th pair.
fn stamp(i: u64) -> u64 {
    1_403_636_579_763_555_584 + i * 50_000_000
}

/// A camera `x_m` meters along x of the body.
fn sensor_yaml(x_m: f64) -> String {
    format!(
        "T_BS:\n  data: [1.0, 0.0, 0.0, {x_m}, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]\n\
         resolution: [{WIDTH}, {HEIGHT}]\n\
         camera_model: pinhole\n\
         intrinsics: [100.0, 100.0, 80.0, 60.0]\n\
         distortion_model: radial-tangential\n\
         distortion_coefficients: [-0.2, 0.05, 0.0, 0.0]\n"
    )
}

/// A stereo sequence of gray images, too plain to start a map from.
struct Folder {
    folder: TempDir,
}

impl Folder {
    fn new() -> Self {
        let folder = Folder { folder: tempfile::tempdir().unwrap() };
        for (camera, x_m) in [("cam0", 0.0), ("cam1", 0.1)] {
            fs::create_dir_all(folder.path(&format!("{camera}/data"))).unwrap();
            folder.write(&format!("{camera}/sensor.yaml"), &sensor_yaml(x_m));
            folder.list(camera, 0);
            (0..N).for_each(|i| folder.image(camera, i, WIDTH));
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join("seq/mav0").join(name)
    }

    /// A path as messages show it.
    fn file(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }

    fn write(&self, name: &str, content: &str) {
        fs::write(self.path(name), content).unwrap();
    }

    /// Writes the list of a camera's images with times `later_ns` after those in their names.
    fn list(&self, camera: &str, later_ns: u64) {
        let row = |i: u64| format!("{},{}.png\n", stamp(i) + later_ns, stamp(i));
        let rows: String = (0..N).map(row).collect();
        self.write(&format!("{camera}/data.csv"), &format!("#timestamp [ns],filename\n{rows}"));
    }

    fn image(&self, camera: &str, i: u64, width: u32) {
        let image = GrayImage::from_pixel(width, HEIGHT, image::Luma([90]));
        image.save(self.path(&image_name(camera, i))).unwrap();
    }

    fn results(&self) -> PathBuf {
        self.folder.path().join("results")
    }

    fn run(&self, args: &[&str]) -> Call {
        let (sequence, results) = (self.folder.path().join("seq"), self.results());
        let mut all = vec!["run", text(&sequence), "--out", text(&results)];
        all.extend(args);
        dsslam(&all)
    }

    /// The sequence is refused with this message, and nothing is written.
    #[track_caller]
    fn refused(&self, message: &str) {
        self.run(&[]).expect(2, &format!("error: {message}"));
        assert!(!self.results().exists(), "nothing is written for a sequence that is refused");
    }

    /// Nothing can be tracked here, but only frame `i` is dropped, for this reason.
    #[track_caller]
    fn dropped(&self, i: u64, reason: &str) -> Call {
        let call = self.run(&[]);
        call.expect(1, &format!("warning: frame {i} dropped: {reason}"));
        let summary = summary(&self.results());
        for (key, expected) in [("frames", N), ("dropped", 1), ("not_ready", N - 1), ("lost", 0)] {
            assert_eq!(summary[key], expected, "{key}: {summary:#}");
        }
        assert_eq!(summary["without_pose"][i as usize]["reason"], reason);
        call
    }
}

fn image_name(camera: &str, i: u64) -> String {
    format!("{camera}/data/{}.png", stamp(i))
}

#[test]
fn a_camera_without_distortion_model_is_refused() {
    for camera in ["cam0", "cam1"] {
        let folder = Folder::new();
        let name = format!("{camera}/sensor.yaml");
        folder.write(&name, &sensor_yaml(0.1).replace("distortion_model: radial-tangential\n", ""));
        folder.refused(&format!(
            "{}: distortion_model: found nothing, expected pinhole-radtan (also radtan, radial-tangential, plumb_bob, opencv), rational_polynomial, \
             kannala-brandt (also equidistant, fisheye, opencv_fisheye) or none",
            folder.file(&name)
        ));
    }
}

#[test]
fn cameras_with_other_times_are_refused() {
    let folder = Folder::new();
    folder.list("cam1", 20_000_000);
    let (left, right) = (folder.file("cam0/data.csv"), folder.file("cam1/data.csv"));
    let (first, last) = (stamp(0), stamp(N - 1));
    folder.refused(&format!(
        "{right}: found no time of an image of cam0: {left} has times {first} to {last}, {right} has times {} to {}, \
         the nearest two are 20.000 ms apart, expected one within 1 ms",
        first + 20_000_000,
        last + 20_000_000
    ));
}

#[test]
fn a_listed_image_that_is_missing_is_told_before_the_run_and_its_frame_dropped() {
    for camera in ["cam0", "cam1"] {
        let folder = Folder::new();
        let name = image_name(camera, 1);
        fs::remove_file(folder.path(&name)).unwrap();
        let call = folder.dropped(1, &format!("{}: no such image", folder.file(&name)));
        let (list, file) = (folder.file(&format!("{camera}/data.csv")), folder.file(&name));
        call.expect(
            1,
            &format!(
                "warning: {list}:3: found the name of a missing file ({file}); 1 of 3 images are missing, and their frames will be dropped"
            ),
        );
    }
}

#[test]
fn a_list_without_any_of_its_images_is_refused() {
    let folder = Folder::new();
    (0..N).for_each(|i| fs::remove_file(folder.path(&image_name("cam0", i))).unwrap());
    folder.refused(&format!(
        "{}:2: found the name of a missing file ({}), expected the name of an image in the folder data",
        folder.file("cam0/data.csv"),
        folder.file(&image_name("cam0", 0))
    ));
}

#[test]
fn an_image_of_another_size_than_its_camera_is_dropped() {
    for i in [0, 1] {
        let folder = Folder::new();
        folder.image("cam0", i, WIDTH / 2);
        folder.image("cam1", i, WIDTH / 2);
        let (image, yaml) = (folder.file(&image_name("cam0", i)), folder.file("cam0/sensor.yaml"));
        let reason = format!("{image}: found 80x120 pixels, expected 160x120 (resolution in {yaml})");
        folder.dropped(i, &reason);
    }
}

#[test]
fn images_that_all_have_another_size_than_their_camera_are_refused() {
    for args in [&[][..], &["--sensor", "mono"]] {
        let folder = Folder::new();
        (0..N).for_each(|i| folder.image("cam0", i, WIDTH / 2));
        let (image, yaml) = (folder.file(&image_name("cam0", 0)), folder.file("cam0/sensor.yaml"));
        let message = format!("error: {image}: found 80x120 pixels, expected 160x120 (resolution in {yaml})");
        folder.run(args).expect(2, &message);
        assert!(!folder.results().exists());
    }
}
