//! What one selection remembers of an image, how it finds a similar one and how it matches two.

use std::sync::Arc;

use anyhow::{Result, anyhow};
use bow::{BowVector, DirectIndex, MatchOptions, MatchSide, PlaceIndex, match_by_node};
use features::{Descriptor, Keypoint};
use geometry::Vec2;

use super::xfeat::{DENSE_CHANNELS, DenseDescriptor};

/// Smallest cosine of two dense descriptors that match (XFeat's own value).
const MIN_COSINE: f32 = 0.82;

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
    /// Learned descriptors, and their mean over the image, weighted by the activation (the paper's equation 3).
    Dense { descriptors: Vec<DenseDescriptor>, mean: Box<DenseDescriptor> },
}

/// Earlier images of one selection.
#[derive(Debug, Default)]
pub(super) struct Memory {
    words: PlaceIndex,
    means: Vec<(usize, DenseDescriptor)>,
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
            Look::Dense { mean, .. } => self.means.push((frame, **mean)),
        }
        Ok(())
    }

    /// The frame that looks most like an image; of equals the earliest.
    pub(super) fn most_similar(&self, sight: &Sight) -> Option<usize> {
        match &sight.look {
            Look::Sparse { bow, .. } => {
                self.words.query(bow, |_| false).first().map(|found| found.keyframe as usize)
            }
            Look::Dense { mean, .. } => {
                let distance = |other: &DenseDescriptor| -> f32 {
                    (0..DENSE_CHANNELS).map(|i| (mean[i] - other[i]).powi(2)).sum()
                };
                let nearest = self.means.iter().min_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)));
                nearest.map(|&(frame, _)| frame)
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

    #[test]
    fn dense_descriptors_match_each_others_nearest_above_the_limit() {
        let a = [unit(0, 0.0), unit(10, 0.0), unit(20, 0.0), unit(0, 0.3)];
        let b = [unit(20, 0.1), unit(0, 0.05), unit(40, 0.0), unit(10, 0.9)];
        // The fourth of `a` wants the second of `b`, which is nearer to the first; the second of `a` finds nothing alike.
        assert_eq!(mutual(&a, &b), [(0, 1), (2, 0)]);
    }
}
