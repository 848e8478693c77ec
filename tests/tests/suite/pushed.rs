//! Images pushed into the library one by one give the files of `dsslam run`, byte for byte: on rendered and on real frames, with every
//! sensor, with and without rectification.

use std::path::Path;

use dsslam::{Camera, Config, Images, Input, InputOptions, Schedule, Slam, SlamOptions};

use crate::program::{dsslam, summary, text};
use crate::real_data::real;
use crate::root;
use crate::sequence::rendered;

/// Runs the program and the library on the first frames of a sequence and compares trajectory and map.
fn compare(sequence: &Path, config: Option<&str>, max_frames: usize, schedule: Schedule) {
    let folder = tempfile::tempdir().unwrap();
    let (out, n) = (folder.path().join("run"), max_frames.to_string());
    let file = config.map(|name| root().join("configs").join(name));
    let sets = ["input.scale=0.8"];
    let mut args = vec!["run", text(sequence), "--out", text(&out), "--max-frames", &n];
    args.extend(sets.iter().flat_map(|set| ["--set", set]));
    args.extend(file.iter().flat_map(|file| ["--config", text(file)]));
    dsslam(&args).expect_success();

    let config = Config::load(file.as_deref(), &sets.map(str::to_owned)).unwrap();
    let input = Input::open(sequence, &config, &InputOptions::default()).unwrap();
    let mut options = SlamOptions::default();
    options.schedule = Some(schedule);
    let mut slam = Slam::with(&config, Camera::of(&input), &options).unwrap();
    for source in &input.sequence().frames[..max_frames] {
        let frame = io::load_frame(source).unwrap();
        let images = match (&frame.right, &frame.depth) {
            (Some(right), _) => Images::from((&frame.left, right)),
            (_, Some(depth)) => Images::from((&frame.left, depth)),
            _ => Images::from(&frame.left),
        };
        slam.track(source.timestamp_ns, images).unwrap();
    }
    let done = slam.finish().unwrap();
    let pushed = folder.path().join("pushed.txt");
    io::write_tum_at(&pushed, &done.trajectory(), &io::Clock::of(&input.sequence().frames)).unwrap();
    let [expected, found] =
        [out.join("trajectory.tum.txt"), pushed].map(|file| std::fs::read_to_string(file).unwrap());
    assert!(found.lines().count() > max_frames / 2, "{found}");
    assert_eq!(found, expected);
    let digest = format!("{:016x}", done.outcome.map.digest());
    assert_eq!(summary(&out)["map_digest"], digest);
}

#[test]
fn rendered_frames() {
    compare(rendered(), None, 25, Schedule::Lockstep);
}

#[test]
fn real_frames() {
    for (name, config, schedule) in [
        ("kitti06_first51", "kitti.yaml", Schedule::Sequential),
        ("tum_fr1_desk", "tum-rgbd.yaml", Schedule::Lockstep),
        ("euroc_MH01_200", "euroc.yaml", Schedule::Lockstep),
    ] {
        let Some(sequence) = real(name) else { return };
        compare(&sequence, Some(config), 40, schedule);
    }
}
