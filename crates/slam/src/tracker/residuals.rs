//! How well a frame's points fit its pose, and where they are: the noise as it is measured.

use features::Frame;
use geometry::median;
use map::Map;

use super::local_map::LocallyTracked;
use crate::noise::{Noise, information};
use crate::quality::CELLS;

/// Median of the absolute values of a normal distribution of standard deviation 1.
const NORMAL_MEDIAN: f64 = 0.6745;
/// Least standard deviation, in units of the expected one: no feature is placed better.
const LEAST: f64 = 0.03;
/// Residuals of a cell of the image from which they have a mean of their own.
const MIN_IN_CELL: usize = 2;
/// Cells that are needed to compare them.
const MIN_CELLS: usize = 3;

/// Noise of the inliers of a frame. Variances are in units of the expected one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Residuals {
    /// Of columns and rows in the left image.
    pub(super) pixel_sq: f64,
    /// Of disparities. Both images place a corner off by the same, so that it is far smaller.
    pub(super) disparity_sq: f64,
    /// How much neighbors agree in their errors: variance of the means of parts of the image over what it would be if each point
    /// had its own error; at least 1. Errors in common do not average out.
    pub(super) in_common: f64,
    /// Parts of the image, of all [`CELLS`], that have a point.
    pub(super) cells: usize,
    /// Points nearer than the depth that counts as close.
    pub(super) near: usize,
    /// Median depth of the points, meters.
    pub(super) median_depth_m: f64,
}

/// Sums of the residuals in a part of the image.
#[derive(Clone, Copy, Default)]
struct Cell {
    n: usize,
    sum: [f64; 2],
    sum_sq: [f64; 2],
}

impl Residuals {
    /// Of the inliers of a frame; `None` without any.
    pub(super) fn of(
        frame: &Frame,
        map: &Map,
        local: &LocallyTracked,
        noise: Noise,
        close_depth_m: f64,
    ) -> Option<Self> {
        let (width, height) = (frame.rig.width as f64, frame.rig.height as f64);
        let (mut pixels, mut disparities, mut depths) = (Vec::new(), Vec::new(), Vec::new());
        let mut cells = [Cell::default(); CELLS[0] * CELLS[1]];
        for &(feature, id) in &local.matches {
            let Some(point) = map.point(id) else { continue };
            let i = feature as usize;
            let point_cam = local.cam_from_world * point.position;
            let uvr = frame.rig.stereo.project(&point_cam);
            let pixel = frame.pixel(i);
            let root = information(frame, i, noise).sqrt();
            let error = [(uvr.x - pixel.x) * root, (uvr.y - pixel.y) * root];
            pixels.extend(error.map(f64::abs));
            if frame.has_depth(i) {
                let right = (uvr.z - f64::from(frame.right_u[i])) * root;
                disparities.push((error[0] - right).abs());
            }
            depths.push(point_cam.z);
            let column = part(pixel.x / width, CELLS[0]);
            cells[column + CELLS[0] * part(pixel.y / height, CELLS[1])].add(error);
        }
        let near = depths.iter().filter(|depth| **depth < close_depth_m).count();
        let pixel_sq = variance(&mut pixels)?;
        Some(Residuals {
            pixel_sq,
            disparity_sq: variance(&mut disparities).unwrap_or(pixel_sq),
            in_common: in_common(&cells),
            cells: cells.iter().filter(|cell| cell.n > 0).count(),
            near,
            median_depth_m: median(&mut depths)?,
        })
    }
}

impl Cell {
    fn add(&mut self, error: [f64; 2]) {
        self.n += 1;
        for (axis, value) in error.into_iter().enumerate() {
            self.sum[axis] += value;
            self.sum_sq[axis] += value * value;
        }
    }

    /// Variance of the mean times the number, and sum of the squares around the mean, both axes together.
    fn between_and_within(&self) -> [f64; 2] {
        let between = self.sum.iter().map(|sum| sum * sum / self.n as f64).sum::<f64>();
        [between, self.sum_sq.iter().sum::<f64>() - between]
    }
}

/// Which of `n` equal parts a share of 0 to 1 falls into.
fn part(share: f64, n: usize) -> usize {
    ((share.max(0.0) * n as f64) as usize).min(n - 1)
}

/// Robust variance from absolute values, never quite zero; `None` without any.
fn variance(absolute: &mut [f64]) -> Option<f64> {
    median(absolute).map(|middle| (middle / NORMAL_MEDIAN).max(LEAST).powi(2))
}

/// Analysis of variance over the parts of the image; 1 where there are too few points.
fn in_common(cells: &[Cell]) -> f64 {
    let filled: Vec<&Cell> = cells.iter().filter(|cell| cell.n >= MIN_IN_CELL).collect();
    if filled.len() < MIN_CELLS {
        return 1.0;
    }
    let sums = filled.iter().map(|cell| cell.between_and_within());
    let [between, within] = sums.fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    let n: usize = filled.iter().map(|cell| cell.n - 1).sum();
    let ratio = between / filled.len() as f64 / (within / n as f64).max(LEAST * LEAST);
    ratio.max(1.0)
}

#[cfg(test)]
#[path = "../../tests/steps/residuals.rs"]
mod tests;
