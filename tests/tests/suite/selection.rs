//! Features selected by the activation network, seen from the command line: the same bits by any schedule, the picture of
//! `dsslam inspect activation`, the curves of `dsslam eval places`, and what is said when something is missing.

use std::fs;
use std::path::Path;

use events::Record;

use crate::program::{command, dsslam, ended, text};
use crate::sequence::{Copy, rendered};
use crate::watching::records;

const ACTIVATION: [&str; 4] = ["--set", "features.selection=activation", "--set", "features.keep=500"];

fn checksums(out: &Path) -> [String; 2] {
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
    ["trajectory_sha256", "map_digest"].map(|key| summary[key].as_str().unwrap().to_owned())
}

#[test]
fn selected_features_give_the_same_bits_by_every_schedule() {
    let folder = tempfile::tempdir().unwrap();
    let mut found = Vec::new();
    for (schedule, threads) in [("sequential", "1"), ("lockstep", "1"), ("lockstep", "4")] {
        let out = folder.path().join(format!("{schedule}{threads}"));
        let mut args = vec!["run", text(rendered()), "--max-frames", "25", "--schedule", schedule];
        args.extend(["--out", text(&out), "--set"]);
        let network_threads = format!("features.network_threads={threads}");
        args.push(&network_threads);
        args.extend(ACTIVATION);
        dsslam(&args).expect_success();
        let call = ended(command(&args).env("RAYON_NUM_THREADS", threads).output().unwrap());
        call.expect_success();
        found.push(checksums(&out));
    }
    assert!(found.windows(2).all(|pair| pair[0] == pair[1]), "{found:?}");
}

#[test]
fn a_viewer_gets_the_activation_of_images_features_and_points() {
    let folder = tempfile::tempdir().unwrap();
    let mut args = vec!["run", text(rendered()), "--out", text(folder.path()), "--events"];
    args.extend(["--max-frames", "12", "--schedule", "sequential"]);
    args.extend(ACTIVATION);
    let call = dsslam(&args);
    call.expect_success();
    let (mut images, mut maps, mut values, mut points) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for record in records(folder.path()) {
        match record {
            Record::Image(image) => images.push(image.frame),
            Record::Activation(map) => {
                assert_eq!(map.values.len() as u32, map.size[0] * map.size[1]);
                values.extend(map.values);
                maps.push(map.frame);
            }
            Record::Features(features) => {
                let n = features.activations.len();
                let trusted = features.activations.iter().filter(|a| **a >= 128).count();
                // A quarter at most of what is kept is taken of other places.
                assert!(n == features.pixels.len() && 10 * trusted > 7 * n, "{trusted} of {n}");
            }
            Record::Map(delta) => points.extend(delta.points.iter().map(|point| point.activation)),
            _ => {}
        }
    }
    assert!(images.len() > 6, "{images:?}");
    assert_eq!(images, maps, "each image has its map");
    let [least, most] = [values.iter().min(), values.iter().max()].map(|value| *value.unwrap());
    assert!(most - least > 40, "not every place of a street is trusted alike: {least} to {most}");
    assert!(points.iter().any(|a| *a < 250), "points have the activation of their features");
}

#[test]
fn the_picture_shows_image_map_and_features() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("heat.png");
    let image = rendered().join("image_0/000003.png");
    let args = ["inspect", "activation", text(&image), "-o", text(&picture), "--keep", "300"];
    let call = dsslam(&args);
    call.expect_success();
    assert!(call.stdout.contains("\nkept        300 features, mean activation 0."), "{call}");
    let (image, picture) = (image::open(&image).unwrap(), image::open(&picture).unwrap());
    assert_eq!(picture.width(), image.width());
    assert!(picture.height() > 3 * image.height(), "three pictures with gaps");
}

