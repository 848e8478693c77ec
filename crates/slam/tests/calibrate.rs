//! The disparity offset is found from the images alone, and nothing is claimed where they do not tell.

#[allow(dead_code, reason = "shared with other tests")]
mod common;

use common::{Pair, World, slalom};
use dsslam_slam::{Params, estimate_disparity_offset};

/// Drives 40 frames down a corridor whose disparities are all wrong by `error_px`.
fn map_with_error(error_px: f64) -> Pair {
    let mut world = World::with_density(60.0, 0.2, 25.0);
    world.disparity_error_px = error_px;
    let mut params = Params::stereo(21.0, 10.0);
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
fn an_offset_of_all_disparities_is_found() {
    for error_px in [0.15, -0.15] {
        let pair = map_with_error(error_px);
        let estimate = estimate_disparity_offset(&pair.mapper.world().map).expect("the images tell");
        // The error is to be taken away again.
        let left = error_px + estimate.offset_px;
        assert!(left.abs() < 0.06, "{error_px} px: {estimate:?} leaves {left} px");
        assert!(estimate.sigma_px > 0.0 && estimate.sigma_px < 0.06, "{estimate:?}");
    }
}

#[test]
fn correct_disparities_are_left_alone() {
    let pair = map_with_error(0.0);
    let estimate = estimate_disparity_offset(&pair.mapper.world().map).expect("the images tell");
    assert!(estimate.offset_px.abs() < 0.03, "{estimate:?}");
}

#[test]
fn a_few_frames_tell_nothing() {
    let world = World::corridor(80.0, 0.2);
    let mut pair = Pair::new(&Params::stereo(21.0, 10.0));
    for i in 0..4 {
        pair.step(&world.frame(i, &slalom(i)));
    }
    assert_eq!(estimate_disparity_offset(&pair.mapper.world().map), None);
}
