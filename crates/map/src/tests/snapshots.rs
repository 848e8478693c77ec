//! Snapshots: cheap, unchanged by later mutations, shareable between threads.

use std::sync::Arc;

use super::world::*;
use crate::arena::Arena;
use crate::{Map, PointId};

#[test]
fn maps_can_be_sent_and_shared_between_threads() {
    fn need<T: Send + Sync + Clone + Default>() {}
    need::<Map>();
}

#[test]
fn a_mutation_copies_what_it_touches_and_nothing_else() {
    let map = row_of_keyframes(40);
    let mut changed = map.clone();
    changed.merge_points(PointId(150), PointId(151)).unwrap();
    let is_shared = |id| {
        let (a, b) = (map.point(PointId(id)).unwrap(), changed.point(PointId(id)).unwrap());
        std::ptr::eq(a, b)
    };
    let copied: Vec<u32> = (0..160).filter(|&id| id != 151 && !is_shared(id)).collect();
    assert_eq!(copied, [150]);
    let frames = map.keyframes().zip(changed.keyframes());
    assert!(frames.into_iter().all(|(a, b)| Arc::ptr_eq(&a.frame, &b.frame)));
    let tables = map.keyframes().zip(changed.keyframes());
    let copied: Vec<u32> =
        tables.filter(|(a, b)| !Arc::ptr_eq(&a.points, &b.points)).map(|t| t.0.id.0).collect();
    assert_eq!(copied, [37, 38, 39], "only tables of the observers");
}

#[test]
fn a_snapshot_keeps_its_content_while_the_original_changes() {
    let mut map = row_of_keyframes(6);
    let snapshot = map.clone();
    let before = snapshot.digest();
    let poses: Vec<_> =
        map.keyframes().map(|k| (k.id, random_pose(&mut generator(u64::from(k.id.0))))).collect();
    map.set_estimates(&poses, &[]).unwrap();
    map.remove_keyframe(crate::KeyframeId(3)).unwrap();
    add(&mut map, &[(0, 20)], &[]);
    assert_ne!(map.digest(), before);
    assert_eq!((snapshot.digest(), snapshot.check()), (before, Ok(())));
}

#[test]
fn the_digest_sees_every_field() {
    let map = row_of_keyframes(6);
    let differs = |change: &dyn Fn(&mut Map)| {
        let mut other = map.clone();
        change(&mut other);
        other.digest() != map.digest()
    };
    assert!(!differs(&|_| {}));
    let (k, p) = (crate::KeyframeId(2), PointId(9));
    assert!(differs(&|m| m.points.live_mut(p).seen += 1));
    assert!(differs(&|m| m.points.live_mut(p).found += 1));
    assert!(differs(&|m| m.points.live_mut(p).belief -= 1));
    assert!(differs(&|m| m.points.live_mut(p).position.z += 1e-12));
    assert!(differs(&|m| m.points.live_mut(p).normal.z *= -1.0));
    assert!(differs(&|m| m.points.live_mut(p).min_distance_m += 1e-12));
    assert!(differs(&|m| m.points.live_mut(p).max_distance_m += 1e-12));
    assert!(differs(&|m| m.points.live_mut(p).descriptor.0[3] ^= 1 << 63));
    assert!(differs(&|m| m.points.live_mut(p).reference.0 += 1));
    assert!(differs(&|m| m.points.live_mut(p).created_by.0 += 1));
    assert!(differs(&|m| m.points.live_mut(p).observations[0].feature += 1));
    assert!(differs(&|m| m.keyframes.live_mut(k).cam_from_world.translation.x += 1e-12));
    assert!(differs(&|m| m.keyframes.live_mut(k).set_point(39, Some(p))));
    assert!(differs(&|m| m.keyframes.live_mut(k).covisible[0].1 += 1));
    assert!(differs(&|m| m.keyframes.live_mut(k).parent = Some(k)));
    assert!(differs(&|m| m.keyframes.live_mut(k).children.push(k)));
    assert!(differs(&|m| m.keyframes.live_mut(k).loop_edges.push(k)));
    assert!(differs(&|m| m.keyframes.live_mut(k).frame = frame(77)));
    assert!(differs(&|m| m.keyframes.live_mut(k).scale = 2.0));
    assert!(differs(&|m| m.roots.push(k)));
    let in_frame = |change: &dyn Fn(&mut features::Frame)| {
        differs(&|m| change(Arc::make_mut(&mut m.keyframes.live_mut(k).frame)))
    };
    assert!(in_frame(&|f| f.timestamp_s += 1.0));
    assert!(in_frame(&|f| f.activation[3] = 0.5));
    assert!(in_frame(&|f| f.lasting[3] = 0.5));
    assert!(in_frame(&|f| Arc::make_mut(&mut f.rig).stereo.baseline_m += 0.1));
    assert!(in_frame(&|f| Arc::make_mut(&mut f.rig).distortion.k3 = 0.1));
    assert!(in_frame(&|f| Arc::make_mut(&mut f.rig).height += 1));
    assert!(in_frame(&|f| f.scales = Arc::new(features::ScaleLevels::new(8, 1.3))));
    assert!(in_frame(&|f| Arc::make_mut(&mut f.scales).inv_sigma_sq[1] = 0.1));
    assert!(differs(&|m| m.points.remove(p, None)));
    let forwarded = |to| {
        let mut other = map.clone();
        other.points.remove(p, Some(PointId(to)));
        other.digest()
    };
    assert_ne!(forwarded(1), forwarded(2));
    // Not the revision.
    let mut counted = map.clone();
    counted.count(&[]).unwrap();
    assert_eq!((counted.digest(), counted.revision()), (map.digest(), map.revision() + 1));
}

#[test]
fn an_arena_gives_ids_in_order_and_never_again() {
    let mut arena: Arena<PointId, u32, PointId> = Arena::default();
    for i in 0..200 {
        assert_eq!(arena.push(10 * i), PointId(i));
    }
    let snapshot = arena.clone();
    arena.remove(PointId(63), None);
    arena.remove(PointId(64), Some(PointId(5)));
    *arena.live_mut(PointId(65)) = 1;
    assert_eq!((arena.len(), arena.n_live(), arena.next_id()), (200, 198, PointId(200)));
    assert_eq!(
        (arena.get(PointId(63)), arena.get(PointId(65)), arena.get(PointId(200))),
        (None, Some(&1), None)
    );
    assert_eq!((arena.forward(PointId(64)), arena.forward(PointId(63))), (Some(&PointId(5)), None));
    let listed: Vec<PointId> = arena.iter().map(|(id, _)| id).collect();
    let expected: Vec<PointId> = (0..200).filter(|i| *i != 63 && *i != 64).map(PointId).collect();
    assert_eq!(listed, expected);
    assert!(snapshot.iter().enumerate().all(|(i, (_, v))| *v as usize == 10 * i));
    arena.remove(PointId(199), None);
    assert_eq!((arena.push(0), arena.iter().next_back().map(|i| i.0)), (PointId(200), Some(PointId(200))));
}
