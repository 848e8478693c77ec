//! Where a keyframe can be: its position, give or take the drift since the earlier visit.

use super::*;
use crate::scene::{Scene, add_under, at, chain, line, params};

fn prior(map: &Map, current: u32, max_drift: f64, prior_margin_m: f64) -> PositionPrior {
    PositionPrior::new(
        map,
        KeyframeId(current),
        &CameraParams { max_drift, prior_margin_m, ..params().camera },
    )
}

#[test]
fn the_margin_grows_with_the_path_in_between() {
    let map = chain(&line(10, 2.0), 4);
    // Keyframe 9 is 2 m per step away; 10 % of the path and 9.01 m: up to five steps.
    let prior = prior(&map, 9, 0.1, 9.01);
    let allowed: Vec<u32> = (0..10).filter(|&id| prior.allows(KeyframeId(id))).collect();
    assert_eq!(allowed, vec![4, 5, 6, 7, 8, 9]);
}

#[test]
fn the_path_is_followed_not_the_straight_line() {
    // Out and back: keyframes 0 and 6 are at one place, 6 m of path apart; keyframe 3 is 3 m away.
    let poses: Vec<_> = [0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0].map(|x| at(x, 0.0, 0.0)).to_vec();
    let map = chain(&poses, 4);
    let far = |drift| prior(&map, 6, drift, 0.0).allows(KeyframeId(3));
    assert!(far(1.01) && !far(0.99));
    let crossing = |drift| prior(&map, 6, drift, 0.0).allows(KeyframeId(1));
    assert!(crossing(0.21) && !crossing(0.19), "1 m away after 5 m");
}

#[test]
fn the_nearest_wanted_keyframes_within_the_margin_come_first() {
    let map = chain(&line(10, 1.0), 4);
    let prior = prior(&map, 5, 0.0, 2.5);
    let nearby = |most, unwanted: &[u32]| -> Vec<u32> {
        let wanted = |id: KeyframeId| !unwanted.contains(&id.0);
        prior.nearby(most, wanted).iter().map(|id| id.0).collect()
    };
    assert_eq!(nearby(9, &[]), vec![5, 4, 6, 3, 7], "of equals the older one");
    assert_eq!(nearby(3, &[5]), vec![4, 6, 3]);
    assert_eq!(nearby(0, &[]), Vec::<u32>::new());
}

#[test]
fn a_keyframe_of_another_sub_map_may_be_anywhere_but_is_not_near() {
    let mut map = chain(&line(4, 1.0), 4);
    let scene = Scene::wall(4);
    let far = at(500.0, 0.0, 0.0);
    let other = add_under(&mut map, scene.whole(9, &far), &far, &[], &[], map::Parent::NewSubmap);
    assert_eq!(map.submap_members(KeyframeId(2)), [0, 1, 2, 3].map(KeyframeId));
    assert_eq!(map.submap_members(other), [other]);
    let prior = prior(&map, 3, 0.01, 1000.0);
    assert!(prior.allows(other));
    assert!(!prior.nearby(9, |_| true).contains(&other));
}
