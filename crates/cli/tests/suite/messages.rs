//! What goes to which stream, in which form.

use std::process::Command;

use serde_json::Value;

use super::support::{Call, N_FRAMES, dsslam, dsslam_in, ended, sandbox};

#[test]
fn json_is_the_summary_and_nothing_else() {
    let dir = sandbox();
    let args = ["run", "kitti/sequences/06", "--json", "--quiet", "--out", "out"];
    let Call { code, stdout, stderr } = dsslam_in(dir.path(), &args);
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    assert_eq!(stdout, std::fs::read_to_string(dir.path().join("out/summary.json")).unwrap());
    let summary: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(summary["frames"], N_FRAMES);
}

#[test]
fn the_layout_chooses_the_configuration_and_the_program_says_which() {
    let dir = sandbox();
    let run = |args: &[&str]| {
        let args = [&["kitti/sequences/06", "--out", "out"], args].concat();
        // The call is that of a user: nothing is added.
        let Call { code, stderr, .. } = dsslam_in(dir.path(), &[&["-v", "run"], &args[..]].concat());
        assert_eq!(code, Some(0), "{stderr}");
        let read = |name: &str| std::fs::read_to_string(dir.path().join("out").join(name)).unwrap();
        (stderr, serde_json::from_str::<Value>(&read("summary.json")).unwrap(), read("config.yaml"))
    };
    let (stderr, summary, config) = run(&[]);
    let line = "configuration kitti, built in, as the layout suggests; --config takes another";
    assert!(stderr.lines().any(|l| l == line), "{stderr}");
    assert_eq!(summary["preset"], "kitti");
    assert!(config.contains("fast_initial: 12"), "{config}");
    for (name, preset) in [("kitti", Value::Null), ("kitti.yaml", Value::Null), ("default", Value::Null)] {
        let lacks = ["--set", "features.selection=response"];
        let (stderr, summary, config) = run(&[&["--config", name], &lacks[..]].concat());
        assert_eq!(summary["preset"], preset, "{stderr}");
        assert_eq!(config.contains("fast_initial: 12"), name != "default", "{config}");
    }
    let args = ["run", "kitti/sequences/06", "--config", "kiti.yaml"];
    let Call { code, stderr, .. } = dsslam_in(dir.path(), &args);
    assert_eq!(
        (code, stderr.contains("built-in ones: default, euroc, kitti, tum-rgbd")),
        (Some(2), true),
        "{stderr}"
    );
}

#[test]
fn log_lines_are_json_objects_with_their_events() {
    let dir = sandbox();
    let args = ["run", "kitti/sequences/06", "-vv", "--log-format", "json", "--out", "out"];
    let Call { code, stderr, .. } = dsslam_in(dir.path(), &args);
    assert_eq!(code, Some(0), "{stderr}");
    let lines: Vec<Value> = stderr.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let n = |event: &str| lines.iter().filter(|line| line["event"] == event).count();
    assert_eq!((n("started"), n("frame")), (1, N_FRAMES));
    assert!(n("keyframe") >= 1, "{stderr}");
    assert!(lines.iter().all(|line| line["level"].is_string() && line["message"].is_string()));
    let frame = lines.iter().find(|line| line["event"] == "frame").unwrap();
    assert!(frame["track_ms"].as_f64().unwrap() > 0.0 && frame["state"] == "tracked", "{frame}");
    // An error is a line, too.
    let Call { code, stderr, .. } = dsslam_in(dir.path(), &["run", "nowhere", "--log-format", "json"]);
    let line: Value = serde_json::from_str(stderr.trim()).unwrap();
    assert_eq!((code, &line["level"]), (Some(2), &"error".into()));
}

#[test]
fn pipes_get_neither_bars_nor_colors() {
    let dir = sandbox();
    // The names of a desktop's settings that ask for colors do not make a pipe a terminal.
    let program = env!("CARGO_BIN_EXE_dsslam");
    let Call { code, stdout, stderr } = ended(
        Command::new(program)
            .args(["run", "kitti/sequences/06", "--set", "camera.fx=1", "--set", "camera.fy=1"])
            .args(["--set", "camera.cx=1", "--set", "camera.cy=1", "--out", "out"])
            .env("TERM", "xterm-256color")
            .current_dir(dir.path()),
    );
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stderr.contains("warning: camera.fx = 1"), "{stderr}");
    for text in [&stdout, &stderr] {
        assert!(!text.contains('\r') && !text.contains('\x1b'), "{text:?}");
    }
}

#[test]
fn more_is_said_when_asked_and_less_when_told() {
    let dir = sandbox();
    let said = |extra: &[&str]| {
        let args =
            [&["run", "kitti/sequences/06", "--set", "camera.fps=5", "--out", "out"][..], extra].concat();
        let Call { code, stderr, .. } = dsslam_in(dir.path(), &args);
        assert_eq!(code, Some(0), "{stderr}");
        stderr.lines().count()
    };
    let counts = [said(&["--quiet"]), said(&["-v"]), said(&["-vv"])];
    assert!(counts[0] == 0 && counts[1] > 0 && counts[2] >= counts[1] + N_FRAMES, "{counts:?}");
    assert_eq!(dsslam(&["-q", "-v", "doctor"]).0, Some(2));
}

#[test]
fn other_light_needs_a_second_round() {
    let dir = sandbox();
    for (more, reason) in [
        (&["--rounds", "1"][..], "found --rounds 1"),
        (&["--rounds", "2", "--preset", "facades"][..], "driven once"),
    ] {
        let mut args = vec!["synth", "relit", "--relight"];
        args.extend(more);
        let Call { code, stderr, .. } = dsslam_in(dir.path(), &args);
        assert!(code == Some(2) && stderr.contains("--relight") && stderr.contains(reason), "{stderr}");
        assert!(!dir.path().join("relit").exists(), "nothing is written");
    }
}
