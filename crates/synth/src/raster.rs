//! Scan conversion of one band of rows: depth test per sample, perspective-correct texture every 16 samples, affine between.
//!
//! Each pixel has 2x2 samples. A sample reads the texture with one bilinear look-up per tap; the level of detail is dithered over the
//! four samples, so that the pixel's mean blends neighbouring levels, and up to four taps follow the long axis of the footprint.

use crate::camera::{Prepared, SAMPLES, WIDTH};
use crate::library::Library;
use crate::mesh::SurfaceKind;
use crate::texture::Texture;

/// Samples between two exact perspective divisions.
const CHUNK: usize = 16;
/// Most texture taps along the footprint's long axis.
const MAX_TAPS: usize = 4;
/// Rounding of the level of detail for even and odd columns, by row parity.
const DITHER: [[f32; 2]; 2] = [[0.125, 0.625], [0.875, 0.375]];
/// Added to the level of detail; the four samples of a pixel are averaged, so a sample may be sharper than its own footprint.
const LOD_BIAS: f32 = -0.15;
/// Coarser detail levels are flat and are not read.
const MAX_DETAIL_LEVEL: usize = 5;
/// Distance at which half of a colour is haze, metres, and the haze's grey value times 256.
const HAZE_M: f32 = 900.0;
const HAZE: f32 = 205.0 * 256.0;

const STRIDE: usize = WIDTH * SAMPLES;

/// Sample buffers of a band of rows.
pub(crate) struct Band {
    first: i32,
    rows: usize,
    inv_z: Vec<f32>,
    /// Grey value times 256.
    tone: Vec<u16>,
    /// Index of the polygon seen.
    pub(crate) polygon: Vec<u32>,
}

