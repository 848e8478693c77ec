//! New points from two covisible keyframes.

use geometry::{SE3, Vec3};

use super::*;
use crate::scene::{BASELINE_M, Scene, Shot, add, at, mapper, params, shot};
use crate::{CameraParams, Params};

/// Landmarks that both keyframes have as points; the others wait for triangulation.
const SHARED: usize = 5;

/// Two keyframes `distance_m` apart; the shots of the second are as `change` makes them.
fn two_views(scene: &Scene, distance_m: f64, stereo: bool, change: impl Fn(&mut Shot)) -> map::Map {
    let mut map = map::Map::new();
    let shots = |changed: bool| -> Vec<Shot> {
        let mut shots: Vec<Shot> = (0..scene.len()).map(|i| Shot { stereo, ..shot(i) }).collect();
        shots.iter_mut().filter(|_| changed).for_each(&change);
        shots
    };
    let new: Vec<(u32, Vec3)> = (0..).zip(scene.landmarks[..SHARED].iter().copied()).collect();
    add(&mut map, scene.frame(0, &SE3::identity(), &shots(false)), &SE3::identity(), &[], &new);
    let pose = at(distance_m, 0.0, 0.0);
    let matches: Vec<(u32, u32)> = (0..SHARED as u32).map(|i| (i, i)).collect();
    add(&mut map, scene.frame(1, &pose, &shots(true)), &pose, &matches, &[]);
    map
}

fn triangulated(distance_m: f64, params: &Params, change: impl Fn(&mut Shot)) -> Mapper {
    let scene = Scene::wall(20);
    let mut mapper =
        mapper(two_views(&scene, distance_m, !params.camera.sensor.is_scale_free(), change), params);
    let n_new = mapper.triangulate(KeyframeId(1));
    assert_eq!(mapper.world.map.n_points(), SHARED + n_new);
    assert_eq!(mapper.young.len(), n_new, "all are on probation");
    assert_eq!(mapper.world.map.check(), Ok(()));
    mapper
}

#[test]
fn unmatched_features_become_points_where_the_landmarks_are() {
    let scene = Scene::wall(20);
    for params in [params(), Params::of(CameraParams::mono(10.0))] {
        let mapper = triangulated(1.0, &params, |_| {});
        assert_eq!(mapper.young.len(), 15);
        for &id in &mapper.young {
            let point = mapper.world.map.point(id).unwrap();
            let [a, b] = point.observations() else { panic!("{:?}", point.observations()) };
            assert_eq!(a.feature, b.feature, "the same landmark");
            let error = (point.position - scene.landmarks[a.feature as usize]).norm();
            assert!(error < 0.01, "{error} m");
        }
    }
}

#[test]
fn keyframes_nearer_than_the_rig_s_baseline_tell_nothing() {
    assert_eq!(triangulated(BASELINE_M - 0.01, &params(), |_| {}).young.len(), 0);
    assert_eq!(triangulated(BASELINE_M + 0.01, &params(), |_| {}).young.len(), 15);
}

#[test]
fn one_camera_needs_a_hundredth_of_the_depth() {
    let scene = Scene::wall(20);
    let mono = Params::of(CameraParams::mono(10.0));
    let range = |distance_m: f64| {
        let mapper = mapper(two_views(&scene, distance_m, false, |_| {}), &mono);
        let [a, b] = [1, 0].map(|id| mapper.world.map.keyframe(KeyframeId(id)).unwrap().clone());
        mapper.depth_range(&View::new(&a), &View::new(&b), KeyframeId(0))
    };
    let map = two_views(&scene, 1.0, false, |_| {});
    let mut depths: Vec<f64> = scene.landmarks[..SHARED].iter().map(|p| p.z).collect();
    depths.sort_by(f64::total_cmp);
    let median = depths[SHARED / 2];
    assert!((median_depth(&map, KeyframeId(0)).unwrap() - median).abs() < 1e-9);
    assert_eq!(range(0.0099 * median), None);
    let (nearest, farthest) = range(0.0101 * median).unwrap();
    assert!((nearest / (0.05 * median) - 1.0).abs() < 1e-9 && farthest.is_infinite());
}

#[test]
fn different_looks_are_not_matched() {
    assert_eq!(triangulated(1.0, &params(), |s| s.flipped = 50).young.len(), 15);
    assert_eq!(triangulated(1.0, &params(), |s| s.flipped = 51).young.len(), 0);
}

#[test]
fn of_two_alike_features_on_the_ray_neither_is_taken() {
    // Landmark 19 looks like 18 and lies behind it on the ray from the first camera.
    let mut scene = Scene::wall(20);
    scene.landmarks[19] = 1.3 * scene.landmarks[18];
    let ambiguous = |bits: u32| {
        let mut scene = scene.clone();
        scene.looks[19] = crate::scene::flipped(scene.looks[18], bits);
        // Both looks of the second view are 20 bits off, so that best and second-best can be compared.
        let map = two_views(&scene, 1.0, false, |s| s.flipped = 20);
        let mut mapper = mapper(map, &Params::of(CameraParams::mono(10.0)));
        mapper.triangulate(KeyframeId(1));
        mapper.world.map.keyframe(KeyframeId(0)).unwrap().point_at(18).is_none()
    };
    assert!(ambiguous(0), "the same look twice");
    assert!(!ambiguous(120));
}

#[test]
fn features_off_the_epipolar_line_are_left() {
    let mapper = triangulated(1.0, &params(), |s| s.shift_px = [0.0, 12.0]);
    assert_eq!(mapper.young.len(), 0);
}
