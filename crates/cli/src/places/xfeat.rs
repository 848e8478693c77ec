//! Dense learned features of a network that the user brings: XFeat (Potje et al., CVPR 2024) as ONNX.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use dsfeat::{ImageModel, Output};
use geometry::GrayImage;

/// Numbers in a descriptor.
pub(super) const DENSE_CHANNELS: usize = 64;
/// Pixels of the input per cell of the descriptor map.
const CELL: usize = 8;
/// Sides of the input are multiples of this.
const MULTIPLE: usize = 32;
/// Reach of the suppression of lower scores around a keypoint, pixels of the input.
const SUPPRESSION: usize = 2;
/// Scores below this are not keypoints (XFeat's own value).
const MIN_SCORE: f32 = 0.05;
/// Most keypoints of an image.
const MAX_KEYPOINTS: usize = 4096;

/// A descriptor of unit length.
pub(super) type DenseDescriptor = [f32; DENSE_CHANNELS];

/// A keypoint with its descriptor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DenseKeypoint {
    /// Column on the image, pixels.
    pub(super) x: f32,
    /// Row on the image, pixels.
    pub(super) y: f32,
    /// How much of a keypoint it is, times how reliable its descriptor is, 0 to 1.
    pub(super) score: f32,
    /// What it looks like.
    pub(super) descriptor: DenseDescriptor,
}

/// Features of an image.
#[derive(Clone, Debug)]
pub(super) struct DenseFeatures {
    /// Best score first.
    pub(super) keypoints: Vec<DenseKeypoint>,
    map: DescriptorMap,
    pixels_per_input: (f32, f32),
}

/// The network.
#[derive(Debug)]
pub(super) struct DenseNetwork(ImageModel);

impl DenseNetwork {
    /// Loads a model with a color image as input, and the outputs `descriptors` (64 channels), `keypoint_logits` (65) and
    /// `reliability` (1) at an eighth of its size. `library` and `threads` as for [`ImageModel::load`].
    ///
    /// # Errors
    /// As [`ImageModel::load`], or a model with other outputs.
    pub(super) fn load(model: &[u8], library: Option<&Path>, threads: usize) -> Result<Self> {
        let model = ImageModel::load(model, library, threads)?;
        for expected in ["descriptors", "keypoint_logits", "reliability"] {
            let found = model.outputs();
            ensure!(
                found.contains(&expected),
                "cannot be used as a model: the list of outputs is {}, expected one called {expected}",
                found.join(", ")
            );
        }
        Ok(Self(model))
    }

    /// The features of an image of at least 32 x 32 pixels.
    ///
    /// # Errors
    /// A smaller image, a failure of the model, or outputs of other shapes.
    pub(super) fn describe(&mut self, image: &GrayImage) -> Result<DenseFeatures> {
        let down = |side: usize| side / MULTIPLE * MULTIPLE;
        let (width, height) = (down(image.width), down(image.height));
        ensure!(width > 0 && height > 0, "the image is smaller than {MULTIPLE} x {MULTIPLE} pixels");
        let outputs = self.0.run(image, (width, height), 3)?;
        let (columns, rows) = (width / CELL, height / CELL);
        let output = |name: &str, channels: usize| -> Result<&[f32]> {
            let find = |output: &&Output| output.name == name;
            let Output { shape, values, .. } = outputs.iter().find(find).context("an output is gone")?;
            let expected = [1, channels, rows, columns];
            ensure!(*shape == expected, "output {name} has shape {shape:?}, expected {expected:?}");
            Ok(values)
        };
        let map = DescriptorMap::new(output("descriptors", DENSE_CHANNELS)?, columns, rows);
        let scores =
            scores(output("keypoint_logits", CELL * CELL + 1)?, output("reliability", 1)?, columns, rows);
        let pixels_per_input = (image.width as f32 / width as f32, image.height as f32 / height as f32);
        let keypoints = keypoints(&scores, (width, height), &map, pixels_per_input);
        Ok(DenseFeatures { keypoints, map, pixels_per_input })
    }
}