/// Texture access of one chunk.
struct Lookup<'a> {
    base: [&'a crate::texture::Level; 2],
    detail: Option<[&'a crate::texture::Level; 2]>,
    taps: usize,
    /// Fixed-point start, step per sample and offset between taps in u and v; the same for the detail texture.
    base_at: Walk,
    detail_at: Walk,
    scale: f32,
    haze: f32,
}

/// A line through a texture in 16.16 texels.
#[derive(Clone, Copy, Default)]
struct Walk {
    start: [i32; 2],
    step: [i32; 2],
    tap_first: [i32; 2],
    tap_step: [i32; 2],
}

impl Band {
    /// Buffers for at most `rows` pixel rows.
    pub(crate) fn new(rows: usize) -> Self {
        let n = rows * SAMPLES * STRIDE;
        Self { first: 0, rows: 0, inv_z: vec![0.0; n], tone: vec![0; n], polygon: vec![0; n] }
    }

    /// Empties the band and moves it to pixel rows `first..first + rows`.
    pub(crate) fn start(&mut self, first: usize, rows: usize) {
        (self.first, self.rows) = ((first * SAMPLES) as i32, rows * SAMPLES);
        self.inv_z.fill(0.0);
        self.tone.fill(0);
        self.polygon.fill(0);
    }

    /// Mean tone (grey value times 256) of each pixel of a row of the band.
    pub(crate) fn resolve(&self, row: usize, out: &mut [u16]) {
        let upper = &self.tone[row * SAMPLES * STRIDE..][..STRIDE];
        let lower = &self.tone[(row * SAMPLES + 1) * STRIDE..][..STRIDE];
        for ((out, a), b) in out.iter_mut().zip(upper.chunks_exact(2)).zip(lower.chunks_exact(2)) {
            let sum = u32::from(a[0]) + u32::from(a[1]) + u32::from(b[0]) + u32::from(b[1]);
            *out = (sum / 4) as u16;
        }
    }

    /// The polygon that most samples of a pixel see; among equals the nearest.
    pub(crate) fn winner(&self, row: usize, x: usize) -> u32 {
        let upper = row * SAMPLES * STRIDE + x * SAMPLES;
        let seen = [upper, upper + 1, upper + STRIDE, upper + STRIDE + 1];
        let votes = |i: usize| seen.iter().filter(|j| self.polygon[**j] == self.polygon[i]).count();
        let mut best = seen[0];
        for i in &seen[1..] {
            let more = votes(*i).cmp(&votes(best));
            if more.is_gt() || (more.is_eq() && self.inv_z[*i] > self.inv_z[best]) {
                best = *i;
            }
        }
        self.polygon[best]
    }

    /// Draws polygon number `index`.
    pub(crate) fn draw(&mut self, polygon: &Prepared, index: u32, library: &Library) {
        let last = self.first + self.rows as i32;
        if polygon.bottom <= f64::from(self.first) || polygon.top >= f64::from(last) {
            return;
        }
        let from = (polygon.top.ceil().max(f64::from(self.first))) as i32;
        let to = (polygon.bottom.ceil().min(f64::from(last))) as i32;
        let cut_out = polygon.kind == SurfaceKind::CutOut;
        for row in from..to {
            let (left, right) = polygon.columns(row);
            let mut x = left;
            while x < right {
                let n = ((right - x) as usize).min(CHUNK);
                let mask = self.test_depth(polygon, row, x, n);
                if mask != 0 {
                    let lookup = Lookup::new(polygon, row, x, n, library);
                    let at = (row - self.first) as usize * STRIDE + x as usize;
                    match (cut_out, lookup.detail.is_some()) {
                        (false, false) => self.fill::<false, false>(polygon, &lookup, index, at, n, mask),
                        (false, true) => self.fill::<false, true>(polygon, &lookup, index, at, n, mask),
                        (true, false) => self.fill::<true, false>(polygon, &lookup, index, at, n, mask),
                        (true, true) => self.fill::<true, true>(polygon, &lookup, index, at, n, mask),
                    }
                }
                x += n as i32;
            }
        }
    }

    /// Inverse depth at the first sample of a chunk and its step, as the depth test sees them.
    fn inv_z_line(polygon: &Prepared, row: i32, x: i32) -> (f32, f32) {
        let [c, dx, dy] = polygon.inv_z.map(|k| k * polygon.bias);
        ((c + dx * f64::from(x) + dy * f64::from(row)) as f32, dx as f32)
    }

    /// Bit k is set when sample x + k is nearer than what is there.
    fn test_depth(&self, polygon: &Prepared, row: i32, x: i32, n: usize) -> u32 {
        let (start, step) = Self::inv_z_line(polygon, row, x);
        let at = (row - self.first) as usize * STRIDE + x as usize;
        let mut mask = 0;
        for (k, there) in self.inv_z[at..at + n].iter().enumerate() {
            mask |= u32::from(start + step * k as f32 > *there) << k;
        }
        mask
    }

    #[inline(always)]
    fn fill<const CUT_OUT: bool, const DETAIL: bool>(
        &mut self,
        polygon: &Prepared,
        lookup: &Lookup<'_>,
        index: u32,
        at: usize,
        n: usize,
        mask: u32,
    ) {
        let row = self.first + (at / STRIDE) as i32;
        let (start, step) = Self::inv_z_line(polygon, row, (at % STRIDE) as i32);
        let inv_z = &mut self.inv_z[at..at + n];
        let tone = &mut self.tone[at..at + n];
        let seen = &mut self.polygon[at..at + n];
        for k in 0..n {
            if mask >> k & 1 == 0 || (CUT_OUT && !lookup.is_opaque(k)) {
                continue;
            }
            inv_z[k] = start + step * k as f32;
            tone[k] = (lookup.gray::<DETAIL>(k) as f32 * lookup.scale + lookup.haze) as u16;
            seen[k] = index;
        }
    }
}

impl<'a> Lookup<'a> {
    fn new(polygon: &Prepared, row: i32, x: i32, n: usize, library: &'a Library) -> Self {
        let (x0, y) = (f64::from(x), f64::from(row));
        let at = |f: &[f64; 3], x: f64| f[0] + f[1] * x + f[2] * y;
        let uv = |x: f64| {
            let z = 1.0 / at(&polygon.inv_z, x).max(1e-7);
            ([at(&polygon.u_over_z, x) * z, at(&polygon.v_over_z, x) * z], z)
        };
        let (first, z_first) = uv(x0);
        let (last, z_last) = uv(x0 + n as f64);
        let step = [0, 1].map(|i| (last[i] - first[i]) / n as f64);
        let z = 0.5 * (z_first + z_last);
        let middle = [0, 1].map(|i| 0.5 * (first[i] + last[i]));
        let over_z = [&polygon.u_over_z, &polygon.v_over_z];
        let per = |axis: usize| {
            [0, 1].map(|i| ((over_z[i][axis] - middle[i] * polygon.inv_z[axis]) * z) as f32)
        };
        let footprint = Footprint::new(per(1), per(2));
        let parity = [(x & 1) as usize, 1 - (x & 1) as usize];
        let row_dither = DITHER[(row & 1) as usize];
        let levels = |texture: &'a Texture, lod: f32| {
            let finest = |column: usize| ((lod + row_dither[parity[column]]).max(0.0) as usize).min(texture.levels.len() - 1);
            [&texture.levels[finest(0)], &texture.levels[finest(1)]]
        };
        let (detail, detail_at) = match polygon.detail {
            None => (None, Walk::default()),
            Some((id, ratio)) => {
                let lod = footprint.lod + (ratio[0].max(ratio[1]) as f32).log2();
                let near = lod < MAX_DETAIL_LEVEL as f32;
                let walk = if near { Walk::new(first, step, &footprint, ratio) } else { Walk::default() };
                (near.then(|| levels(library.texture(id), lod)), walk)
            }
        };
        let fog = if polygon.kind == SurfaceKind::Emissive { 0.0 } else { z as f32 / (z as f32 + HAZE_M) };
        Self {
            base: levels(library.texture(polygon.texture), footprint.lod),
            detail,
            taps: footprint.taps,
            base_at: Walk::new(first, step, &footprint, [1.0; 2]),
            detail_at,
            scale: polygon.gain * (1.0 - fog) / footprint.taps as f32,
            haze: HAZE * fog,
        }
    }

    #[inline(always)]
    fn is_opaque(&self, k: usize) -> bool {
        let [u, v] = self.base_at.at(k);
        self.base[k & 1].alpha(u, v) >= 128 << 8
    }

    /// Grey value times 256, summed over the taps.
    #[inline(always)]
    fn gray<const DETAIL: bool>(&self, k: usize) -> i32 {
        let (walk, fine) = (&self.base_at, &self.detail_at);
        let ([mut u, mut v], [mut du, mut dv]) = (walk.at(k), fine.at(k));
        if self.taps > 1 {
            (u, v) = (u.wrapping_add(walk.tap_first[0]), v.wrapping_add(walk.tap_first[1]));
            (du, dv) = (du.wrapping_add(fine.tap_first[0]), dv.wrapping_add(fine.tap_first[1]));
        }
        let mut sum = 0;
        for _ in 0..self.taps {
            sum += self.base[k & 1].gray(u, v);
            (u, v) = (u.wrapping_add(walk.tap_step[0]), v.wrapping_add(walk.tap_step[1]));
            if DETAIL {
                if let Some(detail) = &self.detail {
                    sum += detail[k & 1].gray(du, dv) - (128 << 8);
                }
                (du, dv) = (du.wrapping_add(fine.tap_step[0]), dv.wrapping_add(fine.tap_step[1]));
            }
        }
        sum
    }
}

