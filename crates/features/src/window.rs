//! Search of a predicted map point among the features of a window.

use crate::descriptor::Descriptor;
use crate::frame::Frame;
use rayon::prelude::*;
use simd::{Simd, Task};

/// Where and how a map point should appear in a frame.
#[derive(Clone, Copy, Debug)]
pub struct ProjectionQuery {
    /// Predicted column, undistorted pixels of level 0.
    pub x: f32,
    /// Predicted row.
    pub y: f32,
    /// Predicted column in the right image; NaN: not checked.
    pub right_u: f32,
    /// Half side of the square window, pixels of level 0.
    pub radius_px: f32,
    /// Finest octave allowed.
    pub min_octave: u8,
    /// Coarsest octave allowed.
    pub max_octave: u8,
    /// Appearance.
    pub descriptor: Descriptor,
}

/// A feature found by a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// Index in its frame.
    pub feature: u32,
    /// Hamming distance to the query, 0 to 256.
    pub distance: u32,
    /// Octave of the feature.
    pub octave: u8,
}

/// The two features nearest to the query in appearance; of equals the one with the lower index comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WindowMatch {
    /// The nearest.
    pub best: Candidate,
    /// The second nearest, for a ratio test.
    pub second: Option<Candidate>,
}

/// Finds the features nearest in appearance among those that are free, in the window and in the octaves, and whose right
/// column, where both are known, differs by at most the radius.
pub fn search_window(
    frame: &Frame,
    query: &ProjectionQuery,
    is_free: impl Fn(usize) -> bool,
) -> Option<WindowMatch> {
    Simd::detect().run(WindowSearch { frame, query, is_free })
}

/// [`search_window`] for many queries against the features marked as free; runs on the current rayon pool, results in
/// the order of the queries. Two queries may find the same feature.
///
/// # Panics
/// When `free` is shorter than the frame.
pub fn search_windows(frame: &Frame, queries: &[ProjectionQuery], free: &[bool]) -> Vec<Option<WindowMatch>> {
    assert!(free.len() >= frame.len(), "one flag per feature");
    queries.par_iter().with_min_len(64).map(|query| search_window(frame, query, |i| free[i])).collect()
}

struct WindowSearch<'a, F> {
    frame: &'a Frame,
    query: &'a ProjectionQuery,
    is_free: F,
}

impl<F: Fn(usize) -> bool> Task for WindowSearch<'_, F> {
    type Output = Option<WindowMatch>;

    #[inline(always)]
    fn run(self) -> Option<WindowMatch> {
        let Self { frame, query, is_free } = self;
        let ProjectionQuery { x, y, right_u, radius_px: radius, .. } = *query;
        let mut nearest = Nearest::default();
        for row in frame.grid().window(x - radius, x + radius, y - radius, y + radius) {
            for entry in row {
                let near = (entry.x - x).abs() <= radius && (entry.y - y).abs() <= radius;
                let octave_fits = entry.octave >= query.min_octave && entry.octave <= query.max_octave;
                // False also where one of them is unknown.
                let right_differs = (entry.right_u - right_u).abs() > radius;
                if near && octave_fits && !right_differs && is_free(entry.feature as usize) {
                    let distance = frame.descriptors[entry.feature as usize].distance(&query.descriptor);
                    nearest.offer(Candidate { feature: entry.feature, distance, octave: entry.octave });
                }
            }
        }
        nearest.finish()
    }
}

/// Keeps the two best candidates, whatever the order in which they come.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Nearest {
    best: Option<Candidate>,
    second: Option<Candidate>,
}

impl Nearest {
    #[inline(always)]
    pub(crate) fn offer(&mut self, candidate: Candidate) {
        let beats = |held: Option<Candidate>| {
            held.is_none_or(|h| (candidate.distance, candidate.feature) < (h.distance, h.feature))
        };
        if beats(self.best) {
            self.second = self.best.replace(candidate);
        } else if beats(self.second) {
            self.second = Some(candidate);
        }
    }

    pub(crate) fn finish(self) -> Option<WindowMatch> {
        self.best.map(|best| WindowMatch { best, second: self.second })
    }
}
