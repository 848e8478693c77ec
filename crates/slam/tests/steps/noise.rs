//! How much a feature counts, and when it agrees with a point.

use geometry::SE3;

use super::*;
use crate::scene::{FOCAL_PX, Scene, shot};

/// A frame of one feature at a landmark 10 m ahead, displaced by pixels; the landmark is in camera coordinates.
fn frame(shift_px: [f64; 2], octave: u8, stereo: bool) -> (std::sync::Arc<Frame>, Vec3) {
    let place = Vec3::new(0.5, -0.25, 10.0);
    let shot = crate::scene::Shot { shift_px, octave, stereo, ..shot(0) };
    (Scene::at(vec![place]).frame(0, &SE3::identity(), &[shot]), place)
}

fn fits(shift_px: [f64; 2], octave: u8, stereo: bool, sigma_px: f64) -> bool {
    let (frame, place) = frame(shift_px, octave, stereo);
    agrees(&frame, 0, &place, sigma_px)
}

#[test]
fn information_is_the_inverse_variance_of_the_octave() {
    let plain = |octave, sigma_px| {
        information(&frame([0.0, 0.0], octave, true).0, 0, Noise { sigma_px, weighted: false })
    };
    assert!((plain(0, 1.0) - 1.0).abs() < 1e-6);
    assert!((plain(0, 2.0) - 0.25).abs() < 1e-6);
    assert!((plain(3, 1.0) - 1.2_f64.powi(-6)).abs() < 1e-6);
}

#[test]
fn a_weighted_feature_counts_as_far_as_it_is_trusted_but_never_nothing() {
    let mut frame = (*frame([0.0, 0.0], 0, true).0).clone();
    let weighted = |frame: &Frame| information(frame, 0, Noise { sigma_px: 1.0, weighted: true });
    frame.activation[0] = 0.5;
    assert!((weighted(&frame) - 0.5).abs() < 1e-6);
    frame.activation[0] = 0.001;
    assert!((weighted(&frame) - 0.05).abs() < 1e-6);
    assert!((information(&frame, 0, Noise { sigma_px: 1.0, weighted: false }) - 1.0).abs() < 1e-6);
}

#[test]
fn one_camera_judges_by_the_limit_of_two_degrees_of_freedom() {
    // 95 %: 5.991, that is 2.4477 standard deviations.
    assert!(fits([0.0, 2.44], 0, false, 1.0) && !fits([0.0, 2.46], 0, false, 1.0));
    assert!(fits([-2.44, 0.0], 0, false, 1.0) && !fits([-2.46, 0.0], 0, false, 1.0));
    assert!(!fits([1.8, 1.8], 0, false, 1.0), "both coordinates count");
    assert!(fits([0.0, 4.8], 0, false, 2.0) && !fits([0.0, 5.0], 0, false, 2.0));
    // A coarser octave measures less exactly.
    assert!(fits([0.0, 2.44 * 1.44], 2, false, 1.0) && !fits([0.0, 2.46 * 1.44], 2, false, 1.0));
}

#[test]
fn the_right_column_counts_where_it_was_measured() {
    // 95 %, three degrees of freedom: 7.815, that is 2.7955 standard deviations.
    assert!(fits([0.0, 2.79], 0, true, 1.0) && !fits([0.0, 2.81], 0, true, 1.0));
    // A shift along x moves both columns.
    assert!(fits([1.97, 0.0], 0, true, 1.0) && !fits([1.98, 0.0], 0, true, 1.0));
}

#[test]
fn a_wrong_depth_shows_in_the_right_column_only() {
    let (frame, place) = frame([0.0, 0.0], 0, true);
    let bf = FOCAL_PX * crate::scene::BASELINE_M;
    let deeper = |pixels: f64| place * (bf / (bf / place.z - pixels) / place.z);
    assert!(agrees(&frame, 0, &deeper(2.7), 1.0) && !agrees(&frame, 0, &deeper(2.9), 1.0));
}

#[test]
fn nothing_behind_the_camera_agrees() {
    let (frame, place) = frame([0.0, 0.0], 0, false);
    // For one camera it projects to the same pixel.
    assert!(agrees(&frame, 0, &place, 1.0) && !agrees(&frame, 0, &-place, 1.0));
}
