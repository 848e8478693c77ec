//! The numbered examples, run on a rendered drive.
#![allow(clippy::unwrap_used, reason = "a test stops at the first problem")]

#[allow(dead_code)]
#[path = "../examples/01_folder.rs"]
mod folder;
#[allow(dead_code)]
#[path = "../examples/02_push_images.rs"]
mod push_images;
#[allow(dead_code)]
#[path = "../examples/03_save_load_localize.rs"]
mod save_load_localize;

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::LazyLock;

use synth::{Preset, World, WriteOptions, write_kitti};
use tempfile::TempDir;

const N_FRAMES: usize = 6;

/// A folder in KITTI's layout with a calibration file for its images beside it.
static DRIVE: LazyLock<TempDir> = LazyLock::new(|| {
    let (folder, world) = (tempfile::tempdir().unwrap(), World::new(Preset::Town, 1, 1));
    let options = WriteOptions { max_frames: Some(N_FRAMES), masks: false, depth: false };
    write_kitti(&world, &folder.path().join("drive"), &options, &mut |_| ControlFlow::Continue(())).unwrap();
    let rig = world.rig();
    let (camera, (width, height)) = (rig.camera, world.image_size());
    let (fx, fy, cx, cy) = (camera.fx, camera.fy, camera.cx, camera.cy);
    let camera = format!(
        "  - {{model: none, resolution: [{width}, {height}], intrinsics: [{fx}, {fy}, {cx}, {cy}]}}\n"
    );
    let way = format!("[[1, 0, 0, {}], [0, 1, 0, 0], [0, 0, 1, 0]]", -rig.baseline_m);
    let two = format!("cameras:\n{camera}{camera}right_from_left: {way}\n");
    fs::write(folder.path().join("two.yaml"), two).unwrap();
    fs::write(folder.path().join("one.yaml"), format!("cameras:\n{camera}")).unwrap();
    folder
});

#[test]
fn a_folder_gives_a_trajectory() {
    let file = DRIVE.path().join("trajectory.txt");
    folder::run(&DRIVE.path().join("drive"), &file).unwrap();
    assert_eq!(
        fs::read_to_string(file).unwrap().lines().filter(|line| !line.starts_with('#')).count(),
        N_FRAMES
    );
}

#[test]
fn pushed_images_give_poses() {
    let at = |name: &str| DRIVE.path().join(name);
    let (left, right) = (at("drive/image_0"), at("drive/image_1"));
    assert_eq!(push_images::run(&at("two.yaml"), &left, Some(&right)).unwrap(), N_FRAMES);
    let error = push_images::run(&at("one.yaml"), &left, Some(&right)).unwrap_err().to_string();
    assert_eq!(error, "the frame at 0 ns: found a right image, expected none with sensor mono");
}

#[test]
fn a_saved_map_finds_the_camera() {
    let (drive, map) = (DRIVE.path().join("drive"), DRIVE.path().join("town.dsmap"));
    assert_eq!(save_load_localize::run(&drive, &drive, &map).unwrap(), N_FRAMES);
}

#[test]
fn the_documents_show_the_examples_as_they_are() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let library = fs::read_to_string(root.join("docs/library.md")).unwrap();
    let text = fs::read_to_string(root.join("crates/dsslam/examples/02_push_images.rs")).unwrap();
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let block = |text: &str| {
        text.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next().map(str::to_owned))
    };
    assert!(block(&readme).is_some_and(|code| code.lines().count() <= 15));
    assert_eq!(block(&readme), block(&library), "the page's code is compiled");
    for line in
        ["let mut slam = Slam::new(&config, ", "let seen = slam.track(t_ns, ", "let done = slam.finish()?;"]
    {
        assert!(library.contains(line) && text.contains(line), "{line}");
    }
}
