//! The drawing surface: an image, magnified, with smooth lines and rings over it.

use geometry::{GrayImage, Raster, Vec2};

use crate::color::{Color, WHITE, mix};
use crate::font;

/// An image that can be drawn on. What lies outside is left out.
#[derive(Clone, Debug)]
pub struct Canvas {
    /// The pixels.
    pub image: Raster<Color>,
}

/// How a line looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Its color.
    pub color: Color,
    /// Its width, pixels.
    pub width_px: f64,
}

impl Canvas {
    /// An empty canvas of one color.
    pub fn new(width: usize, height: usize, fill: Color) -> Self {
        Self { image: Raster::new(width, height, fill) }
    }

    /// A gray image, each pixel a square of `zoom` pixels; see [`Canvas::magnified`].
    pub fn of_gray(image: &GrayImage, zoom: usize) -> Self {
        let pixel = |x: usize, y: usize| [image.at(x / zoom, y / zoom); 3];
        Self { image: Raster::from_fn(image.width * zoom, image.height * zoom, pixel) }
    }

    /// Where a position of the image lies on a canvas that shows it `zoom` times as large.
    pub fn magnified(position: &Vec2, zoom: usize) -> Vec2 {
        position.map(|v| (v + 0.5) * zoom as f64 - 0.5)
    }

    /// Mixes everything with a color, so that what is drawn afterwards stands out.
    pub fn wash(&mut self, color: Color, share: f64) {
        self.image.data.iter_mut().for_each(|pixel| *pixel = mix(*pixel, color, share));
    }

    /// Copies another canvas to column `left`, row `top`.
    pub fn paste(&mut self, other: &Canvas, left: usize, top: usize) {
        for y in 0..other.image.height.min(self.image.height.saturating_sub(top)) {
            let n = other.image.width.min(self.image.width.saturating_sub(left));
            self.image.row_mut(top + y)[left..left + n].copy_from_slice(&other.image.row(y)[..n]);
        }
    }

