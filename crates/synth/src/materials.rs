//! Textures that many surfaces share: ground, plants, roofs, signs, sky. Each repeats without a seam.

use crate::canvas::{Canvas, Rect};
use crate::noise::{octaves, signed, unit};
use crate::texture::Texture;

/// A kind of surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Material {
    Grain,
    Asphalt,
    Paving,
    Grass,
    Paint,
    Manhole,
    Concrete,
    Metal,
    Bark,
    Hedge,
    Clouds,
    Leaves,
    Roof,
    Wall,
    Sign,
}

impl Material {
    /// Texels per meter.
    pub(crate) fn density(self) -> f64 {
        match self {
            Self::Grain => 150.0,
            Self::Asphalt | Self::Grass => 40.0,
            Self::Paving | Self::Concrete | Self::Paint | Self::Metal | Self::Bark | Self::Hedge => 80.0,
            Self::Manhole => 64.0 / 0.8,
            // Stretched over 2.6 m; the tree scales it.
            Self::Leaves => 256.0 / 2.6,
            Self::Roof | Self::Wall => 40.0,
            Self::Sign => 128.0 / 0.8,
            Self::Clouds => 1.0 / 24.0,
        }
    }

    /// Makes the texture.
    pub(crate) fn bake(self, seed: u32) -> Texture {
        match self {
            Self::Grain => tile(256, |x, y| 128.0 + 44.0 * fine(x, y, 256, 8, 5, 0.8, seed)),
            Self::Asphalt => asphalt(seed),
            Self::Paving => paving(seed),
            Self::Grass => tile(512, |x, y| {
                92.0 + 30.0 * fine(x, y, 512, 8, 4, 0.7, seed) + 34.0 * fine(x, y, 512, 128, 2, 0.9, seed ^ 7)
            }),
            Self::Paint => tile(256, |x, y| {
                let worn = fine(x, y, 256, 16, 4, 0.8, seed);
                if worn > 0.55 { 125.0 } else { 208.0 + 14.0 * worn }
            }),
            Self::Manhole => manhole(seed),
            Self::Concrete => tile(256, |x, y| 132.0 + 24.0 * fine(x, y, 256, 4, 6, 0.75, seed)),
            Self::Metal => tile(256, |x, y| {
                let rust = fine(x, y, 256, 16, 4, 0.6, seed);
                118.0 + 10.0 * fine(x, y, 256, 4, 3, 0.5, seed ^ 1) - if rust > 0.6 { 45.0 } else { 0.0 }
            }),
            Self::Bark => tile(256, |x, y| {
                let ridges = octaves(x as f32 / 6.0, y as f32 / 40.0, [256, 256], 3, 0.7, seed);
                72.0 + 42.0 * ridges + 16.0 * fine(x, y, 256, 32, 3, 0.8, seed ^ 3)
            }),
            Self::Hedge => hedge(seed),
            Self::Clouds => clouds(seed),
            Self::Leaves => leaves(seed),
            Self::Roof => roof(seed),
            Self::Wall => wall(seed),
            Self::Sign => sign(seed),
        }
    }
}

fn tile(size: usize, gray: impl Fn(usize, usize) -> f32) -> Texture {
    Texture::opaque(size, size, gray)
}

/// Noise that repeats over a square of `size` texels, `cells` coarsest cells wide.
fn fine(x: usize, y: usize, size: usize, cells: i32, n: u32, gain: f32, seed: u32) -> f32 {
    let s = cells as f32 / size as f32;
    octaves((x as f32 + 0.5) * s, (y as f32 + 0.5) * s, [cells; 2], n, gain, seed)
}

/// Gray with stones of all sizes, repaired areas and cracks; 12.8 m wide.
fn asphalt(seed: u32) -> Texture {
    tile(512, |x, y| {
        let coarse = fine(x, y, 512, 4, 5, 0.6, seed);
        let stones = fine(x, y, 512, 256, 2, 0.9, seed ^ 21);
        let crack = fine(x, y, 512, 5, 5, 0.55, seed ^ 22).abs();
        let patch = fine(x, y, 512, 6, 4, 0.5, seed ^ 23);
        let spot = if fine(x, y, 512, 45, 2, 0.6, seed ^ 24) > 0.72 { -24.0 } else { 0.0 };
        let base = 118.0 + 6.0 * coarse + 22.0 * stones + spot;
        let base = if patch > 0.5 { base - 14.0 } else { base };
        if crack < 0.013 { base - 42.0 } else { base }
    })
}

