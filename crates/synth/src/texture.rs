//! Mip-mapped gray textures that repeat in both directions, with bilinear look-up in fixed point.

/// Index of a texture in the [`Library`](crate::library::Library).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TextureId(pub(crate) u32);

/// One resolution of a texture; width and height are powers of two.
#[derive(Clone, Debug)]
pub(crate) struct Level {
    shift: u32,
    width_mask: i32,
    height_mask: i32,
    /// Texels from a row to the next: one more than the width.
    stride: i32,
    /// Rows and columns followed by the first one again, so that a look-up needs no wrap inside, and [`PADDING`] bytes.
    gray: Vec<u8>,
    /// Opacity per texel, likewise; empty when the texture is opaque.
    alpha: Vec<u8>,
}

/// Bytes after the last texel, so that four bytes can be read from any texel's index.
const PADDING: usize = 2;

/// The gray values or the opacities of a level, made only by [`Level::gray`] and [`Level::alpha`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane<'a> {
    pub(crate) shift: u32,
    pub(crate) width_mask: i32,
    pub(crate) height_mask: i32,
    pub(crate) stride: i32,
    texels: &'a [u8],
}

/// A pyramid of levels, the finest first.
#[derive(Clone, Debug)]
pub(crate) struct Texture {
    pub(crate) levels: Vec<Level>,
}

impl Texture {
    /// Bakes `gray(x, y)` (gray levels, clamped to 0..255) at texel indices; sizes must be powers of two.
    pub(crate) fn opaque(width: usize, height: usize, gray: impl Fn(usize, usize) -> f32) -> Self {
        let gray = (0..width * height).map(|i| gray(i % width, i / width)).collect();
        Self::build(width, height, gray, Vec::new())
    }

    /// Bakes gray and opacity (0..255); coarser levels keep the share of texels that pass the test `alpha >= 128`.
    pub(crate) fn cut_out(width: usize, height: usize, texel: impl Fn(usize, usize) -> [f32; 2]) -> Self {
        let texels: Vec<[f32; 2]> = (0..width * height).map(|i| texel(i % width, i / width)).collect();
        let gray = texels.iter().map(|t| t[0]).collect();
        Self::build(width, height, gray, texels.iter().map(|t| t[1]).collect())
    }

    fn build(width: usize, height: usize, mut gray: Vec<f32>, mut alpha: Vec<f32>) -> Self {
        assert!(width.is_power_of_two() && height.is_power_of_two(), "texture sides are powers of two");
        let coverage = share_opaque(&alpha, 128.0);
        let (mut w, mut h, mut shift) = (width, height, 0);
        let mut levels = Vec::new();
        loop {
            levels.push(Level::new(w, h, shift, &gray, &keep_coverage(&alpha, coverage)));
            if w == 1 && h == 1 {
                return Self { levels };
            }
            (gray, alpha, w, h) = halve(&gray, &alpha, w, h);
            shift += 1;
        }
    }
}

impl Level {
    fn new(width: usize, height: usize, shift: u32, gray: &[f32], alpha: &[f32]) -> Self {
        let quantize = |values: &[f32]| -> Vec<u8> {
            if values.is_empty() {
                return Vec::new();
            }
            let texel = |i: usize| {
                let (x, y) = (i % (width + 1) % width, i / (width + 1) % height);
                (values[y * width + x] + 0.5).clamp(0.0, 255.0) as u8
            };
            (0..(width + 1) * (height + 1)).map(texel).chain([0; PADDING]).collect()
        };
        Self {
            shift,
            width_mask: width as i32 - 1,
            height_mask: height as i32 - 1,
            stride: width as i32 + 1,
            gray: quantize(gray),
            alpha: quantize(alpha),
        }
    }

    /// The gray values.
    pub(crate) fn gray(&self) -> Plane<'_> {
        self.plane(&self.gray)
    }

    /// The opacities; opaque textures have none and must not be asked.
    pub(crate) fn alpha(&self) -> Plane<'_> {
        assert!(!self.alpha.is_empty(), "an opaque texture has no opacities");
        self.plane(&self.alpha)
    }

    fn plane<'a>(&self, texels: &'a [u8]) -> Plane<'a> {
        let Self { shift, width_mask, height_mask, stride, .. } = *self;
        Plane { shift, width_mask, height_mask, stride, texels }
    }
}

