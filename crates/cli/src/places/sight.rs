//! What one selection remembers of an image, how it finds a similar one and how it matches two.

use std::sync::Arc;

use anyhow::{Result, anyhow};
use bow::{
    BowVector, DirectIndex, Familiarity, MatchOptions, MatchSide, PlaceIndex, PlaceMatch, match_by_node,
};
use features::{Descriptor, Keypoint};
use geometry::Vec2;

use super::xfeat::{DENSE_CHANNELS, DenseDescriptor};

/// Smallest cosine of two dense descriptors that match (XFeat's own value).
const MIN_COSINE: f32 = 0.82;
/// Frames before and after one from which the camera may have come to it since the image before.
const STEPS: u32 = 2;
/// Frames whose geometry is looked at: the most familiar ones, and those that look most alike.
const MOST_FAMILIAR: usize = 10;
const MOST_ALIKE: usize = 5;

/// The features of an image that a selection keeps.
#[derive(Clone, Debug)]
pub(super) struct Sight {
    /// Places, pixels.
    pub(super) pixels: Vec<Vec2>,
    /// Weight of each in RANSAC.
    pub(super) trust: Vec<f64>,
    pub(super) look: Look,
}

/// What they look like.
#[derive(Clone, Debug)]
pub(super) enum Look {
    /// ORB and its words.
    Sparse {
        keypoints: Vec<Keypoint>,
        descriptors: Vec<Descriptor>,
        bow: Arc<BowVector>,
        direct: DirectIndex,
    },
    /// Learned descriptors, and their mean over the image, weighted by the activation.
    Dense { descriptors: Vec<DenseDescriptor>, mean: Box<DenseDescriptor> },
}

/// Earlier images of one selection.
#[derive(Debug, Default)]
pub(super) struct Memory {
    words: PlaceIndex,
    means: Vec<(u32, DenseDescriptor)>,
    familiarity: Familiarity,
}

impl Memory {
    /// Remembers the image of a frame.
    ///
    /// # Errors
    /// A frame that is there already.
    pub(super) fn add(&mut self, frame: usize, sight: &Sight) -> Result<()> {
        match &sight.look {
            Look::Sparse { bow, .. } => {
                self.words.add(frame as u32, bow.clone()).map_err(|_| anyhow!("frame {frame} came twice"))?;
            }
            Look::Dense { mean, .. } => self.means.push((frame as u32, **mean)),
        }
        Ok(())
    }

    /// The frames that may show the place of the next image: those that are most familiar after it, then those that look most
    /// like it; with `single` the one that looks most like it alone. Of equals the earliest comes first.
    pub(super) fn candidates(&mut self, sight: &Sight, single: bool) -> Vec<usize> {
        let found = self.alike(sight);
        let mut candidates: Vec<u32> = Vec::new();
        let n_alike = if single { 1 } else { MOST_ALIKE };
        if !single {
            let beside = |frame: u32| frame.saturating_sub(STEPS)..=frame + STEPS;
            let familiar = self.familiarity.advance(&found, beside);
            candidates.extend(familiar.iter().take(MOST_FAMILIAR).map(|place| place.keyframe));
        }
        for place in found.iter().take(n_alike) {
            if !candidates.contains(&place.keyframe) {
                candidates.push(place.keyframe);
            }
        }
        candidates.into_iter().map(|frame| frame as usize).collect()
    }

    /// Earlier frames with how much they look like an image, best first, of equals the earliest.
    fn alike(&self, sight: &Sight) -> Vec<PlaceMatch> {
        match &sight.look {
            Look::Sparse { bow, .. } => self.words.query(bow, |_| false),
            Look::Dense { mean, .. } => {
                let distance = |other: &DenseDescriptor| -> f64 {
                    (0..DENSE_CHANNELS).map(|i| f64::from(mean[i] - other[i]).powi(2)).sum()
                };
                let distances: Vec<(u32, f64)> =
                    self.means.iter().map(|(frame, other)| (*frame, distance(other))).collect();
                // From 0 for the least similar to 1 for an equal one, so that differences count in sums.
                let farthest = distances.iter().fold(f64::MIN_POSITIVE, |most, d| most.max(d.1));
                let place = |&(keyframe, distance): &(u32, f64)| PlaceMatch {
                    keyframe,
                    shared_words: 0,
                    score: 1.0 - distance / farthest,
                };
                let mut found: Vec<PlaceMatch> = distances.iter().map(place).collect();
                found.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.keyframe.cmp(&b.keyframe)));
                found
            }
        }
    }
}

