//! Paints the fronts of houses: wall material, stories, windows, doors, shops, stains; one drawing per house, from its seed.

use crate::canvas::{Canvas, Rect};
use crate::noise::{Tile, signed, unit};
use crate::texture::Texture;

/// What a wall is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Material {
    Plaster,
    Brick,
    Stone,
    Boards,
    Panels,
}

/// Everything that decides how a front looks.
#[derive(Clone, Debug)]
pub(crate) struct FacadePlan {
    pub(crate) size_m: [f32; 2],
    pub(crate) material: Material,
    /// Gray value of the wall.
    pub(crate) tone: f32,
    pub(crate) stories: u32,
    /// Ground floor with shop windows instead of flats.
    pub(crate) shop: bool,
    /// Walls that look at a neighbor have few windows and no door.
    pub(crate) blank: bool,
    /// Half the resolution: for houses that are only seen from afar.
    pub(crate) distant: bool,
    pub(crate) seed: u32,
}

impl FacadePlan {
    /// A front chosen by a seed alone.
    pub(crate) fn from_seed(size_m: [f32; 2], stories: u32, seed: u32) -> Self {
        let r = |k: i32| unit(k, 0, seed);
        let material = match (r(0) * 10.0) as u32 {
            0..=3 => Material::Plaster,
            4..=5 => Material::Brick,
            6 => Material::Stone,
            7 => Material::Boards,
            _ => Material::Panels,
        };
        let tone = match material {
            Material::Brick => 75.0 + 45.0 * r(1),
            Material::Stone => 95.0 + 50.0 * r(1),
            _ => 95.0 + 85.0 * r(1),
        };
        Self { size_m, material, tone, stories, shop: r(2) < 0.3, blank: false, distant: false, seed }
    }

    /// Texels in x and y: about 4 cm wide and 2 cm high, since fronts are seen from the street at a slant.
    pub(crate) fn texels(&self) -> [usize; 2] {
        let coarser = if self.distant { 2.0 } else { 1.0 };
        let side =
            |size: f32, per_m: f32| ((size * per_m / coarser) as usize).next_power_of_two().clamp(64, 512);
        [side(self.size_m[0], 16.0), side(self.size_m[1], 32.0)]
    }

    /// Random number in [0, 1) of a detail.
    fn random(&self, k: i32, j: i32) -> f32 {
        unit(k, j.wrapping_add(1000), self.seed)
    }

    /// Draws the front; `noise` gives the walls their structure.
    pub(crate) fn bake(&self, noise: &Tile) -> Texture {
        let [w, h] = self.texels();
        let mut canvas = Canvas::new(w, h, self.size_m, self.tone);
        self.wall(&mut canvas, noise);
        let story_m = self.size_m[1] / self.stories as f32;
        for story in 0..self.stories {
            let top = self.size_m[1] - (story + 1) as f32 * story_m;
            if story == 0 && self.shop && !self.blank {
                self.shop_front(&mut canvas, noise, top, story_m);
            } else {
                self.story(&mut canvas, noise, story, top, story_m);
            }
            if story > 0 && self.random(1, 1) < 0.5 {
                let band = Rect::new(0.0, top + story_m - 0.16, self.size_m[0], 0.14);
                canvas.fill(band, self.tone * 1.25);
                canvas.fill(Rect::new(0.0, top + story_m - 0.02, self.size_m[0], 0.05), self.tone * 0.55);
            }
        }
        self.weather(&mut canvas, noise);
        canvas.into_texture()
    }

