//! The calibration is refined from the map within a run, and nothing is changed where the images do not tell.

#[allow(dead_code, reason = "shared with other tests")]
mod common;

use std::sync::Arc;

use common::{Pair, World, slalom};
use dsslam_slam::{CameraParams, Params};
use features::Rig;
use geometry::{SE3, SO3, Vec3};

/// Drives 40 frames down a corridor whose disparities are all wrong by `error_px`.
fn pair_with_error(error_px: f64) -> Pair {
    let mut world = World::with_density(60.0, 0.2, 25.0);
    world.disparity_error_px = error_px;
    let mut params = Params::of(CameraParams::stereo(21.0, 10.0));
    // More keyframes than so quiet a drive needs, and none culled.
    params.tracking.keyframe_ratio = Some(0.95);
    params.mapping.keyframe_cull_ratio = 1.0;
    let mut pair = Pair::new(&params);
    for i in 0..40 {
        pair.step(&world.frame(i, &slalom(i)));
    }
    pair
}

#[test]
fn an_offset_of_all_disparities_is_found_and_taken_out_of_the_map() {
    // Half of a usual offset, for a measurement of it has errors of its own; of a large one all but a fixed amount.
    for (error_px, rest_px) in [(0.15, 0.09), (-0.15, 0.09), (0.6, 0.2)] {
        let pair = pair_with_error(error_px);
        let world = pair.mapper.world();
        let refined = world.calibration.as_ref().expect("the images tell");
        let left = error_px + refined.errors[4];
        // The frames of the map lack what was found.
        assert!(left.abs() < rest_px, "{error_px} px: {refined} leaves {left} px");
        assert!(left.abs() < 3.0 * refined.sigma[4], "{error_px} px: {refined}");
        assert_eq!(refined.errors[..4], [0.0; 4], "the scale of a pair is kept");
        let frame = &world.map.keyframes().next().unwrap().frame;
        assert!(Arc::ptr_eq(&frame.rig, &refined.rig) && *refined.rig == *refined.given);
        assert_eq!(world.map.check(), Ok(()));
    }
}

#[test]
fn correct_disparities_are_left_alone() {
    let pair = pair_with_error(0.0);
    let found_px = pair.mapper.world().calibration.as_ref().map_or(0.0, |found| found.errors[4]);
    assert!(found_px.abs() < 0.02, "{found_px} px");
}

#[test]
fn a_few_frames_tell_nothing_and_nothing_is_looked_for_when_it_is_switched_off() {
    let mut world = World::corridor(80.0, 0.2);
    world.disparity_error_px = 0.3;
    let mut params = Params::of(CameraParams::stereo(21.0, 10.0));
    let run = |params: &Params, n: u32| {
        let mut pair = Pair::new(params);
        (0..n).for_each(|i| drop(pair.step(&world.frame(i, &slalom(i)))));
        pair.mapper.world().calibration.clone()
    };
    assert_eq!(run(&params, 4), None);
    params.mapping.refine_calibration = false;
    assert_eq!(run(&params, 40), None);
}

/// Around corners: one camera tells its focal length when it turns.
fn winding(i: u32) -> SE3 {
    let z = 0.5 * f64::from(i);
    let turn = Vec3::new(0.0, 0.3 * (z / 6.0).sin(), 0.0);
    SE3::new(SO3::exp(&turn), Vec3::new(0.8 * (z / 9.0).sin(), 0.0, z))
}

#[test]
fn one_camera_finds_its_focal_length_within_the_stated_uncertainty() {
    let mut world = World::with_density(55.0, 0.2, 15.0);
    world.stereo = false;
    let mut params = Params::of(CameraParams::mono(10.0));
    params.mapping.keyframe_cull_ratio = 1.0;
    let drive = |wrong: f64| {
        let mut pair = Pair::new(&params);
        let given = Rig::clone(&world.rig);
        let mut wrong_rig = given.clone();
        wrong_rig.stereo.camera.fx *= wrong;
        wrong_rig.stereo.camera.fy *= wrong;
        let wrong_rig = Arc::new(wrong_rig);
        for i in 0..80 {
            // What is known of the camera is wrong; what it shows is not.
            pair.step(&Arc::new(world.frame(i, &winding(i)).recalibrated(&wrong_rig, 0.0, 0.0)));
        }
        pair
    };
    for wrong in [1.03, 0.98] {
        let pair = drive(wrong);
        let refined = pair.mapper.world().calibration.clone().expect("the images tell");
        let error = refined.errors[0] + wrong.ln();
        assert!(error.abs() < refined.sigma[0], "{wrong}: {refined}");
        assert!(refined.sigma[0] < 0.03, "{refined}");
        assert_eq!(refined.errors[4..], [0.0; 2]);
    }
    assert_eq!(drive(1.0).mapper.world().calibration, None, "an exact calibration stays");
    assert_eq!(drive(1.2).mapper.world().calibration, None, "nobody's focal length is off by so much");
}
