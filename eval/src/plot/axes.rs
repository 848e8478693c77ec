//! A framed pair of linear axes with ticks, grid, labels, title and legend.

use plotters::style::RGBColor;

use super::canvas::{Anchor, Canvas, FAINT, INK, color};

/// Height of a tick label, logical pixels.
pub(crate) const SMALL: f64 = 15.0;
/// Height of axis labels and legend, logical pixels.
pub(crate) const NORMAL: f64 = 16.0;
/// Height of the title, logical pixels.
pub(crate) const LARGE: f64 = 20.0;

/// Rectangle of a plot inside its figure, logical pixels, without labels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

/// Linear axes: a range of data for each side of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axes {
    pub(crate) frame: Frame,
    pub(crate) x: (f64, f64),
    pub(crate) y: (f64, f64),
}

/// How a range is closed around its data.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Margin {
    /// From zero to 5 % above the largest value: errors.
    FromZero,
    /// 5 % on both sides.
    Both,
    /// Exactly the data.
    Tight,
}

/// Range of `values` with its margin; finite and never empty.
pub(crate) fn range(values: impl Iterator<Item = f64>, margin: Margin) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in values.filter(|v| v.is_finite()) {
        low = low.min(v);
        high = high.max(v);
    }
    if low > high {
        return (0.0, 1.0);
    }
    let pad = 0.05 * (high - low);
    let (low, high) = match margin {
        Margin::FromZero => (0.0, 1.05 * high.max(0.0)),
        Margin::Both => (low - pad, high + pad),
        Margin::Tight => (low, high),
    };
    if high - low > 1e-12 * high.abs().max(1e-12) { (low, high) } else { (low - 0.5, high + 0.5) }
}

impl Frame {
    /// What is left below the header, with room for labels.
    pub(crate) fn below(top: f64, canvas: &Canvas) -> Frame {
        let (width, height) = canvas.extent();
        Frame { left: 90.0, top, width: width - 115.0, height: height - top - 55.0 }
    }
}

impl Axes {
    /// Axes with the same meters per pixel on both sides: the ranges grow around their centers until they fit.
    pub(crate) fn equal(frame: Frame, x: (f64, f64), y: (f64, f64)) -> Axes {
        let per_pixel = ((x.1 - x.0) / frame.width).max((y.1 - y.0) / frame.height);
        let grown = |range: (f64, f64), pixels: f64| {
            let (middle, half) = (0.5 * (range.0 + range.1), 0.5 * per_pixel * pixels);
            (middle - half, middle + half)
        };
        Axes { frame, x: grown(x, frame.width), y: grown(y, frame.height) }
    }

    /// Logical pixel of a data point.
    pub(crate) fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let f = &self.frame;
        (
            f.left + (x - self.x.0) / (self.x.1 - self.x.0) * f.width,
            f.top + f.height - (y - self.y.0) / (self.y.1 - self.y.0) * f.height,
        )
    }

    /// Grid, ticks, tick labels, axis labels.
    pub(crate) fn draw(&self, canvas: &mut Canvas, x_label: &str, y_label: &str) {
        let f = &self.frame;
        let (bottom, right) = (f.top + f.height, f.left + f.width);
        for (value, label) in ticks(self.x, f.width / 90.0) {
            let (x, _) = self.at(value, self.y.0);
            canvas.line(&[(x, f.top), (x, bottom)], FAINT, 1.0);
            canvas.line(&[(x, bottom), (x, bottom + 5.0)], INK, 1.0);
            canvas.text(&label, (x, bottom + 15.0), SMALL, Anchor::Center);
        }
        canvas.text(x_label, (f.left + 0.5 * f.width, bottom + 37.0), NORMAL, Anchor::Center);
        self.draw_y(canvas, y_label);
        let corners = [(f.left, f.top), (right, f.top), (right, bottom), (f.left, bottom), (f.left, f.top)];
        canvas.line(&corners, INK, 1.0);
    }

    /// Grid, ticks and label of the vertical axis alone (bar charts have names below).
    pub(crate) fn draw_y(&self, canvas: &mut Canvas, label: &str) {
        let f = &self.frame;
        for (value, label) in ticks(self.y, f.height / 45.0) {
            let (_, y) = self.at(self.x.0, value);
            canvas.line(&[(f.left, y), (f.left + f.width, y)], FAINT, 1.0);
            canvas.line(&[(f.left - 5.0, y), (f.left, y)], INK, 1.0);
            canvas.text(&label, (f.left - 8.0, y), SMALL, Anchor::Right);
        }
        canvas.text_upwards(label, (f.left - 62.0, f.top + 0.5 * f.height), NORMAL);
    }
}