    /// The bare wall with its material's structure.
    fn wall(&self, canvas: &mut Canvas, noise: &Tile) {
        let (seed, tone) = (self.seed, self.tone);
        // Course height, block width, joint and strength of the variation from block to block.
        let (course, block, joint, vary) = match self.material {
            Material::Plaster => (0.0, 0.0, 0.0, 0.0),
            Material::Brick => (0.085, 0.27, 0.012, 34.0),
            Material::Stone => (0.34, 0.62, 0.02, 28.0),
            Material::Boards => (0.16, 3.1, 0.012, 13.0),
            Material::Panels => (1.4, 1.25, 0.025, 9.0),
        };
        if course > 0.0 {
            canvas.shade(|x, y, _| {
                let row = (y / course).floor();
                let shift = if (row as i32) & 1 == 1 { 0.5 * block } else { 0.0 };
                let column = ((x + shift) / block).floor();
                let (fx, fy) = ((x + shift) - column * block, y - row * course);
                let own = tone + vary * signed(column as i32, row as i32, seed ^ 0x77);
                if fx < joint || fy < joint { own * 0.62 } else { own }
            });
        }
        // Structure at all scales, and sharp-edged patches: old plaster, repairs.
        canvas.shade(|x, y, g| {
            let rough = g + 15.0 * noise.at(x, y, seed ^ 0x1234);
            if noise.at(0.6 * y, 0.6 * x, seed ^ 0x9911) > 0.5 { rough * 0.84 + 6.0 } else { rough }
        });
    }

    /// A row of windows with, in the lowest story, a door.
    fn story(&self, canvas: &mut Canvas, noise: &Tile, story: u32, top: f32, story_m: f32) {
        let pitch = 1.9 + 1.5 * self.random(2, 0);
        let columns = ((self.size_m[0] - 0.8) / pitch).floor().max(1.0) as i32;
        let margin = 0.5 * (self.size_m[0] - columns as f32 * pitch);
        let (width, height) = (0.85 + 0.75 * self.random(3, 0), (0.42 + 0.22 * self.random(4, 0)) * story_m);
        let door = (self.random(5, 0) * columns as f32) as i32;
        for column in 0..columns {
            let key = column + 64 * story as i32;
            if self.blank && self.random(6, key) < 0.8 {
                continue;
            }
            let center = margin + (column as f32 + 0.5) * pitch;
            if story == 0 && column == door && !self.blank {
                self.door(canvas, center, self.size_m[1], 2.2);
                continue;
            }
            if self.random(7, key) < 0.07 {
                continue;
            }
            let rect = Rect::new(center - 0.5 * width, top + 0.26 * story_m, width, height);
            self.window(canvas, noise, rect, key);
        }
    }

    /// Frame, glass with reflections, bars, curtain or blind, shutters, sill.
    fn window(&self, canvas: &mut Canvas, noise: &Tile, rect: Rect, key: i32) {
        let r = |k: i32| self.random(20 + k, key);
        let style = |k: i32| self.random(60 + k, 0);
        let frame_tone = if style(0) < 0.75 { 205.0 + 40.0 * style(1) } else { 50.0 };
        if style(2) < 0.5 {
            let surround = Rect::new(rect.x - 0.13, rect.y - 0.13, rect.w + 0.26, rect.h + 0.26);
            canvas.fill(surround, (self.tone * 1.3 + 20.0).min(235.0));
        }
        canvas.fill(rect, frame_tone);
        let glass = rect.inset(0.07);
        let (dark, seed) = (25.0 + 35.0 * r(0), self.seed ^ key as u32);
        let reflection = |x: f32, y: f32| {
            let cloud = noise.at(1.5 * x, 1.5 * y, seed);
            dark + 16.0 * cloud + if cloud > 0.3 { 32.0 } else { 0.0 }
        };
        canvas.paint(glass, 1.0, reflection);
        if r(1) < 0.5 {
            // Curtain in folds on both sides, or a blind from above.
            let fold = |x: f32, _: f32| 150.0 + 45.0 * r(2) + 22.0 * (x * (38.0 + 20.0 * r(3))).sin();
            let part = glass.w * (0.12 + 0.22 * r(4));
            canvas.paint(Rect::new(glass.x, glass.y, part, glass.h), 0.85, fold);
            canvas.paint(Rect::new(glass.x + glass.w - part, glass.y, part, glass.h), 0.85, fold);
        } else if r(1) < 0.8 {
            let slat = |_: f32, y: f32| 165.0 + 30.0 * (y * 70.0).sin();
            canvas.paint(Rect::new(glass.x, glass.y, glass.w, glass.h * r(5)), 0.9, slat);
        }
        if style(3) < 0.7 {
            canvas.fill(Rect::new(rect.x + 0.5 * rect.w - 0.03, rect.y, 0.06, rect.h), frame_tone);
        }
        if style(4) < 0.6 {
            canvas.fill(Rect::new(rect.x, rect.y + 0.33 * rect.h, rect.w, 0.05), frame_tone);
        }
        // Shadow under the lintel, sill and the shadow under it.
        canvas.paint(Rect::new(rect.x, rect.y, rect.w, 0.1), 0.6, |_, _| 20.0);
        canvas.fill(Rect::new(rect.x - 0.1, rect.y + rect.h, rect.w + 0.2, 0.09), 215.0);
        canvas.paint(Rect::new(rect.x - 0.1, rect.y + rect.h + 0.09, rect.w + 0.2, 0.12), 0.5, |_, _| 30.0);
        if style(5) < 0.28 {
            let tone = 45.0 + 60.0 * style(6);
            let slats = |_: f32, y: f32| tone + 20.0 * (y * 55.0).sin();
            for x in [rect.x - 0.5 * rect.w - 0.02, rect.x + rect.w + 0.02] {
                canvas.paint(Rect::new(x, rect.y, 0.5 * rect.w, rect.h), 1.0, slats);
            }
        }
        if r(6) < 0.15 {
            let plant = |x: f32, y: f32| 70.0 + 60.0 * noise.at(5.0 * x, 5.0 * y, seed ^ 5);
            canvas.paint(Rect::new(rect.x, rect.y + rect.h - 0.18, rect.w, 0.26), 1.0, plant);
        }
    }

