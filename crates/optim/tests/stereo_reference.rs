//! The rig's bundle adjustment against an independent solver.

mod common;

use dsslam_optim::{BundleOptions, refine_bundle};

/// Costs at the start and the end by GTSAM 4.3.0 (tests/reference/stereo_gtsam.py).
const GTSAM_INITIAL_COST: f64 = 2.028201524325e6;
const GTSAM_FINAL_COST: f64 = 6.965196259742e3;
/// Cost at the end by scipy 1.17.1 (tests/reference/stereo_scipy.py), stopped after 100 evaluations.
const SCIPY_FINAL_COST: f64 = 6.965196349294e3;

#[test]
fn the_cost_equals_that_of_an_independent_solver() {
    let options =
        BundleOptions { max_iterations: 100, huber: None, relative_tolerance: 1e-10, ..Default::default() };
    let report = refine_bundle(&common::reference_problem(), &options).report;
    assert!((report.initial_cost / GTSAM_INITIAL_COST - 1.0).abs() < 1e-9, "{report:?}");
    assert!((report.final_cost / GTSAM_FINAL_COST - 1.0).abs() < 1e-9, "{report:?}");
    assert!((report.final_cost / SCIPY_FINAL_COST - 1.0).abs() < 1e-6, "{report:?}");
}
