//! A monocular map starts from two views.

use geometry::SO3;

use super::*;
use crate::CameraParams;
use crate::scene::{Scene, Shot, at, gap, shot};

fn mono() -> Params {
    Params::of(CameraParams::mono(10.0))
}

/// A view of the first `n` landmarks of a wall with depth, without a right camera.
fn view(index: u32, pose: &SE3, n: usize, change: impl Fn(&mut Shot)) -> Arc<Frame> {
    let mut shots: Vec<Shot> = (0..n).map(|i| Shot { stereo: false, octave: 0, ..shot(i) }).collect();
    shots.iter_mut().for_each(change);
    Scene::wall(160).frame(index, pose, &shots)
}

fn side() -> SE3 {
    SE3::new(SO3::exp(&Vec3::new(0.0, 0.04, 0.02)), Vec3::new(-1.0, 0.1, 0.05))
}

/// What the second of two views says.
fn second(frame: &Arc<Frame>, first_from_world: SE3) -> Result<InitialPair, NoPair> {
    let mut slot = None;
    let first = view(0, &SE3::identity(), 160, |_| {});
    let begun = Initializer::advance(&mut slot, &first, first_from_world, &mono());
    assert_eq!(begun.unwrap_err(), NoPair::First);
    Initializer::advance(&mut slot, frame, first_from_world, &mono())
}

#[test]
fn two_views_give_motion_and_points_in_units_of_the_median_depth() {
    let scene = Scene::wall(160);
    let first_from_world = at(3.0, -1.0, 2.0);
    let pair = second(&view(1, &side(), 160, |_| {}), first_from_world).unwrap();
    assert!(pair.points.len() >= 155, "{}", pair.points.len());
    let mut depths: Vec<f64> = pair.points.iter().map(|p| scene.landmarks[p.0 as usize].z).collect();
    depths.sort_by(f64::total_cmp);
    let unit = depths[depths.len() / 2];
    let motion = pair.second_from_world * first_from_world.inverse();
    let expected = SE3::new(side().rotation, side().translation / unit);
    assert!(gap(&motion, &expected) < 5e-3, "{}", gap(&motion, &expected));
    for &(i, j, position) in &pair.points {
        assert_eq!(i, j, "the same landmark");
        let in_first = first_from_world * position;
        let error = (in_first - scene.landmarks[i as usize] / unit).norm();
        assert!(error < 0.02, "{error} units");
    }
    assert_eq!(pair.first_from_world, first_from_world);
}

#[test]
fn a_hundred_features_and_a_hundred_matches_are_needed() {
    let few = NoPair::TooFewFeatures { found: 99, needed: 100 };
    assert_eq!(second(&view(1, &side(), 99, |_| {}), SE3::identity()).unwrap_err(), few);
    let otherwise = |s: &mut Shot| s.flipped = if s.landmark < 61 { 128 } else { 0 };
    let few = NoPair::TooFewMatches { found: 99, needed: 100 };
    assert_eq!(second(&view(1, &side(), 160, otherwise), SE3::identity()).unwrap_err(), few);
}

#[test]
fn the_present_frame_is_the_first_after_too_few_matches() {
    let mut slot = None;
    let blind = |s: &mut Shot| s.flipped = 128;
    let frames = [view(0, &at(0.5, 0.0, 0.0), 160, blind), view(1, &SE3::identity(), 160, |_| {})];
    for frame in &frames {
        assert!(Initializer::advance(&mut slot, frame, SE3::identity(), &mono()).is_err());
    }
    assert!(Arc::ptr_eq(&slot.as_ref().unwrap().first, &frames[1]));
    let pair = Initializer::advance(&mut slot, &view(2, &side(), 160, |_| {}), SE3::identity(), &mono());
    assert!(Arc::ptr_eq(&pair.unwrap().first, &frames[1]));
    assert!(slot.is_none(), "the next map starts anew");
}

#[test]
fn a_turn_on_the_spot_tells_no_depth() {
    let turned = SE3::new(SO3::exp(&Vec3::new(0.0, 0.05, 0.0)), Vec3::zeros());
    let result = second(&view(1, &turned, 160, |_| {}), SE3::identity());
    assert!(matches!(result, Err(NoPair::TwoView(_))), "{:?}", result.err());
}

/// How many of 160 features are matched after `change`.
fn matched(pose: &SE3, change: impl Fn(&mut Shot)) -> usize {
    let mut waiting = None;
    Initializer::begin(&mut waiting, &view(0, &SE3::identity(), 160, |_| {}));
    waiting.unwrap().match_with(&view(1, pose, 160, change)).len()
}

