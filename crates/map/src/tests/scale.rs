//! Corrections that change the scale: points, followers, removed keyframes and old frames keep their shape.

use geometry::{SE3, Vec3};
use proptest::prelude::*;

use super::random_mutations::random_map;
use super::world::*;
use crate::{Correction, KeyframeCorrection, KeyframeId, Map, MapError, RelativePose};

const K: fn(u32) -> KeyframeId = KeyframeId;

/// The motion of the world `x -> scale * (rotation * x + translation)`.
struct Similarity {
    motion: SE3,
    scale: f64,
}

impl Similarity {
    fn of(seed: u64, scale: f64) -> Self {
        Similarity { motion: random_pose(&mut generator(seed)), scale }
    }

    fn point(&self, p: &Vec3) -> Vec3 {
        self.scale * (self.motion * *p)
    }

    fn pose(&self, cam_from_world: &SE3) -> SE3 {
        let moved = *cam_from_world * self.motion.inverse();
        SE3::new(moved.rotation, self.scale * moved.translation)
    }

    /// Moves every keyframe of the map by this.
    fn correction(&self, map: &Map) -> Correction {
        let corrected = |k: &crate::Keyframe| KeyframeCorrection {
            keyframe: k.id,
            cam_from_world: self.pose(&k.cam_from_world),
            scale: self.scale,
        };
        let keyframes = map.keyframes().map(corrected).collect();
        Correction { keyframes, seen_revision: map.revision(), ..Correction::default() }
    }
}

/// Pose of a keyframe, living or removed.
fn pose_of(map: &Map, keyframe: KeyframeId) -> SE3 {
    let (alive, removed_from_alive) = map.resolve_keyframe(keyframe).unwrap();
    removed_from_alive * map.keyframe(alive).unwrap().cam_from_world
}

