//! The configuration: defaults, layers, the complete dump, the shipped files.

use std::fs;
use std::path::Path;

use dsslam::{Config, SCHEMA};
use geometry::Sensor;
use io::Provenance;
use proptest::prelude::*;

use super::support::Folder;

fn overrides(arguments: &[&str]) -> Vec<String> {
    arguments.iter().map(ToString::to_string).collect()
}

fn configs() -> Vec<std::path::PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs");
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

#[test]
fn defaults() {
    let config = Config::load(None, &[]).unwrap();
    assert_eq!((config.features.keep, config.features.levels, config.features.scale_factor), (2000, 8, 1.2));
    assert_eq!((config.stereo.close_depth_baselines, config.tracking.min_inliers), (40.0, 30));
    assert_eq!((config.camera.fx, config.input.sensor), (None, None));
    assert_eq!(config.provenance("features.keep"), &Provenance::Default);
}

#[test]
fn the_file_wins_over_defaults_and_set_wins_over_the_file() {
    let folder = Folder::new();
    let path = folder.write("c.yaml", "features:\n  keep: 700\n  levels: 5\nseed: 9\n");
    let config = Config::load(Some(&path), &overrides(&["features.keep=500", "features.keep=600"])).unwrap();
    assert_eq!((config.features.keep, config.features.levels, config.seed), (600, 5, 9));
    assert_eq!(config.provenance("features.keep"), &Provenance::Override("features.keep=600".to_string()));
    assert_eq!(folder.hide(config.provenance("features.levels")), "DIR/c.yaml:3:11");
    assert_eq!(folder.hide(config.provenance("features.fast_initial")), "default");
}

#[test]
fn every_type_can_be_set() {
    let arguments = [
        "features.subpixel=false",
        "input.sensor=rgbd",
        "camera.k1=-1e-3",
        "stereo.min_depth_m=2",
        "input.mask=my: mask.png",
    ];
    let config = Config::load(None, &overrides(&arguments)).unwrap();
    assert!(!config.features.subpixel);
    assert_eq!(config.input.sensor, Some(Sensor::Rgbd));
    assert_eq!((config.camera.k1, config.stereo.min_depth_m), (-1e-3, Some(2.0)));
    assert_eq!(config.input.mask, Some("my: mask.png".into()));
    let folder = Folder::new();
    let again = Config::load(Some(&folder.write("c.yaml", config.to_yaml())), &[]).unwrap();
    assert_eq!(values(&again), values(&config), "a name with a colon is written so that it can be read");
}

#[test]
fn empty_files_and_sections_are_fine() {
    let folder = Folder::new();
    for text in ["", "# only a comment\n", "camera:\nfeatures:\n"] {
        let path = folder.write("c.yaml", text);
        assert_eq!(Config::load(Some(&path), &[]).unwrap(), Config::load(None, &[]).unwrap(), "{text:?}");
    }
}

#[test]
fn every_shipped_file_parses() {
    let paths = configs();
    assert!(paths.len() >= 2);
    for path in paths {
        if let Err(errors) = Config::load(Some(&path), &[]) {
            panic!("{errors}");
        }
    }
}

#[test]
fn shipped_files_hold_only_what_differs() {
    let defaults = values(&Config::load(None, &[]).unwrap());
    for path in configs() {
        let config = Config::load(Some(&path), &[]).unwrap();
        let differing = values(&config);
        for (entry, (value, default)) in SCHEMA.iter().zip(differing.iter().zip(&defaults)) {
            let is_given = config.provenance(entry.key) != &Provenance::Default;
            // The camera is given as a whole.
            let is_camera = entry.section() == "camera";
            assert_eq!(
                is_given,
                value != default || (is_given && is_camera),
                "{}: {}",
                path.display(),
                entry.key
            );
        }
    }
}

/// The values as the dump shows them, a line per key, without comments.
fn values(config: &Config) -> Vec<String> {
    config
        .to_yaml()
        .lines()
        .filter(|line| line.contains("  # "))
        .map(|line| line.rsplit_once("  # ").unwrap().0.to_string())
        .collect()
}

#[test]
fn the_dump_is_complete_and_says_where_values_come_from() {
    let folder = Folder::new();
    let path = folder.write("c.yaml", "features: {keep: 700}\n");
    let text = Config::load(Some(&path), &overrides(&["seed=3"])).unwrap().to_yaml();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(values(&Config::load(None, &[]).unwrap()).len(), SCHEMA.len());
    assert_eq!(lines[0], "# Complete configuration, as in force.");
    assert!(lines.contains(&"features:"));
    let has =
        |wanted: &str| assert!(lines.iter().any(|line| folder.hide(line) == wanted), "{wanted} in\n{text}");
    has("  keep: 700  # keypoints kept per image (DIR/c.yaml:1:18)");
    has("  fast_initial: 20  # FAST threshold tried first in a cell [gray levels]");
    has("  # fy:  # focal length, vertical [px]");
    has("seed: 3  # seed of all random numbers (--set seed=3)");
}

proptest! {
    #[test]
    fn the_dump_reads_back(
        keep in 50_usize..100_000, fx in 1e-3_f64..1e5, k1 in -10.0_f64..10.0, subpixel: bool, seed in 0_u64..(1 << 63),
        tolerance in 1e-9_f64..1.0, sensor in prop::sample::select(vec!["stereo", "rgbd", "mono"]),
    ) {
        let arguments = [
            format!("features.keep={keep}"), format!("camera.fx={fx}"), format!("camera.fy={fx}"),
            "camera.cx=1".to_string(), "camera.cy=-2.5".to_string(), format!("camera.k1={k1:e}"),
            format!("features.subpixel={subpixel}"), format!("seed={seed}"),
            format!("input.association_tolerance_s={tolerance:e}"), format!("input.sensor={sensor}"),
        ];
        let config = Config::load(None, &arguments).unwrap();
        prop_assert_eq!(config.camera.fx, Some(fx));
        prop_assert_eq!(config.camera.k1, k1);
        prop_assert_eq!(config.input.association_tolerance_s, tolerance);
        let folder = Folder::new();
        let path = folder.write("c.yaml", config.to_yaml());
        let again = Config::load(Some(&path), &[]).unwrap();
        prop_assert_eq!(&again.camera, &config.camera);
        prop_assert_eq!(&again.input, &config.input);
        prop_assert_eq!(&again.features, &config.features);
        prop_assert_eq!(again.seed, config.seed);
    }
}

#[test]
fn a_key_of_an_older_version_is_read_as_the_new_one_and_told() {
    for (frames, refines) in [("0", false), ("30", true)] {
        let argument = format!("stereo.calibration_frames={frames}");
        let config = Config::load(None, std::slice::from_ref(&argument)).unwrap();
        assert_eq!(config.mapping.refine_calibration, refines);
        let told = format!(
            "--set {argument}: stereo.calibration_frames is now mapping.refine_calibration = {refines}"
        );
        assert_eq!(config.renamed_keys(), [told]);
        assert_eq!(config.provenance("mapping.refine_calibration").to_string(), format!("--set {argument}"));
    }
    assert!(Config::load(None, &[]).unwrap().renamed_keys().is_empty());
    let refused = Config::load(None, &["stereo.calibration_frames=many".to_owned()]).unwrap_err().to_string();
    assert!(refused.contains("this key is gone"), "{refused}");
}
