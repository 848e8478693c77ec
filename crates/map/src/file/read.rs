//! Records to a map: the facts are put in place, what follows from them is computed, and `check` judges the whole.
//!
//! The records are not trusted: what does not fit is skipped, and `check` names it.

use std::sync::Arc;

use features::Descriptor;
use geometry::{Mat3, SE3, SO3, Vec3};

use super::MapFileError;
use super::content::{
    Content, KeyframeRecord, KeyframeSlot, LoopRecord, PointRecord, PointSlot, ScalesRecord,
};
use super::frames::{Shared, finite};
use crate::map::RemovedKeyframe;
use crate::{ClosedLoop, Keyframe, KeyframeId, MAX_BELIEF, Map, MapPoint, Observation, PointId};

/// The map of unpacked content.
pub(super) fn map_of(content: &[u8]) -> Result<Map, MapFileError> {
    let (content, rest) = postcard::take_from_bytes::<Content<'_>>(content)
        .map_err(|e| MapFileError::malformed(format!("records: {e}")))?;
    if !rest.is_empty() {
        return Err(MapFileError::malformed(format!("{} bytes behind the records", rest.len())));
    }
    if content.keyframes.len().max(content.points.len()) > u32::MAX as usize {
        return Err(MapFileError::malformed("more ids than 2^32"));
    }
    let mut map = Map::new();
    map.revision = content.revision;
    map.first_young = content.first_young.iter().map(|&p| PointId(p)).collect();
    place_keyframes(&mut map, &content)?;
    place_points(&mut map, content.points);
    map.loops = content.loops.iter().map(|record| Arc::new(closed_loop(record))).collect();
    map.hang_children();
    map.fill_tables();
    map.derive_points();
    map.check().map_err(inconsistent)?;
    Ok(map)
}

fn inconsistent(violations: Vec<crate::Violation>) -> MapFileError {
    let n_more = violations.len().saturating_sub(1);
    match violations.into_iter().next() {
        Some(first) => MapFileError::Inconsistent { violation: Box::new(first), n_more },
        None => MapFileError::malformed("a broken map without a reason"),
    }
}

fn place_keyframes(map: &mut Map, content: &Content<'_>) -> Result<(), MapFileError> {
    let rigs = content.rigs.iter().map(finite).collect::<Result<_, _>>();
    let scales = content.scales.iter().map(ScalesRecord::scales).collect::<Result<_, _>>();
    let shared = Shared {
        rigs: rigs.map_err(MapFileError::malformed)?,
        scales: scales.map_err(MapFileError::malformed)?,
    };
    for slot in &content.keyframes {
        match slot {
            KeyframeSlot::Living(record) => {
                let id = map.next_keyframe_id();
                let keyframe = keyframe(id, record, &shared)
                    .map_err(|reason| MapFileError::malformed(format!("keyframe {id} has {reason}")))?;
                map.keyframes.push(keyframe);
            }
            KeyframeSlot::Removed(replaced_by) => {
                map.keyframes.push_gone(replaced_by.as_ref().map(|r| RemovedKeyframe {
                    parent: KeyframeId(r.parent),
                    removed_from_parent: pose(&r.removed_from_parent),
                    scale: r.scale,
                }));
            }
        }
    }
    Ok(())
}

fn keyframe(id: KeyframeId, record: &KeyframeRecord<'_>, shared: &Shared) -> Result<Keyframe, String> {
    let frame = Arc::new(shared.frame(&record.frame)?);
    let mut keyframe = Keyframe::new(id, frame, pose(&record.cam_from_world), record.inserted_at);
    keyframe.scale = record.scale;
    keyframe.parent = record.parent.map(KeyframeId);
    keyframe.loop_edges = record.loop_edges.iter().map(|&k| KeyframeId(k)).collect();
    Ok(keyframe)
}

