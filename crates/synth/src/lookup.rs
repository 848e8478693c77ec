//! Texture access along a stretch of a row: perspective-correct to second order, level of detail and taps from the footprint.

use crate::camera::Prepared;
use crate::kernel::{self, LANES, Walk};
use crate::library::Library;
use crate::mesh::SurfaceKind;
use crate::texture::{Level, Texture};

/// Most texture taps along the footprint's long axis.
const MAX_TAPS: usize = 4;
/// Share of the footprint's elongation that taps make up for.
const TAPS_PER_RATIO: f32 = 0.55;
/// Rounding of the level of detail in even and odd sample rows: a pixel's mean blends neighboring levels.
const DITHER: [f32; 2] = [0.25, 0.75];
/// Added to the level of detail; a pixel averages two rows of samples, so each may be sharper than its own footprint.
const LOD_BIAS: f32 = -0.5;
/// Coarser detail levels are flat and are not read.
const MAX_DETAIL_LEVEL: f32 = 4.5;

/// How to color the pairs of samples of a stretch.
pub(crate) struct Lookup<'a> {
    base: &'a Level,
    base_at: Walk,
    detail: Option<(&'a Level, Walk)>,
    taps: usize,
    scale: f32,
    haze: f32,
}

/// Texture coordinates at the first pair and their first and second differences from pair to pair.
struct Curve {
    start: [f64; 2],
    step: [f64; 2],
    bend: [f64; 2],
}

impl<'a> Lookup<'a> {
    /// For pairs of samples `pairs.0..pairs.1` (pair p holds samples 2 p and 2 p + 1) of a sample row.
    pub(crate) fn new(polygon: &Prepared, row: i32, pairs: (i32, i32), library: &'a Library) -> Self {
        let y = f64::from(row);
        let at = |f: &[f64; 3], x: f64| f[0] + f[1] * x + f[2] * y;
        let point = |x: f64| {
            let z = 1.0 / at(&polygon.planes.inv_z, x).max(1e-7);
            ([at(&polygon.planes.u_over_z, x) * z, at(&polygon.planes.v_over_z, x) * z], z)
        };
        // Exact at the first pair's center, in the middle and at the end.
        let n = f64::from(pairs.1 - pairs.0);
        let x0 = 2.0 * f64::from(pairs.0) + 0.5;
        let ([first, middle, last], z) = {
            let (a, m, b) = (point(x0), point(x0 + n), point(x0 + 2.0 * n));
            ([a.0, m.0, b.0], m.1)
        };
        let bend = [0, 1].map(|i| 4.0 * (first[i] - 2.0 * middle[i] + last[i]) / (n * n));
        let step = [0, 1].map(|i| (last[i] - first[i]) / n - 0.5 * bend[i] * (n - 1.0));
        let curve = Curve { start: first, step, bend };
        let over_z = [&polygon.planes.u_over_z, &polygon.planes.v_over_z];
        let per = |axis: usize, samples: f64| {
            [0, 1].map(|i| (samples * (over_z[i][axis] - middle[i] * polygon.planes.inv_z[axis]) * z) as f32)
        };
        let footprint = Footprint::new(per(1, 2.0), per(2, 1.0));
        let dither = DITHER[(row & 1) as usize];
        let detail = polygon.surface.detail.and_then(|(id, ratio)| {
            // One tap is enough for grain.
            let lod = footprint.smooth_lod + log2(ratio[0].max(ratio[1]) as f32);
            let walk = || curve.walk(&Footprint { taps: 1, ..footprint }, ratio);
            (lod < MAX_DETAIL_LEVEL).then(|| (level(library.texture(id), lod + dither), walk()))
        });
        let haze = polygon.haze;
        let fog = if polygon.surface.kind == SurfaceKind::Emissive {
            0.0
        } else {
            z as f32 / (z as f32 + haze.half_m)
        };
        Self {
            base: level(library.texture(polygon.surface.texture), footprint.lod + dither),
            base_at: curve.walk(&footprint, [1.0; 2]),
            detail,
            taps: footprint.taps,
            scale: polygon.gain * (1.0 - fog) / footprint.taps as f32,
            haze: haze.tone * fog,
        }
    }

    /// Gray values times 256 of the first `n` pairs.
    #[inline]
    pub(crate) fn tones(&self, n: usize) -> [u16; LANES] {
        let mut sums = kernel::sums(self.base.gray(), &self.base_at, self.taps, n);
        if let Some((level, walk)) = &self.detail {
            let grain = kernel::sums(level.gray(), walk, 1, n);
            for (sum, grain) in sums.iter_mut().zip(&grain) {
                *sum = sum.wrapping_add((grain - (128 << 8)).wrapping_mul(self.taps as i32));
            }
        }
        sums.map(|sum| (sum as f32 * self.scale + self.haze) as u16)
    }

