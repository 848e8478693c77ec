//! The program, its commands, and small data that stand in for what the examples of its help name.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use geometry::{DepthImage, GrayImage};
use tempfile::TempDir;

/// Frames of the rendered sequence.
pub(super) const N_FRAMES: usize = 12;

/// What a call left.
pub(super) struct Call {
    pub(super) code: Option<i32>,
    pub(super) stdout: String,
    pub(super) stderr: String,
}

/// Runs a command to its end.
pub(super) fn ended(command: &mut Command) -> Call {
    let output = command.output().unwrap();
    Call {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// The program with arguments in a folder. A run that names no configuration has the defaults, whatever its layout suggests.
pub(super) fn dsslam_in(dir: &Path, args: &[&str]) -> Call {
    let default = if args[..].first() == Some(&"run") && !args.contains(&"--config") {
        &["--config", "default"][..]
    } else {
        &[]
    };
    ended(Command::new(env!("CARGO_BIN_EXE_dsslam")).args(args).args(default).current_dir(dir))
}

/// The program with arguments: exit code, and standard output followed by standard error.
pub(super) fn dsslam(args: &[&str]) -> (Option<i32>, String) {
    let Call { code, stdout, stderr } = dsslam_in(Path::new("."), args);
    (code, stdout + &stderr)
}

/// The text of a command's `--help`.
pub(super) fn help(command: &[String]) -> String {
    let args: Vec<&str> = command.iter().map(String::as_str).chain(["--help"]).collect();
    let (code, text) = dsslam(&args);
    assert_eq!(code, Some(0), "{command:?}");
    text
}

/// The commands below a command, as its help lists them.
fn commands_below(command: &[String]) -> Vec<Vec<String>> {
    let text = help(command);
    let Some((_, list)) = text.split_once("\nCommands:\n") else { return Vec::new() };
    let lines = list.lines().take_while(|line| !line.is_empty());
    let names = lines.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help");
    names.map(|name| [command, &[name.to_owned()]].concat()).collect()
}

/// Every command of the program, the program itself first, each before the ones below it.
pub(super) fn all_commands() -> &'static [Vec<String>] {
    static FOUND: OnceLock<Vec<Vec<String>>> = OnceLock::new();
    FOUND.get_or_init(|| {
        let mut found = vec![Vec::new()];
        let mut next = 0;
        while next < found.len() {
            let below = commands_below(&found[next]);
            found.extend(below);
            next += 1;
        }
        assert!(found.len() > 15, "{found:?}");
        found
    })
}

/// A folder with a rendered sequence under all the names of the examples, made once.
pub(super) fn data() -> &'static Path {
    static MADE: OnceLock<TempDir> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        prepare(folder.path());
        folder
    })
    .path()
}

