//! The Schur solver with a nine-parameter camera on a public problem, against an independent solver.

#![allow(missing_docs, unreachable_pub)]

mod bal_model;

use std::path::PathBuf;

use bal_model::{BalCamera, BalModel, parse};
use dsslam_optim::{BundleOptions, StopReason, minimize};

/// Costs of ladybug-49-7776 at the start and the end by tests/reference/bal_scipy.py (numpy and scipy 1.17.1).
const SCIPY_INITIAL_COST: f64 = 8.509124607e5;
const SCIPY_FINAL_COST: f64 = 1.334424077e4;

fn graphs_folder() -> PathBuf {
    std::env::var_os("DSSLAM_GRAPHS").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/graphs"),
        PathBuf::from,
    )
}

#[test]
fn ladybug_reaches_the_cost_of_an_independent_solver() {
    let path = graphs_folder().join("ladybug-49-7776.txt");
    let Ok(text) = std::fs::read_to_string(&path) else {
        println!("skipped: no {}; set DSSLAM_GRAPHS", path.display());
        return;
    };
    let options =
        BundleOptions { max_iterations: 1000, huber: None, relative_tolerance: 1e-9, ..Default::default() };
    let minimum = minimize(&BalModel, parse(&text), &options);
    assert_eq!(minimum.stop, StopReason::Converged);
    assert!((minimum.initial_cost / SCIPY_INITIAL_COST - 1.0).abs() < 1e-9, "{}", minimum.initial_cost);
    assert!((minimum.final_cost / SCIPY_FINAL_COST - 1.0).abs() < 1e-6, "{}", minimum.final_cost);
}

#[test]
fn analytic_jacobians_equal_numeric_ones() {
    let values = [0.3, -0.2, 0.5, 0.4, -0.1, -8.0, 400.0, -0.12, 0.03];
    let (point, pixel) = ([0.7, -0.4, 1.1], [10.0, -20.0]);
    let (by_camera, by_point) = BalModel.jacobians(&BalCamera::new(values), &point, &pixel);
    let step = 1e-6;
    for k in 0..12 {
        let at = |sign: f64| {
            let (mut camera, mut point) = (values, point);
            match k {
                0..9 => camera[k] += sign * step,
                _ => point[k - 9] += sign * step,
            }
            BalModel.residual(&BalCamera::new(camera), &point, &pixel)
        };
        for i in 0..2 {
            let numeric = (at(1.0)[i] - at(-1.0)[i]) / (2.0 * step);
            let analytic = if k < 9 { by_camera[i][k] } else { by_point[i][k - 9] };
            assert!(
                (numeric - analytic).abs() < 1e-6 * (1.0 + analytic.abs()),
                "{k} {i}: {numeric} {analytic}"
            );
        }
    }
}
