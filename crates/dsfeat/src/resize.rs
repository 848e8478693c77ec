//! Gray images at the size of a network's input: averages over areas where it gets smaller, bilinear where it gets larger.

use geometry::GrayImage;

/// Source pixels of each target pixel along one axis, with weights that add up to one.
#[derive(Clone, Debug, PartialEq)]
struct Axis {
    from: usize,
    /// First source pixel and range in `weights`, by target pixel.
    spans: Vec<(usize, usize, usize)>,
    weights: Vec<f32>,
}

/// Resizes images; keeps its buffers and, for images of equal size, its weights.
#[derive(Debug, Default)]
pub(crate) struct Resizer {
    axes: Option<[Axis; 2]>,
    lines: Vec<f32>,
}

impl Resizer {
    /// `image` with values of 0 to 1, resized to `width` x `height`, row after row. The corners of both coincide.
    pub(crate) fn run(&mut self, image: &GrayImage, width: usize, height: usize, out: &mut Vec<f32>) {
        let fits = |axes: &[Axis; 2]| {
            let sides = [(image.width, width), (image.height, height)];
            axes.iter().zip(sides).all(|(axis, (from, to))| axis.from == from && axis.spans.len() == to)
        };
        if !self.axes.as_ref().is_some_and(fits) {
            self.axes = Some([Axis::new(image.width, width), Axis::new(image.height, height)]);
        }
        let Some([columns, rows]) = &self.axes else { return };
        self.lines.resize(image.height * width, 0.0);
        for (y, line) in self.lines.chunks_exact_mut(width).enumerate() {
            let row = image.row(y);
            for (value, (first, weights)) in line.iter_mut().zip(columns.iter()) {
                *value = row[first..].iter().zip(weights).map(|(p, w)| f32::from(*p) * w).sum();
            }
        }
        out.clear();
        out.resize(width * height, 0.0);
        for (target, (first, weights)) in out.chunks_exact_mut(width).zip(rows.iter()) {
            for (i, weight) in weights.iter().enumerate() {
                let line = &self.lines[(first + i) * width..(first + i + 1) * width];
                target.iter_mut().zip(line).for_each(|(t, v)| *t += v * (weight / 255.0));
            }
        }
    }
}

impl Axis {
    fn new(from: usize, to: usize) -> Self {
        let mut axis = Axis { from, spans: Vec::with_capacity(to), weights: Vec::new() };
        let ratio = from as f64 / to as f64;
        for i in 0..to {
            let begin = axis.weights.len();
            let first = if ratio > 1.0 { axis.area(i, ratio) } else { axis.line(i, ratio) };
            axis.spans.push((first, begin, axis.weights.len()));
        }
        axis
    }

    /// Weights by how much of each source pixel lies in the target pixel; returns the first source pixel.
    fn area(&mut self, i: usize, ratio: f64) -> usize {
        let (begin, end) = (i as f64 * ratio, ((i + 1) as f64 * ratio).min(self.from as f64));
        let first = begin as usize;
        let last = (end.ceil() as usize).clamp(first + 1, self.from);
        for pixel in first..last {
            let inside = end.min((pixel + 1) as f64) - begin.max(pixel as f64);
            self.weights.push((inside.max(0.0) / (end - begin)) as f32);
        }
        first
    }

    /// Weights of the two source pixels around the center of the target pixel; returns the first.
    fn line(&mut self, i: usize, ratio: f64) -> usize {
        let last = self.from - 1;
        let position = ((i as f64 + 0.5) * ratio - 0.5).clamp(0.0, last as f64);
        let first = (position as usize).min(last.saturating_sub(1));
        let t = (position - first as f64) as f32;
        self.weights.push(1.0 - t);
        if last > first {
            self.weights.push(t);
        }
        first
    }

    /// First source pixel and weights of each target pixel.
    fn iter(&self) -> impl Iterator<Item = (usize, &[f32])> {
        self.spans.iter().map(|&(first, begin, end)| (first, &self.weights[begin..end]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resized(image: &GrayImage, width: usize, height: usize) -> Vec<f32> {
        let mut out = Vec::new();
        Resizer::default().run(image, width, height, &mut out);
        out
    }

    #[test]
    fn halving_averages_squares_and_equal_sizes_copy() {
        let image = GrayImage::from_vec(4, 2, vec![0, 10, 20, 30, 40, 50, 60, 70]).unwrap();
        let half = resized(&image, 2, 1);
        assert!((half[0] * 255.0 - 25.0).abs() < 1e-4 && (half[1] * 255.0 - 45.0).abs() < 1e-4, "{half:?}");
        let same: Vec<f32> = resized(&image, 4, 2).iter().map(|v| (v * 255.0).round()).collect();
        assert_eq!(same, [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0]);
    }

    #[test]
    fn a_ramp_stays_a_ramp_for_any_sizes() {
        let image = GrayImage::from_fn(100, 3, |x, _| 2 * x as u8);
        for width in [7, 33, 99, 130] {
            let ratio = 100.0 / width as f32;
            let line = &resized(&image, width, 2)[..width];
            for (i, value) in line.iter().enumerate().skip(1).take(width - 2) {
                let expected = 2.0 * ((i as f32 + 0.5) * ratio - 0.5);
                assert!(
                    (value * 255.0 - expected).abs() < 1e-2,
                    "{width}: {i}: {} {expected}",
                    value * 255.0
                );
            }
        }
    }

    #[test]
    fn brightness_is_kept_and_buffers_may_be_used_again() {
        let image = GrayImage::from_fn(50, 40, |x, y| ((x * 31 + y * 17) % 251) as u8);
        let mean = image.data.iter().map(|&v| f32::from(v)).sum::<f32>() / image.data.len() as f32 / 255.0;
        let mut resizer = Resizer::default();
        let mut out = Vec::new();
        for (width, height) in [(13, 9), (50, 40), (1, 1), (13, 9)] {
            resizer.run(&image, width, height, &mut out);
            let found = out.iter().sum::<f32>() / out.len() as f32;
            assert!((found - mean).abs() < 1e-3, "{width} x {height}: {found} {mean}");
        }
        let one = GrayImage::new(1, 1, 51);
        assert!(resized(&one, 3, 2).iter().all(|v| (v - 0.2).abs() < 1e-6));
    }
}
