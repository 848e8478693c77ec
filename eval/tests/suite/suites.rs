//! A suite from its file to its report, with a small program in the place of `dsslam`.

use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use super::support::fixture;
use dsslam_eval::baseline::{Metric, read_baselines};
use dsslam_eval::figures::result_figures;
use dsslam_eval::report::html_report;
use dsslam_eval::suite::{
    Event, Plan, Results, RunOptions, RunRecord, RunState, job_lines, read_plan, run_suite,
};
use dsslam_eval::table::{metric_table, runs_csv, runs_table};
use dsslam_eval::{Estimate, Evaluation, EvaluationOptions};

/// Takes `run SEQUENCE ... --out DIR`; a sequence with a file `fail` makes it fail, with `sleep` makes it slow.
const PROGRAM: &str = r#"#!/bin/sh
sequence=$2
all="$*"
while [ $# -gt 0 ]; do
  if [ "$1" = --out ]; then out=$2; fi
  if [ "$1" = --set ]; then set_=$2; fi
  shift
done
echo "called $set_" >> "$sequence/calls"
echo "$all" >> "$sequence/arguments"
[ -f "$sequence/sleep" ] && sleep 20
[ -f "$sequence/problem" ] && problem="$(cat "$sequence/problem")"
[ -f "$sequence/fail" ] && { echo "error: no features" >&2; exit 1; }
cp "$sequence/evaluation.json" "$sequence"/*.tum.txt "$out"
cat > "$out/summary.json" <<JSON
{"version": "0", "frames": 300, "lost": 2, "dropped": 0, "keyframes": 9, "points": 99, "loops": 0, "alignment": "SE3",
 "ate_rmse_m": 0.5, "track_ms_median": 3.0, "wall_s": 1.5, "peak_rss_mb": 10.0, "new_key": [1], "evaluation_problem": ${problem:-null},
 "without_pose": [{"frame": 0, "state": "not_ready", "reason": "x"}, {"frame": 120, "state": "lost", "reason": "x"}]}
JSON
"#;

/// What a run writes that loses frames 0 and 120.
fn results_of_a_run(folder: &Path) {
    let times_s: Vec<f64> = (0..300).map(|i| f64::from(i) * 0.1).collect();
    let read = |name: &str| io::read_trajectory(&fixture(name), None).unwrap().at_frames(&times_s, 0);
    let (mut est, truth) = (read("kitti_est.txt"), read("kitti_gt.txt"));
    let is_lost = |i: usize| i == 0 || i == 120;
    let frames = est.poses.iter().enumerate();
    let estimate =
        Estimate::new(frames.map(|(i, p)| (p.timestamp_s, (!is_lost(i)).then_some(p.world_from_cam))));
    let evaluation = Evaluation::of(&estimate, &truth, &EvaluationOptions::default()).unwrap();
    std::fs::write(folder.join("evaluation.json"), serde_json::to_string(&evaluation).unwrap()).unwrap();
    est.poses.retain(|pose| ![0.0, times_s[120]].contains(&pose.timestamp_s));
    io::write_tum(&folder.join("trajectory.tum.txt"), &est).unwrap();
    io::write_tum(&folder.join("ground_truth.tum.txt"), &truth).unwrap();
}

struct Site {
    _folder: tempfile::TempDir,
    root: PathBuf,
}

impl Site {
    /// Sequences `good` and `bad` (which fails), a program and a suite.
    fn new() -> Site {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        for sequence in ["00", "bad"] {
            std::fs::create_dir(root.join(sequence)).unwrap();
            results_of_a_run(&root.join(sequence));
        }
        std::fs::write(root.join("bad/fail"), "").unwrap();
        let program = root.join("program.sh");
        std::fs::write(&program, PROGRAM).unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
        let suite = "name: small\ndataset: kitti\nsequences: [{name: '00', path: '00'}, {name: bad, path: bad}]\n\
                     configurations: [{name: a, set: [x=1]}, {name: b, sensor: stereo}]\nrepeats: 1\n";
        std::fs::write(root.join("suite.yaml"), suite).unwrap();
        Site { _folder: folder, root }
    }

    fn plan(&self) -> Plan {
        read_plan(&self.root.join("suite.yaml")).unwrap()
    }

    fn options(&self) -> RunOptions {
        RunOptions {
            program: self.root.join("program.sh"),
            results: self.root.join("results"),
            jobs: 2,
            retry_failed: false,
            only: None,
        }
    }

    fn run(&self, options: &RunOptions) -> Vec<RunRecord> {
        run_suite(&self.plan(), options, &|_| {}).unwrap()
    }

    fn n_calls(&self, sequence: &str) -> usize {
        std::fs::read_to_string(self.root.join(sequence).join("calls")).map_or(0, |text| text.lines().count())
    }
}

fn states(records: &[RunRecord]) -> Vec<String> {
    let state = |record: &RunRecord| match &record.state {
        RunState::Done => format!("{} done", record.id),
        RunState::Failed { reason } => format!("{} {reason}", record.id),
    };
    records.iter().map(state).collect()
}

#[test]
fn a_failure_does_not_end_the_suite_and_what_has_ended_is_not_run_again() {
    let site = Site::new();
    let first = site.run(&site.options());
    let expected = [
        "00/a/1 done",
        "00/b/1 done",
        "bad/a/1 exit status: 1: error: no features",
        "bad/b/1 exit status: 1: error: no features",
    ];
    assert_eq!(states(&first), expected);
    assert_eq!((site.n_calls("00"), site.n_calls("bad")), (2, 2));

    let skipped = Mutex::new(0);
    let again = run_suite(&site.plan(), &site.options(), &|event| {
        if matches!(event, Event::Skipped(_)) {
            *skipped.lock().unwrap() += 1;
        }
    });
    assert_eq!(again.unwrap(), first);
    assert_eq!((*skipped.lock().unwrap(), site.n_calls("00"), site.n_calls("bad")), (4, 2, 2));

    std::fs::remove_file(site.root.join("bad/fail")).unwrap();
    let retried = site.run(&RunOptions { retry_failed: true, ..site.options() });
    assert!(retried.iter().all(|r| r.state == RunState::Done));
    assert_eq!((site.n_calls("00"), site.n_calls("bad")), (2, 4));
}

#[test]
fn a_run_of_an_older_version_keeps_its_summary_and_says_so() {
    let site = Site::new();
    let options = RunOptions { only: Some("00/a".to_owned()), ..site.options() };
    site.run(&options);
    let folder = site.root.join("results");
    let ate =
        |results: &Results| metric_table(results, &[], Metric::AteRmseM).unwrap().rows[0].cells[0].value;
    let written = ate(&Results::read(&folder).unwrap()).unwrap();
    assert!((written - 0.49).abs() < 0.01, "{written}");
    // Such a file compared the left camera with EuRoC's body.
    std::fs::write(folder.join("00/a/1/evaluation.json"), "{\"t_rel_percent\": 148.8}").unwrap();
    site.run(&options);
    assert_eq!(site.n_calls("00"), 1, "the run itself is as good as before");
    let results = Results::read(&folder).unwrap();
    assert_eq!(ate(&results), Some(0.5), "of summary.json");
    let told = "no evaluation.json of this version, so the figures are those of summary.json";
    assert_eq!(results.runs[0].problem().as_deref(), Some(told));
    let (_, problems) = result_figures(&results, &[]);
    assert_eq!(problems, ["00/a/1: no usable evaluation.json, which says how to align the estimate"]);
}

#[test]
fn the_program_is_told_how_to_evaluate() {
    let site = Site::new();
    let suite = "name: small\nsequences: [{name: '00', path: '00', ground_truth: 00/ground_truth.tum.txt}]\n\
                 configurations: [{name: a}]\nlengths_m: [10, 20.5]\n";
    std::fs::write(site.root.join("suite.yaml"), suite).unwrap();
    site.run(&site.options());
    let root = site.root.display();
    let expected = format!(
        "run {root}/00 --ground-truth {root}/00/ground_truth.tum.txt --lengths 10,20.5 --out {root}/results/00/a/1\n"
    );
    assert_eq!(std::fs::read_to_string(site.root.join("00/arguments")).unwrap(), expected);
}

#[test]
fn an_interrupted_run_and_a_changed_one_are_run_again() {
    let site = Site::new();
    let options = RunOptions { only: Some("00/a".to_owned()), ..site.options() };
    site.run(&options);
    // Interrupted: the folder holds files, but no record of an end.
    std::fs::remove_file(site.root.join("results/00/a/1/run.json")).unwrap();
    site.run(&options);
    assert_eq!(site.n_calls("00"), 2);
    let suite = std::fs::read_to_string(site.root.join("suite.yaml")).unwrap();
    std::fs::write(site.root.join("suite.yaml"), suite.replace("x=1", "x=2")).unwrap();
    site.run(&options);
    let calls = std::fs::read_to_string(site.root.join("00/calls")).unwrap();
    assert_eq!(calls, "called x=1\ncalled x=1\ncalled x=2\n");
}

#[test]
fn a_run_that_hangs_is_stopped() {
    let site = Site::new();
    std::fs::write(site.root.join("00/sleep"), "").unwrap();
    let plan = Plan { timeout_s: Some(0.3), ..site.plan() };
    let options = RunOptions { only: Some("00/a/1".to_owned()), ..site.options() };
    let records = run_suite(&plan, &options, &|_| {}).unwrap();
    assert_eq!(states(&records), ["00/a/1 stopped after the time limit of 0.3 s"]);
}

#[test]
fn a_program_that_is_not_there_is_named() {
    let site = Site::new();
    let options =
        RunOptions { program: site.root.join("nowhere"), only: Some("00/a".to_owned()), ..site.options() };
    let reason = states(&site.run(&options)).remove(0);
    assert!(reason.contains("cannot start") && reason.contains("nowhere: No such file"), "{reason}");
}

#[test]
fn a_run_that_could_not_be_compared_is_said() {
    let site = Site::new();
    std::fs::write(site.root.join("00/problem"), "\"no overlap in time\"").unwrap();
    let records = site.run(&RunOptions { only: Some("00/a".to_owned()), ..site.options() });
    assert_eq!(records[0].evaluation_problem.as_deref(), Some("no overlap in time"));
    let results = Results::read(&site.root.join("results")).unwrap();
    assert_eq!(results.runs[0].problem().as_deref(), Some("cannot be evaluated: no overlap in time"));
}

#[test]
fn each_run_has_its_command_for_other_engines() {
    let site = Site::new();
    let options = RunOptions { results: PathBuf::from("/tmp/my results"), ..site.options() };
    let lines =
        job_lines(&site.plan(), Path::new("/s/suite.yaml"), Path::new("/bin/dsslam"), &options).unwrap();
    let program = site.root.join("program.sh");
    let expected = format!(
        "/bin/dsslam eval run /s/suite.yaml --out '/tmp/my results' --only 00/a/1 --program {}",
        program.display()
    );
    assert_eq!((lines.len(), &lines[0]), (4, &expected));
    let none = RunOptions { only: Some("0".to_owned()), ..site.options() };
    let message = job_lines(&site.plan(), Path::new("s"), Path::new("p"), &none).unwrap_err().to_string();
    assert_eq!(message, "'0' is not a run of the suite small; runs are <sequence>/<configuration>/<repeat>");
}

#[test]
fn tables_count_what_was_lost_and_name_what_failed() {
    let site = Site::new();
    site.run(&site.options());
    let results = Results::read(&site.root.join("results")).unwrap();
    let baselines = read_baselines(None).unwrap();
    let table = metric_table(&results, &baselines, Metric::TRelPercent).unwrap();
    assert_eq!(
        table.columns,
        ["a", "b", "DSFeat (paper)", "ORB-SLAM2 (DSFeat paper)", "ORB-SLAM2 (published)"]
    );
    let names: Vec<&str> = table.rows.iter().map(|row| row.name.as_str()).collect();
    assert_eq!(names, ["00", "bad", "mean", "pooled"]);
    let cell = &table.rows[0].cells[0];
    assert!(cell.has_lost_frames && cell.value.is_some());
    assert_eq!((table.rows[0].cells[4].text.as_str(), table.rows[1].cells[0].text.as_str()), ("-", "failed"));
    let cut = "00: 300 of 4541 frames: no published figure to compare with";
    assert!(table.notes.iter().any(|note| note == cut), "{:?}", table.notes);
    let lost = "\u{2020} 00/a/1: 2 of 300 frames without a pose of their own (coverage 99.33 %)";
    assert!(table.notes.iter().any(|note| note == lost), "{:?}", table.notes);
    assert!(table.notes.iter().any(|note| note == "bad/a/1: failed: exit status: 1: error: no features"));
    assert!(table.notes.iter().any(|note| note.starts_with("ORB-SLAM2 (published): R. Mur-Artal")));
    assert!(metric_table(&results, &baselines, Metric::Auc).is_none());

    // ATE is over the 298 frames with a pose; drift over all, the lost ones filled.
    let evaluation = results.runs[0].evaluation.clone().unwrap();
    assert_eq!((evaluation.n_used, evaluation.coverage.n_lost, evaluation.n_segments), (298, 2, 36));
    assert_eq!(runs_table(&results).rows.len(), 4);
    let csv = runs_csv(&results);
    let columns: Vec<usize> = csv.lines().map(|line| line.split(',').count()).collect();
    assert_eq!(columns, [columns[0]; 5]);
}

#[test]
fn published_figures_stand_beside_whole_sequences_only() {
    let site = Site::new();
    let baselines = read_baselines(None).unwrap();
    let published = |results: &Results, metric| {
        metric_table(results, &baselines, metric).unwrap().rows[0].cells[4].text.clone()
    };
    site.run(&RunOptions { only: Some("bad".to_owned()), ..site.options() });
    let mut results = Results::read(&site.root.join("results")).unwrap();
    // Nothing says that the sequence is cut short.
    assert_eq!(published(&results, Metric::TRelPercent), "0.70");
    results.plan.lengths_m = vec![10.0];
    let table = metric_table(&results, &baselines, Metric::TRelPercent);
    assert!(table.is_none_or(|table| table.columns == ["a", "b"]));
    results.plan.sequences[0].max_frames = Some(100);
    let table = metric_table(&results, &baselines, Metric::AteRmseM).unwrap();
    assert_eq!(table.rows[0].cells[2].text, "-");
    assert!(
        table.notes.contains(&"00: not all of 4541 frames: no published figure to compare with".to_owned())
    );
}

#[test]
fn the_report_stands_alone() {
    let site = Site::new();
    site.run(&site.options());
    std::fs::write(
        site.root.join("results/00/a/1/detections.csv"),
        "# events 3\nscore,correct\n1,1\n2,0\n3,1\n",
    )
    .unwrap();
    let results = Results::read(&site.root.join("results")).unwrap();
    let baselines = read_baselines(None).unwrap();
    let (figures, problems) = result_figures(&results, &baselines);
    assert!(problems.is_empty(), "{problems:?}");
    let names: Vec<&str> = figures.iter().map(|f| f.name.as_str()).collect();
    let expected = [
        "bars_t_rel",
        "bars_r_rel",
        "bars_ate",
        "bars_auc",
        "drift_length",
        "drift_speed",
        "precision_recall_00",
        "00_a_top",
        "00_a_side",
        "00_a_error",
        "00_b_top",
        "00_b_side",
        "00_b_error",
    ];
    assert_eq!(names, expected);
    let html = html_report(&results, &baselines, &figures, &problems).unwrap();
    assert_eq!(html.matches("<svg").count(), figures.len());
    // Nothing is loaded from elsewhere.
    for load in ["src=", "href=", "@import", "url("] {
        assert!(!html.contains(load), "the report contains {load}");
    }
    assert!(html.contains("2 of 4 runs of version 0 have a result"));
}

#[test]
fn a_folder_without_results_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let message = format!("{:#}", Results::read(folder.path()).unwrap_err());
    assert!(message.contains("is not a results folder of 'dsslam eval run'"), "{message}");
}
