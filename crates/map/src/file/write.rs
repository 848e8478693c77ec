//! A map as records: the facts only, nothing that follows from them.

use super::content::{
    Content, KeyframeRecord, KeyframeSlot, LoopRecord, PointRecord, PointSlot, RemovedRecord, ScalesRecord,
};
use super::frames::Shared;
use crate::ids::Id;
use crate::map::RemovedKeyframe;
use crate::{ClosedLoop, Keyframe, KeyframeId, Map, MapPoint, PointId};

/// The records of a map as bytes.
pub(super) fn content_of(map: &Map) -> Vec<u8> {
    let mut shared = Shared::default();
    let ids = (0..map.keyframes.len()).map(KeyframeId::from_index);
    let keyframes = ids.map(|id| keyframe_slot(map, id, &mut shared)).collect();
    let content = Content {
        revision: map.revision,
        first_young: map.first_young.iter().map(|p| p.0).collect(),
        rigs: shared.rigs.iter().map(|rig| rig.as_ref().clone()).collect(),
        scales: shared.scales.iter().map(|scales| ScalesRecord::of(scales)).collect(),
        keyframes,
        points: (0..map.points.len()).map(|i| point_slot(map, PointId::from_index(i))).collect(),
        loops: map.loops.iter().map(|closed| loop_record(closed)).collect(),
    };
    postcard::to_stdvec(&content).expect("records of known length can be written to memory")
}

fn keyframe_slot<'a>(map: &Map, id: KeyframeId, shared: &mut Shared) -> KeyframeSlot<'a> {
    match map.keyframe(id) {
        Some(keyframe) => KeyframeSlot::Living(Box::new(keyframe_record(keyframe, shared))),
        None => KeyframeSlot::Removed(map.keyframes.forward(id).map(|r| Box::new(removed_record(r)))),
    }
}

fn keyframe_record<'a>(keyframe: &Keyframe, shared: &mut Shared) -> KeyframeRecord<'a> {
    KeyframeRecord {
        frame: shared.record(&keyframe.frame),
        cam_from_world: keyframe.cam_from_world.rows_3x4(),
        inserted_at: keyframe.inserted_at,
        scale: keyframe.scale,
        parent: keyframe.parent().map(|p| p.0),
        loop_edges: keyframe.loop_edges().iter().map(|k| k.0).collect(),
    }
}

fn removed_record(removed: &RemovedKeyframe) -> RemovedRecord {
    RemovedRecord {
        parent: removed.parent.0,
        removed_from_parent: removed.removed_from_parent.rows_3x4(),
        scale: removed.scale,
    }
}

fn point_slot(map: &Map, id: PointId) -> PointSlot {
    match (map.point(id), map.points.forward(id)) {
        (Some(point), _) => PointSlot::Living(Box::new(point_record(point))),
        (None, Some(keep)) => PointSlot::Merged(keep.0),
        (None, None) => PointSlot::Removed,
    }
}

fn point_record(point: &MapPoint) -> PointRecord {
    PointRecord {
        position: point.position.into(),
        reference: point.reference.0,
        created_by: point.created_by.0,
        seen: point.seen,
        found: point.found,
        belief: point.belief,
        observations: point.observations().iter().map(|o| (o.keyframe.0, o.feature)).collect(),
    }
}

fn loop_record(closed: &ClosedLoop) -> LoopRecord {
    let ids = |list: &[KeyframeId]| list.iter().map(|k| k.0).collect();
    let before = closed.before.iter().map(|(id, pose, scale)| (id.0, pose.rows_3x4(), *scale));
    LoopRecord {
        matched: closed.matched.0,
        keyframe: closed.keyframe.0,
        revision: closed.revision,
        next: closed.next.0,
        visit: ids(&closed.visit),
        near: ids(&closed.near),
        before: before.collect(),
    }
}
