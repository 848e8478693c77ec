//! Time of one frame's pose and of one local bundle adjustment, on fixed synthetic streets.

#![allow(missing_docs)]

#[path = "../tests/common/mod.rs"]
mod common;

use common::{StreetOptions, displaced, frame, random, rig, small_motion, street};
use criterion::{Criterion, criterion_group, criterion_main};
use dsslam_optim::{BundleOptions, BundleProblem, PoseOptions, refine_bundle, refine_pose};

fn pose(criterion: &mut Criterion) {
    for (name, outliers) in [("clean", 0.0), ("10 % outliers", 0.1), ("50 % outliers", 0.5)] {
        let (truth, observations) = frame(1, 300, 1.0, outliers, 0.3);
        let initial = small_motion(&mut random(2), 0.05, 0.005) * truth;
        let options = PoseOptions::default();
        criterion.bench_function(&format!("refine_pose 300 observations, {name}"), |b| {
            b.iter(|| refine_pose(&rig(), initial, &observations, &options));
        });
    }
}

/// 25 free and 20 fixed cameras, 3000 points, about 15 000 observations of which 3 % are wrong.
fn local_problem() -> BundleProblem {
    let options =
        StreetOptions { seed: 3, cameras: 45, points: 3000, max_track: 5, noise_px: 0.7, mono_share: 0.2 };
    let mut problem = street(&options);
    problem.fixed[..20].fill(true);
    for observation in problem.observations.iter_mut().step_by(33) {
        observation.pixel.x += 25.0;
    }
    displaced(&problem, 4, 0.03, 0.002, 0.1)
}

/// Five robust iterations, outliers dropped, ten plain ones.
fn two_stages(problem: &BundleProblem) -> f64 {
    let first = BundleOptions { max_iterations: 5, relative_tolerance: 0.0, ..Default::default() };
    let robust = refine_bundle(problem, &first);
    let mut rest = problem.clone();
    (rest.cameras, rest.points) = (robust.cameras, robust.points);
    let mut chi_sq = robust.chi_sq.iter();
    rest.observations.retain(|o| {
        let limit = if o.right_u.is_nan() { dsslam_optim::CHI2_MONO } else { dsslam_optim::CHI2_STEREO };
        chi_sq.next().is_some_and(|&c| c <= limit)
    });
    let second =
        BundleOptions { max_iterations: 10, huber: None, relative_tolerance: 0.0, ..Default::default() };
    refine_bundle(&rest, &second).report.final_cost
}

fn bundle(criterion: &mut Criterion) {
    let problem = local_problem();
    let mut group = criterion.benchmark_group("refine_bundle");
    group.sample_size(20);
    let name = format!("25 + 20 cameras, {} observations, 5 + 10 iterations", problem.observations.len());
    group.bench_function(name, |b| b.iter(|| two_stages(&problem)));
    let defaults = BundleOptions::default();
    group.bench_function("the same to the default tolerance", |b| {
        b.iter(|| refine_bundle(&problem, &defaults))
    });
    group.finish();
}

criterion_group!(benches, pose, bundle);
criterion_main!(benches);