impl DenseFeatures {
    /// Mean of all descriptors of the image, weighted by `weight` at their pixels: the DSFeat paper's equation 3, but divided by the
    /// sum of the weights. Undivided, the means of two images differ by how much of each is trusted.
    pub(super) fn weighted_mean(&self, weight: impl Fn(f32, f32) -> f32) -> DenseDescriptor {
        let (mut mean, mut sum) = ([0.0; DENSE_CHANNELS], f32::MIN_POSITIVE);
        for cell in 0..self.map.columns * self.map.rows {
            let at = |i: usize, scale: f32| ((i as f32 + 0.5) * CELL as f32) * scale - 0.5;
            let x = at(cell % self.map.columns, self.pixels_per_input.0);
            let y = at(cell / self.map.columns, self.pixels_per_input.1);
            let share = weight(x, y);
            sum += share;
            mean.iter_mut().zip(self.map.cell(cell)).for_each(|(m, d)| *m += share * d);
        }
        mean.iter_mut().for_each(|m| *m /= sum);
        mean
    }
}

/// Descriptors of unit length, cell after cell.
#[derive(Clone, Debug)]
struct DescriptorMap {
    columns: usize,
    rows: usize,
    values: Vec<f32>,
}

impl DescriptorMap {
    /// From channels one after the other.
    fn new(channels: &[f32], columns: usize, rows: usize) -> Self {
        let cells = columns * rows;
        let mut values = vec![0.0; cells * DENSE_CHANNELS];
        for (cell, descriptor) in values.chunks_exact_mut(DENSE_CHANNELS).enumerate() {
            descriptor.iter_mut().enumerate().for_each(|(c, value)| *value = channels[c * cells + cell]);
            normalize(descriptor);
        }
        Self { columns, rows, values }
    }

    fn cell(&self, cell: usize) -> &[f32] {
        &self.values[cell * DENSE_CHANNELS..(cell + 1) * DENSE_CHANNELS]
    }

    /// The descriptor at a pixel of the input, bilinear between cells.
    fn at(&self, x: f32, y: f32) -> DenseDescriptor {
        let place = |p: f32, len: usize| {
            let position = ((p + 0.5) / CELL as f32 - 0.5).clamp(0.0, (len - 1) as f32);
            let first = (position as usize).min(len - 1);
            (first, (first + 1).min(len - 1), position - first as f32)
        };
        let ((x0, x1, dx), (y0, y1, dy)) = (place(x, self.columns), place(y, self.rows));
        let mut descriptor = [0.0; DENSE_CHANNELS];
        for (row, v) in [(y0, 1.0 - dy), (y1, dy)] {
            for (column, u) in [(x0, 1.0 - dx), (x1, dx)] {
                let cell = self.cell(row * self.columns + column);
                descriptor.iter_mut().zip(cell).for_each(|(d, c)| *d += u * v * c);
            }
        }
        normalize(&mut descriptor);
        descriptor
    }
}

fn normalize(descriptor: &mut [f32]) {
    let norm = descriptor.iter().map(|d| d * d).sum::<f32>().sqrt().max(1e-12);
    descriptor.iter_mut().for_each(|d| *d /= norm);
}

/// Score of each pixel of the input: the softmax over the 64 pixels of its cell and "no keypoint", times the cell's
/// reliability; 0 below the least score.
fn scores(logits: &[f32], reliability: &[f32], columns: usize, rows: usize) -> Vec<f32> {
    let (cells, width) = (columns * rows, columns * CELL);
    let mut scores = vec![0.0; cells * CELL * CELL];
    for cell in 0..cells {
        let logit = |channel: usize| logits[channel * cells + cell];
        let highest = (0..=CELL * CELL).map(logit).fold(f32::NEG_INFINITY, f32::max);
        let sum: f32 = (0..=CELL * CELL).map(|channel| (logit(channel) - highest).exp()).sum();
        for channel in 0..CELL * CELL {
            let share = (logit(channel) - highest).exp() / sum;
            let (x, y) = (cell % columns * CELL + channel % CELL, cell / columns * CELL + channel / CELL);
            scores[y * width + x] =
                if share >= MIN_SCORE { share * reliability[cell].clamp(0.0, 1.0) } else { 0.0 };
        }
    }
    scores
}