fn closed_loop(record: &LoopRecord) -> ClosedLoop {
    let ids = |list: &[u32]| list.iter().map(|&k| KeyframeId(k)).collect();
    let before = record.before.iter().map(|(id, rows, scale)| (KeyframeId(*id), pose(rows), *scale));
    ClosedLoop {
        matched: KeyframeId(record.matched),
        keyframe: KeyframeId(record.keyframe),
        revision: record.revision,
        next: KeyframeId(record.next),
        visit: ids(&record.visit),
        near: ids(&record.near),
        before: before.collect(),
    }
}

/// `[R t]` row by row, taken to the bit: whether it is a rotation is for `check` to say.
fn pose(rows: &[f64; 12]) -> SE3 {
    let r = Mat3::from_fn(|row, column| rows[4 * row + column]);
    SE3::new(SO3::from_matrix_unchecked(r), Vec3::from_fn(|row, _| rows[4 * row + 3]))
}

fn place_points(map: &mut Map, slots: Vec<PointSlot>) {
    for slot in slots {
        match slot {
            PointSlot::Living(record) => {
                let point = point(map.next_point_id(), &record);
                map.points.push(point);
            }
            PointSlot::Merged(keep) => map.points.push_gone(Some(PointId(keep))),
            PointSlot::Removed => map.points.push_gone(None),
        }
    }
}

/// A point whose descriptor and viewing geometry are still to be computed.
fn point(id: PointId, record: &PointRecord) -> MapPoint {
    let observation = |&(keyframe, feature)| Observation { keyframe: KeyframeId(keyframe), feature };
    MapPoint {
        id,
        position: Vec3::from(record.position),
        descriptor: Descriptor::default(),
        normal: Vec3::zeros(),
        min_distance_m: 0.0,
        max_distance_m: 0.0,
        reference: KeyframeId(record.reference),
        created_by: KeyframeId(record.created_by),
        seen: record.seen,
        found: record.found,
        belief: record.belief.clamp(-MAX_BELIEF, MAX_BELIEF),
        observations: record.observations.iter().map(observation).collect(),
    }
}

impl Map {
    /// Children and roots follow from the parents.
    fn hang_children(&mut self) {
        let parents: Vec<(KeyframeId, Option<KeyframeId>)> =
            self.keyframes().map(|k| (k.id, k.parent)).collect();
        for (id, parent) in parents {
            match parent {
                Some(parent) if self.keyframe(parent).is_some() => {
                    self.keyframes.live_mut(parent).children.push(id);
                }
                Some(_) => {}
                None => self.roots.push(id),
            }
        }
    }

    /// Tables of keyframes and covisibility follow from the observations of the points.
    fn fill_tables(&mut self) {
        let observed: Vec<(PointId, Observation)> =
            self.points().flat_map(|p| p.observations.iter().map(|&o| (p.id, o))).collect();
        for (point, o) in observed {
            let feature = self.keyframe(o.keyframe).and_then(|k| k.points.get(o.feature as usize));
            if feature.is_some_and(Option::is_none) {
                self.keyframes.live_mut(o.keyframe).set_point(o.feature, Some(point));
            }
        }
        let ids: Vec<KeyframeId> = self.keyframes().map(|k| k.id).collect();
        for id in ids {
            let counts = self.count_shared(self.keyframes.live(id));
            let shared = (0_u32..).map(KeyframeId).zip(counts).filter(|&(_, count)| count > 0);
            let mut covisible: Vec<(KeyframeId, u32)> = shared.collect();
            covisible.sort_unstable_by_key(|&(other, count)| (std::cmp::Reverse(count), other));
            self.keyframes.live_mut(id).covisible = covisible;
        }
    }

    /// Descriptors and viewing geometry follow from observations that exist.
    fn derive_points(&mut self) {
        let exists =
            |o: &Observation| self.keyframe(o.keyframe).is_some_and(|k| (o.feature as usize) < k.frame.len());
        let is_sound =
            |p: &&MapPoint| p.feature_in(p.reference).is_some() && p.observations.iter().all(exists);
        let sound: Vec<PointId> = self.points().filter(is_sound).map(|p| p.id).collect();
        sound.into_iter().for_each(|p| self.refresh_point(p));
    }
}