impl Plane<'_> {
    /// `stride` texels for each of height + 1 rows, and at least two bytes more.
    pub(crate) fn texels(&self) -> &[u8] {
        self.texels
    }

    /// Bilinear value times 256 at (`u`, `v`) in 16.16 fixed-point texels of the finest level.
    #[inline(always)]
    pub(crate) fn bilinear(&self, u: i32, v: i32) -> i32 {
        // Texel centers lie at half integers.
        let (u, v) = ((u >> self.shift).wrapping_sub(0x8000), (v >> self.shift).wrapping_sub(0x8000));
        let (fu, fv) = ((u >> 8) & 0xff, (v >> 8) & 0xff);
        let (x, y) = ((u >> 16) & self.width_mask, (v >> 16) & self.height_mask);
        let upper = (y * self.stride + x) as usize;
        let lower = upper + self.stride as usize;
        let ([a, b], [c, d]) = (two(self.texels, upper), two(self.texels, lower));
        // Both rows at once: a product is below 2^16.
        let (left, right) = (a | (c << 16), b | (d << 16));
        let rows = left * (256 - fu as u32) + right * fu as u32;
        let (top, bottom) = ((rows & 0xffff) as i32, (rows >> 16) as i32);
        (top * (256 - fv) + bottom * fv) >> 8
    }
}

/// Two neighboring texels.
#[inline(always)]
fn two(data: &[u8], at: usize) -> [u32; 2] {
    let pair = &data[at..at + 2];
    [u32::from(pair[0]), u32::from(pair[1])]
}

/// Halves both sides (a side of one stays); gray is averaged by opacity so that hidden texels leave no fringe.
fn halve(gray: &[f32], alpha: &[f32], w: usize, h: usize) -> (Vec<f32>, Vec<f32>, usize, usize) {
    let (w2, h2) = ((w / 2).max(1), (h / 2).max(1));
    let (mut gray2, mut alpha2) = (Vec::with_capacity(w2 * h2), Vec::new());
    for y in 0..h2 {
        for x in 0..w2 {
            let (xs, ys) = ([(2 * x) % w, (2 * x + 1) % w], [(2 * y) % h, (2 * y + 1) % h]);
            let (mut sum, mut weight, mut opacity) = (0.0, 0.0, 0.0);
            for i in [ys[0] * w + xs[0], ys[0] * w + xs[1], ys[1] * w + xs[0], ys[1] * w + xs[1]] {
                let a = alpha.get(i).map_or(255.0, |a| a.clamp(0.0, 255.0)) + 0.5;
                sum += a * gray[i];
                weight += a;
                opacity += alpha.get(i).copied().unwrap_or(255.0) / 4.0;
            }
            gray2.push(sum / weight);
            if !alpha.is_empty() {
                alpha2.push(opacity);
            }
        }
    }
    (gray2, alpha2, w2, h2)
}

fn share_opaque(alpha: &[f32], threshold: f32) -> f32 {
    alpha.iter().filter(|a| **a >= threshold).count() as f32 / alpha.len().max(1) as f32
}

/// Scales opacities so that the share that passes the test stays `coverage`: distant crowns do not thin out.
fn keep_coverage(alpha: &[f32], coverage: f32) -> Vec<f32> {
    if alpha.is_empty() {
        return Vec::new();
    }
    let mut sorted = alpha.to_vec();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let rank = ((coverage * sorted.len() as f32).round() as usize).min(sorted.len() - 1);
    let threshold = sorted[rank].clamp(8.0, 250.0);
    alpha.iter().map(|a| a * 128.0 / threshold).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bilinear_reproduces_texels_and_midpoints() {
        let t = Texture::opaque(4, 2, |x, y| (40 * x + 10 * y) as f32);
        let center = |i: i32| (i << 16) + 0x8000;
        assert_eq!(t.levels[0].gray().bilinear(center(2), center(1)), 90 * 256);
        assert_eq!(t.levels[0].gray().bilinear(center(2) + 0x8000, center(1)), 110 * 256);
        assert_eq!(t.levels[0].gray().bilinear(center(2 + 4), center(1 - 2)), 90 * 256);
    }

    #[test]
    fn levels_keep_the_mean_and_end_at_one_texel() {
        let t = Texture::opaque(64, 16, |x, y| ((x * 37 + y * 91) % 200) as f32);
        let mean = |l: &Level| {
            let center = |i: i32| ((i << 16) + 0x8000) << l.shift;
            let texels = (0..=l.height_mask).flat_map(|y| (0..=l.width_mask).map(move |x| (x, y)));
            let sum: i32 = texels.map(|(x, y)| l.gray().bilinear(center(x), center(y))).sum();
            f64::from(sum) / 256.0 / f64::from((l.width_mask + 1) * (l.height_mask + 1))
        };
        assert_eq!(t.levels.len(), 7);
        assert_eq!((t.levels[6].width_mask, t.levels[6].height_mask), (0, 0));
        assert!((mean(&t.levels[0]) - mean(&t.levels[6])).abs() < 2.0);
    }

    #[test]
    fn coarse_levels_stay_as_opaque_as_the_finest() {
        let t = Texture::cut_out(64, 64, |x, y| {
            [100.0, if crate::noise::unit(x as i32, y as i32, 1) < 0.3 { 255.0 } else { 0.0 }]
        });
        for level in &t.levels[..4] {
            let share = level.alpha.iter().filter(|a| **a >= 128).count() as f64 / level.alpha.len() as f64;
            assert!((share - 0.3).abs() < 0.12, "{share}");
        }
    }
}