/// Local maxima of the scores, best first, of equals the upper left one.
fn keypoints(
    scores: &[f32],
    (width, height): (usize, usize),
    map: &DescriptorMap,
    scale: (f32, f32),
) -> Vec<DenseKeypoint> {
    let is_highest = |x: usize, y: usize| {
        let own = scores[y * width + x];
        let rows = y.saturating_sub(SUPPRESSION)..(y + SUPPRESSION + 1).min(height);
        own > 0.0
            && rows.into_iter().all(|v| {
                let columns = x.saturating_sub(SUPPRESSION)..(x + SUPPRESSION + 1).min(width);
                columns.into_iter().all(|u| {
                    let other = scores[v * width + u];
                    other < own || (other == own && (v, u) >= (y, x))
                })
            })
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let mut found: Vec<(usize, usize)> = places.filter(|&(x, y)| is_highest(x, y)).collect();
    found.sort_by(|a, b| scores[b.1 * width + b.0].total_cmp(&scores[a.1 * width + a.0]));
    found.truncate(MAX_KEYPOINTS);
    let keypoint = |&(column, row): &(usize, usize)| {
        let (x, y) = (column as f32, row as f32);
        DenseKeypoint {
            x: (x + 0.5) * scale.0 - 0.5,
            y: (y + 0.5) * scale.1 - 0.5,
            score: scores[row * width + column],
            descriptor: map.at(x, y),
        }
    };
    found.iter().map(keypoint).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pixel_with_the_high_logit_is_the_keypoint() {
        let (columns, rows) = (3, 2);
        let cells = columns * rows;
        let mut logits = vec![0.0; 65 * cells];
        logits[64 * cells..].fill(6.0);
        // Cell (1, 1), pixel (2, 5) in it.
        logits[(5 * CELL + 2) * cells + columns + 1] = 9.0;
        let scores = scores(&logits, &vec![0.8; cells], columns, rows);
        let channels: Vec<f32> = (0..DENSE_CHANNELS * cells).map(|i| ((i * 31) % 17) as f32 - 8.0).collect();
        let map = DescriptorMap::new(&channels, columns, rows);
        let found = keypoints(&scores, (columns * CELL, rows * CELL), &map, (2.0, 1.0));
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].x, found[0].y),
            (20.5, 13.0),
            "pixel (10, 13) of the input, twice as wide on the image"
        );
        assert!(found[0].score > 0.7 && found[0].score < 0.8);
        assert!((found[0].descriptor.iter().map(|d| d * d).sum::<f32>() - 1.0).abs() < 1e-5);
    }

    #[test]
    fn the_mean_follows_its_weights() {
        let mut channels = vec![0.0; DENSE_CHANNELS * 2];
        (channels[0], channels[3]) = (2.0, 5.0);
        let map = DescriptorMap::new(&channels, 2, 1);
        let features = DenseFeatures { keypoints: Vec::new(), map, pixels_per_input: (1.0, 1.0) };
        let mean = features.weighted_mean(|x, _| if x < 8.0 { 1.0 } else { 0.5 });
        assert!((mean[0] - 2.0 / 3.0).abs() < 1e-6 && (mean[1] - 1.0 / 3.0).abs() < 1e-6 && mean[2] == 0.0);
        assert_eq!(features.weighted_mean(|_, _| 0.0), [0.0; DENSE_CHANNELS]);
    }
}
