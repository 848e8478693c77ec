//! A closed loop is taken back: the drive is what it would be if the loop had not been closed.

use geometry::{SE3, SO3, Vec3};

use super::world::*;
use crate::file::{MapFileInfo, decode, encode};
use crate::{
    Batch, Correction, KeyframeCorrection, KeyframeId, Map, MapError, NewKeyframe, Parent, PointId,
    RelativePose,
};

const K: fn(u32) -> KeyframeId = KeyframeId;
const LOOP: (KeyframeId, KeyframeId) = (KeyframeId(0), KeyframeId(8));

/// Where keyframe `k` is on the drive without a loop.
fn drive(k: u32) -> SE3 {
    SE3::new(SO3::exp(&Vec3::new(0.0, 0.1 * f64::from(k), 0.0)), Vec3::new(0.3, 0.0, f64::from(k)))
}

/// Nine keyframes of a row whose neighbors, but no others, share points.
fn nine() -> Map {
    let mut map = row_of_keyframes(9);
    let poses: Vec<(KeyframeId, SE3)> = (0..9).map(|k| (K(k), drive(k))).collect();
    map.set_estimates(&poses, &[]).unwrap();
    map
}

/// Closes a loop from keyframe 8 to 0, which bends the drive and merges four points of each.
fn close(map: &mut Map, scale: f64) {
    let bent = |k: u32| {
        let bend = SO3::exp(&Vec3::new(0.0, 0.0, 0.05 * f64::from(k)));
        SE3::new(bend, Vec3::new(0.2 * f64::from(k), 0.0, 0.0)) * drive(k)
    };
    let moved = |k| KeyframeCorrection { keyframe: K(k), cam_from_world: bent(k), scale };
    map.apply_correction(&Correction {
        keyframes: (1..9).map(moved).collect(),
        seen_revision: map.revision(),
        merged: (0..4).map(|p| (PointId(p), PointId(32 + p))).collect(),
        loop_edges: vec![LOOP],
        ..Correction::default()
    })
    .unwrap();
}

/// Inserts the next keyframe where it is seen from the one before, with matches to what `points` are now.
fn drive_on(map: &mut Map, parent: Parent, scale: f64, points: &[u32]) -> KeyframeId {
    let k = map.next_keyframe_id().0;
    let mut motion = drive(k) * drive(k - 1).inverse();
    motion.translation *= scale;
    let last = map.keyframe(K(k - 1)).unwrap().cam_from_world;
    let matches = (10..).zip(points).map(|(f, &p)| (f, map.resolve(PointId(p)).unwrap())).collect();
    let keyframe = NewKeyframe { frame: frame(k), cam_from_world: motion * last, matches, parent };
    let points = (0..4).map(|f| new_point(&[(k, f)])).collect();
    map.insert(Batch { keyframe: Some(keyframe), points }).unwrap().keyframe.unwrap()
}

/// The drive goes on by three keyframes; where a loop was closed, they also see points of the earlier visit.
fn go_on(map: &mut Map, scale: f64) {
    let was_closed = !map.loops().is_empty();
    // Keyframe 9 hangs under the wrong side and is removed later, so that 10 takes its place there.
    let parent = if was_closed { Parent::Under(K(0)) } else { Parent::Under(K(8)) };
    drive_on(
        map,
        parent,
        scale,
        if was_closed { &[32, 33, 34, 28, 29, 4, 5] } else { &[32, 33, 34, 28, 29] },
    );
    drive_on(map, Parent::Under(K(9)), scale, &[32, 33, 28]);
    drive_on(map, Parent::Closest, scale, &[33, 34, 35]);
    map.remove_keyframe(K(9)).unwrap();
}

/// Which features of which keyframes show the same point, without the points' names.
fn tracks(map: &Map) -> Vec<Vec<(u32, u32)>> {
    let track = |p: &crate::MapPoint| p.observations().iter().map(|o| (o.keyframe.0, o.feature)).collect();
    let mut tracks: Vec<_> = map.points().map(track).collect();
    tracks.sort_unstable();
    tracks
}

fn take_back(map: &mut Map) {
    let seen_revision = map.revision();
    map.apply_correction(&Correction { taken_back: vec![LOOP], seen_revision, ..Correction::default() })
        .unwrap();
    assert_eq!(map.check(), Ok(()));
}

