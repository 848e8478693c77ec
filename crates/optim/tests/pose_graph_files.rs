//! Public pose graphs against an independent solver: costs by tests/reference/pose_graph_gtsam.py (GTSAM 4.3.0).

#![allow(clippy::print_stdout, reason = "a skipped test says so")]

mod g2o;

use dsslam_optim::{PoseGraphOptions, StopReason, refine_pose_graph};

/// Solves the file from its own values and compares both costs.
fn check(name: &str, initial_cost: f64, final_cost: f64) {
    let Some(text) = g2o::find(name) else {
        println!("skipped: no {name}; set DSSLAM_GRAPHS");
        return;
    };
    let problem = g2o::parse(&text);
    let solution = refine_pose_graph(&problem, &PoseGraphOptions::default());
    let report = solution.report;
    println!("{name}: {report:?}");
    assert!((report.initial_cost / initial_cost - 1.0).abs() < 1e-9, "{report:?}");
    assert_eq!(report.stop, StopReason::Converged);
    assert!(report.final_cost <= 1.000_001 * final_cost, "{report:?}");
    assert!(report.final_cost >= 0.999_999 * final_cost, "another minimum or another cost: {report:?}");
    assert_eq!(solution.poses[0], problem.poses[0]);
    let from_edges = 0.5 * solution.chi_sq.iter().sum::<f64>();
    assert!((from_edges / report.final_cost - 1.0).abs() < 1e-12);
}

#[test]
fn sphere2500() {
    check("sphere2500.g2o", 1.305657711806e6, 6.757009629259e2);
}

#[test]
fn parking_garage() {
    check("parking-garage.g2o", 8.363601948120e3, 6.341923996322e-1);
}

#[test]
fn small_grid_3d() {
    check("smallGrid3D.g2o", 8.389433343553e4, 5.179253323603e2);
}
