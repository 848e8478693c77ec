//! Videos as raw streams: the same run as on the images, and what happens when one is cut.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::program::{Call, dsslam, summary, text};
use crate::sequence::rendered;

/// Bytes of a frame of two images, without its line.
const FRAME: usize = 2 * 1241 * 376;

const CAMERA: &str = "  - model: none\n    resolution: [1241, 376]\n    intrinsics: [707.0912, 707.0912, 601.8873, 183.1104]\n";

/// A calibration of the rendered cameras, and videos of their images.
struct Videos {
    folder: TempDir,
}

impl Videos {
    fn new() -> Self {
        let videos = Videos { folder: tempfile::tempdir().unwrap() };
        let motion = "right_from_left:\n  - [1, 0, 0, -0.54]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n";
        videos.write("stereo.yaml", format!("cameras:\n{CAMERA}{CAMERA}{motion}"));
        videos.write("mono.yaml", format!("cameras:\n{CAMERA}"));
        videos
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        fs::write(self.path(name), content).unwrap();
        self.path(name)
    }

    /// A video of the first `n` frames, one or two images side by side, of which the last `cut` bytes are missing.
    fn video(&self, name: &str, n: usize, cameras: &[&str], cut: usize) -> PathBuf {
        let images = |i: usize| {
            let image = |camera: &&str| {
                image::open(rendered().join(format!("{camera}/{i:06}.png"))).unwrap().into_luma8()
            };
            cameras.iter().map(image).collect::<Vec<_>>()
        };
        let width = 1241 * cameras.len();
        let mut stream = format!("YUV4MPEG2 W{width} H376 F10:1 Ip A1:1 Cmono\n").into_bytes();
        for i in 0..n {
            stream.extend(b"FRAME\n");
            let images = images(i);
            for y in 0..376 {
                images.iter().for_each(|image| stream.extend(&image.as_raw()[y * 1241..(y + 1) * 1241]));
            }
        }
        stream.truncate(stream.len() - cut);
        self.write(name, stream)
    }

    fn run(&self, video: &Path, calibration: &str, args: &[&str]) -> Call {
        let (results, calibration) = (self.path("results"), self.path(calibration));
        let mut all = vec!["run", text(video), "--calib", text(&calibration), "--out", text(&results)];
        all.extend(args);
        dsslam(&all)
    }
}

#[test]
fn a_video_gives_the_run_of_its_images() {
    let videos = Videos::new();
    for (name, calibration, cameras, sensor) in [
        ("two.y4m", "stereo.yaml", &["image_0", "image_1"][..], "stereo"),
        ("one.Y4M", "mono.yaml", &["image_0"], "mono"),
    ] {
        let video = videos.video(name, 14, cameras, 0);
        videos.run(&video, calibration, &[]).expect_success();
        let of_video = summary(&videos.path("results"));
        assert_eq!((&of_video["frames"], &of_video["sensor"]), (&14.into(), &sensor.into()), "{of_video:#}");
        assert_eq!(of_video["interrupted"], false);
        let out = videos.path("images");
        let camera = videos.path(calibration);
        let args = ["--max-frames", "14", "--sensor", sensor, "--calib", text(&camera)];
        dsslam(&[&["run", text(rendered()), "--out", text(&out)][..], &args].concat()).expect_success();
        let of_images = summary(&out);
        assert_eq!(of_video["trajectory_sha256"], of_images["trajectory_sha256"], "{name}");
        assert_eq!(of_video["map_digest"], of_images["map_digest"], "{name}");
    }
}

#[test]
fn a_video_that_ends_in_the_middle_of_a_frame_is_used_up_to_there() {
    let videos = Videos::new();
    let video = videos.video("cut.y4m", 6, &["image_0", "image_1"], 1000);
    let call = videos.run(&video, "stereo.yaml", &[]);
    let line = format!(
        "{}: ends in the middle of frame 5: found {} of {FRAME} bytes; only the 5 frames before it are used",
        video.display(),
        FRAME - 1000
    );
    call.expect(0, &format!("warning: {line}"));
    let s = summary(&videos.path("results"));
    assert_eq!(
        (&s["frames"], &s["tracked"], &s["interrupted"]),
        (&5.into(), &5.into(), &false.into()),
        "{s:#}"
    );
    assert!(s["notices"].as_array().unwrap().contains(&line.into()), "{s:#}");
}

#[test]
fn what_is_no_video_or_does_not_fit_is_refused() {
    let videos = Videos::new();
    let refused = |video: &Path, calibration: &str, args: &[&str], message: &str| {
        videos.run(video, calibration, args).expect(2, &format!("error: {message}"));
        assert!(!videos.path("results").exists());
    };
    let text = videos.write("text.y4m", "hello\n");
    refused(
        &text,
        "mono.yaml",
        &[],
        &format!(
            "{}: found `hello`, expected a line such as `YUV4MPEG2 W640 H480 F30:1 Cmono` (width, height, frame rate; \
             C: mono, 420, 422 or 444)",
            text.display()
        ),
    );
    let small = videos.write("small.y4m", "YUV4MPEG2 W640 H480 F30:1 Cmono\n");
    let (name, one, two) = (small.display(), videos.path("mono.yaml"), videos.path("stereo.yaml"));
    refused(
        &small,
        "mono.yaml",
        &[],
        &format!("{name}: found 640x480 pixels, expected 1241x376 (resolution in {})", one.display()),
    );
    refused(
        &small,
        "stereo.yaml",
        &["--sensor", "stereo"],
        &format!(
            "{name}: found 640x480 pixels, expected 2482x376 (left and right side by side, each 1241x376 as in {})",
            two.display()
        ),
    );
    refused(
        &small,
        "mono.yaml",
        &["--sensor", "stereo"],
        &format!("{name}: sensor stereo is not possible here: {} describes a single camera", one.display()),
    );
    videos.write("mono.yaml", "cameras: []\n");
    refused(
        &small,
        "mono.yaml",
        &[],
        &format!(
            "{}:1: cameras: found 0 cameras, expected a list of one camera, or of the left and the right one",
            one.display()
        ),
    );
}
