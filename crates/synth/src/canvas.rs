//! A gray drawing surface in meters, with smooth edges: what facades, cars and signs are painted on before mip-mapping.

use crate::noise::{octaves, signed};
use crate::texture::Texture;

/// Gray values over a rectangle of `size_m`; x to the right, y down, origin in the upper left corner.
pub(crate) struct Canvas {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Texels per meter in x and y.
    pub(crate) density: [f32; 2],
    pub(crate) gray: Vec<f32>,
}

/// A rectangle in meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rect {
    pub(crate) x: f32,
    pub(crate) y: f32,
    pub(crate) w: f32,
    pub(crate) h: f32,
}

impl Rect {
    pub(crate) fn new(x: f32, y: f32, w: f32, h: f32) -> Self {
        Self { x, y, w, h }
    }

    /// The rectangle with a border of `by` meters taken off all round.
    pub(crate) fn inset(&self, by: f32) -> Self {
        Self::new(self.x + by, self.y + by, (self.w - 2.0 * by).max(0.0), (self.h - 2.0 * by).max(0.0))
    }
}

impl Canvas {
    pub(crate) fn new(width: usize, height: usize, size_m: [f32; 2], tone: f32) -> Self {
        let density = [width as f32 / size_m[0], height as f32 / size_m[1]];
        Self { width, height, density, gray: vec![tone; width * height] }
    }

    /// Sets every texel from its position in meters and its present value.
    pub(crate) fn shade(&mut self, tone: impl Fn(f32, f32, f32) -> f32) {
        let (w, d) = (self.width, self.density);
        for (i, g) in self.gray.iter_mut().enumerate() {
            *g = tone(((i % w) as f32 + 0.5) / d[0], ((i / w) as f32 + 0.5) / d[1], *g);
        }
    }

    /// Mixes `tone(x, y)` into a rectangle; border texels by the share that is covered.
    pub(crate) fn paint(&mut self, rect: Rect, opacity: f32, tone: impl Fn(f32, f32) -> f32) {
        let span = |from: f32, length: f32, density: f32, n: usize| {
            let (a, b) = (from * density, (from + length) * density);
            let first = a.floor().clamp(0.0, n as f32) as usize;
            (a, b, first, b.ceil().clamp(first as f32, n as f32) as usize)
        };
        let (left, right, x0, x1) = span(rect.x, rect.w, self.density[0], self.width);
        let (top, bottom, y0, y1) = span(rect.y, rect.h, self.density[1], self.height);
        let cover = |i: usize, a: f32, b: f32| (b.min(i as f32 + 1.0) - a.max(i as f32)).clamp(0.0, 1.0);
        for y in y0..y1 {
            let row = cover(y, top, bottom) * opacity;
            for x in x0..x1 {
                let share = row * cover(x, left, right);
                let g = &mut self.gray[y * self.width + x];
                let at = ((x as f32 + 0.5) / self.density[0], (y as f32 + 0.5) / self.density[1]);
                *g += share * (tone(at.0, at.1) - *g);
            }
        }
    }

    /// Fills a rectangle with one tone.
    pub(crate) fn fill(&mut self, rect: Rect, tone: f32) {
        self.paint(rect, 1.0, |_, _| tone);
    }

    /// Draws the border of a rectangle, `line` meters wide, inside it.
    pub(crate) fn frame(&mut self, rect: Rect, line: f32, tone: f32) {
        let Rect { x, y, w, h } = rect;
        self.fill(Rect::new(x, y, w, line), tone);
        self.fill(Rect::new(x, y + h - line, w, line), tone);
        self.fill(Rect::new(x, y, line, h), tone);
        self.fill(Rect::new(x + w - line, y, line, h), tone);
    }

    /// Fills an ellipse (meters).
    pub(crate) fn ellipse(&mut self, center: [f32; 2], radii: [f32; 2], tone: f32) {
        let [cx, cy] = center;
        let soft = 0.7 / (self.density[0].min(self.density[1]) * radii[0].min(radii[1]));
        let (w, d) = (self.width, self.density);
        let bounds = |c: f32, r: f32, d: f32, n: usize| {
            let low = ((c - r) * d - 1.0).clamp(0.0, n as f32) as usize;
            low..(((c + r) * d + 2.0).clamp(0.0, n as f32) as usize).max(low)
        };
        for y in bounds(cy, radii[1], d[1], self.height) {
            for x in bounds(cx, radii[0], d[0], w) {
                let ex = ((x as f32 + 0.5) / d[0] - cx) / radii[0];
                let ey = ((y as f32 + 0.5) / d[1] - cy) / radii[1];
                let share = ((1.0 - (ex * ex + ey * ey).sqrt()) / soft + 0.5).clamp(0.0, 1.0);
                let g = &mut self.gray[y * w + x];
                *g += share * (tone - *g);
            }
        }
    }

    /// Adds multi-octave noise; `cell_m` is the coarsest structure, `fine` the number of octaves.
    pub(crate) fn roughen(&mut self, cell_m: f32, fine: u32, gain: f32, amplitude: f32, seed: u32) {
        let period = [4096, 4096];
        self.shade(|x, y, g| g + amplitude * octaves(x / cell_m, y / cell_m, period, fine, gain, seed));
    }

    /// Writes lines of something like letters into a rectangle: bars at random, as signs and posters have.
    pub(crate) fn letters(&mut self, rect: Rect, letter_m: f32, tone: f32, seed: u32) {
        let lines = (rect.h / (1.6 * letter_m)).floor().max(1.0) as i32;
        let columns = (rect.w / (0.8 * letter_m)).floor() as i32;
        for line in 0..lines {
            for column in 0..columns {
                let at = |k: i32| signed(column * 8 + k, line, seed);
                if at(0) > 0.7 {
                    continue;
                }
                let x = rect.x + column as f32 * 0.8 * letter_m;
                let y = rect.y + (line as f32 + 0.2) * 1.6 * letter_m;
                let stroke = 0.16 * letter_m;
                let (w, h) = (0.6 * letter_m, letter_m);
                self.fill(Rect::new(x, y, stroke, h), tone);
                if at(1) > -0.3 {
                    self.fill(Rect::new(x, y, w, stroke), tone);
                }
                if at(2) > -0.3 {
                    self.fill(Rect::new(x, y + 0.42 * h, w, stroke), tone);
                }
                if at(3) > 0.0 {
                    self.fill(Rect::new(x, y + h - stroke, w, stroke), tone);
                }
                if at(4) > 0.1 {
                    self.fill(Rect::new(x + w - stroke, y, stroke, h), tone);
                }
            }
        }
    }

    /// Mip-maps the drawing.
    pub(crate) fn into_texture(self) -> Texture {
        Texture::opaque(self.width, self.height, |x, y| self.gray[y * self.width + x])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_covered_by_their_share() {
        let mut c = Canvas::new(8, 8, [8.0, 8.0], 0.0);
        c.fill(Rect::new(1.5, 2.0, 2.0, 1.0), 100.0);
        assert_eq!(&c.gray[2 * 8..2 * 8 + 5], &[0.0, 50.0, 100.0, 50.0, 0.0]);
        assert_eq!(c.gray.iter().sum::<f32>(), 200.0);
    }

    #[test]
    fn an_ellipse_has_its_area() {
        let mut c = Canvas::new(64, 64, [2.0, 2.0], 0.0);
        c.ellipse([1.0, 1.0], [0.5, 0.25], 1.0);
        let area = c.gray.iter().sum::<f32>() / (32.0 * 32.0);
        assert!((area - std::f32::consts::PI * 0.125).abs() < 0.02, "{area}");
    }
}
