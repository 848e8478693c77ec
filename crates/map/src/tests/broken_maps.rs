//! `check` finds each broken relation and names it. Maps are broken through the fields that only this crate sees.

use std::sync::Arc;

use geometry::{Mat3, SO3, Vec3};

use super::world::*;
use crate::{ClosedLoop, Correction, KeyframeId, Map, PointId, PoseDefect, Violation};

const K: fn(u32) -> KeyframeId = KeyframeId;
const P: fn(u32) -> PointId = PointId;

/// Seven keyframes in a row with a loop edge, a removed keyframe, a merged and a removed point.
fn sound_map() -> Map {
    let mut map = row_of_keyframes(8);
    let loop_edges = vec![(K(0), K(5))];
    map.apply_correction(&Correction { loop_edges, ..Correction::default() }).unwrap();
    map.remove_keyframe(K(3)).unwrap();
    map.merge_points(P(16), P(17)).unwrap();
    map.remove_point(P(18)).unwrap();
    assert_eq!(map.check(), Ok(()));
    map
}

/// Breaks a sound map and expects the violation among those found.
#[track_caller]
fn expect(violation: Violation, break_it: impl FnOnce(&mut Map)) {
    let mut map = sound_map();
    break_it(&mut map);
    let found = map.check().expect_err("broken");
    assert!(found.contains(&violation), "{violation:?} not in {found:#?}");
}

#[test]
fn wrong_names() {
    expect(Violation::KeyframeId { keyframe: K(2), carries: K(9) }, |m| m.keyframes.live_mut(K(2)).id = K(9));
    expect(Violation::PointId { point: P(2), carries: P(9) }, |m| m.points.live_mut(P(2)).id = P(9));
}

#[test]
fn broken_forwarding() {
    expect(Violation::PointForward { point: P(18) }, |m| m.points.remove(P(18), Some(P(99))));
    expect(Violation::PointForward { point: P(18) }, |m| m.points.remove(P(18), Some(P(18))));
    expect(Violation::KeyframeForward { keyframe: K(3) }, |m| m.keyframes.remove(K(3), None));
    let mut removed = *sound_map().keyframes.forward(K(3)).unwrap();
    removed.parent = K(3);
    expect(Violation::KeyframeForward { keyframe: K(3) }, |m| m.keyframes.remove(K(3), Some(removed)));
    removed.parent = K(2);
    removed.removed_from_parent.translation.x = f64::NAN;
    let pose = Violation::Pose { keyframe: K(3), defect: PoseDefect::NotFinite };
    expect(pose, |m| m.keyframes.remove(K(3), Some(removed)));
    let scale = Violation::Scale { keyframe: K(3), scale: -1.0 };
    expect(scale, |m| m.keyframes.forward_mut(K(3)).unwrap().scale = -1.0);
}

#[test]
fn ids_of_removed_things() {
    let missing = K(3);
    let by = |keyframe| Violation::MissingKeyframe { keyframe, missing };
    expect(by(K(5)), |m| m.keyframes.live_mut(K(5)).covisible.push((missing, 1)));
    expect(by(K(5)), |m| m.keyframes.live_mut(K(5)).loop_edges.push(missing));
    expect(by(K(5)), |m| m.keyframes.live_mut(K(5)).children.push(missing));
    expect(by(K(5)), |m| m.keyframes.live_mut(K(5)).parent = Some(missing));
    let observer = Violation::MissingObserver { point: P(20), missing };
    expect(observer.clone(), |m| m.points.live_mut(P(20)).observations.insert(0, at(3, 39)));
    expect(observer, |m| m.points.live_mut(P(20)).reference = missing);
    let point = |missing| Violation::MissingPoint { keyframe: K(5), feature: 39, missing };
    for id in [P(17), P(18), P(99)] {
        expect(point(id), |m| m.keyframes.live_mut(K(5)).set_point(39, Some(id)));
    }
}

#[test]
fn observations_of_one_side() {
    let feature = sound_map().point(P(20)).unwrap().feature_in(K(6)).unwrap();
    let one_sided =
        |feature, shows| Violation::OneSidedObservation { point: P(20), keyframe: K(6), feature, shows };
    expect(one_sided(feature, None), |m| m.keyframes.live_mut(K(6)).set_point(feature, None));
    expect(one_sided(feature, Some(P(21))), |m| m.keyframes.live_mut(K(6)).set_point(feature, Some(P(21))));
    expect(one_sided(99, None), |m| m.points.live_mut(P(20)).observations[1].feature = 99);
    let unlisted = Violation::UnlistedObservation { keyframe: K(6), feature, point: P(20) };
    expect(unlisted, |m| {
        m.points.live_mut(P(20)).observations.remove(1);
    });
    // One point at two features of a keyframe.
    let second = Violation::UnlistedObservation { keyframe: K(6), feature: 39, point: P(20) };
    expect(second, |m| m.keyframes.live_mut(K(6)).set_point(39, Some(P(20))));
    expect(Violation::ObservationOrder { point: P(20), keyframe: K(6) }, |m| {
        m.points.live_mut(P(20)).observations.insert(2, at(6, 39));
        m.keyframes.live_mut(K(6)).set_point(39, Some(P(20)));
    });
    expect(Violation::TableLength { keyframe: K(6), n_features: 40, n_entries: 41 }, |m| {
        std::sync::Arc::make_mut(&mut m.keyframes.live_mut(K(6)).points).push(None);
    });
}