    /// Lays a color over one pixel.
    pub fn blend(&mut self, x: i64, y: i64, color: Color, share: f64) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if x < self.image.width && y < self.image.height {
            let pixel = &mut self.image.row_mut(y)[x];
            *pixel = mix(*pixel, color, share.clamp(0.0, 1.0));
        }
    }

    /// A straight line with round ends.
    pub fn line(&mut self, from: &Vec2, to: &Vec2, stroke: Stroke) {
        let (along, half) = (to - from, 0.5 * stroke.width_px);
        let length_sq = along.norm_squared();
        let distance = |p: &Vec2| {
            let t = if length_sq > 0.0 { ((p - from).dot(&along) / length_sq).clamp(0.0, 1.0) } else { 0.0 };
            (p - (from + along * t)).norm()
        };
        // Steps along the longer side, and at each step across the line.
        let steep = along.y.abs() > along.x.abs();
        let (a, b) = if steep { (from.yx(), to.yx()) } else { (*from, *to) };
        let (first, last) = if a.x <= b.x { (a, b) } else { (b, a) };
        let slope = if last.x > first.x { (last.y - first.y) / (last.x - first.x) } else { 0.0 };
        let limit = if steep { self.image.height } else { self.image.width } as f64;
        let reach = half * std::f64::consts::SQRT_2 + 1.0;
        let begin = (first.x - reach).floor().max(0.0) as i64;
        let end = (last.x + reach).ceil().min(limit) as i64;
        for step in begin..=end {
            let middle = first.y + slope * (step as f64 - first.x).clamp(0.0, last.x - first.x);
            for across in (middle - reach).floor() as i64..=(middle + reach).ceil() as i64 {
                let (x, y) = if steep { (across, step) } else { (step, across) };
                let share = half + 0.5 - distance(&Vec2::new(x as f64, y as f64));
                if share > 0.0 {
                    self.blend(x, y, stroke.color, share);
                }
            }
        }
    }

    /// A circle's line.
    pub fn ring(&mut self, center: &Vec2, radius_px: f64, stroke: Stroke) {
        let half = 0.5 * stroke.width_px;
        let share = |distance: f64| half + 0.5 - (distance - radius_px).abs();
        self.round(center, radius_px + half, stroke.color, share);
    }

    /// A filled circle.
    pub fn disc(&mut self, center: &Vec2, radius_px: f64, color: Color) {
        self.round(center, radius_px, color, |distance| radius_px + 0.5 - distance);
    }

    fn round(&mut self, center: &Vec2, reach: f64, color: Color, share: impl Fn(f64) -> f64) {
        let (low, high) =
            (center.map(|v| (v - reach).floor() - 1.0), center.map(|v| (v + reach).ceil() + 1.0));
        for y in low.y.max(0.0) as i64..=high.y.min(self.image.height as f64) as i64 {
            for x in low.x.max(0.0) as i64..=high.x.min(self.image.width as f64) as i64 {
                let share = share((Vec2::new(x as f64, y as f64) - center).norm());
                if share > 0.0 {
                    self.blend(x, y, color, share);
                }
            }
        }
    }

    /// A filled rectangle: `width` by `height` pixels from column `left`, row `top` on.
    pub fn rectangle(&mut self, left: usize, top: usize, width: usize, height: usize, color: Color) {
        let columns = left.min(self.image.width)..(left + width).min(self.image.width);
        for y in top..(top + height).min(self.image.height) {
            self.image.row_mut(y)[columns.clone()].fill(color);
        }
    }

    /// One line of text, its upper left corner at `(left, top)`.
    pub fn text(&mut self, text: &str, size_px: f32, left: f64, top: f64, color: Color) {
        font::cover_text(text, size_px, left as f32, top as f32, |x, y, share| {
            self.blend(x, y, color, share)
        });
    }

    /// The canvases one below the other, white where one is narrower.
    pub fn stacked(parts: &[Canvas]) -> Self {
        let width = parts.iter().map(|part| part.image.width).max().unwrap_or(0);
        let height = parts.iter().map(|part| part.image.height).sum();
        let mut whole = Self::new(width, height, WHITE);
        let mut top = 0;
        for part in parts {
            whole.paste(part, 0, top);
            top += part.image.height;
        }
        whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::BLACK;

    const RED: Stroke = Stroke { color: [255, 0, 0], width_px: 1.0 };

    fn n_red(canvas: &Canvas) -> f64 {
        canvas.image.data.iter().map(|pixel| f64::from(pixel[0]) / 255.0).sum()
    }

    #[test]
    fn a_line_covers_its_length_times_its_width_in_every_direction() {
        for (x, y) in [(60.0, 0.0), (0.0, 60.0), (40.0, 40.0), (-30.0, 51.0), (20.0, -55.0)] {
            for width_px in [1.0, 3.0] {
                let mut canvas = Canvas::new(160, 160, BLACK);
                let from = Vec2::new(80.0, 80.0);
                canvas.line(&from, &(from + Vec2::new(x, y)), Stroke { width_px, ..RED });
                let area = Vec2::new(x, y).norm() * width_px;
                // Thin slanted lines are sampled a little too densely.
                assert!((n_red(&canvas) / area - 1.0).abs() < 0.2, "{x} {y}: {} of {area}", n_red(&canvas));
            }
        }
    }

    #[test]
    fn discs_and_rings_have_their_area() {
        let mut canvas = Canvas::new(100, 100, BLACK);
        canvas.disc(&Vec2::new(50.2, 49.7), 20.0, RED.color);
        assert!((n_red(&canvas) / (std::f64::consts::PI * 400.0) - 1.0).abs() < 0.02);
        let mut canvas = Canvas::new(100, 100, BLACK);
        canvas.ring(&Vec2::new(50.2, 49.7), 20.0, RED);
        assert!((n_red(&canvas) / (std::f64::consts::TAU * 20.0) - 1.0).abs() < 0.02);
    }

    #[test]
    fn what_lies_outside_is_left_out() {
        let mut canvas = Canvas::new(10, 8, BLACK);
        canvas.line(&Vec2::new(-1e6, -1e6), &Vec2::new(1e6, 1e6), RED);
        canvas.line(&Vec2::new(50.0, -3.0), &Vec2::new(50.0, 90.0), RED);
        canvas.disc(&Vec2::new(-90.0, 4.0), 3.0, RED.color);
        canvas.ring(&Vec2::new(5.0, 1e5), 3.0, RED);
        canvas.rectangle(20, 20, 5, 5, RED.color);
        canvas.text("far away", 12.0, -500.0, 900.0, RED.color);
        canvas.paste(&Canvas::new(4, 4, RED.color), 12, 12);
        assert!((n_red(&canvas) - 8.0 * std::f64::consts::SQRT_2).abs() < 1.5, "the diagonal alone");
    }

    #[test]
    fn magnified_pixels_keep_their_center() {
        let mut image = GrayImage::new(5, 4, 0);
        image.row_mut(2)[3] = 200;
        let canvas = Canvas::of_gray(&image, 3);
        let center = Canvas::magnified(&Vec2::new(3.0, 2.0), 3);
        assert_eq!(center, Vec2::new(10.0, 7.0));
        let bright: Vec<usize> = (0..15).filter(|&x| canvas.image.at(x, 7) == [200; 3]).collect();
        assert_eq!(bright, [9, 10, 11]);
    }

    #[test]
    fn parts_are_stacked_in_order() {
        let whole = Canvas::stacked(&[Canvas::new(4, 2, BLACK), Canvas::new(6, 1, RED.color)]);
        assert_eq!((whole.image.width, whole.image.height), (6, 3));
        assert_eq!(
            [whole.image.at(0, 0), whole.image.at(5, 0), whole.image.at(5, 2)],
            [BLACK, WHITE, RED.color]
        );
    }
}