/// Slabs of 40 cm, each of its own tone.
fn paving(seed: u32) -> Texture {
    tile(512, |x, y| {
        let (column, row) = (x / 32, y / 32);
        let own = 20.0 * signed(column as i32, row as i32, seed);
        let base = 142.0 + own + 15.0 * fine(x, y, 512, 32, 5, 0.8, seed ^ 1);
        if x % 32 == 0 || y % 32 == 0 { 68.0 } else { base }
    })
}

fn manhole(seed: u32) -> Texture {
    let mut canvas = Canvas::new(64, 64, [0.8, 0.8], 100.0);
    canvas.ellipse([0.4, 0.4], [0.4, 0.4], 45.0);
    canvas.ellipse([0.4, 0.4], [0.34, 0.34], 92.0);
    for i in 0..5 {
        for j in 0..5 {
            canvas.fill(Rect::new(0.17 + 0.1 * i as f32, 0.17 + 0.1 * j as f32, 0.05, 0.05), 50.0);
        }
    }
    canvas.roughen(0.1, 3, 0.7, 18.0, seed);
    canvas.into_texture()
}

/// A leaf: position (texels), half axes, direction and tone.
fn leaf(i: i32, seed: u32, size: f32) -> ([f32; 2], [f32; 2], f32, f32) {
    let r = |k: i32| unit(i, k, seed);
    let length = 5.0 + 5.0 * r(2);
    let tone = 38.0 + 120.0 * r(4) * r(5) + 25.0 * r(6);
    ([r(0) * size, r(1) * size], [length, length * (0.35 + 0.2 * r(7))], r(3) * 6.3, tone)
}

/// Draws leaves one over another into `texels` ([gray, opacity]), wrapping at the border.
fn scatter(texels: &mut [[f32; 2]], size: usize, n: i32, seed: u32, keep: impl Fn([f32; 2]) -> bool) {
    for i in 0..n {
        let (center, axes, direction, tone) = leaf(i, seed, size as f32);
        if !keep(center) {
            continue;
        }
        let (sin, cos) = direction.sin_cos();
        let reach = axes[0].ceil() as i32;
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let (fx, fy) = (dx as f32, dy as f32);
                let (a, b) = ((fx * cos + fy * sin) / axes[0], (fy * cos - fx * sin) / axes[1]);
                if a * a + b * b <= 1.0 {
                    let x = (center[0] as i32 + dx).rem_euclid(size as i32) as usize;
                    let y = (center[1] as i32 + dy).rem_euclid(size as i32) as usize;
                    // Lighter towards one side, a vein in the middle.
                    let vein = if b.abs() < 0.12 { 0.8 } else { 1.0 };
                    texels[y * size + x] = [tone * (1.0 + 0.35 * b) * vein, 255.0];
                }
            }
        }
    }
}

/// A bough seen from the side: leaves within a ragged disc, air between them.
fn leaves(seed: u32) -> Texture {
    let size = 256;
    let mut texels = vec![[45.0, 0.0]; size * size];
    let half = size as f32 / 2.0;
    let inside = |p: [f32; 2]| {
        let (x, y) = ((p[0] - half) / half, (p[1] - half) / half);
        let angle = y.atan2(x);
        let ragged = octaves(angle * 1.9 + 7.0, 3.3, [64, 64], 3, 0.7, seed ^ 5);
        (x * x + y * y).sqrt() < 0.78 + 0.15 * ragged
            && octaves(p[0] / 26.0, p[1] / 26.0, [64, 64], 2, 0.6, seed ^ 6) > -0.55
            && x.abs().max(y.abs()) < 0.93
    };
    scatter(&mut texels, size, 2600, seed, inside);
    Texture::cut_out(size, size, |x, y| texels[y * size + x])
}

fn hedge(seed: u32) -> Texture {
    let size = 256;
    let mut texels = vec![[28.0, 255.0]; size * size];
    scatter(&mut texels, size, 2600, seed, |_| true);
    Texture::opaque(size, size, |x, y| texels[y * size + x][0])
}

