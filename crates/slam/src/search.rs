//! Search by projection: where points should appear in a frame, and which features are found there.

use features::{Frame, ProjectionQuery, WindowMatch, consistent_rotations, search_windows};
use geometry::SE3;
use map::{KeyframeId, Map, PointId};

use crate::assign::one_to_one;
use crate::visibility::{Projection, Visible, visible_points};

/// Largest descriptor distance of a match by projection (of 256 bits).
pub(crate) const MAX_DISTANCE_WIDE: u32 = 100;

/// How far from its projection and how different in appearance a point may be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    /// Half width, pixels at octave 0.
    pub(crate) radius_px: f32,
    /// Largest descriptor distance, bits.
    pub(crate) max_distance: u32,
}

/// Matches found, and what could have been.
#[derive(Clone, Debug, Default)]
pub(crate) struct Found {
    /// Sorted by feature, one to one, those that were given included.
    pub(crate) matches: Vec<(u32, PointId)>,
    /// The other points that should be visible, in the order in which they were asked for.
    pub(crate) visible: Vec<PointId>,
}

/// Looks for each key where its query says; of all keys that want a feature the most similar one gets it. `accept`
/// judges each find alone. Matches `(feature, key)` are sorted by feature.
pub(crate) fn search<K: Copy>(
    frame: &Frame,
    asked: impl IntoIterator<Item = (K, ProjectionQuery)>,
    free: &[bool],
    accept: impl Fn(K, &WindowMatch) -> bool,
) -> Vec<(u32, K)> {
    let (keys, queries): (Vec<K>, Vec<ProjectionQuery>) = asked.into_iter().unzip();
    let finds = search_windows(frame, &queries, free);
    let pairs = one_to_one(&finds, frame.len(), |query, find| accept(keys[query], find));
    pairs.into_iter().map(|(feature, query)| (feature, keys[query])).collect()
}

/// Adds to the `given` matches of a frame those of other `points` that its pose makes visible.
pub(crate) fn search_points(
    frame: &Frame,
    map: &Map,
    cam_from_world: &SE3,
    points: &[PointId],
    given: &[(u32, PointId)],
    window: Window,
) -> Found {
    let accept = |find: &WindowMatch| find.best.distance <= window.max_distance;
    search_points_with(frame, map, cam_from_world, points, given, |_| window.radius_px, accept)
}

/// [`search_points`] with a window for each projection (pixels at octave 0) and any judgment of the finds.
pub(crate) fn search_points_with(
    frame: &Frame,
    map: &Map,
    cam_from_world: &SE3,
    points: &[PointId],
    given: &[(u32, PointId)],
    radius_px: impl Fn(&Projection) -> f32,
    accept: impl Fn(&WindowMatch) -> bool,
) -> Found {
    let mut free = vec![true; frame.len()];
    for &(feature, _) in given {
        free[feature as usize] = false;
    }
    let visible = visible_points(frame, map, cam_from_world, points, given.iter().map(|m| m.1));
    let asked = visible.iter().map(|seen| (seen.point.id, query(frame, seen, radius_px(&seen.projection))));
    let mut matches = search(frame, asked, &free, |_, find| accept(find));
    matches.extend_from_slice(given);
    matches.sort_unstable();
    Found { matches, visible: visible.iter().map(|seen| seen.point.id).collect() }
}

/// Asks for a visible point at the octave where it should appear and the next finer one.
pub(crate) fn query(frame: &Frame, seen: &Visible<'_>, radius_px: f32) -> ProjectionQuery {
    let Projection { u, v, right_u, octave, .. } = seen.projection;
    ProjectionQuery {
        x: u as f32,
        y: v as f32,
        right_u: right_u as f32,
        radius_px: radius_px * frame.scales.scales[usize::from(octave)],
        min_octave: octave.saturating_sub(1),
        max_octave: octave,
        descriptor: seen.point.descriptor,
    }
}

/// Keeps the matches whose features turned as most of them did; `angle_deg` is a key's angle where it was seen before.
pub(crate) fn consistent_in_rotation<K>(
    frame: &Frame,
    matches: Vec<(u32, K)>,
    angle_deg: impl Fn(&K) -> f32,
) -> Vec<(u32, K)> {
    let turn = |(feature, key): &(u32, K)| angle_deg(key) - frame.keypoints[*feature as usize].angle_deg;
    let kept = consistent_rotations(&matches.iter().map(turn).collect::<Vec<f32>>());
    matches.into_iter().zip(kept).filter(|(_, kept)| *kept).map(|(pair, _)| pair).collect()
}

/// Points of these keyframes, sorted, each once.
pub(crate) fn points_of(map: &Map, keyframes: impl IntoIterator<Item = KeyframeId>) -> Vec<PointId> {
    let keyframes = keyframes.into_iter().filter_map(|id| map.keyframe(id));
    let mut points: Vec<PointId> = keyframes.flat_map(|kf| kf.points().iter().flatten().copied()).collect();
    points.sort_unstable();
    points.dedup();
    points
}

/// Points of a keyframe and of its `n` best covisible ones, sorted, each once.
pub(crate) fn points_around(map: &Map, keyframe: KeyframeId, n: usize) -> Vec<PointId> {
    let Some(center) = map.keyframe(keyframe) else { return Vec::new() };
    points_of(map, std::iter::once(keyframe).chain(center.best_covisible(n).iter().map(|&(id, _)| id)))
}

#[cfg(test)]
#[path = "../tests/steps/search.rs"]
mod tests;
