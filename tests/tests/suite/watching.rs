//! Who watches the program's runs: the file of events, and viewers that are there, missing, or die in the middle.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use events::{Record, StreamReader};

use crate::program::{Call, command, dsslam, ended, program, summary, text};
use crate::sequence::{N_RENDERED, rendered};

/// The records of `events.dslog`.
pub(crate) fn records(results: &Path) -> Vec<Record> {
    let file = fs::File::open(results.join("events.dslog")).unwrap();
    let mut reader = StreamReader::new(std::io::BufReader::new(file)).unwrap();
    let mut records = Vec::new();
    while let Some(record) = reader.next_record().unwrap() {
        records.push(record);
    }
    records
}

#[test]
fn events_tell_the_run_and_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let [plain, watched] = ["plain", "watched"].map(|name| folder.path().join(name));
    dsslam(&["run", text(rendered()), "--out", text(&plain)]).expect_success();
    dsslam(&["run", text(rendered()), "--out", text(&watched), "--events"]).expect_success();
    for key in ["trajectory_sha256", "map_digest"] {
        assert_eq!(summary(&plain)[key], summary(&watched)[key], "{key}");
    }
    assert!(!plain.join("events.dslog").exists(), "nothing is written that was not asked for");
    let records = records(&watched);
    let Some(Record::Start(start)) = records.first() else { panic!("no start") };
    assert_eq!((start.n_frames, start.truth.len() as u32), (N_RENDERED, N_RENDERED));
    let Some(Record::End(end)) = records.last() else { panic!("no end") };
    assert!(end.summary.contains("ATE") && end.trajectory.len() == N_RENDERED as usize, "{}", end.summary);
    assert!(
        records
            .iter()
            .any(|r| matches!(r, Record::Stages { stages, .. } if stages.iter().any(|s| s.name == "map")))
    );
    // A run without events into the same folder leaves none that would belong to another run.
    dsslam(&["run", text(rendered()), "--out", text(&watched), "--max-frames", "3"]).expect_success();
    assert!(!watched.join("events.dslog").exists());
}

/// The program in a folder of its own, with a shell script beside it as its viewer.
pub(crate) fn with_viewer(folder: &Path, script: &str) -> PathBuf {
    let copy = folder.join("dsslam");
    fs::copy(program(), &copy).unwrap();
    let viewer = folder.join("dsslam-rerun");
    fs::write(&viewer, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(&viewer, fs::Permissions::from_mode(0o755)).unwrap();
    copy
}

/// A run of the copied program with these arguments.
fn watched(program: &Path, out: &Path, args: &[&str]) -> Call {
    let mut command = std::process::Command::new(program);
    command
        .args(["run", text(rendered()), "--config", "default", "--out", text(out)])
        .args(args)
        .env("NO_COLOR", "1");
    ended(command.output().unwrap())
}

#[test]
fn the_viewer_gets_its_arguments_and_the_whole_stream() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let program = with_viewer(
        folder.path(),
        "here=$(dirname \"$0\"); echo \"$@\" > \"$here/args\"; mkdir -p \"$here/out\"; cat > \"$here/out/stream\"",
    );
    let rrd = folder.path().join("a.rrd");
    watched(&program, &out, &["--rerun-save", text(&rrd)]).expect_success();
    assert_eq!(
        fs::read_to_string(folder.path().join("args")).unwrap(),
        format!("- --save {}\n", rrd.display())
    );
    fs::rename(out.join("stream"), out.join("events.dslog")).unwrap();
    assert!(matches!(records(&out).last(), Some(Record::End(_))));
}

#[test]
fn a_viewer_that_dies_does_not_end_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain");
    dsslam(&["run", text(rendered()), "--out", text(&plain)]).expect_success();
    let scripts = [("at once", "exit 7"), ("in the middle", "head -c 100000 > /dev/null; kill -9 $$")];
    for (name, script) in scripts {
        let place = folder.path().join(name);
        fs::create_dir(&place).unwrap();
        let out = place.join("out");
        let call = watched(&with_viewer(&place, script), &out, &["--rerun"]);
        call.expect_success();
        let told = "the run continued without it";
        assert!(
            call.stderr.contains(told) || call.stderr.contains("the viewer ended with"),
            "{name}: {call}"
        );
        assert_eq!(summary(&out)["trajectory_sha256"], summary(&plain)["trajectory_sha256"], "{name}");
    }
}

#[test]
fn a_viewer_that_is_not_there_is_told_before_anything_is_run() {
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("dsslam");
    fs::copy(program(), &copy).unwrap();
    let out = folder.path().join("out");
    let mut command = std::process::Command::new(&copy);
    command
        .args(["run", text(rendered()), "--out", text(&out), "--rerun"])
        .env("PATH", "")
        .env("NO_COLOR", "1");
    ended(command.output().unwrap()).expect(
        2,
        "error: dsslam-rerun was found neither beside this program nor in PATH: build it with ./install.sh --rerun",
    );
    assert!(!out.exists());
    let call = ended(self::command(&["run", "x", "--rerun", "--rerun-save", "a.rrd"]).output().unwrap());
    assert!(call.code == 2 && call.stderr.contains("cannot be used with"), "{call}");
}
