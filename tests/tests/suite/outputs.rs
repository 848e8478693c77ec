//! Situations around the results: sub-maps that are not connected, a full disk, a full standard output, two runs into one folder.

use std::fs::{self, File};
use std::path::Path;
use std::process::Stdio;

use geometry::GrayImage;

use crate::program::{command, ended, summary, text};
use crate::sequence::Copy;

/// Frames of the town, then of later ones upside down: the camera was covered while it was carried away.
fn carried_away() -> Copy {
    const TOWN: usize = 10;
    const OTHER: usize = 14;
    let copy = Copy::of_first(TOWN + OTHER);
    for camera in ["image_0", "image_1"] {
        for i in TOWN..TOWN + OTHER {
            let name = format!("{camera}/{i:06}.png");
            let image = io::load_gray(&copy.path().join(&name)).unwrap();
            copy.remove(&name);
            let turned =
                GrayImage::from_fn(image.width, image.height, |x, y| image.at(x, image.height - 1 - y));
            io::save_png_gray(&copy.path().join(&name), &turned).unwrap();
        }
    }
    // The mirrored world: y has the other sign in rotation and position.
    copy.edit("poses.txt", |i, line| {
        let mut numbers: Vec<f64> = line.split_whitespace().map(|n| n.parse().unwrap()).collect();
        if i >= TOWN {
            [1, 4, 6, 7, 9].iter().for_each(|&at| numbers[at] = -numbers[at]);
        }
        Some(numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" "))
    });
    copy
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Situation: a covered camera starts a new sub-map. It was glued to the last pose: one path, with one error over both.
#[test]
fn sub_maps_stay_apart_in_every_result() {
    let copy = carried_away();
    let call = copy.run(&["--set", "camera.fps=2", "--no-loops"]);
    call.expect_success();
    let (results, summary) = (copy.results(), summary(&copy.results()));
    let apart = summary["per_submap"].as_array().unwrap();
    assert_eq!(apart.len(), 2, "{call}");
    let largest = apart[0]["submap"].as_str().unwrap();
    assert!(call.stderr.contains("warning: 2 sub-maps are in unrelated coordinate frames"), "{call}");
    assert!(call.stdout.contains("of sub-map"), "{call}");
    // Each has poses, a drawing and a small error of its own, and the files of the run hold the largest.
    for submap in apart {
        let (name, tracked) = (submap["submap"].as_str().unwrap(), submap["tracked"].as_u64().unwrap());
        let poses = fs::read_to_string(results.join(format!("trajectory_submap_{name}.tum.txt"))).unwrap();
        assert_eq!(poses.lines().filter(|line| !line.starts_with('#')).count() as u64, tracked);
        assert!(results.join(format!("trajectory_submap_{name}.png")).is_file());
        let (ate, path) = (submap["ate_rmse_m"].as_f64().unwrap(), submap["path_m"].as_f64().unwrap());
        assert!(ate < 0.02 * path, "{submap:#}");
        if name == largest {
            assert_eq!(poses, fs::read_to_string(results.join("trajectory.tum.txt")).unwrap());
        }
    }
    let ate = summary["ate_rmse_m"].as_f64().unwrap();
    assert!((ate - apart[0]["ate_rmse_m"].as_f64().unwrap()).abs() < 1e-6, "{summary:#}");
    // A run in one piece into the same folder leaves none of them behind.
    copy.run(&["--max-frames", "5"]).expect_success();
    assert!(!names(&results).iter().any(|name| name.contains("submap")), "{:?}", names(&results));
}

/// Situation: the file of events fills the disk; the trajectory was lost.
#[test]
fn the_file_of_events_yields_to_the_results_when_the_disk_is_full() {
    let copy = Copy::of_first(4);
    fs::create_dir(copy.results()).unwrap();
    std::os::unix::fs::symlink("/dev/full", copy.results().join("events.dslog")).unwrap();
    let call = copy.run(&["--events"]);
    call.expect_success();
    assert!(call.stderr.contains("warning: events.dslog: "), "{call}");
    assert!(!names(&copy.results()).contains(&"events.dslog".to_owned()), "{call}");
    assert_eq!(summary(&copy.results())["tracked"], 4);
}

/// Situation: some file cannot be written; everything else is.
#[test]
fn a_file_that_cannot_be_written_costs_no_other() {
    let copy = Copy::of_first(4);
    for name in ["frames.csv", "trajectory.png"] {
        fs::create_dir_all(copy.results().join(name).join("in the way")).unwrap();
    }
    let call = copy.run(&["--save-map", "/proc/no/such.dsmap"]);
    assert_eq!(call.code, 3, "{call}");
    let journal = copy.path().with_file_name("journal.json");
    let call = copy.run(&["--journal", text(&journal)]);
    assert_eq!(call.code, 3, "{call}");
    for name in ["frames.csv", "trajectory.png"] {
        assert!(call.stderr.lines().any(|l| l.starts_with("error: ") && l.contains(name)), "{call}");
    }
    for name in ["trajectory.kitti.txt", "trajectory.tum.txt", "summary.json", "timings.csv", "loops.csv"] {
        assert!(copy.results().join(name).is_file(), "{name}: {call}");
    }
    assert!(journal.is_file());
}

/// Situation: standard output goes to a file on a full disk; the program said nothing and ended with 0.
#[test]
fn a_full_standard_output_is_an_error() {
    for args in [&["config", "default"][..], &["--help"], &["run", "--help"]] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let call = ended(command(args).stdout(Stdio::from(full)).output().unwrap());
        assert_eq!(call.code, 3, "{args:?}: {call}");
        assert!(call.stderr.contains("error: standard output cannot be written: "), "{args:?}: {call}");
    }
}

/// Situation: two runs into one `--out`; both ended well, their results mixed.
#[test]
fn a_folder_that_another_run_writes_into_is_refused() {
    let copy = Copy::of_first(3);
    fs::create_dir(copy.results()).unwrap();
    let lock = File::open(copy.results()).unwrap();
    lock.lock().unwrap();
    let out = copy.results();
    copy.run(&[]).expect(
        3,
        &format!(
            "error: {}: another run is writing its results into this folder, expected an --out of its own",
            out.display()
        ),
    );
    assert_eq!(names(&out), [""; 0], "nothing is written");
    drop(lock);
    copy.run(&[]).expect_success();
}
