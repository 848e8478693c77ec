//! Time to evaluate a KITTI pair of 4541 poses, and to build the tables of a whole suite.
#![allow(clippy::unwrap_used, missing_docs, reason = "a benchmark")]

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use dsslam_eval::baseline::{Metric, read_baselines};
use dsslam_eval::suite::Results;
use dsslam_eval::table::{metric_table, runs_csv, runs_table};
use dsslam_eval::{Association, Estimate, Evaluation, EvaluationOptions};
use geometry::{SE3, SO3, Vec3};
use io::{TrajectoryFile, read_trajectory};

const N_POSES: usize = 4541;

/// A drive as long as KITTI 00 in KITTI's format; every step of the estimate errs by `error`.
fn drive(error: f64) -> String {
    let mut pose = SE3::identity();
    let mut text = String::new();
    for i in 0..N_POSES {
        let row: Vec<String> = pose.rows_3x4().iter().map(|v| format!("{v:.9e}")).collect();
        text += &format!("{}\n", row.join(" "));
        let turn = 0.03 * (i as f64 / 40.0).sin() + error;
        pose = pose * SE3::new(SO3::exp(&Vec3::new(0.0, turn, 0.0)), Vec3::new(0.0, error, 0.82 + error));
    }
    text
}

fn evaluate(estimate: &TrajectoryFile, truth: &TrajectoryFile) -> Evaluation {
    let options = EvaluationOptions { association: Association::Index, ..EvaluationOptions::default() };
    Evaluation::of(&Estimate::of_file(estimate), &truth.trajectory, &options).unwrap()
}

fn pair(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let (gt, est) = (folder.path().join("gt.txt"), folder.path().join("est.txt"));
    std::fs::write(&gt, drive(0.0)).unwrap();
    std::fs::write(&est, drive(1e-4)).unwrap();
    let read = |path: &Path| read_trajectory(path, None).unwrap();
    let (truth, estimate) = (read(&gt), read(&est));
    criterion.bench_function("evaluate a pair of 4541 poses in memory", |b| {
        b.iter(|| black_box(evaluate(&estimate, &truth)));
    });
    criterion.bench_function("read and evaluate a pair of 4541 poses", |b| {
        b.iter(|| black_box(evaluate(&read(&est), &read(&gt))));
    });
}

/// 11 sequences, 3 configurations, 3 repeats.
fn tables(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<String> = (0..11).map(|i| format!("{i:02}")).collect();
    let sequences: Vec<_> = names.iter().map(|n| serde_json::json!({"name": n, "path": "/"})).collect();
    let configurations: Vec<_> = ["a", "b", "c"].iter().map(|n| serde_json::json!({"name": n})).collect();
    let plan = serde_json::json!({"name": "kitti", "dataset": "kitti", "sequences": sequences,
        "configurations": configurations, "repeats": 3});
    std::fs::write(folder.path().join("suite.json"), plan.to_string()).unwrap();
    let gt = folder.path().join("gt.txt");
    std::fs::write(&gt, drive(0.0)).unwrap();
    let truth = read_trajectory(&gt, None).unwrap();
    let figures = evaluate(&truth, &truth);
    for run in Results::read(folder.path()).unwrap().runs {
        std::fs::create_dir_all(&run.folder).unwrap();
        let record = serde_json::json!({"id": run.id, "state": "done", "arguments": [], "wall_s": 1.0});
        std::fs::write(run.folder.join("run.json"), record.to_string()).unwrap();
        std::fs::write(run.folder.join("summary.json"), "{\"frames\": 4541, \"lost\": 0}").unwrap();
        std::fs::write(run.folder.join("evaluation.json"), serde_json::to_string(&figures).unwrap()).unwrap();
    }
    criterion.bench_function("all tables of 99 runs", |b| {
        b.iter(|| {
            let results = Results::read(folder.path()).unwrap();
            let baselines = read_baselines(None).unwrap();
            for metric in [Metric::TRelPercent, Metric::RRelDegPer100m, Metric::AteRmseM, Metric::Auc] {
                if let Some(table) = metric_table(&results, &baselines, metric) {
                    black_box((table.to_terminal(), table.to_markdown(), table.to_csv(), table.to_latex()));
                }
            }
            black_box((runs_table(&results).to_terminal(), runs_csv(&results)));
        });
    });
}

criterion_group!(benches, pair, tables);
criterion_main!(benches);