    /// Whether the two samples of each of the first `n` pairs are hit, for textures with opacity.
    pub(crate) fn opacity(&self, n: i32) -> [[bool; 2]; LANES] {
        let walk = Walk { tap_step: [0; 2], ..self.base_at };
        // A quarter of a pair's step before and after its center.
        let aside = walk.step.map(|step| step >> 2);
        let [before, after] = [-1, 1].map(|sign| {
            let walk = Walk { tap_first: aside.map(|a| a.wrapping_mul(sign)), ..walk };
            kernel::sums(self.base.alpha(), &walk, 1, n as usize)
        });
        std::array::from_fn(|k| [before[k] >= 128 << 8, after[k] >= 128 << 8])
    }
}

fn level(texture: &Texture, lod: f32) -> &Level {
    &texture.levels[(lod.max(0.0) as usize).min(texture.levels.len() - 1)]
}

/// Binary logarithm to 0.09: exponent and linear mantissa; the same on every machine.
fn log2(x: f32) -> f32 {
    let bits = x.max(f32::MIN_POSITIVE).to_bits();
    (bits as f32) * (1.0 / (1 << 23) as f32) - 127.0
}

impl Curve {
    /// In fixed point, `ratio` times as fine.
    fn walk(&self, footprint: &Footprint, ratio: [f64; 2]) -> Walk {
        // Truncated to 32 bits: textures repeat after a power of two texels, so that the lost bits do not matter.
        let fixed = |texels: f64| (texels * 65536.0) as i64 as i32;
        let axis = |i: usize| f64::from(footprint.axis[i]) * ratio[i] / footprint.taps as f64;
        let first = 0.5 * (1.0 - footprint.taps as f64);
        Walk {
            start: [0, 1].map(|i| fixed(self.start[i] * ratio[i])),
            step: [0, 1].map(|i| fixed(self.step[i] * ratio[i])),
            bend: [0, 1].map(|i| fixed(self.bend[i] * ratio[i])),
            tap_first: [0, 1].map(|i| fixed(first * axis(i))),
            tap_step: [0, 1].map(|i| fixed(axis(i))),
        }
    }
}

/// The parallelogram of texels under a pair of samples.
#[derive(Clone, Copy)]
struct Footprint {
    lod: f32,
    /// Level of detail for a single tap.
    smooth_lod: f32,
    taps: usize,
    /// Its longer side, texels.
    axis: [f32; 2],
}

impl Footprint {
    /// From the texture's change over the width and the height of a pair; the singular values of that 2x2 matrix are the footprint's
    /// axes.
    fn new(across: [f32; 2], down: [f32; 2]) -> Self {
        let (x_sq, y_sq) =
            (across[0] * across[0] + across[1] * across[1], down[0] * down[0] + down[1] * down[1]);
        let area = (across[0] * down[1] - across[1] * down[0]).abs();
        let sum = x_sq + y_sq;
        let long = (0.5 * (sum + (sum * sum - 4.0 * area * area).max(0.0).sqrt())).sqrt().max(1e-6);
        let short = area / long;
        let wanted = (TAPS_PER_RATIO * long / short.max(0.7) + 0.5) as usize;
        let taps = wanted.clamp(1, MAX_TAPS);
        let lod = log2((long / taps as f32).max(short)) + LOD_BIAS;
        let smooth_lod = log2((0.6 * long).max(short)) + LOD_BIAS;
        Self { lod, smooth_lod, taps, axis: if x_sq > y_sq { across } else { down } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parabola_passes_through_all_pairs_of_a_slanted_wall() {
        // u = a / (b + c x): as on a wall that recedes by a seventh over the stretch.
        let exact = |x: f64| 4000.0 / (10.0 + 0.05 * x);
        let n = 16.0;
        let (first, middle, last) = (exact(0.5), exact(0.5 + n), exact(0.5 + 2.0 * n));
        let bend = 4.0 * (first - 2.0 * middle + last) / (n * n);
        let step = (last - first) / n - 0.5 * bend * (n - 1.0);
        let curve = Curve { start: [first; 2], step: [step; 2], bend: [bend; 2] };
        let footprint = Footprint { lod: 0.0, smooth_lod: 0.0, taps: 1, axis: [0.0; 2] };
        let walk = curve.walk(&footprint, [1.0; 2]);
        for pair in 0..16 {
            let u = f64::from(walk.at(pair)[0]) / 65536.0;
            let wanted = exact(0.5 + 2.0 * f64::from(pair));
            // Two hundredths of a pixel, which is 4 texels wide here.
            assert!((u - wanted).abs() < 0.08, "{pair}: {u} {wanted}");
        }
    }

    #[test]
    fn long_footprints_take_more_taps_and_stay_sharp() {
        let square = Footprint::new([2.0, 0.0], [0.0, 2.0]);
        let long = Footprint::new([8.0, 0.0], [0.0, 2.0]);
        assert_eq!((square.taps, long.taps), (1, 2));
        assert!(
            (square.lod - 0.5).abs() < 0.1 && (long.lod - 1.5).abs() < 0.1,
            "{} {}",
            square.lod,
            long.lod
        );
        assert_eq!(Footprint::new([0.1, 0.0], [0.0, 0.1]).taps, 1);
    }

    #[test]
    fn log2_is_close() {
        for i in 1..200 {
            let x = 0.07 * i as f32;
            assert!((log2(x) - x.log2()).abs() < 0.09, "{x}");
        }
    }
}