#[test]
fn too_few_observations() {
    let few = |point, created_by, n_observations| Violation::TooFewObservations {
        point,
        created_by,
        n_observations,
    };
    let mut map = sound_map();
    // Point 28 is seen by its creator 7 only, and young until two more are there.
    for (creator, is_found) in [(5, false), (4, true)] {
        map.points.live_mut(P(28)).created_by = K(creator);
        let found = map.check().expect_err("the notes on probation do not fit");
        assert_eq!(found.contains(&few(P(28), K(creator), 1)), is_found);
    }
    expect(few(P(28), K(7), 0), |m| m.points.live_mut(P(28)).observations.clear());
    let creator = Violation::Creator { point: P(28), created_by: K(8) };
    expect(creator, |m| m.points.live_mut(P(28)).created_by = K(8));
    expect(Violation::Reference { point: P(28), reference: K(1) }, |m| {
        m.points.live_mut(P(28)).reference = K(1)
    });
}

#[test]
fn an_impossible_history() {
    let revision = sound_map().revision();
    let inserted = |keyframe, inserted_at| Violation::InsertedAt { keyframe, inserted_at, revision };
    let at_revision = |k, inserted_at| move |m: &mut Map| m.keyframes.live_mut(k).inserted_at = inserted_at;
    expect(inserted(K(7), revision + 1), at_revision(K(7), revision + 1));
    expect(inserted(K(0), 0), at_revision(K(0), 0));
    expect(inserted(K(4), 2), at_revision(K(4), 2)); // that of K1

    assert_eq!(sound_map().first_young, [P(20), P(24), P(28)]);
    let noted = |keyframe, first| Violation::Probation { keyframe, first };
    expect(noted(K(6), Some(P(23))), |m| m.first_young[1] = P(23));
    expect(noted(K(6), Some(P(25))), |m| m.first_young[1] = P(25));
    expect(noted(K(7), Some(P(33))), |m| m.first_young[2] = P(33));
    expect(noted(K(7), None), |m| m.first_young.truncate(2));
    expect(noted(K(8), Some(P(32))), |m| m.first_young.push(P(32)));
}

#[test]
fn wrong_covisibility() {
    let counted = sound_map().keyframe(K(5)).unwrap().shared_points(K(6));
    assert!(counted > 1);
    let wrong = |stored| Violation::Covisibility { keyframe: K(5), other: K(6), stored, counted };
    let entry = |m: &Map| m.keyframe(K(5)).unwrap().covisible().iter().position(|e| e.0 == K(6)).unwrap();
    expect(wrong(counted - 1), |m| {
        let at = entry(m);
        m.keyframes.live_mut(K(5)).covisible[at].1 -= 1;
    });
    expect(wrong(0), |m| {
        let at = entry(m);
        m.keyframes.live_mut(K(5)).covisible.remove(at);
    });
    let extra = Violation::Covisibility { keyframe: K(0), other: K(7), stored: 1, counted: 0 };
    expect(extra, |m| m.keyframes.live_mut(K(0)).covisible.push((K(7), 1)));
    let entry_of = |keyframe, other| Violation::CovisibilityEntry { keyframe, other };
    expect(entry_of(K(0), K(7)), |m| m.keyframes.live_mut(K(0)).covisible.push((K(7), 0)));
    let last = sound_map().keyframe(K(5)).unwrap().covisible().last().unwrap().0;
    expect(entry_of(K(5), K(6)), |m| m.keyframes.live_mut(K(5)).covisible.reverse());
    assert_ne!(last, K(6));
    // In order and with the right sum, but listed twice.
    expect(entry_of(K(5), K(6)), |m| {
        let at = entry(m);
        let list = &mut m.keyframes.live_mut(K(5)).covisible;
        list[at].1 -= 1;
        list.push((K(6), 1));
        list.sort_unstable_by_key(|&(k, w)| (std::cmp::Reverse(w), k));
    });
}

