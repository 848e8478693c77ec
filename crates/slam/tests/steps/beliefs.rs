//! Beliefs of tracking: evidence counts at once, once only, and for its own point.

use super::*;
use crate::scene::{Scene, at};
use geometry::Vec3;

/// A map of two points.
fn map() -> Map {
    let (near, pose) = ([Vec3::new(2.0, 1.0, 10.0), Vec3::new(-2.0, 1.0, 12.0)], at(0.0, 0.0, 0.0));
    Scene::at(near.to_vec()).map(&[pose, pose])
}

fn count(point: u32, evidence: i32) -> PointCount {
    PointCount { point: PointId(point), seen: 1, found: 1, evidence }
}

#[test]
fn evidence_counts_before_the_map_has_heard_of_it_and_once() {
    let (mut map, mut beliefs) = (map(), Beliefs::default());
    let first = beliefs.trust(&map, PointId(0));
    let told = [[count(0, -900), count(1, 100)], [count(0, -800), count(1, 0)], [count(0, 300), count(1, 0)]];
    for counts in &told {
        beliefs.add(&map, counts);
    }
    let known = beliefs.trust(&map, PointId(0));
    assert!(known < first && beliefs.trust(&map, PointId(1)) > first);
    // The map hears of the frames one by one; what is known in all stays.
    for counts in &told {
        map.count(counts).unwrap();
        beliefs.add(&map, &[]);
        assert_eq!(beliefs.trust(&map, PointId(0)), known);
    }
    assert_eq!(known, map.point(PointId(0)).unwrap().trust() as f32);
    assert!(beliefs.unheard.is_empty());
}

#[test]
fn a_map_that_hears_nothing_leaves_only_the_last_frames() {
    let (map, mut beliefs) = (map(), Beliefs::default());
    for _ in 0..10 * MOST_FRAMES {
        beliefs.add(&map, &[count(0, -10)]);
    }
    assert_eq!(beliefs.unheard[&PointId(0)].len(), MOST_FRAMES);
    assert_eq!(beliefs.trust(&map, PointId(7)), 1.0, "a point that is not in the map");
}