impl Walk {
    fn new(start: [f64; 2], step: [f64; 2], footprint: &Footprint, ratio: [f64; 2]) -> Self {
        // Truncated to 32 bits: textures repeat after a power of two texels, so that the lost bits do not matter.
        let fixed = |texels: f64| (texels * 65536.0) as i64 as i32;
        let axis = |i: usize| f64::from(footprint.axis[i]) * ratio[i] / footprint.taps as f64;
        let first = 0.5 * (1.0 - footprint.taps as f64);
        Self {
            start: [0, 1].map(|i| fixed(start[i] * ratio[i])),
            step: [0, 1].map(|i| fixed(step[i] * ratio[i])),
            tap_first: [0, 1].map(|i| fixed(first * axis(i))),
            tap_step: [0, 1].map(|i| fixed(axis(i))),
        }
    }

    #[inline(always)]
    fn at(&self, k: usize) -> [i32; 2] {
        [0, 1].map(|i| self.start[i].wrapping_add(self.step[i].wrapping_mul(k as i32)))
    }
}

/// The parallelogram of texels under one sample.
struct Footprint {
    lod: f32,
    taps: usize,
    /// Its longer side, texels.
    axis: [f32; 2],
}

impl Footprint {
    /// From the texture's change per sample in x and in y; the singular values of that 2x2 matrix are the footprint's half axes.
    fn new(per_x: [f32; 2], per_y: [f32; 2]) -> Self {
        let (x_sq, y_sq) = (per_x[0] * per_x[0] + per_x[1] * per_x[1], per_y[0] * per_y[0] + per_y[1] * per_y[1]);
        let area = (per_x[0] * per_y[1] - per_x[1] * per_y[0]).abs();
        let sum = x_sq + y_sq;
        let long = (0.5 * (sum + (sum * sum - 4.0 * area * area).max(0.0).sqrt())).sqrt().max(1e-6);
        let short = area / long;
        let taps = if long <= 1.0 { 1 } else { ((long / short.max(0.5)) as usize).clamp(1, MAX_TAPS) };
        let lod = (long / taps as f32).max(short).log2() + LOD_BIAS;
        Self { lod, taps, axis: if x_sq > y_sq { per_x } else { per_y } }
    }
}
