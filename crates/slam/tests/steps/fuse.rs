//! Duplicates become one point, free features are linked, and what does not fit stays apart.

use geometry::SE3;
use map::Map;

use super::*;
use crate::scene::{Scene, Shot, add, at, mapper, params, shot};

/// Landmarks that both keyframes know as one point.
const SHARED: usize = 12;

/// Two keyframes with common points; of the landmark behind them the first has a point, and the second shows it as
/// `second`, as a point of its own if `own`.
fn two_views(second: Shot, own: bool) -> Mapper {
    let scene = Scene::wall(SHARED + 1);
    let last = scene.landmarks[SHARED];
    let mut map = scene.map(&[SE3::identity()]);
    let pose = at(0.3, 0.0, 0.0);
    let mut shots: Vec<Shot> = (0..SHARED).map(shot).collect();
    shots.push(second);
    let matches: Vec<(u32, u32)> = (0..SHARED as u32).map(|i| (i, i)).collect();
    let new = [(SHARED as u32, last)];
    add(&mut map, scene.frame(1, &pose, &shots), &pose, &matches, if own { &new } else { &[] });
    mapper(map, &params())
}

fn point_of(map: &Map, keyframe: u32, feature: usize) -> Option<PointId> {
    map.keyframe(KeyframeId(keyframe)).unwrap().point_at(feature as u32)
}

fn fused(second: Shot, own: bool) -> bool {
    let mut mapper = two_views(second, own);
    let changed = mapper.fuse(KeyframeId(1));
    let map = &mapper.world.map;
    assert_eq!(map.check(), Ok(()));
    let (first, second) = (point_of(map, 0, SHARED), point_of(map, 1, SHARED));
    let one = first.is_some() && first == second;
    assert_eq!(changed, usize::from(one), "each change is counted once");
    assert_eq!(map.n_points(), SHARED + 1 + usize::from(own && !one));
    one
}

#[test]
fn two_points_of_one_landmark_become_the_older_one() {
    let mut mapper = two_views(shot(SHARED), true);
    assert_eq!(mapper.fuse(KeyframeId(1)), 1);
    let map = &mapper.world.map;
    let older = PointId(SHARED as u32);
    assert_eq!([point_of(map, 0, SHARED), point_of(map, 1, SHARED)], [Some(older); 2]);
    assert_eq!(map.resolve(PointId(SHARED as u32 + 1)), Some(older));
}

#[test]
fn a_free_feature_is_linked() {
    assert!(fused(shot(SHARED), false));
}

#[test]
fn a_different_look_is_not_fused() {
    assert!(fused(Shot { flipped: 50, ..shot(SHARED) }, true));
    assert!(!fused(Shot { flipped: 51, ..shot(SHARED) }, true));
}

#[test]
fn only_what_reprojects_within_the_gate_is_fused() {
    // Octave 2: standard deviation 1.44 px; with three degrees of freedom the gate is at 2.7955 of them, 4.03 px.
    let shifted = |pixels: f64| Shot { shift_px: [0.0, pixels], ..shot(SHARED) };
    for sign in [1.0, -1.0] {
        assert!(fused(shifted(sign * 3.9), false));
        assert!(!fused(shifted(sign * 4.15), false), "still in the window of 4.32 px");
    }
}

#[test]
fn what_looks_more_alike_but_is_farther_away_does_not_matter() {
    let scene = Scene::wall(SHARED + 1);
    let mut map = scene.map(&[SE3::identity()]);
    let pose = at(0.3, 0.0, 0.0);
    let mut shots: Vec<Shot> = (0..SHARED).map(shot).collect();
    // 7 px are beyond the window of 3 px * 1.2^3.
    shots.push(Shot { flipped: 20, ..shot(SHARED) });
    shots.push(Shot { shift_px: [0.0, 7.0], ..shot(SHARED) });
    let matches: Vec<(u32, u32)> = (0..SHARED as u32).map(|i| (i, i)).collect();
    add(&mut map, scene.frame(1, &pose, &shots), &pose, &matches, &[]);
    let mut mapper = mapper(map, &params());
    assert_eq!(mapper.fuse(KeyframeId(1)), 1);
    assert_eq!(point_of(&mapper.world.map, 1, SHARED), Some(PointId(SHARED as u32)));
}

#[test]
fn the_point_with_more_observations_stays() {
    let scene = Scene::wall(4);
    let mut map = scene.map(&[SE3::identity()]);
    let pose = at(0.3, 0.0, 0.0);
    let doubled: Vec<(u32, geometry::Vec3)> = (0..).zip(scene.landmarks.iter().copied()).take(3).collect();
    add(&mut map, scene.whole(1, &pose), &pose, &[], &doubled);
    // Points 4, 5 and 6 double 0, 1 and 2; 5 is seen a second time.
    add(&mut map, scene.whole(2, &pose), &pose, &[(1, 5)], &[]);
    let mapper = mapper(map, &params());
    assert_eq!(
        mapper.longer_lived(PointId(0), PointId(4)),
        (PointId(0), PointId(4)),
        "equals: the older one"
    );
    assert_eq!(mapper.longer_lived(PointId(4), PointId(0)), (PointId(0), PointId(4)));
    assert_eq!(mapper.longer_lived(PointId(1), PointId(5)), (PointId(5), PointId(1)));
    assert_eq!(mapper.longer_lived(PointId(5), PointId(1)), (PointId(5), PointId(1)));
}

#[test]
fn a_point_of_the_same_keyframe_is_not_fused_with_another_of_it() {
    // Both features of the first keyframe show nearly the same place with the same look.
    let mut scene = Scene::wall(6);
    scene.landmarks.push(scene.landmarks[0]);
    scene.looks.push(scene.looks[0]);
    let mut mapper = mapper(scene.map(&[SE3::identity()]), &params());
    assert_eq!(mapper.fuse_into(KeyframeId(0), &(0..7).map(PointId).collect::<Vec<_>>()), 0);
    assert_eq!(mapper.world.map.n_points(), 7);
}

#[test]
fn neighbors_of_first_and_second_order_are_looked_at_once() {
    // A chain in which neighboring keyframes share points, numbered by landmark.
    let scene = Scene::wall(20);
    let mut map = Map::new();
    for k in 0..5_usize {
        let pose = at(0.1 * k as f64, 0.0, 0.0);
        let shots: Vec<Shot> = (4 * k..4 * k + 4).chain((4 * k).saturating_sub(2)..4 * k).map(shot).collect();
        let new: Vec<(u32, geometry::Vec3)> =
            (0..4).map(|i| (i, scene.landmarks[4 * k + i as usize])).collect();
        let old: Vec<(u32, u32)> =
            if k == 0 { vec![] } else { (4..6).map(|i| (i, 4 * k as u32 + i - 6)).collect() };
        add(&mut map, scene.frame(k as u32, &pose, &shots), &pose, &old, &new);
    }
    let mut few = params();
    let targets = |params: &crate::Params, map: &Map| -> Vec<u32> {
        mapper(map.clone(), params).fusion_targets(KeyframeId(2)).iter().map(|id| id.0).collect()
    };
    assert_eq!(targets(&few, &map), vec![1, 0, 3, 4]);
    few.mapping.second_neighbors = 0;
    assert_eq!(targets(&few, &map), vec![1, 3]);
    few.mapping.neighbours = Some(1);
    assert_eq!(targets(&few, &map), vec![1]);
}
