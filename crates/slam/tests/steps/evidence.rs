//! Evidence for standing still: laws on a scene whose landmarks stand, moved, or are missed.

use map::PointCount;

use super::super::TrackStats;
use super::*;
use crate::scene::{Scene, Shot, at, shot};

/// A camera that has gone a meter ahead since the last frame, 0.1 s ago.
fn yardstick() -> Yardstick {
    Yardstick::new(&at(0.0, 0.0, 1.0), &at(0.0, 0.0, 0.0), 0.1, true)
}

/// Evidence for the landmark of a scene with one at `place`, shown by this shot (`None`: missed) with this activation.
fn evidence(place: Vec3, shown: Option<Shot>, activation: f32, yardstick: Yardstick) -> i32 {
    let scene = Scene::at(vec![place]);
    let pose = at(0.0, 0.0, 0.0);
    let map = scene.map(&[pose, pose]);
    let mut frame = (*scene.frame(5, &pose, &[shown.unwrap_or(shot(0))])).clone();
    frame.activation[0] = activation;
    let id = PointId(0);
    let mut local = LocallyTracked {
        cam_from_world: pose,
        reference: map::KeyframeId(0),
        cam_from_reference: pose,
        matches: Vec::new(),
        matched: shown.map(|_| (0, id)).into_iter().collect(),
        counts: vec![PointCount { point: id, seen: 1, found: 0, evidence: 0 }],
        stats: TrackStats::default(),
        aligned: None,
        shifts: Vec::new(),
    };
    add_evidence(&mut local, &frame, &map, yardstick, 1.0);
    local.counts[0].evidence
}

const NEAR: Vec3 = Vec3::new(2.0, 1.0, 10.0);
/// An activation whose odds are even.
const NO_WORD: f32 = 0.5;

fn shifted(px: f64) -> Option<Shot> {
    Some(Shot { shift_px: [px, 0.0], ..shot(0) })
}

#[test]
fn a_point_that_is_where_it_would_stand_does_so_and_one_that_is_not_moves() {
    let of = |px: f64| evidence(NEAR, shifted(px), NO_WORD, yardstick());
    assert_eq!(of(0.0), (1000.0 * MOST_FOR) as i32);
    assert!(of(1.0) > 0 && of(8.0) < 0, "{} {}", of(1.0), of(8.0));
    assert_eq!(of(40.0), (-1000.0 * MOST_AGAINST) as i32);
    assert!([0.0, 3.0, 5.0, 8.0, 12.0].map(of).is_sorted_by(|a, b| a >= b));
}

#[test]
fn a_shift_of_both_views_says_less_than_one_of_one_against_the_other() {
    let of = |shift_px: [f64; 2], right_px: f64| {
        evidence(NEAR, Some(Shot { shift_px, right_px, ..shot(0) }), NO_WORD, yardstick())
    };
    let (common, apart) = (of([3.0, 0.0], 0.0), of([0.0, 0.0], 3.0));
    assert!(common > 0 && apart < 0, "{common} {apart}");
    assert_eq!(common, of([-3.0, 0.0], 0.0));
    assert!(of([1.5, 0.0], -3.0) < 0, "one column to the right and the other to the left");
}

#[test]
fn agreement_says_nothing_where_no_motion_could_be_seen() {
    let far = Vec3::new(200.0, 100.0, 20_000.0);
    assert!(evidence(far, shifted(0.0), NO_WORD, yardstick()).abs() < 5);
    let still = Yardstick::new(&at(0.0, 0.0, 0.0), &at(0.0, 0.0, 0.0), 0.1, false);
    assert_eq!(evidence(NEAR, shifted(0.0), NO_WORD, still), 0, "a camera without scale that stands");
    let walker = Yardstick::new(&at(0.0, 0.0, 0.0), &at(0.0, 0.0, 0.0), 0.1, true);
    assert!(evidence(NEAR, shifted(0.0), NO_WORD, walker) > 0);
}

#[test]
fn the_networks_word_counts_in_both_directions_and_a_miss_says_nothing() {
    assert_eq!(evidence(NEAR, None, 0.0, yardstick()), 0);
    let [low, even, high] = [0.01, 0.5, 0.99].map(|a| evidence(NEAR, shifted(0.0), a, yardstick()));
    assert!(low < even && even < high, "{low} {even} {high}");
    assert_eq!(even - low, (1000.0 * SHARE_OF_WORD * MOST_OF_WORD) as i32);
    assert_eq!(high - even, even - low);
}

#[test]
fn the_yardstick_turns_with_the_camera_and_is_at_least_a_walkers() {
    let Yardstick(step) = yardstick();
    assert!((step - Vec3::new(0.0, 0.0, 1.0)).norm() < 1e-12, "{step}");
    let Yardstick(slow) = Yardstick::new(&at(0.0, 0.0, 0.05), &at(0.0, 0.0, 0.0), 0.1, true);
    assert!((slow.norm() - 0.14).abs() < 1e-12, "{slow}");
    let Yardstick(free) = Yardstick::new(&at(0.0, 0.0, 0.05), &at(0.0, 0.0, 0.0), 0.1, false);
    assert!((free.norm() - 0.05).abs() < 1e-12, "{free}");
}
