//! The command line as the `dsslam` program includes it.

use std::path::Path;

use super::support::fixture;
use clap::{CommandFactory, Parser, Subcommand};
use dsslam_eval::command::EvalCommand;

#[derive(Debug, Parser)]
struct Program {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    #[command(subcommand)]
    Eval(EvalCommand),
}

fn run(arguments: &[&str]) -> anyhow::Result<()> {
    let all = ["dsslam", "eval"].iter().chain(arguments);
    let Command::Eval(command) = Program::try_parse_from(all)?.command;
    command.run()
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

fn message(arguments: &[&str]) -> String {
    format!("{:#}", run(arguments).unwrap_err())
}

#[test]
fn the_arguments_are_consistent() {
    Program::command().debug_assert();
}

#[test]
fn a_pair_of_files_with_plots() {
    let folder = tempfile::tempdir().unwrap();
    let (est, gt, out) =
        (text(&fixture("kitti_est.txt")), text(&fixture("kitti_gt.txt")), text(folder.path()));
    run(&["traj", &est, &gt, "--plots", &out]).unwrap();
    for name in ["trajectory_top", "trajectory_side", "error", "drift_length", "drift_speed"] {
        for extension in ["png", "svg"] {
            assert!(folder.path().join(format!("{name}.{extension}")).is_file(), "{name}.{extension}");
        }
    }
    run(&[
        "traj",
        &text(&fixture("tum_est.txt")),
        &text(&fixture("tum_gt.txt")),
        "--align",
        "sim3",
        "--json",
    ])
    .unwrap();
    run(&["traj", &text(&fixture("kitti_est_numbered.txt")), &gt, "--lost", "skip", "--lengths", "50"])
        .unwrap();
}

#[test]
fn loops_with_scores_become_a_curve() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("loops.csv"), "query,answer,score\n2,0,0.5\n3,2,1.5\n3,1,2.5\n").unwrap();
    std::fs::write(at("matrix.txt"), "0 0 0 0\n0 0 0 0\n1 0 0 0\n0 1 0 0\n").unwrap();
    let (loops, matrix) = (text(&at("loops.csv")), text(&at("matrix.txt")));
    let (out, plots) = (text(&at("detections.csv")), text(&at("plots")));
    run(&["loops", &loops, "--matrix", &matrix, "--out", &out, "--plots", &plots]).unwrap();
    let expected = "# events 2\nscore,correct\n0.5,1\n1.5,0\n2.5,1\n";
    assert_eq!(std::fs::read_to_string(at("detections.csv")).unwrap(), expected);
    assert!(at("plots/precision_recall.png").is_file());
    run(&["loops", &loops, "--poses", &text(&fixture("kitti_gt.txt")), "--min-gap", "1"]).unwrap();
    std::fs::write(at("loops.csv"), "1;2\n").unwrap();
    let expected = format!("{loops}:1: found '1;2', expected query,answer or query,answer,score");
    assert_eq!(message(&["loops", &loops, "--matrix", &matrix]), expected);
}

#[test]
fn messages_name_the_files() {
    let (est, gt) = (text(&fixture("kitti_est.txt")), text(&fixture("tum_gt.txt")));
    assert_eq!(
        message(&["traj", &est, &gt]),
        format!(
            "cannot compare {est} with {gt}: a KITTI file has no timestamps: match by index, or give both files in a format \
             with times"
        )
    );
    let folder = tempfile::tempdir().unwrap();
    let plain = text(folder.path());
    assert!(
        message(&["table", &plain])
            .starts_with(&format!("{plain} is not a results folder of 'dsslam eval run'"))
    );
    assert!(message(&["run", &text(&folder.path().join("none.yaml"))]).starts_with("cannot read "));
}
