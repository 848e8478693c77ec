//! Guided matching: features of two frames are compared only where the vocabulary leads both to the same node.

use crate::direct::DirectIndex;
use crate::kernels::distance;
use features::{Descriptor, Keypoint, consistent_rotations};
use simd::{Task, run_counting};

/// One of the two frames to match.
#[derive(Clone, Copy)]
pub struct MatchSide<'a> {
    /// Its descriptors.
    pub descriptors: &'a [Descriptor],
    /// Its direct index, at the same level of the same vocabulary as the other's.
    pub direct: &'a DirectIndex,
    /// Its keypoints, for the test of rotation; none to leave the test out.
    pub keypoints: Option<&'a [Keypoint]>,
    /// Whether each feature takes part; all do when absent.
    pub eligible: Option<&'a [bool]>,
}

/// What counts as a match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchOptions {
    /// Greatest distance in bits.
    pub max_distance: u32,
    /// The distance must be below this share of the second best one's.
    pub ratio: f32,
}

impl Default for MatchOptions {
    /// ORB-SLAM2's values for loops and relocalization.
    fn default() -> Self {
        Self { max_distance: 50, ratio: 0.75 }
    }
}

/// Two features that look alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeMatch {
    /// Feature of the first frame.
    pub a: u32,
    /// Feature of the second frame.
    pub b: u32,
    /// Distance of their descriptors in bits.
    pub distance: u32,
}

/// Matches of two frames, one to one, ascending features of `a`.
///
/// Each feature of `a` takes the nearest one of `b` under its node (the first of equals) if it passes distance and ratio;
/// a feature of `b` that several want goes to the nearest (the first of equals). With keypoints on both sides only the
/// matches whose rotation agrees with most remain.
pub fn match_by_node(a: &MatchSide<'_>, b: &MatchSide<'_>, options: &MatchOptions) -> Vec<NodeMatch> {
    let mut matches = run_counting(Nearest { a, b, options });
    matches.sort_unstable_by_key(|m| (m.b, m.distance, m.a));
    matches.dedup_by_key(|m| m.b);
    matches.sort_unstable_by_key(|m| m.a);
    if let (Some(a), Some(b)) = (a.keypoints, b.keypoints) {
        let turn = |m: &NodeMatch| a[m.a as usize].angle_deg - b[m.b as usize].angle_deg;
        let kept = consistent_rotations(&matches.iter().map(turn).collect::<Vec<_>>());
        let mut kept = kept.into_iter();
        matches.retain(|_| kept.next().unwrap_or(false));
    }
    matches
}

struct Nearest<'a> {
    a: &'a MatchSide<'a>,
    b: &'a MatchSide<'a>,
    options: &'a MatchOptions,
}

impl Task for Nearest<'_> {
    type Output = Vec<NodeMatch>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { a, b, options } = self;
        let takes_part = |side: &MatchSide<'_>, feature: u32| {
            side.eligible.is_none_or(|eligible| eligible[feature as usize])
        };
        let mut matches = Vec::new();
        let mut others = Vec::new();
        for (group_a, group_b) in a.direct.common(b.direct) {
            others.clear();
            others.extend(group_b.iter().copied().filter(|&feature| takes_part(b, feature)));
            for &feature in group_a.iter().filter(|&&feature| takes_part(a, feature)) {
                let descriptor = &a.descriptors[feature as usize].0;
                let (mut best, mut second, mut partner) = (u32::MAX, u32::MAX, 0);
                for &other in &others {
                    let distance = distance(descriptor, &b.descriptors[other as usize].0);
                    if distance < best {
                        (second, best, partner) = (best, distance, other);
                    } else {
                        second = second.min(distance);
                    }
                }
                if best <= options.max_distance && (best as f32) < options.ratio * second as f32 {
                    matches.push(NodeMatch { a: feature, b: partner, distance: best });
                }
            }
        }
        matches
    }
}
