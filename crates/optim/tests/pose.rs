//! Motion-only optimisation on synthetic frames.

mod common;

use common::{frame, pose_difference, random, rig, small_motion};
use optim::{PoseOptions, refine_pose};

#[test]
fn a_displaced_pose_returns_in_spite_of_outliers() {
    for seed in 0..20 {
        let (truth, observations) = frame(seed, 200, 1.0, 0.5, 0.3);
        let initial = small_motion(&mut random(seed + 1000), 0.1, 0.01) * truth;
        let solution = refine_pose(&rig(), initial, &observations, &PoseOptions::default());
        let (metres, radians) = pose_difference(&solution.cam_from_world, &truth);
        println!("{metres:.4} {radians:.5} {:?}", solution.report);
        assert!(metres < 0.1 && radians < 0.01, "{metres} m, {radians} rad");
    }
}
