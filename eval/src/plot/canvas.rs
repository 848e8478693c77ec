//! Drawing surface of all figures: fonts, colors, sizes, and the way to PNG and SVG.
//!
//! Figures are laid out in logical pixels, 800 wide. They are drawn four times as large: the PNG is averaged down to
//! twice the logical size (anti-aliased lines), the SVG keeps the fine coordinates in its view box.

use std::path::Path;
use std::sync::OnceLock;

use anyhow::{Context, Result, ensure};
use draw::FONT;
use image::RgbImage;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

/// Drawn pixels per logical pixel.
const UNIT: u32 = 4;
/// Drawn pixels averaged into one of the PNG, per side.
const SHRINK: u32 = 2;

/// Ground truth, axes and text.
pub(crate) const INK: RGBColor = RGBColor(60, 60, 60);
/// Grid lines.
pub(crate) const FAINT: RGBColor = RGBColor(225, 225, 225);
/// Distinguishable with every common color-vision deficiency (Okabe and Ito 2008, and a gray), in order of use.
pub(crate) const PALETTE: [RGBColor; 9] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(60, 60, 60),
    RGBColor(240, 228, 66),
    RGBColor(150, 150, 150),
];

/// Color number `i` of the palette, repeating from the start.
pub(crate) fn color(i: usize) -> RGBColor {
    PALETTE[i % PALETTE.len()]
}

/// Draws a figure as an RGB image, twice its logical size.
///
/// # Errors
/// The backend's error.
pub fn render(figure: &Canvas) -> Result<RgbImage> {
    let size = figure.drawn_size();
    let mut pixels = vec![255; size.0 as usize * size.1 as usize * 3];
    paint(BitMapBackend::with_buffer(&mut pixels, size), &figure.shapes, Lines::Segments)?;
    Ok(shrink(&pixels, size.0))
}

/// Draws a figure as SVG text of its logical size.
///
/// # Errors
/// The backend's error.
pub fn svg(figure: &Canvas) -> Result<String> {
    let (size, (width, height)) = (figure.drawn_size(), figure.size);
    let mut text = String::new();
    paint(SVGBackend::with_string(&mut text, size), &figure.shapes, Lines::Whole)?;
    Ok(text.replacen(
        &format!("width=\"{}\" height=\"{}\"", size.0, size.1),
        &format!("width=\"{width}\" height=\"{height}\" stroke-linejoin=\"round\" stroke-linecap=\"round\""),
        1,
    ))
}

/// Writes a figure as PNG, twice its logical size.
///
/// # Errors
/// It cannot be drawn; or the file cannot be written.
pub fn save_png(path: &Path, figure: &Canvas) -> Result<()> {
    let image = render(figure).with_context(|| format!("cannot draw {}", path.display()))?;
    image.save(path).with_context(|| format!("cannot write {}", path.display()))
}

/// Writes a figure as `<folder>/<name>.png` and `<name>.svg`.
///
/// # Errors
/// It cannot be drawn; or a file cannot be written.
pub fn save(folder: &Path, name: &str, figure: &Canvas) -> Result<()> {
    save_png(&folder.join(format!("{name}.png")), figure)?;
    let path = folder.join(format!("{name}.svg"));
    let text = svg(figure).with_context(|| format!("cannot draw {}", path.display()))?;
    std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// Averages squares of drawn pixels.
fn shrink(pixels: &[u8], width: u32) -> RgbImage {
    let height = pixels.len() as u32 / 3 / width;
    let sample = |x: u32, y: u32, c: usize| u32::from(pixels[((y * width + x) * 3) as usize + c]);
    RgbImage::from_fn(width / SHRINK, height / SHRINK, |x, y| {
        let mean = |c: usize| {
            let mut sum = 0;
            for dy in 0..SHRINK {
                for dx in 0..SHRINK {
                    sum += sample(x * SHRINK + dx, y * SHRINK + dy, c);
                }
            }
            (sum / (SHRINK * SHRINK)) as u8
        };
        image::Rgb([mean(0), mean(1), mean(2)])
    })
}

/// How a thick line is handed to the backend.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lines {
    /// Segment by segment with discs as joints: the bitmap backend fills a whole outline by the even-odd rule, so that
    /// a path that runs over itself would vanish there.
    Segments,
    /// As one path.
    Whole,
}