/// A folder to run examples in: everything in [`data`] by its name, and results of its own.
pub(super) fn sandbox() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(data()).unwrap() {
        let entry = entry.unwrap();
        symlink(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    fs::create_dir(folder.path().join("results")).unwrap();
    symlink(data().join("finished"), folder.path().join("results/latest")).unwrap();
    folder
}

fn call(dir: &Path, args: &[&str]) {
    let Call { code, stderr, .. } = dsslam_in(dir, args);
    assert_eq!(code, Some(0), "{args:?}\n{stderr}");
}

fn prepare(dir: &Path) {
    let sequence = dir.join("kitti/sequences/06");
    let frames = N_FRAMES.to_string();
    call(dir, &["synth", sequence.to_str().unwrap(), "--preset", "town", "--frames", &frames, "--depth"]);
    for name in ["morning", "evening"] {
        symlink(&sequence, dir.join(name)).unwrap();
    }
    fs::create_dir_all(dir.join("path/to")).unwrap();
    symlink(&sequence, dir.join("path/to/sequence")).unwrap();
    symlink(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs"), dir.join("configs")).unwrap();
    tum(dir, &sequence);
    euroc(dir, &sequence);
    revisited(dir, &sequence);
    image_folder(dir, &sequence);
    symlink(sequence.join("image_0"), dir.join("more")).unwrap();
    symlink(sequence.join("image_0"), dir.join("image_0")).unwrap();
    symlink(sequence.join("image_0/000000.png"), dir.join("image.jpg")).unwrap();
    call(dir, &["inspect", "vocab", "train", "images/left", "-k", "3", "-l", "2", "-o", "ORBvoc.txt"]);
    call(dir, &["run", "kitti/sequences/06", "--out", "finished", "--save-map", "street.dsmap"]);
    symlink(dir.join("street.dsmap"), dir.join("campus.dsmap")).unwrap();
    // A bag without messages.
    fs::write(dir.join("drive.bag"), "#ROSBAG V2.0\n").unwrap();
    fs::create_dir(dir.join("kitti/poses")).unwrap();
    fs::copy(sequence.join("poses.txt"), dir.join("kitti/poses/06.txt")).unwrap();
    for name in ["est.txt", "groundtruth.txt"] {
        fs::copy(dir.join("finished/trajectory.tum.txt"), dir.join(name)).unwrap();
    }
    let driven = io::read_trajectory(&dir.join("est.txt"), None).unwrap().trajectory;
    io::write_euroc(&dir.join("gt.csv"), &driven).unwrap();
    fs::write(dir.join("detections.csv"), "query,answer,score\n4,0,0.5\n").unwrap();
    let suite = "name: short\ndataset: kitti\nsequences:\n  - {name: \"06\", path: kitti/sequences/06}\n\
                 configurations:\n  - {name: orb, set: [features.keep=1000]}\nlengths_m: [1, 2]\n";
    fs::write(dir.join("suite.yaml"), suite).unwrap();
}

fn image_name(i: usize) -> String {
    format!("{i:06}.png")
}

/// The sequence as an RGB-D camera of 640 by 480 pixels might show it: the middle of the images, taller than it is.
fn tum(dir: &Path, sequence: &Path) {
    const SIZE: (usize, usize) = (640, 480);
    let dir = dir.join("rgbd_dataset_freiburg1_desk");
    let lists: Vec<(&str, String)> = ["rgb", "depth"]
        .map(|kind| {
            fs::create_dir_all(dir.join(kind)).unwrap();
            let line = |i: usize| format!("{}.0 {kind}/{}\n", i + 1, image_name(i));
            (kind, (0..N_FRAMES).map(line).collect())
        })
        .into();
    for (kind, list) in lists {
        fs::write(dir.join(format!("{kind}.txt")), list).unwrap();
    }
    for name in (0..N_FRAMES).map(image_name) {
        let gray = io::load_gray(&sequence.join("image_0").join(&name)).unwrap();
        let depth = io::load_depth(&sequence.join("depth").join(&name)).unwrap();
        let place = |x: usize, y: usize| ((gray.width - SIZE.0) / 2 + x, y * gray.height / SIZE.1);
        let gray_at = |x, y| gray.at(place(x, y).0, place(x, y).1);
        // 256 per meter there, 5000 here; a street is farther away than a desk.
        let depth_at = |x, y| depth.at(place(x, y).0, place(x, y).1) / 2;
        io::save_png_gray(&dir.join("rgb").join(&name), &GrayImage::from_fn(SIZE.0, SIZE.1, gray_at))
            .unwrap();
        let depth = DepthImage::from_fn(SIZE.0, SIZE.1, depth_at);
        io::save_png_depth(&dir.join("depth").join(&name), &depth).unwrap();
    }
}

/// The sequence in EuRoC's layout; its images are rectified already.
fn euroc(dir: &Path, sequence: &Path) {
    let opened = io::open_sequence(sequence, None).unwrap();
    let rig = opened.calibration.unwrap().rig;
    let size = io::image_size(&sequence.join("image_0/000000.png")).unwrap();
    for (camera, images, x_m) in [("cam0", "image_0", 0.0), ("cam1", "image_1", rig.baseline_m)] {
        let dir = dir.join("MH_01_easy/mav0").join(camera);
        fs::create_dir_all(&dir).unwrap();
        symlink(sequence.join(images), dir.join("data")).unwrap();
        let pinhole = rig.camera;
        let yaml = format!(
            "T_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0, 0.0, {x_m}, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]\n\
             resolution: [{}, {}]\ncamera_model: pinhole\nintrinsics: [{}, {}, {}, {}]\n\
             distortion_model: radial-tangential\ndistortion_coefficients: [0.0, 0.0, 0.0, 0.0]\n",
            size.width, size.height, pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy
        );
        fs::write(dir.join("sensor.yaml"), yaml).unwrap();
        let row = |i: usize| format!("{},{}\n", (i as u64 + 1) * 100_000_000, image_name(i));
        let rows: String = (0..N_FRAMES).map(row).collect();
        fs::write(dir.join("data.csv"), format!("#timestamp [ns],filename\n{rows}")).unwrap();
    }
}

/// The sequence driven twice: every place is seen again.
fn revisited(dir: &Path, sequence: &Path) {
    let dir = dir.join("revisited");
    for images in ["image_0", "image_1"] {
        fs::create_dir_all(dir.join(images)).unwrap();
        for i in 0..2 * N_FRAMES {
            let original = sequence.join(images).join(image_name(i % N_FRAMES));
            symlink(original, dir.join(images).join(image_name(i))).unwrap();
        }
    }
    let times: Vec<String> = (0..2 * N_FRAMES).map(|i| format!("{}\n", 0.1 * i as f64)).collect();
    fs::write(dir.join("times.txt"), times.concat()).unwrap();
    fs::copy(sequence.join("calib.txt"), dir.join("calib.txt")).unwrap();
    let poses = fs::read_to_string(sequence.join("poses.txt")).unwrap();
    fs::write(dir.join("poses.txt"), poses.clone() + &poses).unwrap();
}

/// The sequence as folders of images, left and right, with a calibration file.
fn image_folder(dir: &Path, sequence: &Path) {
    fs::create_dir(dir.join("images")).unwrap();
    for (side, images) in [("left", "image_0"), ("right", "image_1")] {
        symlink(sequence.join(images), dir.join("images").join(side)).unwrap();
    }
    let rig = io::open_sequence(sequence, None).unwrap().calibration.unwrap().rig;
    let size = io::image_size(&sequence.join("image_0/000000.png")).unwrap();
    let geometry::Pinhole { fx, fy, cx, cy } = rig.camera;
    let camera = format!(
        "  - model: none\n    resolution: [{}, {}]\n    intrinsics: [{fx}, {fy}, {cx}, {cy}]\n",
        size.width, size.height
    );
    let right_from_left =
        format!("right_from_left:\n  - [1, 0, 0, -{}]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n", rig.baseline_m);
    fs::write(dir.join("camera.yaml"), format!("fps: 10\ncameras:\n{camera}{camera}{right_from_left}"))
        .unwrap();
}

/// The folder of the program, for the `PATH`.
pub(super) fn program_folder() -> PathBuf {
    Path::new(env!("CARGO_BIN_EXE_dsslam")).parent().unwrap().to_owned()
}
