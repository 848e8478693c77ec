//! The strip below a picture that says what its colors mean.

use crate::canvas::Canvas;
use crate::color::{Color, WHITE};
use crate::font::text_width;

/// One entry: a piece of color and what it stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Swatch {
    /// The colors from left to right; one for a kind, many for a scale.
    pub colors: Vec<Color>,
    /// What it stands for.
    pub label: String,
}

/// A title and the swatches, on white.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strip {
    /// What the picture shows.
    pub title: String,
    /// What its colors mean.
    pub swatches: Vec<Swatch>,
}

const INK: Color = [40, 40, 40];
const SIZE_PX: f32 = 22.0;
const LINE_PX: usize = 34;
const MARGIN_PX: usize = 10;

impl Swatch {
    /// A kind of thing with its color.
    pub fn kind(color: Color, label: impl Into<String>) -> Self {
        Self { colors: vec![color; 24], label: label.into() }
    }

    /// A scale from `color(0)` to `color(1)`.
    pub fn scale(color: impl Fn(f64) -> Color, label: impl Into<String>) -> Self {
        const N: usize = 160;
        Self { colors: (0..N).map(|i| color(i as f64 / (N - 1) as f64)).collect(), label: label.into() }
    }

    fn width(&self) -> usize {
        self.colors.len() + 8 + text_width(&self.label, SIZE_PX).ceil() as usize + 24
    }
}

impl Strip {
    /// The strip, `width` pixels wide; swatches that do not fit go to further lines.
    pub fn drawn(&self, width: usize) -> Canvas {
        let mut places = Vec::new();
        let (mut left, mut line) = (MARGIN_PX, 1);
        for swatch in &self.swatches {
            if left > MARGIN_PX && left + swatch.width() > width {
                (left, line) = (MARGIN_PX, line + 1);
            }
            places.push((left, line));
            left += swatch.width();
        }
        let n_lines = places.last().map_or(1, |&(_, line)| line + 1);
        let mut canvas = Canvas::new(width, n_lines * LINE_PX + MARGIN_PX, WHITE);
        canvas.text(&self.title, SIZE_PX, MARGIN_PX as f64, 6.0, INK);
        for (swatch, (left, line)) in self.swatches.iter().zip(places) {
            let top = line * LINE_PX + 6;
            canvas.rectangle(left - 1, top, swatch.colors.len() + 2, 24, INK);
            for (i, &color) in swatch.colors.iter().enumerate() {
                canvas.rectangle(left + i, top + 1, 1, 22, color);
            }
            canvas.text(&swatch.label, SIZE_PX, (left + swatch.colors.len() + 8) as f64, top as f64, INK);
        }
        canvas
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swatches_that_do_not_fit_go_to_the_next_line() {
        let swatches = (0..6).map(|i| Swatch::kind([0, 0, i], "a kind of thing")).collect();
        let strip = Strip { title: "title".to_owned(), swatches };
        let (wide, narrow) = (strip.drawn(3000), strip.drawn(500));
        assert_eq!(wide.image.height, 2 * LINE_PX + MARGIN_PX);
        assert!(narrow.image.height >= 4 * LINE_PX);
        for i in 0..6 {
            let shown = |canvas: &Canvas| canvas.image.data.iter().filter(|p| **p == [0, 0, i]).count();
            assert_eq!((shown(&wide), shown(&narrow)), (24 * 22, 24 * 22));
        }
    }

    #[test]
    fn a_strip_that_is_too_narrow_is_cut() {
        let strip = Strip { title: "a long title".to_owned(), swatches: vec![Swatch::scale(|_| WHITE, "x")] };
        assert_eq!(strip.drawn(20).image.width, 20);
    }
}