/// Something on a canvas, in drawn pixels.
enum Shape {
    Text(String, (i32, i32), Box<TextStyle<'static>>),
    Line(Vec<(i32, i32)>, ShapeStyle),
    Bar((i32, i32), (i32, i32), RGBColor),
    Dot((i32, i32), u32, RGBColor),
}

/// Draws `shapes` in order with `backend`.
fn paint<B: DrawingBackend>(mut backend: B, shapes: &[Shape], lines: Lines) -> Result<()>
where
    B::ErrorType: 'static,
{
    backend.ensure_prepared()?;
    for shape in shapes {
        match shape {
            Shape::Text(text, at, style) => backend.draw_text(text, style.as_ref(), *at)?,
            Shape::Line(path, style) if lines == Lines::Whole || path.len() < 2 => {
                backend.draw_path(path.iter().copied(), style)?;
            }
            Shape::Line(path, style) => {
                let has_joints = style.stroke_width > UNIT && path.len() > 2;
                for ends in path.windows(2) {
                    backend.draw_path(ends.iter().copied(), style)?;
                    if has_joints {
                        backend.draw_circle(ends[1], style.stroke_width / 2, &style.color, true)?;
                    }
                }
            }
            Shape::Bar(a, b, color) => backend.draw_rect(*a, *b, color, true)?,
            Shape::Dot(at, radius, color) => backend.draw_circle(*at, *radius, color, true)?,
        }
    }
    Ok(backend.present()?)
}

/// A figure: what is drawn on it, and its width and height in logical pixels.
pub struct Canvas {
    size: (u32, u32),
    shapes: Vec<Shape>,
}

/// Where a text hangs from its point.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Left,
    Center,
    Right,
}

impl Canvas {
    /// An empty figure.
    ///
    /// # Errors
    /// The built-in font cannot be read.
    pub(crate) fn new(width: u32, height: u32) -> Result<Self> {
        static REGISTERED: OnceLock<bool> = OnceLock::new();
        let registered =
            *REGISTERED.get_or_init(|| register_font("sans-serif", FontStyle::Normal, FONT).is_ok());
        ensure!(registered, "the built-in font cannot be read");
        Ok(Self { size: (width, height), shapes: Vec::new() })
    }

    /// Width and height.
    pub(crate) fn extent(&self) -> (f64, f64) {
        (f64::from(self.size.0), f64::from(self.size.1))
    }

    fn drawn_size(&self) -> (u32, u32) {
        (self.size.0 * UNIT, self.size.1 * UNIT)
    }

    /// Text of `size` logical pixels, vertically centered at `at`.
    pub(crate) fn text(&mut self, text: &str, at: (f64, f64), size: f64, anchor: Anchor) {
        self.styled_text(text, at, size, anchor, FontTransform::None);
    }

    /// Text that reads upwards, centered at `at`.
    pub(crate) fn text_upwards(&mut self, text: &str, at: (f64, f64), size: f64) {
        self.styled_text(text, at, size, Anchor::Center, FontTransform::Rotate270);
    }

    fn styled_text(
        &mut self,
        text: &str,
        at: (f64, f64),
        size: f64,
        anchor: Anchor,
        transform: FontTransform,
    ) {
        let h_pos = match anchor {
            Anchor::Left => HPos::Left,
            Anchor::Center => HPos::Center,
            Anchor::Right => HPos::Right,
        };
        let font = ("sans-serif", size * f64::from(UNIT)).into_font().transform(transform);
        let style = TextStyle::from(font).color(&INK).pos(Pos::new(h_pos, VPos::Center));
        self.shapes.push(Shape::Text(text.to_owned(), to_drawn(at), Box::new(style)));
    }

    /// Width of a text of `size`, logical pixels.
    pub(crate) fn text_width(&self, text: &str, size: f64) -> f64 {
        let font = ("sans-serif", size * f64::from(UNIT)).into_font();
        font.box_size(text)
            .map_or(0.6 * size * text.chars().count() as f64, |(width, _)| f64::from(width) / f64::from(UNIT))
    }

    /// A line of `width` logical pixels through `points`, with round joints.
    pub(crate) fn line(&mut self, points: &[(f64, f64)], color: RGBColor, width: f64) {
        let mut path: Vec<(i32, i32)> = points.iter().map(|&p| to_drawn(p)).collect();
        path.dedup();
        let width = (width * f64::from(UNIT)).round().max(1.0) as u32;
        self.shapes.push(Shape::Line(path, color.stroke_width(width)));
    }

    /// A filled rectangle between two corners.
    pub(crate) fn bar(&mut self, a: (f64, f64), b: (f64, f64), color: RGBColor) {
        let ((ax, ay), (bx, by)) = (to_drawn(a), to_drawn(b));
        self.shapes.push(Shape::Bar((ax.min(bx), ay.min(by)), (ax.max(bx), ay.max(by)), color));
    }

    /// A filled disc of radius `radius` logical pixels.
    pub(crate) fn dot(&mut self, at: (f64, f64), radius: f64, color: RGBColor) {
        self.shapes.push(Shape::Dot(to_drawn(at), (radius * f64::from(UNIT)).round() as u32, color));
    }
}

fn to_drawn(point: (f64, f64)) -> (i32, i32) {
    let unit = f64::from(UNIT);
    ((point.0 * unit).round() as i32, (point.1 * unit).round() as i32)
}
