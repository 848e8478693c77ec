//! Changes of the map: adding them up gives the map, whatever is done to it; what a viewer cannot show is omitted.

use std::collections::BTreeMap;

use geometry::Vec3;
use map::{KeyframeId, Map, PointId};

use super::world::{camera_at, insert, row};
use crate::{DeltaOptions, DeltaTracker, MapDelta};

/// What the changes add up to: frames by keyframe, positions by point.
#[derive(Default)]
struct Told {
    keyframes: BTreeMap<u32, u32>,
    points: BTreeMap<u32, [f32; 3]>,
}

impl Told {
    fn add(&mut self, delta: &MapDelta) {
        self.keyframes.extend(delta.keyframes.iter().map(|k| (k.id, k.frame)));
        self.points.extend(delta.points.iter().map(|p| (p.id, p.position)));
        self.keyframes.retain(|id, _| delta.gone_keyframes.iter().all(|gone| gone.id != *id));
        self.points.retain(|id, _| !delta.gone_points.contains(id));
    }

    #[track_caller]
    fn expect(&self, map: &Map) {
        let keyframes: BTreeMap<u32, u32> = map.keyframes().map(|k| (k.id.0, k.frame.index)).collect();
        assert_eq!(self.keyframes, keyframes);
        let points: BTreeMap<u32, [f32; 3]> = map
            .points()
            .map(|p| (p.id.0, [p.position.x as f32, p.position.y as f32, p.position.z as f32]))
            .collect();
        assert_eq!(self.points, points);
    }
}

#[test]
fn changes_add_up_to_the_map() {
    let (mut tracker, mut told) = (DeltaTracker::new(DeltaOptions::default()), Told::default());
    let mut map = Map::new();
    let mut tell = |map: &Map| {
        told.add(&tracker.advance(map, 0));
        told.expect(map);
    };
    for k in 0..70 {
        let seen: Vec<u32> = (4 * k.max(1) - 4..4 * k).collect();
        insert(&mut map, 5 * k, f64::from(k), &seen, 4);
        if k % 3 == 0 {
            tell(&map);
        }
    }
    map.merge_points(PointId(150), PointId(151)).unwrap();
    map.remove_point(PointId(30)).unwrap();
    tell(&map);
    map.remove_keyframe(KeyframeId(20)).unwrap();
    tell(&map);
    let moved: Vec<_> = map.keyframes().map(|k| (k.id, camera_at(1.0 + f64::from(k.id.0)))).collect();
    let points: Vec<_> = map.points().map(|p| (p.id, p.position + Vec3::x())).collect();
    map.set_estimates(&moved, &points).unwrap();
    tell(&map);
}

#[test]
fn what_did_not_change_is_not_told() {
    let mut map = row(40);
    let mut tracker = DeltaTracker::new(DeltaOptions::default());
    assert_eq!(tracker.advance(&map, 0).points.len(), map.n_points());
    assert!(tracker.advance(&map, 0).is_empty());
    map.set_estimates(&[], &[(PointId(8), Vec3::new(50.0, 0.0, 9.0))]).unwrap();
    let delta = tracker.advance(&map, 0);
    assert_eq!(delta.points.iter().map(|p| p.id).collect::<Vec<_>>(), [8]);
    assert!(delta.keyframes.is_empty() && delta.gone_points.is_empty());
}

#[test]
fn small_moves_are_told_when_they_add_up_and_at_the_end() {
    let mut map = row(4);
    let mut tracker = DeltaTracker::new(DeltaOptions { moved_share: 0.01, ..DeltaOptions::default() });
    tracker.advance(&map, 0);
    let mut told = Vec::new();
    for step in 1..=5 {
        // About ten meters away: a tenth of a meter is a visible move.
        let position = Vec3::new(0.0, 1.0, 10.0 + 0.04 * f64::from(step));
        map.set_estimates(&[], &[(PointId(0), position)]).unwrap();
        told.push(tracker.advance(&map, 0).points.len());
    }
    assert_eq!(told, [0, 0, 1, 0, 0]);
    let rest = tracker.finish(&map, 0);
    assert_eq!(rest.points.len(), 1, "{rest:?}");
    assert!((f64::from(rest.points[0].position[2]) - 10.2).abs() < 1e-6);
    assert!(tracker.finish(&map, 0).is_empty());
}

#[test]
fn a_removed_keyframe_names_its_heir() {
    let mut map = row(5);
    let mut tracker = DeltaTracker::new(DeltaOptions::default());
    tracker.advance(&map, 0);
    map.remove_keyframe(KeyframeId(3)).unwrap();
    let delta = tracker.advance(&map, 0);
    let [gone] = &delta.gone_keyframes[..] else { panic!("{:?}", delta.gone_keyframes) };
    let (heir, gone_from_heir) = map.resolve_keyframe(KeyframeId(3)).unwrap();
    assert_eq!((gone.id, gone.heir), (3, heir.0));
    assert_eq!(gone.gone_from_heir.translation, <[f64; 3]>::from(gone_from_heir.translation));
    // One that came and went between two snapshots was never told of.
    insert(&mut map, 90, 6.0, &[12, 13, 14, 15], 0);
    let passing = map.newest_keyframe().unwrap();
    map.remove_keyframe(passing).unwrap();
    assert!(tracker.advance(&map, 0).gone_keyframes.is_empty());
}

#[test]
fn points_are_as_old_as_their_keyframe() {
    let mut map = row(5);
    map.remove_keyframe(KeyframeId(3)).unwrap();
    let mut tracker = DeltaTracker::new(DeltaOptions::default());
    let delta = tracker.advance(&map, 0);
    let born = |id: u32| delta.points.iter().find(|p| p.id == id).unwrap().born;
    assert_eq!((born(0), born(4), born(8)), (0, 5, 10));
    assert!(delta.points.iter().all(|p| p.activation == 225), "nothing is known: seven of eight stand still");
}

#[test]
fn edges_point_to_older_keyframes() {
    let map = row(6);
    let options = DeltaOptions { covisible_points: 4, covisible_shown: 1, ..DeltaOptions::default() };
    let delta = DeltaTracker::new(options).advance(&map, 0);
    let edges: Vec<(u32, Vec<u32>)> = delta.keyframes.iter().map(|k| (k.id, k.covisible.clone())).collect();
    let expected: Vec<(u32, Vec<u32>)> =
        (0..6_u32).map(|id| (id, id.checked_sub(1).into_iter().collect())).collect();
    assert_eq!(edges, expected);
}
