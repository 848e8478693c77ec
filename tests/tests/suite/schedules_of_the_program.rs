//! The program's schedules, maps and journals: checksums of trajectory and map are equal where they must be, and files
//! that cannot be used are named before anything is run.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::program::{command, dsslam, ended, summary, text};
use crate::root;
use crate::sensors::rendered_radtan;
use crate::sequence::{Copy, N_RENDERED, rendered};

/// A run of the rendered sequence or of a real one, with its summary.
fn run(sequence: &Path, out: &Path, threads: usize, args: &[&str]) -> Value {
    let map = out.join("map.dsmap");
    let mut all = vec!["run", text(sequence), "--out", text(out), "--save-map", text(&map)];
    all.extend(args);
    ended(command(&all).env("RAYON_NUM_THREADS", threads.to_string()).output().unwrap()).expect_success();
    summary(out)
}

/// Checksums of trajectory and map.
fn sums(summary: &Value) -> [&Value; 3] {
    ["trajectory_sha256", "map_sha256", "map_digest"].map(|key| &summary[key])
}

/// `Sequential` twice, `Lockstep` with 1, 2 and 4 threads under random pauses.
fn check_schedules(sequence: &Path, args: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str, threads: usize, more: &[&str]| {
        run(sequence, &folder.path().join(name), threads, &[args, more].concat())
    };
    let first = of("first", 2, &["--schedule", "sequential"]);
    assert_eq!((&first["schedule"], &first["lost"]), (&"sequential".into(), &0.into()), "{first:#}");
    assert!(first["map_sha256"].as_str().is_some_and(|sum| sum.len() == 64), "{first:#}");
    assert_eq!(sums(&first), sums(&of("second", 1, &["--schedule", "sequential"])), "in turn, twice");
    for (threads, seed) in [(1, "11"), (2, "12"), (4, "13")] {
        let summary = of(&format!("{threads}"), threads, &["--delays", seed]);
        assert_eq!(summary["schedule"], "lockstep");
        assert_eq!(sums(&first), sums(&summary), "lockstep with {threads} threads");
    }
}

#[test]
fn schedules_and_threads_do_not_change_a_rendered_drive() {
    check_schedules(rendered(), &[]);
}

#[test]
fn schedules_and_threads_do_not_change_a_drive_with_one_camera() {
    check_schedules(rendered(), &["--sensor", "mono"]);
}

#[test]
fn schedules_and_threads_do_not_change_a_drive_with_raw_cameras() {
    check_schedules(rendered_radtan(), &[]);
}

#[test]
fn schedules_and_threads_do_not_change_a_real_drive() {
    match std::env::var_os("DSSLAM_DATA") {
        None => println!("skipped: DSSLAM_DATA is not set, so kitti06_first51 is not available"),
        Some(data) => {
            let config = root().join("configs/kitti.yaml");
            let sequence = PathBuf::from(data).join("kitti06_first51");
            let args = ["--config", text(&config), "--set", "mapping.neighbours=11"];
            check_schedules(&sequence, &args);
        }
    }
}

#[test]
fn a_live_run_is_replayed_from_its_journal() {
    let folder = tempfile::tempdir().unwrap();
    let [live, again] = ["live", "again"].map(|name| folder.path().join(name));
    let journal = folder.path().join("journals/run.json");
    let args = ["--schedule", "live", "--realtime", "--journal", text(&journal), "--delays", "3"];
    let first = run(rendered(), &live, 2, &args);
    assert_eq!((&first["schedule"], &first["frames"]), (&"live".into(), &N_RENDERED.into()), "{first:#}");
    let second = run(rendered(), &again, 1, &["--replay", text(&journal)]);
    assert_eq!(second["schedule"], "replay");
    assert_eq!(sums(&first), sums(&second));
    let frames = |out: &Path| fs::read_to_string(out.join("frames.csv")).unwrap();
    assert_eq!(frames(&live), frames(&again));

    fs::write(&journal, "{}").unwrap();
    let copy = Copy::of_first(3);
    let line = format!("error: {}: not a journal: the version is missing", journal.display());
    copy.run(&["--replay", text(&journal)]).expect(2, &line);
}

#[test]
fn a_map_of_the_first_half_localizes_the_second() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    let half = run(rendered(), &first, 2, &["--max-frames", "25"]);
    let map = first.join("map.dsmap");
    let found = run(rendered(), &second, 2, &["--load-map", text(&map), "--localize"]);
    assert_eq!(found["keyframes"], half["keyframes"], "nothing is inserted");
    assert!(found["relocalizations"].as_u64() >= Some(1), "{found:#}");
    assert!(found["tracked"].as_u64() >= Some(25), "{found:#}");
    assert!(found["ate_rmse_m"].as_f64().unwrap() < 0.2, "{found:#}");
}

#[test]
fn what_cannot_be_used_is_named_before_the_run() {
    let copy = Copy::of_first(3);
    let folder = tempfile::tempdir().unwrap();
    let refused = |args: &[&str], code: i32, line: &str| {
        copy.run(args).expect(code, line);
        assert!(!copy.results().join("summary.json").exists(), "{line}: there was a run");
    };
    let file = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, content).unwrap();
        path
    };
    let no_map = file("no.dsmap", b"something else");
    let line = format!(
        "error: {}: not a map file: it begins with `somethin`, expected a file that begins with `DSMAP`",
        no_map.display()
    );
    refused(&["--load-map", text(&no_map)], 2, &line);
    let missing = folder.path().join("missing.dsmap");
    let line =
        format!("error: {}: cannot be read: No such file or directory (os error 2)", missing.display());
    refused(&["--load-map", text(&missing)], 2, &line);
    refused(&["--realtime"], 2, "error: --realtime needs --schedule live");
    let line = format!("error: {}: cannot be written: it is a folder", folder.path().display());
    refused(&["--save-map", text(folder.path())], 3, &line);
    let below_a_file = no_map.join("x.dsmap");
    let call = copy.run(&["--save-map", text(&below_a_file)]);
    assert!(call.code == 3 && call.stderr.contains("cannot be written"), "{call}");
    let call = dsslam(&["run", text(&copy.path()), "--localize"]);
    assert!(call.code == 2 && call.stderr.contains("--load-map"), "{call}");
}

#[test]
fn without_loops_the_run_says_so() {
    let copy = Copy::of_first(4);
    copy.run(&["--no-loops"]).expect_success();
    let config = fs::read_to_string(copy.results().join("config.yaml")).unwrap();
    assert!(config.contains("\n  enabled: false"), "{config}");
    assert_eq!(fs::read_to_string(copy.results().join("loops.csv")).unwrap().lines().count(), 1);
    let rows = fs::read_to_string(copy.results().join("frames.csv")).unwrap();
    assert_eq!(rows.lines().count(), 5);
    assert!(rows.lines().nth(1).unwrap().starts_with("0,0,tracked,"), "{rows}");
}