impl Sight {
    /// Pairs of features that look alike, one to one.
    pub(super) fn matches(&self, other: &Sight) -> Vec<(usize, usize)> {
        match (&self.look, &other.look) {
            (Look::Sparse { .. }, Look::Sparse { .. }) => {
                let (Some(a), Some(b)) = (self.side(), other.side()) else { return Vec::new() };
                let matches = match_by_node(&a, &b, &MatchOptions::default());
                matches.into_iter().map(|m| (m.a as usize, m.b as usize)).collect()
            }
            (Look::Dense { descriptors: a, .. }, Look::Dense { descriptors: b, .. }) => mutual(a, b),
            _ => Vec::new(),
        }
    }

    fn side(&self) -> Option<MatchSide<'_>> {
        let Look::Sparse { keypoints, descriptors, direct, .. } = &self.look else { return None };
        Some(MatchSide { descriptors, direct, keypoints: Some(keypoints), eligible: None })
    }
}

/// Descriptors that are each other's most similar, of equals the first.
fn mutual(a: &[DenseDescriptor], b: &[DenseDescriptor]) -> Vec<(usize, usize)> {
    let forth = most_similar_of_each(a, b);
    let back = most_similar_of_each(b, a);
    let is_mutual = |&(i, found): &(usize, Option<(usize, f32)>)| {
        found.is_some_and(|(j, cosine)| cosine >= MIN_COSINE && back[j].is_some_and(|(k, _)| k == i))
    };
    let pairs = forth.into_iter().enumerate().filter(is_mutual);
    pairs.filter_map(|(i, found)| Some((i, found?.0))).collect()
}

/// For each of `a` the index of the most similar of `b`, with the cosine.
fn most_similar_of_each(a: &[DenseDescriptor], b: &[DenseDescriptor]) -> Vec<Option<(usize, f32)>> {
    let cosine =
        |x: &DenseDescriptor, y: &DenseDescriptor| -> f32 { x.iter().zip(y).map(|(p, q)| p * q).sum() };
    a.iter()
        .map(|x| {
            let mut best: Option<(usize, f32)> = None;
            for (j, y) in b.iter().enumerate() {
                let value = cosine(x, y);
                if best.is_none_or(|(_, highest)| value > highest) {
                    best = Some((j, value));
                }
            }
            best
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(axis: usize, tilt: f32) -> DenseDescriptor {
        let mut descriptor = [0.0; DENSE_CHANNELS];
        descriptor[axis] = (1.0 - tilt * tilt).sqrt();
        descriptor[axis + 1] = tilt;
        descriptor
    }

    /// A sight whose mean points along an axis, tilted towards the next one.
    fn look(axis: usize, tilt: f32) -> Sight {
        let look = Look::Dense { descriptors: Vec::new(), mean: Box::new(unit(axis, tilt)) };
        Sight { pixels: Vec::new(), trust: Vec::new(), look }
    }

    #[test]
    fn the_way_to_a_place_makes_it_a_candidate_before_what_looks_more_alike() {
        let mut memory = Memory::default();
        // A way of 40 different looks; frame 30 looks like what will be the last query, 33 nearly so.
        for frame in 0..40 {
            memory.add(frame, &look(frame, 0.0)).unwrap();
        }
        assert_eq!(memory.candidates(&look(3, 0.0), true), [3]);
        for frame in 3..8 {
            memory.candidates(&look(frame, 0.1), false);
        }
        let candidates = memory.candidates(&look(30, 0.1), false);
        assert_eq!(memory.candidates(&look(30, 0.1), true), [30]);
        assert!(candidates.len() > MOST_FAMILIAR && candidates.contains(&30), "{candidates:?}");
        assert!(candidates[0].abs_diff(7) <= STEPS as usize + 1, "{candidates:?}");
        let mut once = candidates.clone();
        once.sort_unstable();
        once.dedup();
        assert_eq!(once.len(), candidates.len());
    }

    #[test]
    fn dense_descriptors_match_each_others_nearest_above_the_limit() {
        let a = [unit(0, 0.0), unit(10, 0.0), unit(20, 0.0), unit(0, 0.3)];
        let b = [unit(20, 0.1), unit(0, 0.05), unit(40, 0.0), unit(10, 0.9)];
        // The fourth of `a` wants the second of `b`, which is nearer to the first; the second of `a` finds nothing alike.
        assert_eq!(mutual(&a, &b), [(0, 1), (2, 0)]);
    }
}