fn gap(a: &SE3, b: &SE3) -> f64 {
    a.rows_3x4().iter().zip(b.rows_3x4()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

#[test]
fn a_similarity_of_all_keyframes_is_one_of_the_whole_map() {
    let mut map = row_of_keyframes(9);
    for k in [4, 3, 5] {
        map.remove_keyframe(K(k)).unwrap();
    }
    let before = map.clone();
    let s = Similarity::of(1, 2.5);
    map.apply_correction(&s.correction(&before)).unwrap();
    assert_eq!(map.check(), Ok(()));
    for (old, new) in before.points().zip(map.points()) {
        assert!((s.point(&old.position) - new.position).norm() < 1e-11);
        assert!((s.motion.rotation * old.normal - new.normal).norm() < 1e-11);
        assert!((2.5 * old.max_distance_m - new.max_distance_m).abs() < 1e-11 * new.max_distance_m);
    }
    for k in (0..9).map(K) {
        assert!(gap(&s.pose(&pose_of(&before, k)), &pose_of(&map, k)) < 1e-11, "keyframe {k}");
        assert_eq!([before.scale_of(k), map.scale_of(k)], [1.0, 2.5]);
    }
    // The next keyframe starts anew, the others multiply.
    add(&mut map, &[], &[]);
    map.apply_correction(&Similarity::of(2, 0.5).correction(&map.clone())).unwrap();
    assert_eq!([0, 4, 9].map(|k| map.scale_of(K(k))), [1.25, 1.25, 0.5]);
    assert_eq!(map.scale_of(K(99)), 1.0);
}

#[test]
fn later_keyframes_and_their_points_follow_in_the_scale_of_their_parent() {
    let seen = row_of_keyframes(5);
    let mut map = seen.clone();
    for _ in 0..4 {
        let k = map.next_keyframe_id().0;
        add(&mut map, &[(9, 4 * k - 1)], &[&[(k, 0)], &[(k, 1), (1, 20 + k)], &[(k, 2)], &[(k, 3)]]);
    }
    map.remove_keyframe(K(6)).unwrap(); // a later one, removed before the correction comes
    let before = map.clone();
    let s = Similarity::of(3, 0.25);
    map.apply_correction(&s.correction(&seen)).unwrap();
    assert_eq!(map.check(), Ok(()));
    for k in (0..9).map(K) {
        assert!(gap(&s.pose(&pose_of(&before, k)), &pose_of(&map, k)) < 1e-11, "keyframe {k}");
        assert_eq!(map.scale_of(k), 0.25);
    }
    for (old, new) in before.points().zip(map.points()) {
        assert!((s.point(&old.position) - new.position).norm() < 1e-11, "point {}", old.id);
    }
}

#[test]
fn a_pose_noted_relative_to_a_keyframe_is_told_the_scale_since() {
    let mut map = row_of_keyframes(6);
    map.apply_correction(&Similarity::of(4, 3.0).correction(&map.clone())).unwrap();
    let reference = K(4);
    let cam_from_reference = random_pose(&mut generator(5));
    let scale_then = map.scale_of(reference);
    let noted = cam_from_reference * pose_of(&map, reference);

    let s = Similarity::of(6, 0.4);
    map.apply_correction(&s.correction(&map.clone())).unwrap();
    map.remove_keyframe(reference).unwrap();
    let since = map.scale_of(reference) / scale_then;
    let now = SE3::new(cam_from_reference.rotation, since * cam_from_reference.translation)
        * pose_of(&map, reference);
    assert!(gap(&now, &s.pose(&noted)) < 1e-11);
    // Later scales reach it through the keyframe that carries it.
    let t = Similarity::of(7, 5.0);
    map.apply_correction(&t.correction(&map.clone())).unwrap();
    assert!((map.scale_of(reference) / scale_then - 0.4 * 5.0).abs() < 1e-12);
}

#[test]
fn a_scale_of_one_keyframe_leaves_the_others() {
    let mut map = row_of_keyframes(6);
    map.remove_keyframe(K(4)).unwrap(); // carried by its parent 3
    let before = map.clone();
    let cam_from_world = before.keyframe(K(3)).unwrap().cam_from_world;
    let keyframes = vec![KeyframeCorrection { keyframe: K(3), cam_from_world, scale: 2.0 }];
    let seen_revision = map.revision();
    map.apply_correction(&Correction { keyframes, seen_revision, ..Correction::default() }).unwrap();
    assert_eq!(map.check(), Ok(()));
    assert_eq!([2, 3, 4, 5].map(|k| map.scale_of(K(k))), [1.0, 2.0, 2.0, 1.0]);
    for (old, new) in before.points().zip(map.points()) {
        if old.reference == K(3) {
            let (a, b) = (cam_from_world * old.position, cam_from_world * new.position);
            assert!((2.0 * a - b).norm() < 1e-12, "twice as far from the camera");
        } else {
            assert_eq!(old.position, new.position);
        }
    }
}

#[test]
fn solutions_leave_scales_alone() {
    let mut map = row_of_keyframes(4);
    map.apply_correction(&Similarity::of(8, 2.0).correction(&map.clone())).unwrap();
    map.remove_keyframe(K(2)).unwrap();
    let [kept, removed] = [K(1), K(2)].map(|k| (map.scale_of(k), map.resolve_keyframe(k).unwrap().1));
    map.set_estimates(&[(K(1), random_pose(&mut generator(9)))], &[]).unwrap();
    assert_eq!((map.scale_of(K(1)), map.scale_of(K(2))), (kept.0, removed.0));
    assert_eq!(map.resolve_keyframe(K(2)).unwrap().1, removed.1);
}

#[test]
fn what_is_no_scale_is_refused() {
    let mut map = row_of_keyframes(4);
    map.remove_keyframe(K(2)).unwrap();
    for scale in [0.0, -1.0, f64::INFINITY, f64::NEG_INFINITY] {
        let correction = Similarity { motion: SE3::identity(), scale: 1.0 }.correction(&map);
        let mut bad = correction.clone();
        bad.keyframes[1].scale = scale;
        let error = refused(&mut map, |m| m.apply_correction(&bad));
        assert_eq!(error, MapError::Scale { keyframe: K(1), scale });
        bad.keyframes[1].scale = f64::NAN;
        let error = refused(&mut map, |m| m.apply_correction(&bad));
        assert!(matches!(error, MapError::Scale { keyframe: KeyframeId(1), .. }));
    }
    // A product beyond the numbers: 1e-200 twice.
    let at_rest = |map: &Map, scale| {
        let cam_from_world = map.keyframe(K(3)).unwrap().cam_from_world;
        let keyframes = vec![KeyframeCorrection { keyframe: K(3), cam_from_world, scale }];
        Correction { keyframes, seen_revision: map.revision(), ..Correction::default() }
    };
    map.apply_correction(&at_rest(&map.clone(), 1e-200)).unwrap();
    let again = at_rest(&map, 1e-200);
    let error = refused(&mut map, |m| m.apply_correction(&again));
    assert_eq!(error, MapError::Scale { keyframe: K(3), scale: 0.0 });
    assert_eq!(error.to_string(), "scale of keyframe K3 is 0, expected a positive finite number");
    // A follower out of range: the removed keyframe of the one that grows.
    let cam_from_world = map.keyframe(K(1)).unwrap().cam_from_world;
    let keyframes = vec![KeyframeCorrection { keyframe: K(1), cam_from_world, scale: 1e13 }];
    let correction = Correction { keyframes, seen_revision: map.revision(), ..Correction::default() };
    assert_eq!(map.resolve_keyframe(K(2)).unwrap().0, K(1));
    refused(&mut map, |m| m.apply_correction(&correction));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever happened to a map: scaled as a whole, every keyframe that ever was and every point goes along.
    #[test]
    fn any_map_can_be_scaled(seed in any::<u64>(), scale in 0.2..5.0_f64) {
        let mut map = random_map(seed, 120);
        let before = map.clone();
        let s = Similarity::of(seed, scale);
        map.apply_correction(&s.correction(&before)).unwrap();
        prop_assert_eq!(map.check(), Ok(()));
        for k in (0..map.next_keyframe_id().0).map(K) {
            let (expected, found) = (s.pose(&pose_of(&before, k)), pose_of(&map, k));
            prop_assert!(gap(&expected, &found) < 1e-9 * (1.0 + expected.translation.norm()));
            prop_assert!((map.scale_of(k) / before.scale_of(k) - scale).abs() < 1e-12);
        }
        for (old, new) in before.points().zip(map.points()) {
            let expected = s.point(&old.position);
            prop_assert!((expected - new.position).norm() < 1e-9 * (1.0 + expected.norm()));
        }
    }
}

#[test]
fn a_relative_pose_follows_its_keyframe_through_removal_and_similarity() {
    let mut map = row_of_keyframes(6);
    let cam_from_keyframe = random_pose(&mut generator(3));
    let pose = RelativePose::new(&map, K(3), cam_from_keyframe);
    let before = pose.cam_from_world(&map).unwrap();
    assert_eq!(before, cam_from_keyframe * pose_of(&map, K(3)));
    map.remove_keyframe(K(3)).unwrap();
    assert!(gap(&pose.cam_from_world(&map).unwrap(), &before) < 1e-12, "removal moves nothing");
    let similarity = Similarity::of(4, 1.7);
    map.apply_correction(&similarity.correction(&map)).unwrap();
    let moved = similarity.pose(&before);
    assert!(gap(&pose.cam_from_world(&map).unwrap(), &moved) < 1e-9);
    let living = pose.on_living(&map);
    assert!(living.keyframe != K(3) && map.keyframe(living.keyframe).is_some());
    assert!(gap(&living.cam_from_world(&map).unwrap(), &moved) < 1e-9);
    assert_eq!(RelativePose::new(&map, K(99), cam_from_keyframe).cam_from_world(&map), None);
}