fn gap(a: &SE3, b: &SE3) -> f64 {
    (a.rows_3x4().iter().zip(b.rows_3x4())).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

#[test]
fn the_drive_is_as_if_the_loop_had_not_been_closed() {
    for scale in [1.0, 1.25] {
        let (mut open, mut map) = (nine(), nine());
        close(&mut map, scale);
        assert_eq!(map.loops().len(), 1);
        go_on(&mut open, 1.0);
        go_on(&mut map, scale);
        let shared = |m: &Map| m.keyframe(K(0)).unwrap().shared_points(K(10));
        assert!(shared(&map) > 0 && tracks(&map) != tracks(&open), "both sides share points");
        assert!(gap(&map.keyframe(K(8)).unwrap().cam_from_world, &drive(8)) > 0.1, "it was bent");
        take_back(&mut map);

        assert!(map.loops().is_empty() && map.keyframe(K(8)).unwrap().loop_edges().is_empty());
        // Two points of keyframe 1 that only the wrong match of keyframe 9 had added to are whole again.
        assert_eq!(tracks(&map), tracks(&open));
        for (a, b) in map.keyframes().zip(open.keyframes()) {
            assert_eq!((a.id, a.covisible()), (b.id, b.covisible()));
            assert!(gap(&a.cam_from_world, &b.cam_from_world) < 1e-9, "{} at scale {scale}", a.id);
            // What came later was never as long as it is now.
            let change = if a.id < K(9) { 1.0 } else { 1.0 / scale };
            assert!((map.scale_of(a.id) - change).abs() < 1e-12);
        }
        assert_eq!(map.keyframe(K(10)).unwrap().parent(), Some(K(8)));
        // The removed keyframe was on the new visit too.
        let pose = |m: &Map| RelativePose::of_keyframe(K(9)).cam_from_world(m).unwrap();
        assert!(gap(&pose(&map), &pose(&open)) < 1e-9);
    }
}

#[test]
fn a_pose_noted_beside_the_wrong_place_goes_with_its_own_visit() {
    for scale in [1.0, 1.25] {
        let mut map = nine();
        let before = RelativePose::new(&map, K(1), SE3::identity());
        close(&mut map, scale);
        drive_on(&mut map, Parent::Closest, scale, &[32, 33]);
        // The camera is 0.2 m beside keyframe 9, and the tracker knows it from keyframe 0.
        let beside = |scale: f64| SE3::new(SO3::identity(), Vec3::new(0.2 * scale, 0.0, 0.0));
        let of = |m: &Map, k| m.keyframe(K(k)).unwrap().cam_from_world;
        let cam_from_world = beside(scale) * of(&map, 9);
        let [noted, by_visit] =
            [0, 9].map(|k| RelativePose::new(&map, K(k), cam_from_world * of(&map, k).inverse()));
        take_back(&mut map);
        for pose in [noted, by_visit, noted.on_living(&map)] {
            let expected = beside(1.0) * of(&map, 9);
            assert!(gap(&pose.cam_from_world(&map).unwrap(), &expected) < 1e-9, "scale {scale}");
        }
        assert_eq!(noted.on_living(&map).keyframe, K(9));
        assert!(gap(&before.cam_from_world(&map).unwrap(), &drive(1)) < 1e-9, "noted before: where it was");
        let after = RelativePose::new(&map, K(0), SE3::identity());
        assert!(gap(&after.cam_from_world(&map).unwrap(), &of(&map, 0)) < 1e-12, "noted after: as said");
    }
}

#[test]
fn poses_without_a_loop_are_told_without_taking_it_back() {
    let (mut open, mut map) = (nine(), nine());
    close(&mut map, 1.0);
    drive_on(&mut open, Parent::Under(K(8)), 1.0, &[32, 33, 34]);
    drive_on(&mut map, Parent::Under(K(8)), 1.0, &[32, 33, 34]);
    let digest = map.digest();
    let closed = map.loops()[0].clone();
    let of = |k: &crate::Keyframe| gap(&map.pose_without(&closed, k.id).unwrap(), &k.cam_from_world);
    assert_eq!(open.keyframes().map(of).filter(|gap| *gap < 1e-9).count(), 10);
    assert_eq!(map.pose_without(&closed, K(10)), None);
    assert_eq!(map.digest(), digest);
}

#[test]
fn a_later_loop_stands_and_no_longer_goes_back_to_the_bent_drive() {
    let mut map = nine();
    close(&mut map, 1.0);
    go_on(&mut map, 1.0);
    let second = (K(2), K(11));
    let seen_revision = map.revision();
    map.apply_correction(&Correction { loop_edges: vec![second], seen_revision, ..Correction::default() })
        .unwrap();
    take_back(&mut map);
    assert_eq!(map.loops().iter().map(|l| (l.matched, l.keyframe)).collect::<Vec<_>>(), [second]);
    assert_eq!(map.keyframe(K(11)).unwrap().loop_edges(), [K(2)]);
    let closed = &map.loops()[0];
    let moved = |k: &crate::Keyframe| gap(&map.pose_without(closed, k.id).unwrap(), &k.cam_from_world);
    assert!(map.keyframes().all(|k| moved(k) < 1e-9));
}

#[test]
fn the_oldest_of_many_loops_stands_for_good() {
    let mut map = nine();
    for n in 0..70 {
        let loop_edges = vec![(K(n % 4), K(8))];
        let seen_revision = map.revision();
        map.apply_correction(&Correction { loop_edges, seen_revision, ..Correction::default() }).unwrap();
    }
    let matched: Vec<u32> = map.loops().iter().map(|l| l.matched.0).collect();
    assert_eq!(matched, (6..70).map(|n| n % 4).collect::<Vec<u32>>());
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn a_map_file_keeps_what_is_needed() {
    let mut map = nine();
    close(&mut map, 1.0);
    go_on(&mut map, 1.0);
    let (mut read, _) = decode(&encode(&map, &MapFileInfo::default())).unwrap();
    assert_eq!(read.digest(), map.digest());
    take_back(&mut map);
    take_back(&mut read);
    assert_eq!(read.digest(), map.digest());
}

#[test]
fn what_does_not_stand_cannot_be_taken_back() {
    let mut map = nine();
    close(&mut map, 1.0);
    let taken_back = vec![LOOP, (K(1), K(7))];
    let error = refused(&mut map, |m| {
        m.apply_correction(&Correction { taken_back, seen_revision: m.revision(), ..Correction::default() })
    });
    assert_eq!(error, MapError::NoLoop { matched: K(1), keyframe: K(7) });
    // Where a sub-map is joined to another one, coordinates change for good.
    let root = NewKeyframe { parent: Parent::NewSubmap, ..new_keyframe(&map, &[]) };
    map.insert(Batch { keyframe: Some(root), points: Vec::new() }).unwrap();
    let joined = vec![(K(9), K(8))];
    map.apply_correction(&Correction { joined, seen_revision: map.revision(), ..Correction::default() })
        .unwrap();
    assert!(map.loops().is_empty());
}
