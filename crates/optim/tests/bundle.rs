//! Bundle adjustment on synthetic streets.

mod common;

use common::{StreetOptions, displaced, pose_difference, street};
use optim::{BundleOptions, refine_bundle};

#[test]
fn a_displaced_street_returns() {
    let mut truth = street(&StreetOptions {
        seed: 1,
        cameras: 12,
        points: 600,
        max_track: 6,
        noise_px: 0.0,
        mono_share: 0.2,
    });
    truth.fixed[0] = true;
    let problem = displaced(&truth, 2, 0.05, 0.005, 0.2);
    let solution = refine_bundle(&problem, &BundleOptions { max_iterations: 50, ..Default::default() });
    println!("{:?}", solution.report);
    for (solved, expected) in solution.cameras.iter().zip(&truth.cameras) {
        let (metres, radians) = pose_difference(solved, expected);
        assert!(metres < 1e-6 && radians < 1e-7, "{metres} m, {radians} rad");
    }
}
