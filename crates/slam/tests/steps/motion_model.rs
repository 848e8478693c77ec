//! A constant velocity over any time.

use geometry::{SO3, Vec3};

use super::*;
use crate::scene::gap;

fn step() -> SE3 {
    SE3::new(SO3::exp(&Vec3::new(0.0, 0.1, 0.02)), Vec3::new(0.1, 0.0, -1.0))
}

#[test]
fn twice_the_time_is_the_motion_twice() {
    let model = MotionModel::between(&SE3::identity(), &step(), 0.1);
    assert!(gap(&model.motion_over(0.2), &(step() * step())) < 1e-12);
    assert_eq!(model.motion_over(0.1), model.motion);
}

#[test]
fn the_motion_leads_from_the_earlier_to_the_later_camera() {
    let before = SE3::new(SO3::exp(&Vec3::new(0.3, 0.0, 0.1)), Vec3::new(4.0, 1.0, 2.0));
    let after = step() * before;
    assert!(gap(&(MotionModel::between(&before, &after, 0.1).motion_over(0.1) * before), &after) < 1e-12);
}

#[test]
fn senseless_times_repeat_the_motion() {
    for (seen, asked) in [(0.0, 0.1), (0.1, 0.0), (0.1, -3.0), (f64::NAN, 1.0)] {
        let model = MotionModel::between(&SE3::identity(), &step(), seen);
        assert!(gap(&model.motion_over(asked), &step()) < 1e-12);
    }
}

#[test]
fn a_long_gap_is_not_believed_to_the_end() {
    let straight = SE3::new(SO3::identity(), Vec3::new(0.0, 0.0, -1.0));
    let model = MotionModel::between(&SE3::identity(), &straight, 0.1);
    assert!((model.motion_over(1.9).translation.z + 19.0).abs() < 1e-9);
    assert!((model.motion_over(60.0).translation.z + 20.0).abs() < 1e-9);
}
