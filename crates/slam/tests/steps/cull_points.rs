//! Probation of young points: found often enough, and soon observed by more than one keyframe.

use geometry::SE3;
use map::{PointCount, PointId};

use super::*;
use crate::scene::{Scene, Shot, add, at, mapper, params, shot};
use crate::{CameraParams, Params};

/// A first keyframe with four points and `n` further keyframes of which the first `observers[i]` observe point `i`.
fn world(observers: [usize; 4], n: usize, stereo: bool, params: &Params) -> Mapper {
    let scene = Scene::wall(5);
    let shots: Vec<Shot> = (0..5).map(|i| Shot { stereo, ..shot(i) }).collect();
    let mut map = map::Map::new();
    let new: Vec<(u32, geometry::Vec3)> = (0..).zip(scene.landmarks.iter().copied()).collect();
    add(&mut map, scene.frame(0, &SE3::identity(), &shots), &SE3::identity(), &[], &new);
    for k in 0..n {
        let pose = at(0.2 * (k + 1) as f64, 0.0, 0.0);
        let seen = (0..4_u32).filter(|&i| observers[i as usize] > k);
        let matches: Vec<(u32, u32)> = seen.chain([4]).map(|i| (i, i)).collect();
        add(&mut map, scene.frame(k as u32 + 1, &pose, &shots), &pose, &matches, &[]);
    }
    let mut mapper = mapper(map, params);
    mapper.young = (0..4).map(PointId).collect();
    mapper
}

fn count(mapper: &mut Mapper, point: u32, seen: u32, found: u32) {
    mapper.count(&[PointCount { point: PointId(point), seen, found, evidence: 0 }]);
}

fn left(mapper: &Mapper) -> Vec<u32> {
    mapper.world.map.points().map(|p| p.id.0).collect()
}

#[test]
fn a_point_found_in_less_than_a_quarter_of_its_views_goes() {
    let mut mapper = world([1; 4], 1, true, &params());
    count(&mut mapper, 0, 8, 2);
    count(&mut mapper, 1, 9, 2);
    count(&mut mapper, 2, 100, 100);
    assert_eq!(mapper.cull_points(KeyframeId(1)), 1);
    assert_eq!(left(&mapper), vec![0, 2, 3, 4]);
    assert_eq!(mapper.young, [0, 2, 3].map(PointId), "the others stay on probation");
}

#[test]
fn after_two_keyframes_a_point_needs_two_stereo_observations() {
    // Made by keyframe 0: at keyframe 1 one observation is enough, at keyframe 2 it takes two.
    let mut mapper = world([0, 1, 2, 0], 2, true, &params());
    assert_eq!(mapper.clone().cull_points(KeyframeId(1)), 0);
    assert_eq!(mapper.cull_points(KeyframeId(2)), 2);
    assert_eq!(left(&mapper), vec![1, 2, 4]);
}

#[test]
fn an_observation_without_depth_counts_half() {
    // Two observations of one camera count 2, three 3, four 4; with depth 4 are needed, without 3.
    let mut mapper = world([1, 2, 1, 1], 2, false, &params());
    assert_eq!(mapper.cull_points(KeyframeId(2)), 4);
    let mono = Params::of(CameraParams::mono(10.0));
    let mut mapper = world([1, 2, 1, 1], 2, false, &mono);
    assert_eq!(mapper.cull_points(KeyframeId(2)), 3);
    assert_eq!(left(&mapper), vec![1, 4]);
}

#[test]
fn after_three_keyframes_probation_is_over() {
    let mut mapper = world([3; 4], 3, true, &params());
    assert_eq!(mapper.cull_points(KeyframeId(2)), 0);
    assert_eq!(mapper.young.len(), 4);
    assert_eq!(mapper.cull_points(KeyframeId(3)), 0);
    assert!(mapper.young.is_empty());
    count(&mut mapper, 0, 100, 0);
    assert_eq!(mapper.cull_points(KeyframeId(3)), 0, "it is not judged any more");
}