/// Rows of tiles 25 cm wide and 33 cm high; 6.4 m wide.
fn roof(seed: u32) -> Texture {
    let base = 62.0 + 60.0 * unit(0, 0, seed);
    tile(256, |x, y| {
        let (x, y) = (x as f32, y as f32);
        let row = (y / 12.8).floor();
        let shift = if (row as i32) % 2 == 0 { 0.0 } else { 5.333 };
        let column = ((x + shift) / 10.667).floor();
        let (fx, fy) = ((x + shift) / 10.667 - column, y / 12.8 - row);
        let own = 22.0 * signed(column as i32 % 24, row as i32, seed ^ 9);
        let round = 22.0 * (std::f32::consts::PI * fx).sin();
        let edge = if fy > 0.85 { -32.0 } else { 0.0 };
        base + own + round + edge + 16.0 * fine(x as usize, y as usize, 256, 6, 4, 0.6, seed)
    })
}

/// Masonry of garden walls and chimneys; 6.4 m wide.
fn wall(seed: u32) -> Texture {
    let (rows, columns) = if unit(1, 0, seed) < 0.5 { (64.0, 26.0) } else { (20.0, 12.0) };
    let base = 85.0 + 50.0 * unit(2, 0, seed);
    tile(256, |x, y| {
        let (sx, sy) = (x as f32 * columns / 256.0, y as f32 * rows / 256.0);
        let row = sy.floor();
        let sx = sx + if (row as i32) % 2 == 0 { 0.0 } else { 0.5 };
        let own = 24.0 * signed(sx.floor() as i32 % columns as i32, row as i32, seed);
        let joint = sy.fract() < 0.15 || sx.fract() < 0.06;
        let tone = base + own + 20.0 * fine(x, y, 256, 5, 6, 0.7, seed ^ 2);
        if joint { tone * 0.7 } else { tone }
    })
}

fn sign(seed: u32) -> Texture {
    let r = |k: i32| unit(k, 3, seed);
    let back = if r(0) < 0.6 { 225.0 } else { 60.0 };
    let mut canvas = Canvas::new(128, 128, [0.8, 0.8], back);
    canvas.frame(Rect::new(0.0, 0.0, 0.8, 0.8), 0.07, 255.0 - back);
    if r(1) < 0.5 {
        canvas.ellipse([0.4, 0.4], [0.26, 0.26], 70.0);
        canvas.ellipse([0.4, 0.4], [0.18, 0.18], 230.0);
        canvas.letters(Rect::new(0.28, 0.3, 0.26, 0.2), 0.14, 30.0, seed);
    } else {
        canvas.letters(Rect::new(0.12, 0.1, 0.6, 0.6), 0.12 + 0.2 * r(2), 255.0 - back, seed);
    }
    canvas.roughen(0.3, 4, 0.6, 7.0, seed);
    canvas.into_texture()
}

/// Broken cumulus on a bright sky, seen from below on a plane.
fn clouds(seed: u32) -> Texture {
    tile(512, |x, y| {
        let n = fine(x, y, 512, 8, 6, 0.58, seed);
        let cover = ((n + 0.15) * 1.8).clamp(0.0, 1.0);
        let shade = fine(x, y, 512, 16, 4, 0.6, seed ^ 11);
        176.0 + cover * (60.0 + 22.0 * shade)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_repeat_without_a_seam() {
        let center = |i: i32| (i << 16) + 0x8000;
        for (material, size) in [(Material::Asphalt, 512), (Material::Hedge, 256), (Material::Clouds, 512)] {
            let level = &material.bake(7).levels[0];
            let step = |x: i32| {
                (0..size)
                    .map(|y| {
                        (level.gray().bilinear(center(x), center(y))
                            - level.gray().bilinear(center(x + 1), center(y)))
                        .abs()
                    })
                    .sum::<i32>()
            };
            let inside = (10..20).map(step).sum::<i32>() / 10;
            assert!(step(size - 1) < 2 * inside, "{material:?}");
        }
    }

    #[test]
    fn boughs_are_neither_full_nor_empty() {
        let level = &Material::Leaves.bake(3).levels[0];
        let center = |i: i32| (i << 16) + 0x8000;
        let opaque = (0..256 * 256)
            .filter(|i| level.alpha().bilinear(center(i % 256), center(i / 256)) >= 128 << 8)
            .count();
        let share = opaque as f64 / 65536.0;
        assert!(share > 0.3 && share < 0.75, "{share}");
    }
}
