//! Text by the one font of the program.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, Glyph, ScaleFont, point};

/// DejaVu Sans, so that pictures look alike on every machine (license beside the file).
pub static FONT: &[u8] = include_bytes!("../assets/DejaVuSans.ttf");

fn font() -> &'static FontRef<'static> {
    static READ: OnceLock<FontRef<'static>> = OnceLock::new();
    READ.get_or_init(|| FontRef::try_from_slice(FONT).expect("the font beside this file is sound"))
}

/// The glyphs of one line whose baseline begins at `(x, y)`, and where the line ends.
fn glyphs(text: &str, size_px: f32, x: f32, y: f32) -> (Vec<Glyph>, f32) {
    let scaled = font().as_scaled(size_px);
    let mut pen = x;
    let mut glyphs: Vec<Glyph> = Vec::new();
    for letter in text.chars() {
        let id = scaled.glyph_id(letter);
        if let Some(before) = glyphs.last() {
            pen += scaled.kern(before.id, id);
        }
        glyphs.push(id.with_scale_and_position(size_px, point(pen, y)));
        pen += scaled.h_advance(id);
    }
    (glyphs, pen)
}

/// Width of a line of text, pixels.
pub fn text_width(text: &str, size_px: f32) -> f32 {
    glyphs(text, size_px, 0.0, 0.0).1
}

/// Calls `cover(x, y, share)` for each pixel that a line of text covers; `top` is the upper edge of the line.
pub(crate) fn cover_text(
    text: &str,
    size_px: f32,
    left: f32,
    top: f32,
    mut cover: impl FnMut(i64, i64, f64),
) {
    let baseline = top + font().as_scaled(size_px).ascent();
    for glyph in glyphs(text, size_px, left, baseline).0 {
        if let Some(outline) = font().outline_glyph(glyph) {
            let corner = outline.px_bounds().min;
            outline.draw(|x, y, share| {
                cover(corner.x as i64 + i64::from(x), corner.y as i64 + i64::from(y), f64::from(share));
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn width_grows_with_text_and_size() {
        let short = text_width("12", 20.0);
        assert!(short > 10.0 && text_width("123", 20.0) > short);
        assert!((text_width("12", 40.0) - 2.0 * short).abs() < 0.1);
        assert_eq!(text_width("", 20.0), 0.0);
    }

    #[test]
    fn text_covers_pixels_of_its_line_only() {
        let (mut n, mut inside) = (0, true);
        cover_text("Ag|", 20.0, 5.0, 10.0, |x, y, share| {
            n += usize::from(share > 0.5);
            inside &= (4..=5 + text_width("Ag|", 20.0) as i64 + 1).contains(&x) && (10..=31).contains(&y);
        });
        assert!(n > 50 && inside, "{n} {inside}");
    }
}
