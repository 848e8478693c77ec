//! Which points a camera should see: in front, in the image, at a believable distance, from a similar direction.

use geometry::SO3;

use super::*;
use crate::scene::{OCTAVE, Scene, at, rig};

/// A point 10 m ahead of the keyframe that made it.
fn point_ahead() -> (Map, MapPoint) {
    let map = Scene::at(vec![Vec3::new(0.0, 0.0, 10.0)]).map(&[SE3::identity()]);
    let point = map.point(PointId(0)).unwrap().clone();
    (map, point)
}

fn seen_from(map: &Map, point: &MapPoint, cam_from_world: &SE3) -> Option<Projection> {
    let frame = &map.keyframes().next().unwrap().frame;
    project_visible(frame, cam_from_world, &cam_from_world.center(), point)
}

#[test]
fn a_point_ahead_falls_where_the_rig_projects_it() {
    let (map, point) = point_ahead();
    let seen = seen_from(&map, &point, &at(1.0, 0.0, 0.0)).unwrap();
    let expected = rig().stereo.project(&Vec3::new(-1.0, 0.0, 10.0));
    assert_eq!([seen.u, seen.v, seen.right_u], [expected.x, expected.y, expected.z]);
    // The normal is the z axis, the ray is inclined by atan(1 / 10).
    assert!((seen.view_cos - 10.0 / 101.0_f64.sqrt()).abs() < 1e-12);
}

#[test]
fn what_is_behind_or_outside_is_not_seen() {
    let (map, point) = point_ahead();
    let frame = &map.keyframes().next().unwrap().frame;
    let inside =
        |x: f64, y: f64, z: f64| project_inside(frame, &SE3::identity(), &Vec3::new(x, y, z)).is_some();
    assert!(inside(0.0, 0.0, 1.0) && !inside(0.0, 0.0, 0.0) && !inside(0.0, 0.0, -1.0));
    // 320 pixels to both sides, 240 up and down; the last column and row belong to the next pixel.
    assert!(inside(-6.4, 0.0, 10.0) && !inside(-6.41, 0.0, 10.0));
    assert!(inside(6.39, 0.0, 10.0) && !inside(6.4, 0.0, 10.0));
    assert!(inside(0.0, -4.8, 10.0) && !inside(0.0, -4.81, 10.0));
    assert!(inside(0.0, 4.79, 10.0) && !inside(0.0, 4.8, 10.0));
    assert!(seen_from(&map, &point, &at(0.0, 0.0, 12.0)).is_none(), "the camera has passed it");
}

#[test]
fn a_point_is_seen_at_distances_where_its_scale_is_in_the_pyramid() {
    let (map, point) = point_ahead();
    let max = 10.0 * 1.2_f64.powi(i32::from(OCTAVE));
    assert!((point.max_distance_m / max - 1.0).abs() < 1e-6);
    let seen_at = |distance: f64| seen_from(&map, &point, &at(0.0, 0.0, 10.0 - distance)).is_some();
    assert!(seen_at(1.199 * max) && !seen_at(1.201 * max));
    let min = max / 1.2_f64.powi(7);
    assert!(seen_at(0.801 * min) && !seen_at(0.799 * min));
}

#[test]
fn a_point_is_seen_up_to_sixty_degrees_from_its_normal() {
    let (map, point) = point_ahead();
    let seen_at = |degrees: f64| {
        // The camera goes round the point and keeps it in the middle.
        let turn = SO3::exp(&Vec3::new(0.0, degrees.to_radians(), 0.0));
        let world_from_cam = SE3::new(turn, point.position - turn * Vec3::new(0.0, 0.0, 10.0));
        seen_from(&map, &point, &world_from_cam.inverse()).is_some()
    };
    assert!(seen_at(0.0) && seen_at(59.9) && seen_at(-59.9));
    assert!(!seen_at(60.1) && !seen_at(-60.1));
}

#[test]
fn the_octave_follows_from_the_distance() {
    let (map, _) = point_ahead();
    let frame = &map.keyframes().next().unwrap().frame;
    let octave_at = |distance: f64| predict_octave(frame, 12.0, distance);
    assert_eq!(octave_at(13.0), 0);
    assert_eq!(octave_at(12.0), 0);
    assert_eq!(octave_at(11.9), 1);
    assert_eq!(octave_at(12.0 / 1.2_f64.powi(3) * 1.001), 3);
    assert_eq!(octave_at(12.0 / 1.2_f64.powi(3) * 0.999), 4);
    assert_eq!(octave_at(0.1), 7, "the coarsest there is");
}

#[test]
fn visible_points_keep_their_order_and_leave_the_known_ones_out() {
    let scene = Scene::wall(20);
    let mut map = scene.map(&[SE3::identity(), at(0.2, 0.0, 0.0)]);
    map.remove_point(PointId(4)).unwrap();
    let frame = scene.whole(2, &SE3::identity());
    let asked: Vec<PointId> = (0..20).rev().map(PointId).collect();
    let known = [PointId(7), PointId(3)];
    let seen = visible_points(&frame, &map, &SE3::identity(), &asked, known.into_iter());
    let expected: Vec<PointId> = asked.iter().copied().filter(|id| ![3, 4, 7].contains(&id.0)).collect();
    assert_eq!(seen.iter().map(|s| s.point.id).collect::<Vec<_>>(), expected);
}
