//! Turns snapshots of the map into changes since the last record; what a viewer cannot show is omitted.

use map::{Keyframe, KeyframeId, Map, MapPoint};

use crate::Pose;
use crate::map_delta::{GoneKeyframe, KeyframeUpdate, MapDelta, PointUpdate};

/// What is worth telling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeltaOptions {
    /// A point has moved when it did so by more than this share of its distance from the camera that follows it.
    pub moved_share: f64,
    /// Shared points from which on two keyframes are shown as covisible.
    pub covisible_points: u32,
    /// Most covisible keyframes that are shown of one.
    pub covisible_shown: usize,
}

impl Default for DeltaOptions {
    fn default() -> Self {
        DeltaOptions { moved_share: 0.003, covisible_points: 30, covisible_shown: 4 }
    }
}

/// Remembers what was told of a map.
#[derive(Clone, Debug)]
pub struct DeltaTracker {
    options: DeltaOptions,
    last: Map,
    points: Vec<Option<PointUpdate>>,
    keyframes: Vec<Option<KeyframeUpdate>>,
    /// The frame that each keyframe was, also of those that are gone.
    frame_of: Vec<Option<u32>>,
}

impl DeltaTracker {
    /// One that has told nothing yet.
    pub fn new(options: DeltaOptions) -> Self {
        DeltaTracker {
            options,
            last: Map::new(),
            points: Vec::new(),
            keyframes: Vec::new(),
            frame_of: Vec::new(),
        }
    }

    /// What changed visibly since the last call; `frame` is the number of the newest frame. Costs as much as was written to.
    pub fn advance(&mut self, map: &Map, frame: u32) -> MapDelta {
        let last = std::mem::replace(&mut self.last, map.clone());
        let changes = map.changes_since(&last);
        let mut delta = self.empty(map, frame);
        self.note_keyframes(map, changes.keyframes.into_iter(), &mut delta);
        delta.gone_keyframes =
            changes.gone_keyframes.into_iter().filter_map(|id| self.gone_keyframe(map, id)).collect();
        self.note_points(map, changes.points.into_iter(), self.options.moved_share, &mut delta);
        delta.gone_points = changes.gone_points.into_iter().filter_map(|id| self.gone_point(id.0)).collect();
        delta
    }

    /// Everything that is other than it was told, however little: for the end of a run.
    pub fn finish(&mut self, map: &Map, frame: u32) -> MapDelta {
        let mut delta = self.advance(map, frame);
        let mut rest = self.empty(map, frame);
        self.note_keyframes(map, map.keyframes(), &mut rest);
        self.note_points(map, map.points(), 0.0, &mut rest);
        // A second update of the same thing replaces the first.
        delta.keyframes.retain(|k| rest.keyframes.binary_search_by_key(&k.id, |r| r.id).is_err());
        delta.points.retain(|p| rest.points.binary_search_by_key(&p.id, |r| r.id).is_err());
        delta.keyframes.extend(rest.keyframes);
        delta.points.extend(rest.points);
        delta.keyframes.sort_by_key(|k| k.id);
        delta.points.sort_by_key(|p| p.id);
        delta
    }

    fn empty(&self, map: &Map, frame: u32) -> MapDelta {
        MapDelta { frame, revision: map.revision(), ..MapDelta::default() }
    }

    fn note_keyframes<'m>(
        &mut self,
        map: &Map,
        changed: impl Iterator<Item = &'m Keyframe>,
        delta: &mut MapDelta,
    ) {
        for keyframe in changed {
            let update = self.shown_keyframe(map, keyframe);
            *slot(&mut self.frame_of, keyframe.id.0) = Some(update.frame);
            let told = slot(&mut self.keyframes, keyframe.id.0);
            if told.as_ref() != Some(&update) {
                *told = Some(update.clone());
                delta.keyframes.push(update);
            }
        }
    }

    fn note_points<'m>(
        &mut self,
        map: &Map,
        changed: impl Iterator<Item = &'m MapPoint>,
        moved_share: f64,
        delta: &mut MapDelta,
    ) {
        for point in changed {
            let update = self.shown_point(map, point);
            let told = slot(&mut self.points, point.id.0);
            if told.is_none_or(|told| is_other(&told, &update, tolerance_m(map, point, moved_share))) {
                *told = Some(update);
                delta.points.push(update);
            }
        }
    }

    fn shown_keyframe(&self, map: &Map, keyframe: &Keyframe) -> KeyframeUpdate {
        let is_older = |id: &KeyframeId| *id < keyframe.id;
        let covisible = keyframe.covisible_at_least(self.options.covisible_points).iter().map(|(id, _)| *id);
        let covisible = covisible.filter(is_older).take(self.options.covisible_shown);
        KeyframeUpdate {
            id: keyframe.id.0,
            frame: keyframe.frame.index,
            cam_from_world: Pose::from(&keyframe.cam_from_world),
            scale: map.scale_of(keyframe.id),
            submap: map.submap_of(keyframe.id).unwrap_or(keyframe.id).0,
            parent: keyframe.parent().map(|id| id.0),
            covisible: covisible.map(|id| id.0).collect(),
            loops: keyframe.loop_edges().iter().copied().filter(is_older).map(|id| id.0).collect(),
        }
    }

    fn shown_point(&self, map: &Map, point: &MapPoint) -> PointUpdate {
        let known = self.frame_of.get(point.created_by.0 as usize).copied().flatten();
        let heir = || map.resolve_keyframe(point.created_by).and_then(|(id, _)| map.keyframe(id));
        PointUpdate {
            id: point.id.0,
            position: [point.position.x as f32, point.position.y as f32, point.position.z as f32],
            born: known.or_else(|| Some(heir()?.frame.index)).unwrap_or(0),
            activation: quantized(point.trust()),
        }
    }

    fn gone_point(&mut self, id: u32) -> Option<u32> {
        slot(&mut self.points, id).take().map(|_| id)
    }

    fn gone_keyframe(&mut self, map: &Map, id: KeyframeId) -> Option<GoneKeyframe> {
        slot(&mut self.keyframes, id.0).take()?;
        let (heir, gone_from_heir) = map.resolve_keyframe(id)?;
        Some(GoneKeyframe {
            id: id.0,
            heir: heir.0,
            gone_from_heir: Pose::from(&gone_from_heir),
            scales: [map.scale_of(id), map.scale_of(heir)],
        })
    }
}

/// A share of 0 to 1 as 0 to 255.
fn quantized(share: f64) -> u8 {
    (share.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// How far a point may be from where it was told to be, meters.
fn tolerance_m(map: &Map, point: &MapPoint, moved_share: f64) -> f64 {
    let distance = map.keyframe(point.reference).map_or(0.0, |k| (point.position - k.center()).norm());
    moved_share * distance
}

fn is_other(told: &PointUpdate, new: &PointUpdate, tolerance_m: f64) -> bool {
    let moved_sq: f64 =
        told.position.iter().zip(&new.position).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
    moved_sq > tolerance_m * tolerance_m || told.activation.abs_diff(new.activation) > 12
}

/// The place of an id in a list that grows with the ids.
fn slot<T: Clone>(list: &mut Vec<Option<T>>, id: u32) -> &mut Option<T> {
    let index = id as usize;
    if list.len() <= index {
        list.resize(index + 1, None);
    }
    &mut list[index]
}
