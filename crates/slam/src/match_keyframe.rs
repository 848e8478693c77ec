//! A frame's features matched with the points of a keyframe by their looks alone.

use bow::{DirectIndex, MatchOptions, MatchSide, match_by_node};
use features::{Descriptor, Frame, match_brute_force};
use map::{Keyframe, PointId};

use crate::keyframe_database::KeyframeDatabase;
use crate::search::consistent_in_rotation;

/// Mutual best matches `(feature, point)` of the frame with all points of the keyframe, consistent in rotation, sorted by
/// feature; no vocabulary is needed.
pub(crate) fn match_all(frame: &Frame, keyframe: &Keyframe) -> Vec<(u32, PointId)> {
    let MatchOptions { max_distance, ratio } = MatchOptions::default();
    let shown = keyframe.points().iter().zip(0..).filter_map(|(point, feature)| Some((feature, (*point)?)));
    let shown: Vec<(usize, PointId)> = shown.collect();
    let descriptors: Vec<Descriptor> = shown.iter().map(|&(i, _)| keyframe.frame.descriptors[i]).collect();
    let pairs = match_brute_force(&descriptors, &frame.descriptors, max_distance, ratio);
    let pairs = pairs.into_iter().map(|(a, b)| (b, shown[a as usize])).collect();
    let kept = consistent_in_rotation(frame, pairs, |&(i, _)| keyframe.frame.keypoints[i].angle_deg);
    let mut matches: Vec<(u32, PointId)> = kept.into_iter().map(|(b, (_, point))| (b, point)).collect();
    matches.sort_unstable();
    matches
}

/// Matches `(feature of the frame, feature of the keyframe)` under common nodes of the vocabulary, consistent in rotation,
/// sorted by the frame's feature. Of the keyframe those features take part that show a point, of the frame all or the
/// `eligible` ones.
pub(crate) fn match_by_words(
    frame: &Frame,
    direct: &DirectIndex,
    eligible: Option<&[bool]>,
    keyframe: &Keyframe,
    places: &KeyframeDatabase,
) -> Vec<(u32, u32)> {
    let Some((_, keyframe_direct)) = places.of(keyframe.id) else { return Vec::new() };
    let with_point = with_point(keyframe);
    let (here, there) =
        (side(frame, direct, eligible), side(&keyframe.frame, keyframe_direct, Some(&with_point)));
    match_by_node(&here, &there, &MatchOptions::default()).into_iter().map(|m| (m.a, m.b)).collect()
}

/// Whether each feature of a keyframe shows a point.
pub(crate) fn with_point(keyframe: &Keyframe) -> Vec<bool> {
    keyframe.points().iter().map(Option::is_some).collect()
}

fn side<'a>(frame: &'a Frame, direct: &'a DirectIndex, eligible: Option<&'a [bool]>) -> MatchSide<'a> {
    MatchSide { descriptors: &frame.descriptors, direct, keypoints: Some(&frame.keypoints), eligible }
}

#[cfg(test)]
#[path = "../tests/steps/match_keyframe.rs"]
mod tests;
