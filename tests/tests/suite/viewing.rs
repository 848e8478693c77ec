//! `dsslam view`: what the viewer is given of a finished run, with its events and without.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use events::{FrameState, Record, Scene};

use crate::program::{Call, dsslam, ended, text};
use crate::sequence::{N_RENDERED, rendered};
use crate::watching::{records, with_viewer};

/// A script that writes down its arguments and what comes through its pipe.
const NOTES: &str = "here=$(dirname \"$0\"); echo \"$@\" > \"$here/args\"; mkdir -p \"$here/got\"; cat > \"$here/got/events.dslog\"";

/// A program with a viewer that takes notes.
struct Desk {
    folder: tempfile::TempDir,
    program: PathBuf,
}

impl Desk {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let program = with_viewer(folder.path(), NOTES);
        Self { folder, program }
    }

    fn view(&self, args: &[&str]) -> Call {
        let mut command = Command::new(&self.program);
        ended(command.arg("view").args(args).env("NO_COLOR", "1").output().unwrap())
    }

    /// What the viewer was called with.
    fn args(&self) -> String {
        fs::read_to_string(self.folder.path().join("args")).unwrap().trim_end().to_owned()
    }

    /// What came through its pipe, added up.
    fn scene(&self) -> Scene {
        let mut scene = Scene::default();
        records(&self.folder.path().join("got")).iter().for_each(|record| scene.apply(record));
        scene
    }
}

fn run(out: &Path, args: &[&str]) {
    dsslam(&[&["run", text(rendered()), "--out", text(out)], args].concat()).expect_success();
}

#[test]
fn events_are_shown_from_their_file() {
    let desk = Desk::new();
    let results = desk.folder.path().join("results");
    run(&results, &["--max-frames", "5", "--events"]);
    let rrd = desk.folder.path().join("new/run.rrd");
    let file = results.join("events.dslog");
    for (args, expected) in [
        (&[][..], format!("{}", file.display())),
        (&["--save", text(&rrd)], format!("{} --save {}", file.display(), rrd.display())),
        (&["--connect"], format!("{} --connect", file.display())),
    ] {
        desk.view(&[&[text(&results)], args].concat()).expect_success();
        assert_eq!(desk.args(), expected);
    }
}

#[test]
fn a_run_without_events_is_shown_from_its_other_files() {
    let desk = Desk::new();
    let [results, map] = ["results", "town.dsmap"].map(|name| desk.folder.path().join(name));
    run(&results, &["--save-map", text(&map)]);
    let trajectory =
        io::read_trajectory(&results.join("trajectory.kitti.txt"), None).unwrap().trajectory.poses;
    for args in [&[][..], &["--map", text(&map)]] {
        desk.view(&[&[text(&results)], args].concat()).expect_success();
        assert_eq!(desk.args(), "-");
        let scene = desk.scene();
        let start = scene.start().unwrap();
        assert_eq!((start.n_frames, start.truth.len() as u32), (N_RENDERED, N_RENDERED));
        for (index, expected) in (0..).zip(&trajectory) {
            let frame = scene.frame(index).unwrap();
            assert_eq!(frame.state, FrameState::Tracked);
            let gap = frame.world_from_cam.unwrap().translation - expected.world_from_cam.translation;
            assert!(gap.norm() < 1e-9, "frame {index}: {gap}");
        }
        assert_eq!(scene.n_points() > 500 && scene.keyframes().len() > 2, !args.is_empty());
        let errors = scene.errors_m(&scene.alignment().unwrap());
        assert!(errors.len() == N_RENDERED as usize && errors.iter().all(|(_, error)| *error < 0.2));
    }
    let received = records(&desk.folder.path().join("got"));
    let with_times =
        |r: &&Record| matches!(r, Record::Frame(frame) if frame.stages.iter().any(|s| s.ms > 0.0));
    assert_eq!(received.iter().filter(with_times).count(), N_RENDERED as usize);
    let Some(Record::End(end)) = received.last() else { panic!("no end") };
    assert!(end.summary.contains("| ate_rmse_m | 0."), "{}", end.summary);
}

#[test]
fn what_cannot_be_viewed_is_named() {
    let desk = Desk::new();
    let folder = desk.folder.path();
    desk.view(&["/no/such"]).expect(2, "error: /no/such: not a results folder");
    let call = desk.view(&[text(folder)]);
    assert_eq!(call.code, 2, "{call}");
    assert!(call.stderr.contains("summary.json: cannot be read; `dsslam run` writes it"), "{call}");
    assert!(!folder.join("args").exists(), "the viewer was not started");
    let results = folder.join("results");
    run(&results, &["--max-frames", "3"]);
    fs::write(results.join("frames.csv"), "frame,timestamp_s,state,submap,inliers,reason\n0,0.0,flying,,,\n")
        .unwrap();
    let call = desk.view(&[text(&results)]);
    assert!(
        call.code == 2 && call.stderr.contains("frames.csv line 2: state `flying`, expected tracked"),
        "{call}"
    );
    fs::write(results.join("events.dslog"), "").unwrap();
    fs::write(folder.join("dsslam-rerun"), "#!/bin/sh\nexit 3\n").unwrap();
    desk.view(&[text(&results)]).expect(3, "error: the viewer ended with exit status: 3");
}
