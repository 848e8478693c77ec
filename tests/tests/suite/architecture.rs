//! The rules of docs/architecture.md, checked: who may depend on whom, how long a file may be, what the configurations
//! must hold.

use std::fs;
use std::path::{Path, PathBuf};

use crate::root;

/// Each crate with the workspace crates that it may depend on. Dependencies go down the list, never up or sideways.
const ALLOWED: &[(&str, &[&str])] = &[
    ("crates/geometry", &[]),
    ("crates/settings", &[]),
    ("crates/simd", &[]),
    ("crates/draw", &["geometry"]),
    ("crates/features", &["geometry", "settings", "simd"]),
    ("crates/dsfeat", &["geometry", "features"]),
    ("crates/optim", &["geometry", "simd"]),
    ("crates/io", &["geometry", "settings"]),
    ("crates/bag", &["geometry", "io"]),
    ("crates/bow", &["geometry", "simd", "features", "io"]),
    ("crates/map", &["geometry", "features"]),
    ("crates/export", &["geometry", "features", "io", "map", "draw"]),
    ("crates/slam", &["geometry", "settings", "features", "bow", "optim", "map"]),
    ("crates/events", &["geometry", "map"]),
    ("crates/runtime", &["geometry", "settings", "features", "bow", "map", "slam", "io", "events"]),
    ("crates/viewer", &["geometry", "draw", "events"]),
    ("crates/synth", &["geometry", "simd", "io"]),
    ("eval", &["geometry", "io", "draw"]),
    (
        "crates/dsslam",
        &[
            "geometry", "settings", "features", "dsfeat", "bow", "map", "slam", "events", "runtime", "io",
            "synth", "eval", "bag",
        ],
    ),
    (
        "crates/cli",
        &[
            "dsslam", "geometry", "features", "map", "slam", "runtime", "io", "bow", "synth", "eval", "draw",
            "export", "dsfeat", "events", "bag",
        ],
    ),
    ("crates/python", &["dsslam", "cli", "geometry", "map", "io", "eval"]),
    ("crates/cv", &["geometry"]),
    ("tests", &[]),
];

/// External crates that are slow to build or to start, each with the one crate that may use it.
const HEAVY: &[(&str, &str)] = &[
    ("opencv", "crates/cv"),
    ("plotters", "eval"),
    ("ab_glyph", "crates/draw"),
    ("crossbeam", "crates/runtime"),
    ("rerun", "crates/viewer"),
    ("faer", "crates/optim"),
    ("clarabel", "crates/optim"),
    ("ort", "crates/dsfeat"),
    ("rten", "crates/dsfeat"),
    ("pyo3", "crates/python"),
];

/// The longest a source file may be, lines.
const MAX_LINES: usize = 400;

/// Names under `[dependencies]` of a crate.
fn dependencies(krate: &str) -> Vec<String> {
    let manifest = fs::read_to_string(root().join(krate).join("Cargo.toml")).unwrap();
    let section = manifest.split_once("\n[dependencies]\n").map_or("", |(_, rest)| rest);
    section
        .lines()
        .take_while(|line| !line.starts_with('['))
        .filter_map(|line| line.split(['.', ' ', '=']).next())
        .filter(|name| !name.is_empty() && !name.starts_with('#'))
        .map(str::to_owned)
        .collect()
}

/// Folders of the workspace with a manifest, relative to the root.
fn crates() -> Vec<String> {
    let mut found = vec!["eval".to_owned(), "tests".to_owned()];
    for entry in fs::read_dir(root().join("crates")).unwrap() {
        found.push(format!("crates/{}", entry.unwrap().file_name().to_str().unwrap()));
    }
    found.sort();
    found
}

/// Rust files below a folder.
fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

pub(crate) fn all_rust_files() -> Vec<PathBuf> {
    let mut found = Vec::new();
    for krate in crates() {
        rust_files(&root().join(krate), &mut found);
    }
    found.sort();
    assert!(found.len() > 50, "only {} source files found", found.len());
    found
}

#[test]
fn every_crate_is_in_the_table_of_dependencies() {
    let mut listed: Vec<&str> = ALLOWED.iter().map(|&(krate, _)| krate).collect();
    listed.sort_unstable();
    assert_eq!(crates(), listed);
}

#[test]
fn dependencies_go_downward_only() {
    let names: Vec<&str> = ALLOWED.iter().map(|(krate, _)| krate.rsplit('/').next().unwrap()).collect();
    for (krate, allowed) in ALLOWED {
        for dependency in dependencies(krate) {
            let internal = names.contains(&dependency.as_str());
            assert!(
                !internal || allowed.contains(&dependency.as_str()),
                "{krate} may not depend on {dependency}: only on {allowed:?}"
            );
        }
    }
    assert!(dependencies("crates/slam").contains(&"map".to_owned()), "the manifests are read at all");
}

#[test]
fn heavy_dependencies_stand_in_one_crate_each() {
    for (heavy, owner) in HEAVY {
        let users: Vec<String> =
            crates().into_iter().filter(|krate| dependencies(krate).iter().any(|d| d == heavy)).collect();
        assert!(
            users.is_empty() || users == [owner.to_string()],
            "{heavy} is used by {users:?}, not by {owner} alone"
        );
    }
}

#[test]
fn no_file_is_too_long_and_each_says_what_it_is() {
    for path in all_rust_files() {
        let text = fs::read_to_string(&path).unwrap();
        let lines = text.lines().count();
        assert!(
            lines <= MAX_LINES,
            "{}: {lines} lines, more than {MAX_LINES}: split it by idea",
            path.display()
        );
        assert!(text.starts_with("//! "), "{}: does not open with a //! line", path.display());
    }
}

#[test]
fn nothing_is_left_for_later() {
    // Put together here, so that this file does not find itself.
    let marks =
        ["TO".to_owned() + "DO", "FIX".to_owned() + "ME", "XX".to_owned() + "X", "#[ig".to_owned() + "nore"];
    for path in all_rust_files() {
        let text = fs::read_to_string(&path).unwrap();
        for mark in &marks {
            assert!(!text.contains(mark.as_str()), "{}: holds {mark}", path.display());
        }
    }
}

#[test]
fn the_table_of_crates_names_every_crate() {
    let document = fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    for krate in crates() {
        assert!(
            document.contains(&format!("\n| `{krate}` |")),
            "docs/architecture.md has no row for `{krate}`"
        );
    }
}

#[test]
fn every_configuration_is_valid() {
    let mut n_files = 0;
    for entry in fs::read_dir(root().join("configs")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "yaml") {
            n_files += 1;
            if let Err(problems) = dsslam::Config::load(Some(&path), &[]) {
                panic!("{}: {problems}", path.display());
            }
        }
    }
    assert!(n_files >= 2, "configs/ holds {n_files} files");
}

/// Files and streams of Rerun are read by the viewer of the same version: whoever names one names the same.
#[test]
fn rerun_has_one_version() {
    let read = |file: &str| fs::read_to_string(root().join(file)).unwrap();
    let cargo = read("Cargo.toml");
    let line = cargo.lines().find(|line| line.starts_with("rerun = ")).unwrap();
    let version = line.split('"').nth(1).unwrap().trim_start_matches('=');
    for (file, before) in [
        ("README.md", "rerun-sdk=="),
        ("docs/viewer.md", "rerun-sdk=="),
        ("crates/cli/src/doctor/checks.rs", "RERUN_VERSION: &str = \""),
        ("crates/viewer/src/output.rs", "rerun-sdk=="),
    ] {
        assert!(
            read(file).contains(&format!("{before}{version}")),
            "{file} names another version than {version}"
        );
    }
}
