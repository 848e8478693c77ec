//! Wide and baseline instructions give equal bits.

use simd::Simd;

use crate::bundle::refine_bundle_with;
use crate::common::{StreetOptions, displaced, frame, random, rig, small_motion, street};
use crate::pose::refine_pose_with;
use crate::{BundleOptions, PoseOptions};

/// On a processor without AVX2 both are the same; the comparison says so.
#[test]
fn wide_and_baseline_instructions_give_equal_bits() {
    if Simd::detect() == Simd::scalar() {
        println!("no wider instructions on this processor");
    }
    for seed in 0..5 {
        let (truth, observations) = frame(seed, 203, 1.0, 0.3, 0.4);
        let initial = small_motion(&mut random(seed), 0.1, 0.01) * truth;
        let pose = |simd| refine_pose_with(&rig(), initial, &observations, &PoseOptions::default(), simd);
        assert_eq!(pose(Simd::detect()), pose(Simd::scalar()));
    }
    let options =
        StreetOptions { seed: 9, cameras: 9, points: 300, max_track: 6, noise_px: 0.7, mono_share: 0.3 };
    let mut problem = displaced(&street(&options), 10, 0.03, 0.003, 0.1);
    problem.fixed[0] = true;
    for robust in [false, true] {
        let options = BundleOptions { huber: robust.then_some(0.5), ..Default::default() };
        let bundle = |simd| refine_bundle_with(&problem, &options, simd);
        assert_eq!(bundle(Simd::detect()), bundle(Simd::scalar()));
    }
}