#[test]
fn a_broken_tree() {
    let two = Violation::Roots { roots: vec![K(0)], parentless: vec![K(0), K(5)] };
    expect(two, |m| m.keyframes.live_mut(K(5)).parent = None);
    let none = Violation::Roots { roots: vec![K(0)], parentless: vec![] };
    expect(none, |m| m.keyframes.live_mut(K(0)).parent = Some(K(1)));
    let lost = Violation::Roots { roots: vec![], parentless: vec![K(0)] };
    expect(lost, |m| m.roots.clear());
    let one_more = Violation::Roots { roots: vec![K(0), K(5)], parentless: vec![K(0)] };
    expect(one_more, |m| m.roots.push(K(5)));
    let other_root = Violation::Roots { roots: vec![K(1)], parentless: vec![K(0)] };
    expect(other_root, |m| m.roots = vec![K(1)]);

    let parent = sound_map().keyframe(K(6)).unwrap().parent().unwrap();
    let silent = Violation::ParentChild { child: K(6), parent: Some(parent), other: parent, listed: false };
    expect(silent, |m| m.keyframes.live_mut(parent).children.retain(|c| *c != K(6)));
    let loud = Violation::ParentChild { child: K(6), parent: Some(parent), other: K(0), listed: true };
    expect(loud, |m| m.keyframes.live_mut(K(0)).children.push(K(6)));

    // 5 and 6 agree to be each other's parent: two-sided, and yet a cycle.
    let tie = |m: &mut Map| {
        for (child, new_parent) in [(K(5), K(6)), (K(6), K(5))] {
            let old = m.keyframe(child).unwrap().parent().unwrap();
            m.keyframes.live_mut(old).children.retain(|c| *c != child);
            m.keyframes.live_mut(child).parent = Some(new_parent);
            m.keyframes.live_mut(new_parent).children.push(child);
            m.keyframes.live_mut(new_parent).children.sort_unstable();
        }
    };
    expect(Violation::Cycle { keyframe: K(5) }, tie);
    expect(Violation::Cycle { keyframe: K(6) }, tie);
    let order = Violation::ListOrder { keyframe: K(0), entry: K(1) };
    expect(order, |m| m.keyframes.live_mut(K(0)).children.push(K(1)));
}

#[test]
fn loop_edges_of_one_side() {
    expect(Violation::LoopEdge { from: K(0), to: K(5) }, |m| m.keyframes.live_mut(K(5)).loop_edges.clear());
    expect(Violation::LoopEdge { from: K(1), to: K(1) }, |m| {
        m.keyframes.live_mut(K(1)).loop_edges.push(K(1))
    });
    let order = Violation::ListOrder { keyframe: K(5), entry: K(0) };
    expect(order, |m| m.keyframes.live_mut(K(5)).loop_edges.push(K(0)));
}

#[test]
fn what_is_kept_of_a_loop() {
    let broken = |break_it: fn(&mut ClosedLoop)| {
        expect(Violation::ClosedLoop { matched: K(0), keyframe: K(5) }, |m| {
            break_it(Arc::make_mut(&mut m.loops[0]));
        });
    };
    broken(|l| l.visit.push(K(0)));
    broken(|l| l.near.push(K(99)));
    broken(|l| l.before.truncate(5));
    broken(|l| l.before[1].1.translation.x = f64::NAN);
    broken(|l| l.before[1].2 = 0.0);
    broken(|l| l.next = K(99));
    broken(|l| l.revision = 99);
}

#[test]
fn bad_numbers() {
    let pose = |defect| Violation::Pose { keyframe: K(1), defect };
    expect(pose(PoseDefect::NotFinite), |m| {
        m.keyframes.live_mut(K(1)).cam_from_world.translation.y = f64::NAN
    });
    expect(pose(PoseDefect::NotRotation { deviation: 3.0 }), |m| {
        m.keyframes.live_mut(K(1)).cam_from_world.rotation =
            SO3::from_matrix_unchecked(Mat3::identity() * 2.0);
    });
    let scale = |scale| Violation::Scale { keyframe: K(1), scale };
    expect(scale(0.0), |m| m.keyframes.live_mut(K(1)).scale = 0.0);
    expect(scale(f64::INFINITY), |m| m.keyframes.live_mut(K(1)).scale = f64::INFINITY);
    let numbers = Violation::PointNumbers { point: P(1) };
    expect(numbers.clone(), |m| m.points.live_mut(P(1)).position.x = f64::NAN);
    expect(numbers.clone(), |m| m.points.live_mut(P(1)).normal.x = f64::NAN);
    expect(numbers.clone(), |m| m.points.live_mut(P(1)).min_distance_m = f64::INFINITY);
    expect(numbers, |m| m.points.live_mut(P(1)).max_distance_m = f64::NAN);
}

#[test]
fn stale_derived_data() {
    expect(Violation::StaleDescriptor { point: P(1) }, |m| m.points.live_mut(P(1)).descriptor.0[0] ^= 1);
    let stale = Violation::StaleGeometry { point: P(1) };
    expect(stale.clone(), |m| m.points.live_mut(P(1)).position += Vec3::x());
    expect(stale.clone(), |m| m.points.live_mut(P(1)).max_distance_m *= 1.5);
    expect(stale, |m| m.keyframes.live_mut(K(0)).cam_from_world.translation += Vec3::x());
}

#[test]
fn messages_name_ids_and_numbers() {
    let covisibility = Violation::Covisibility { keyframe: K(1), other: K(2), stored: 3, counted: 4 };
    assert_eq!(covisibility.to_string(), "keyframes K1 and K2 share 4 points, stored are 3");
    let loud = Violation::ParentChild { child: K(6), parent: None, other: K(0), listed: true };
    assert_eq!(loud.to_string(), "keyframe K6 has parent None, but keyframe K0 lists it as a child");
}