#[test]
fn features_are_searched_around_where_they_were_last_seen() {
    assert_eq!(matched(&SE3::identity(), |s| s.shift_px = [99.0, 0.0]), 160);
    assert_eq!(matched(&SE3::identity(), |s| s.shift_px = [101.0, 0.0]), 0);
    // In two steps of 80 px.
    let mut waiting = None;
    Initializer::begin(&mut waiting, &view(0, &SE3::identity(), 160, |_| {}));
    let mut waiting = waiting.unwrap();
    for pixels in [80.0, 160.0] {
        let frame = view(1, &SE3::identity(), 160, |s| s.shift_px = [pixels - 80.0, 0.0]);
        assert_eq!(waiting.match_with(&frame).len(), 160);
    }
    assert_eq!(waiting.match_with(&view(1, &SE3::identity(), 160, |s| s.shift_px = [170.0, 0.0])).len(), 160);
}

#[test]
fn looks_octaves_and_turns_must_agree() {
    assert_eq!(matched(&SE3::identity(), |s| s.flipped = 50), 160);
    assert_eq!(matched(&SE3::identity(), |s| s.flipped = 51), 0);
    assert_eq!(matched(&SE3::identity(), |s| s.octave = 1), 0, "another octave than before");
    assert_eq!(matched(&SE3::identity(), |s| s.angle_deg = if s.landmark < 8 { 170.0 } else { 10.0 }), 152);
}

#[test]
fn of_two_alike_features_neither_is_taken() {
    let mut scene = Scene::wall(160);
    // 1 looks like 0 but for a few bits; in the second view both are about as far from the look of 0.
    scene.landmarks[1] = scene.landmarks[0] + Vec3::new(0.1, 0.0, 0.0);
    let matched = |bits: u32| {
        let mut scene = scene.clone();
        scene.looks[1] = crate::scene::flipped(scene.looks[0], bits);
        let shots: Vec<Shot> =
            (0..160).map(|i| Shot { stereo: false, octave: 0, flipped: 20, ..shot(i) }).collect();
        let mut waiting = None;
        let whole: Vec<Shot> = (0..160).map(|i| Shot { stereo: false, octave: 0, ..shot(i) }).collect();
        Initializer::begin(&mut waiting, &scene.frame(0, &SE3::identity(), &whole));
        waiting.unwrap().match_with(&scene.frame(1, &SE3::identity(), &shots)).iter().any(|m| m.0 == 0)
    };
    // Distances 20 and 20: not clear. 20 and 100: clear.
    assert!(!matched(40) && matched(120));
}

#[test]
fn coarse_features_do_not_take_part() {
    for (octave, n) in [(2, 160), (3, 0)] {
        let coarse = |s: &mut Shot| s.octave = octave;
        let mut waiting = None;
        Initializer::begin(&mut waiting, &view(0, &SE3::identity(), 160, coarse));
        assert_eq!(waiting.unwrap().match_with(&view(1, &SE3::identity(), 160, coarse)).len(), n);
    }
}

#[test]
fn points_that_do_not_fit_both_views_are_dropped() {
    let first = view(0, &SE3::identity(), 160, |_| {});
    // 6 px across the motion: beyond the gate of 2.45 px however it is shared.
    let frame = view(1, &side(), 160, |s| s.shift_px = [0.0, if s.landmark < 5 { 8.0 } else { 0.0 }]);
    let landmarks = Scene::wall(160).landmarks;
    let points: Vec<(u32, u32, Vec3)> = (0..).zip(&landmarks).map(|(i, &p)| (i, i, p)).collect();
    let adjusted = adjust_pair([&first, &frame], side(), &points, &mono());
    let (motion, left) = (adjusted.second_from_first, adjusted.points);
    // The length of the motion is free.
    let direction = motion.translation.normalize().dot(&side().translation.normalize());
    assert!(direction > 0.999, "{direction}");
    assert!((motion.rotation * side().rotation.inverse()).angle() < 0.01);
    assert_eq!(left.iter().map(|p| p.0).collect::<Vec<_>>(), (5..160).collect::<Vec<_>>());
}

#[test]
fn a_short_move_is_not_enough_for_features_that_are_placed_badly() {
    assert_eq!(clear_of_noise(11.1, 1.0), Ok(()));
    assert_eq!(clear_of_noise(5.6, 0.5), Ok(()));
    let refused = clear_of_noise(11.1, 1.2).unwrap_err();
    assert!(matches!(refused, NoPair::TooNoisy { parallax_px: 11.1, needed_px } if needed_px > 13.0));
    let words = "too little parallax for the noise of the features: 11.1 of 13.2 pixels";
    assert_eq!(refused.to_string(), words);
}

#[test]
fn noise_comes_from_residuals_and_outliers() {
    assert_eq!(noise(100.0, 100, 0), 1.0);
    assert!((noise(100.0, 100, 20) - ((100.0 + 20.0 * CHI2_MONO) / 120.0).sqrt()).abs() < 1e-12);
    assert_eq!(noise(0.0, 0, 0), 0.0);
}
