//! One point from two features: by rays or by the better stereo depth, and refused where the two do not fit together.

use super::*;
use crate::scene::{Scene, Shot, add, at, shot};

/// Locates landmark 0 from two cameras that see it as `shots`, the second at `second`.
fn located(landmark: Vec3, second: &SE3, shots: [Shot; 2]) -> Option<Vec3> {
    let scene = Scene::at(vec![landmark]);
    let mut map = map::Map::new();
    for (index, (pose, shot)) in (0..).zip([(SE3::identity(), shots[0]), (*second, shots[1])]) {
        add(&mut map, scene.frame(index, &pose, &[shot]), &pose, &[], &[(0, landmark)]);
    }
    let keyframes: Vec<&Keyframe> = map.keyframes().collect();
    locate(&View::new(keyframes[0]), 0, &View::new(keyframes[1]), 0)
}

fn mono() -> Shot {
    Shot { stereo: false, ..shot(0) }
}

const AHEAD: Vec3 = Vec3::new(1.0, -0.5, 10.0);

#[test]
fn two_rays_meet_at_the_landmark() {
    for shots in [[mono(); 2], [shot(0); 2], [mono(), shot(0)], [shot(0), mono()]] {
        let position = located(AHEAD, &at(2.0, 0.0, 0.0), shots).unwrap();
        assert!((position - AHEAD).norm() < 1e-3, "{position}");
    }
}

#[test]
fn rays_without_parallax_give_a_point_only_with_stereo() {
    // 0.1 m apart at 10 m: 0.57 degrees, less than the 1.15 that rays alone need.
    let second = at(0.1, 0.0, 0.0);
    assert_eq!(located(AHEAD, &second, [mono(); 2]), None);
    for shots in [[shot(0), mono()], [mono(), shot(0)], [shot(0); 2]] {
        let position = located(AHEAD, &second, shots).unwrap();
        assert!((position - AHEAD).norm() < 1e-2, "{position}");
    }
    assert!(located(AHEAD, &at(0.25, 0.0, 0.0), [mono(); 2]).is_some(), "1.43 degrees");
}

#[test]
fn the_nearer_stereo_view_is_taken() {
    // A feature that is 0.3 px off moves the point that its depth gives; the gates let it pass.
    let off = |shift: f64| Shot { shift_px: [shift, 0.0], ..shot(0) };
    let second = at(0.0, 0.0, 0.4);
    let ahead = Vec3::new(0.0, 0.0, 10.0);
    let position = located(ahead, &second, [off(0.3), off(0.0)]).unwrap();
    assert!(position.x.abs() < 1e-4, "from the second view, which has no shift: {position}");
    let position = located(ahead, &at(0.0, 0.0, -0.4), [off(0.0), off(0.3)]).unwrap();
    assert!(position.x.abs() < 1e-4, "from the first view: {position}");
}

#[test]
fn the_larger_parallax_decides_between_rays_and_stereo() {
    // A pixel off along the motion: rays would put the landmark half a meter off, the stereo depth of the other view not.
    let shots = [shot(0), Shot { shift_px: [1.0, 0.0], ..mono() }];
    let error_m =
        |distance_m: f64| (located(AHEAD, &at(distance_m, 0.0, 0.0), shots).unwrap() - AHEAD).norm();
    // The rig's own parallax is that of 0.5 m.
    assert!(error_m(0.4) < 0.02, "{}", error_m(0.4));
    assert!(error_m(0.6) > 0.2, "{}", error_m(0.6));
}

#[test]
fn a_stereo_depth_must_fit_the_other_view_too() {
    let second = at(0.1, 0.0, 0.0);
    let up = |pixels: f64| Shot { shift_px: [0.0, pixels], ..mono() };
    // One camera, octave 2: the gate is at 2.4477 * 1.44 px.
    assert!(located(AHEAD, &second, [shot(0), up(3.4)]).is_some());
    assert!(located(AHEAD, &second, [shot(0), up(3.6)]).is_none());
    assert!(located(AHEAD, &second, [up(3.6), shot(0)]).is_none());
}

#[test]
fn what_does_not_reproject_is_refused() {
    // Octave 2: the gate is at 4.03 px with the right column; DLT shares an error across the line between both views.
    let up = |pixels: f64| Shot { shift_px: [0.0, pixels], ..shot(0) };
    let second = at(2.0, 0.0, 0.0);
    assert!(located(AHEAD, &second, [shot(0), up(5.0)]).is_some());
    assert!(located(AHEAD, &second, [shot(0), up(10.0)]).is_none());
    assert!(located(AHEAD, &second, [up(-10.0), shot(0)]).is_none());
}

#[test]
fn scales_must_fit_the_distances() {
    // As far from both: 1.2 * 1.5 = 1.8 is allowed, that is three octaves (1.728) but not four (2.07).
    let second = at(2.0, 0.0, 0.0);
    let octaves = |a: u8, b: u8| {
        located(AHEAD, &second, [Shot { octave: a, ..shot(0) }, Shot { octave: b, ..shot(0) }]).is_some()
    };
    assert!(octaves(0, 3) && octaves(3, 0));
    assert!(!octaves(0, 4) && !octaves(4, 0));
}

#[test]
fn from_half_the_distance_a_landmark_is_four_octaves_larger() {
    let ahead = Vec3::new(1.0, 0.5, 10.0);
    let nearer = at(1.0, 0.0, 5.0);
    let octaves = |far: u8, near: u8| {
        located(ahead, &nearer, [Shot { octave: far, ..shot(0) }, Shot { octave: near, ..shot(0) }]).is_some()
    };
    assert!(octaves(0, 4), "the scale doubles");
    assert!(!octaves(4, 0), "the wrong way round");
}