#[test]
fn places_seen_twice_are_recognized() {
    const N: usize = 12;
    let copy = Copy::of_first(2 * N);
    for camera in ["image_0", "image_1"] {
        for i in 0..N {
            let again = copy.path().join(format!("{camera}/{:06}.png", N + i));
            fs::remove_file(&again).unwrap();
            let original = rendered().join(format!("{camera}/{:06}.png", i + 1));
            std::os::unix::fs::symlink(original, again).unwrap();
        }
    }
    let poses = fs::read_to_string(copy.path().join("poses.txt")).unwrap();
    // The second visit sees each place from a step farther on: two equal images would show no motion.
    let visits = [0, 1].map(|step| poses.lines().skip(step).take(N).collect::<Vec<_>>().join("\n"));
    copy.write("poses.txt", visits.join("\n") + "\n");
    let out = tempfile::tempdir().unwrap();
    let path = copy.path();
    let args = ["eval", "places", text(&path), "--out", text(out.path()), "--gap", "12", "--radius", "3"];
    let call = dsslam(&args);
    call.expect_success();
    let rows: Vec<&str> = call.stdout.lines().filter(|l| l.ends_with('%')).collect();
    assert_eq!(rows.len(), 3, "{call}");
    assert!(rows.iter().all(|row| row.split_whitespace().nth(1) == Some("100.0%")), "{call}");
    assert!(out.path().join("precision_recall.png").is_file());
    let table = fs::read_to_string(out.path().join("places.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 3 * N, "a row per query and selection");
    // Every frame of the second visit, and none of the first, shows a place again.
    let areas = fs::read_to_string(out.path().join("areas.csv")).unwrap();
    for (row, name) in areas.lines().skip(1).zip(["trad", "seman", "ours"]) {
        assert!(row.starts_with(&format!("{name},{},{N},", 2 * N)), "{areas}");
    }
}

#[test]
fn without_onnx_runtime_the_network_runs_and_its_user_is_told_once() {
    let folder = tempfile::tempdir().unwrap();
    let (out, nowhere) = (folder.path().join("run"), folder.path().join("nowhere"));
    let without = |args: &[&str]| {
        let mut command = command(args);
        command.env("HOME", &nowhere).env("XDG_DATA_HOME", &nowhere).env_remove("ORT_DYLIB_PATH");
        ended(command.output().unwrap())
    };
    let mut args = vec!["run", text(rendered()), "--max-frames", "5", "--out", text(&out)];
    args.extend(ACTIVATION);
    let call = without(&args);
    call.expect_success();
    if without(&["doctor"]).stdout.contains("the network runs without it") {
        assert_eq!(call.stderr.matches("ONNX Runtime was not found").count(), 1, "{call}");
        assert!(
            call.stderr.contains("several times slower") && call.stderr.contains("pip install"),
            "{call}"
        );
    } else {
        println!("skipped: the system has an ONNX Runtime of its own");
    }
}

#[test]
fn what_is_missing_is_named() {
    let copy = Copy::of_first(5);
    let (path, out) = (copy.path(), tempfile::tempdir().unwrap());
    let mut args = vec!["run", text(&path), "--out", text(out.path()), "--onnxruntime", "/no/such.so"];
    args.extend(ACTIVATION);
    let call = dsslam(&args);
    assert_eq!(call.code, 2, "{call}");
    assert!(call.stderr.contains("/no/such.so: not a usable ONNX Runtime"), "{call}");
    assert!(call.stderr.contains("pip install"), "{call}");
    args[4] = "--dsfeat-model";
    args[5] = "/no/such.onnx";
    let call = dsslam(&args);
    assert!(call.code == 2 && call.stderr.contains("/no/such.onnx: cannot be read"), "{call}");
    let call = dsslam(&["eval", "places", text(&path), "--out", text(out.path()), "--selection", "trad"]);
    assert_eq!(call.code, 2, "{call}");
    assert!(call.stderr.contains("no frame shows a place that was seen 100 frames earlier"), "{call}");
}
