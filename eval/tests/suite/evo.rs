//! ATE and RPE agree with `evo`, the field's independent judge, to 1e-6.

use std::path::PathBuf;

use super::evo_values::{Ape, FIXTURES_APE, FIXTURES_RPE, PUBLISHED_APE, PUBLISHED_RPE, Part, Rpe};
use super::support::{fixture, pairs, published};
use dsslam_eval::{RpeOptions, Statistics, apply_alignment, ate, estimate_alignment, rpe};

const TOLERANCE: f64 = 1e-6;

fn check_ape(expected: &Ape, folder: impl Fn(&str) -> Option<PathBuf>) {
    let (Some(gt), Some(est)) = (folder(expected.gt), folder(expected.est)) else { return };
    let pairs = pairs(&gt, &est);
    let report = ate(&pairs.est, &pairs.gt, expected.alignment).unwrap().error_m;
    assert_eq!(report.n, expected.n, "{expected:?}");
    let found = [report.rmse, report.mean, report.median, report.std, report.max];
    check(found, [expected.rmse, expected.mean, expected.median, expected.std, expected.max], expected);
}

fn check_rpe(expected: &Rpe, folder: impl Fn(&str) -> Option<PathBuf>) {
    let (Some(gt), Some(est)) = (folder(expected.gt), folder(expected.est)) else { return };
    let pairs = pairs(&gt, &est);
    let gt_from_est = estimate_alignment(&pairs.est, &pairs.gt, expected.alignment).unwrap();
    let (delta, unit, mode, pairs_from_ground_truth) = expected.options;
    let options = RpeOptions { delta, unit, pairs: mode, pairs_from_ground_truth, ..RpeOptions::default() };
    let report = rpe(&apply_alignment(&gt_from_est, &pairs.est), &pairs.gt, &options).unwrap();
    let s: Statistics = match expected.part {
        Part::Translation => report.translation,
        Part::Rotation => report.rotation_deg,
    };
    assert_eq!(s.n, expected.n, "{expected:?}");
    let values = [expected.rmse, expected.mean, expected.median, expected.std, expected.max];
    check([s.rmse, s.mean, s.median, s.std, s.max], values, expected);
}

fn check(found: [f64; 5], expected: [f64; 5], case: &impl std::fmt::Debug) {
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() < TOLERANCE, "found {found:?} for {case:?}");
    }
}

#[test]
fn ate_of_the_fixtures() {
    FIXTURES_APE.iter().for_each(|case| check_ape(case, |name| Some(fixture(name))));
}

#[test]
fn rpe_of_the_fixtures() {
    FIXTURES_RPE.iter().for_each(|case| check_rpe(case, |name| Some(fixture(name))));
}

#[test]
fn ate_of_published_trajectories() {
    PUBLISHED_APE.iter().for_each(|case| check_ape(case, published));
}

#[test]
fn rpe_of_published_trajectories() {
    PUBLISHED_RPE.iter().for_each(|case| check_rpe(case, published));
}
