//! Search of an unmatched feature of one frame along its epipolar line in another, for triangulation.

use crate::frame::Frame;
use crate::grid::{Entry, Grid};
use crate::window::{Candidate, Nearest, WindowMatch};
use geometry::{SE3, Vec2};
use rayon::prelude::*;
use simd::{Simd, Task};

/// Chi-square, 1 degree of freedom, 95 %: squared distance to the epipolar line in units of the feature's variance.
const CHI2_LINE: f32 = 3.84;

/// Which candidates count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EpipolarRange {
    /// Nearest depth of the point in frame A, meters, above zero.
    pub min_depth_m: f64,
    /// Farthest depth in frame A; infinity is allowed.
    pub max_depth_m: f64,
    /// Largest Hamming distance of the best candidate.
    pub max_distance: u32,
}

/// The features of `b` nearest in appearance to feature `feature` of `a` among those that are free, within one octave, and
/// no farther from the epipolar segment between the two depths than `sqrt(3.84)` sigma of their octave; `None` when the best
/// is too far in appearance. `b_from_a` maps camera coordinates of `a` to those of `b`.
pub fn search_epipolar(
    a: &Frame,
    feature: usize,
    b: &Frame,
    b_from_a: &SE3,
    range: &EpipolarRange,
    is_free: impl Fn(usize) -> bool,
) -> Option<WindowMatch> {
    let segment = Segment::new(a, feature, b, b_from_a, range)?;
    let found = Simd::detect().run(LineSearch { a, feature, b, segment, is_free })?;
    (found.best.distance <= range.max_distance).then_some(found)
}

/// [`search_epipolar`] for many features of `a` against those of `b` marked as free; runs on the current rayon pool, results
/// in the order of `features`. Two features may find the same one.
///
/// # Panics
/// When `free` is shorter than frame `b`.
pub fn search_epipolar_all(
    a: &Frame,
    features: &[u32],
    b: &Frame,
    b_from_a: &SE3,
    range: &EpipolarRange,
    free: &[bool],
) -> Vec<Option<WindowMatch>> {
    assert!(free.len() >= b.len(), "one flag per feature");
    let search = |&feature: &u32| search_epipolar(a, feature as usize, b, b_from_a, range, |i| free[i]);
    features.par_iter().with_min_len(64).map(search).collect()
}

/// A piece of an epipolar line: `start + t * direction`, `0 <= t <= length`, pixels of level 0.
#[derive(Clone, Copy, Debug)]
struct Segment {
    start: [f32; 2],
    direction: [f32; 2],
    length: f32,
}

impl Segment {
    /// The images in `b` of the viewing ray of a feature of `a` between two depths; `None` when it lies behind `b`.
    fn new(a: &Frame, feature: usize, b: &Frame, b_from_a: &SE3, range: &EpipolarRange) -> Option<Self> {
        /// Nearest depth in front of camera `b` that is projected, meters.
        const NEAR: f64 = 0.01;
        let direction = b_from_a.rotation * a.rig.stereo.camera.unproject(&a.pixel(feature));
        let origin = b_from_a.translation;
        let (mut near, mut far) = (range.min_depth_m.max(0.0), range.max_depth_m);
        // z in b is origin.z + depth * direction.z: keep the depths for which it is at least NEAR.
        let crossing = (NEAR - origin.z) / direction.z;
        if direction.z > 0.0 {
            near = near.max(crossing);
        } else if direction.z < 0.0 {
            far = far.min(crossing);
        } else if origin.z < NEAR {
            return None;
        }
        if near > far {
            return None;
        }
        let camera = &b.rig.stereo.camera;
        let image = |depth: f64| -> Vec2 {
            if depth.is_finite() {
                camera.project(&(origin + direction * depth))
            } else {
                camera.project(&direction)
            }
        };
        let (start, end) = (image(near), image(far));
        let length = (end - start).norm();
        let direction = if length > 1e-9 { (end - start) / length } else { Vec2::new(1.0, 0.0) };
        let narrow = |v: Vec2| [v.x as f32, v.y as f32];
        let segment = Self { start: narrow(start), direction: narrow(direction), length: length as f32 };
        (start + end).iter().all(|c| c.is_finite()).then_some(segment)
    }

    /// Entries of the cells within `margin` pixels of the segment: for each row of cells that it crosses those columns.
    #[inline(always)]
    fn cells<'g>(&self, grid: &'g Grid, margin: f32) -> impl Iterator<Item = &'g [Entry]> {
        let Self { start, direction, length } = *self;
        // Cell borders are rounded.
        let margin = margin + 0.01;
        let end_y = start[1] + length * direction[1];
        grid.rows(start[1].min(end_y) - margin, start[1].max(end_y) + margin).map(move |row| {
            let (top, bottom) = grid.row_span(row);
            let place = |y: f32| ((y - start[1]) / direction[1]).clamp(0.0, length);
            let (t0, t1) = if direction[1].abs() * length > 1e-3 {
                let ends = (place(top - margin), place(bottom + margin));
                (ends.0.min(ends.1), ends.0.max(ends.1))
            } else {
                (0.0, length)
            };
            let (x0, x1) = (start[0] + t0 * direction[0], start[0] + t1 * direction[0]);
            grid.row_entries(row, x0.min(x1) - margin, x0.max(x1) + margin)
        })
    }

    /// Squared distance of a point to the segment.
    #[inline(always)]
    fn distance_sq(&self, x: f32, y: f32) -> f32 {
        let (dx, dy) = (x - self.start[0], y - self.start[1]);
        let along = dx * self.direction[0] + dy * self.direction[1];
        let across = dx * self.direction[1] - dy * self.direction[0];
        let beyond = (along - along.clamp(0.0, self.length)).abs();
        across * across + beyond * beyond
    }
}

struct LineSearch<'a, F> {
    a: &'a Frame,
    feature: usize,
    b: &'a Frame,
    segment: Segment,
    is_free: F,
}

impl<F: Fn(usize) -> bool> Task for LineSearch<'_, F> {
    type Output = Option<WindowMatch>;

    #[inline(always)]
    fn run(self) -> Option<WindowMatch> {
        let Self { a, feature, b, segment, is_free } = self;
        let descriptor = &a.descriptors[feature];
        let octave = a.keypoints[feature].octave;
        let (min_octave, max_octave) = (octave.saturating_sub(1), octave + 1);
        let limit_sq = |octave: u8| CHI2_LINE * b.scales.sigma_sq[usize::from(octave)];
        let coarsest = usize::from(max_octave).min(b.scales.len().saturating_sub(1));
        let margin = limit_sq(coarsest as u8).sqrt();
        let mut nearest = Nearest::default();
        for entry in segment.cells(b.grid(), margin).flatten() {
            let octave_fits = entry.octave >= min_octave && entry.octave <= max_octave;
            if octave_fits
                && segment.distance_sq(entry.x, entry.y) < limit_sq(entry.octave)
                && is_free(entry.feature as usize)
            {
                let distance = b.descriptors[entry.feature as usize].distance(descriptor);
                nearest.offer(Candidate { feature: entry.feature, distance, octave: entry.octave });
            }
        }
        nearest.finish()
    }
}