    fn door(&self, canvas: &mut Canvas, center: f32, bottom: f32, height: f32) {
        let tone = 40.0 + 70.0 * self.random(8, 0);
        let rect = Rect::new(center - 0.6, bottom - height - 0.15, 1.2, height + 0.15);
        canvas.fill(Rect::new(rect.x - 0.14, rect.y - 0.14, rect.w + 0.28, rect.h + 0.14), self.tone * 0.7);
        canvas.fill(rect, tone);
        for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let panel =
                Rect::new(rect.x + 0.12 + 0.52 * column as f32, rect.y + 0.2 + 1.05 * row as f32, 0.42, 0.85);
            canvas.frame(panel, 0.05, tone * 1.6);
        }
        canvas.fill(Rect::new(rect.x + 1.02, rect.y + 1.2, 0.06, 0.16), 225.0);
        canvas.fill(Rect::new(rect.x + 1.5, rect.y + 0.9, 0.25, 0.35), 200.0);
        canvas.letters(Rect::new(rect.x + 1.52, rect.y + 0.93, 0.2, 0.3), 0.07, 40.0, self.seed);
    }

    /// Shop windows with goods, a sign with letters, a door between.
    fn shop_front(&self, canvas: &mut Canvas, noise: &Tile, top: f32, story_m: f32) {
        let width = self.size_m[0];
        canvas.fill(Rect::new(0.0, top, width, story_m), 50.0 + 90.0 * self.random(10, 0));
        let sign = Rect::new(0.3, top + 0.25, width - 0.6, 0.62);
        let sign_tone = if self.random(11, 0) < 0.5 { 215.0 } else { 45.0 };
        canvas.fill(sign, sign_tone);
        let start = 0.25 * width * self.random(12, 0);
        let text = Rect::new(0.5 + start, top + 0.31, 0.6 * width, 0.5);
        canvas.letters(text, 0.42, 255.0 - sign_tone, self.seed ^ 0xabc);
        let panes = (width / 2.3).floor().max(2.0) as i32;
        let pitch = (width - 0.4) / panes as f32;
        let door = (self.random(13, 0) * panes as f32) as i32;
        for pane in 0..panes {
            let x = 0.2 + pane as f32 * pitch;
            if pane == door {
                self.door(canvas, x + 0.5 * pitch, self.size_m[1], 2.1);
                continue;
            }
            let rect = Rect::new(x + 0.1, top + 1.05, pitch - 0.2, story_m - 1.55);
            self.shop_window(canvas, noise, rect, pane);
        }
        let plinth = Rect::new(0.0, self.size_m[1] - 0.35, width, 0.35);
        canvas.paint(plinth, 0.35, |_, _| 30.0);
    }

    fn shop_window(&self, canvas: &mut Canvas, noise: &Tile, rect: Rect, pane: i32) {
        let seed = self.seed ^ (pane as u32).wrapping_mul(7919);
        canvas.fill(rect, 190.0);
        let glass = rect.inset(0.06);
        canvas.paint(glass, 1.0, |x, y| 45.0 + 28.0 * noise.at(x, y, seed));
        for k in 0..7 {
            let r = |j: i32| unit(k, j, seed);
            let (w, h) = (0.15 + 0.5 * r(0), 0.15 + 0.6 * r(1));
            let x = glass.x + (glass.w - w).max(0.0) * r(2);
            let y = glass.y + (glass.h - h).max(0.0) * (0.5 + 0.5 * r(3));
            let goods = Rect::new(x, y, w.min(glass.w), h.min(glass.h));
            canvas.fill(goods, 30.0 + 200.0 * r(4));
            if r(5) < 0.5 {
                canvas.letters(goods.inset(0.03), 0.1, 30.0 + 200.0 * r(6), seed ^ k as u32);
            }
        }
    }

    /// Dirt that runs down, soot near the ground, posters and scribbles, a pipe.
    fn weather(&self, canvas: &mut Canvas, noise: &Tile) {
        let (seed, height) = (self.seed, self.size_m[1]);
        canvas.shade(|x, y, g| {
            let streak = noise.at(3.0 * x, 0.2 * y, seed ^ 0x3131);
            let soot = (1.0 - (height - y) / 0.9).max(0.0);
            g * (1.0 - 0.1 * streak.max(0.0) - 0.25 * soot)
        });
        for k in 0..3 {
            let r = |j: i32| self.random(200 + 10 * k + j, 3);
            if r(0) > 0.45 {
                continue;
            }
            let rect = Rect::new(
                self.size_m[0] * 0.9 * r(1),
                height - 1.1 - 1.2 * r(2),
                0.3 + 0.7 * r(3),
                0.4 + 0.6 * r(4),
            );
            let tone = if r(5) < 0.5 { 215.0 } else { 60.0 };
            canvas.fill(rect, tone);
            canvas.letters(rect.inset(0.05), 0.09 + 0.2 * r(6), 255.0 - tone, seed ^ k as u32);
        }
        if self.random(9, 9) < 0.5 {
            let x = (self.size_m[0] - 0.3) * self.random(9, 10).round() + 0.08;
            canvas.fill(Rect::new(x, 0.0, 0.13, height), self.tone * 0.5);
            canvas.fill(Rect::new(x + 0.03, 0.0, 0.03, height), self.tone * 0.95);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fronts_differ_by_seed_and_have_contrast_at_all_scales() {
        let gray = |seed: u32, level: usize| {
            let t = FacadePlan::from_seed([12.0, 9.0], 3, seed).bake(&Tile::new(1));
            let side = 256 >> level;
            let texel = |i: i32| ((i << 16) + 0x8000) << level;
            (0..side * side)
                .map(|i| t.levels[level].gray().bilinear(texel(i % side), texel(i / side)) as f64 / 256.0)
                .collect::<Vec<_>>()
        };
        for level in 0..5 {
            let (a, b) = (gray(3, level), gray(4, level));
            let difference = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum::<f64>() / a.len() as f64;
            assert!(difference > 10.0, "level {level}: {difference}");
            let step = a.windows(2).map(|w| (w[1] - w[0]).abs()).sum::<f64>() / a.len() as f64;
            assert!(step > 4.0, "level {level}: {step}");
        }
    }
}