/// A legend entry.
pub(crate) struct Key<'a> {
    pub(crate) text: &'a str,
    pub(crate) color: RGBColor,
    pub(crate) width: f64,
}

/// Keys of curves in the colors of the palette.
pub(crate) fn colored<'a>(names: impl Iterator<Item = &'a str>, width: f64) -> Vec<Key<'a>> {
    names.enumerate().map(|(i, text)| Key { text, color: color(i), width }).collect()
}

/// Title and legend above the frame; returns their height.
pub(crate) fn header(canvas: &mut Canvas, title: &str, keys: &[Key<'_>]) -> f64 {
    let (width, _) = canvas.extent();
    let mut size = LARGE;
    while size > 10.0 && canvas.text_width(title, size) > width - 20.0 {
        size -= 1.0;
    }
    canvas.text(title, (0.5 * width, 20.0), size, Anchor::Center);
    let (mut x, mut y) = (20.0, 48.0);
    for key in keys {
        let needed = 40.0 + canvas.text_width(key.text, NORMAL) + 22.0;
        if x + needed > width && x > 20.0 {
            (x, y) = (20.0, y + LEGEND_ROW);
        }
        canvas.line(&[(x, y), (x + 32.0, y)], key.color, key.width);
        canvas.text(key.text, (x + 40.0, y), NORMAL, Anchor::Left);
        x += needed;
    }
    header_height(width, keys.iter().map(|key| key.text))
}

/// Height of one row of the legend, logical pixels.
const LEGEND_ROW: f64 = 22.0;

/// Height of the title and legend of `names`, a safe estimate before anything is drawn.
pub(crate) fn header_height<'a>(width: f64, names: impl Iterator<Item = &'a str>) -> f64 {
    let (mut x, mut rows) = (20.0, 1.0);
    for name in names {
        let needed = 62.0 + 0.62 * NORMAL * name.chars().count() as f64;
        if x + needed > width && x > 20.0 {
            (x, rows) = (20.0, rows + 1.0);
        }
        x += needed;
    }
    44.0 + LEGEND_ROW * rows
}

/// Values and labels of about `wanted` ticks at 1, 2 or 5 times a power of ten.
fn ticks(range: (f64, f64), wanted: f64) -> Vec<(f64, String)> {
    let raw = (range.1 - range.0) / wanted.max(1.0);
    let power = 10.0_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].iter().map(|m| m * power).find(|s| *s >= raw).unwrap_or(10.0 * power);
    let digits = if step >= 1.0 { 0 } else { (-step.log10().floor()) as usize };
    let (first, last) = ((range.0 / step).ceil() as i64, (range.1 / step).floor() as i64);
    (first..=last)
        .map(|i| {
            let value = i as f64 * step;
            (value, format!("{value:.digits$}"))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(range: (f64, f64), wanted: f64) -> Vec<String> {
        ticks(range, wanted).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels((0.0, 1.0), 5.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels((-270.0, 310.0), 6.0), ["-200", "-100", "0", "100", "200", "300"]);
        assert_eq!(labels((0.0, 0.013), 3.0), ["0.000", "0.005", "0.010"]);
    }

    #[test]
    fn equal_axes_have_equal_scale() {
        let frame = Frame { left: 0.0, top: 0.0, width: 600.0, height: 300.0 };
        let axes = Axes::equal(frame, (0.0, 100.0), (-10.0, 500.0));
        let per_pixel_x = (axes.x.1 - axes.x.0) / frame.width;
        let per_pixel_y = (axes.y.1 - axes.y.0) / frame.height;
        assert!((per_pixel_x - per_pixel_y).abs() < 1e-12);
        assert!(axes.x.0 <= 0.0 && axes.x.1 >= 100.0 && axes.y.0 <= -10.0 && axes.y.1 >= 500.0);
    }

    #[test]
    fn ranges_are_never_empty() {
        for margin in [Margin::FromZero, Margin::Both, Margin::Tight] {
            for values in [vec![], vec![3.0], vec![f64::NAN], vec![0.0, 0.0]] {
                let (low, high) = range(values.iter().copied(), margin);
                assert!(high > low && low.is_finite() && high.is_finite());
            }
        }
    }
}
