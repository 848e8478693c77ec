//! Sums of the normal equations of a patch alignment, in integers, so that the order of summation does not matter.

#[cfg(target_arch = "x86_64")]
use crate::kernels::avx2;
use crate::plane::Plane;
use simd::Simd;
use simd::Task;

/// Half side of the patch in pixels; rows are computed as 16 lanes of which the last has no weight.
pub(crate) const HALF: usize = 7;
/// Rows of the patch, and columns with weight.
pub(crate) const SIDE: usize = 2 * HALF + 1;
/// Lanes of a row.
pub(crate) const LANES: usize = 16;
/// Pixels left of the patch that its derivative needs, with the patch's half: the distance to keep from the left edge.
pub(crate) const MARGIN: usize = HALF + 1;
/// Units of brightness per gray level.
pub(crate) const ONE: i32 = 128;
/// Largest difference that counts, in units of brightness; pixels with more have no weight.
pub(crate) const LIMIT: i32 = 64 * ONE - 1;
/// Units of the derivative along the row per gray level and pixel.
const ONE_SLOPE: i32 = 8;
/// Standard deviation of the patch's weights, pixels.
const SIGMA_PX: f64 = 5.0;

/// A patch of the left image.
#[derive(Debug, PartialEq)]
pub(crate) struct Patch {
    /// Brightness, 128 per gray level.
    pub(crate) values: [[i16; LANES]; SIDE],
    /// Derivative along the row, 8 per gray level and pixel.
    pub(crate) gradients: [[i16; LANES]; SIDE],
    /// Mean absolute deviation from the mean, gray levels.
    pub(crate) contrast: f64,
}

/// Where a row of the patch lies in the right image: between `pixels[i]` and `pixels[i + 1]`, `fraction` / 128 of the way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row<'a> {
    pub(crate) pixels: &'a [u8],
    pub(crate) fraction: i16,
}

/// Weighted sums over the patch; `j` is the row relative to the middle, `g` the derivative of the left patch, `e` the
/// difference right + offset - left, in gray levels and pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sums {
    pub(crate) gg: f64,
    pub(crate) jgg: f64,
    pub(crate) jjgg: f64,
    pub(crate) g: f64,
    pub(crate) jg: f64,
    pub(crate) one: f64,
    pub(crate) ge: f64,
    pub(crate) jge: f64,
    pub(crate) e: f64,
    pub(crate) abs: f64,
}

/// The same in integers. `m = 8 - j` counts the rows from below; `_2` are sums weighted by `m (m + 1) / 2`, `_1` by `m`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct IntegerSums {
    pub(crate) gg: [i64; 3],
    pub(crate) g: [i64; 2],
    pub(crate) ge: [i64; 2],
    pub(crate) one: i64,
    pub(crate) e: i64,
    pub(crate) abs: i64,
}

impl Patch {
    /// The patch around `(x, y)`.
    ///
    /// # Panics
    /// Nearer than [`MARGIN`] to an edge.
    pub(crate) fn new(simd: Simd, image: &Plane, x: usize, y: usize) -> Self {
        assert!(x >= MARGIN && y >= HALF && x + MARGIN < image.width() && y + HALF < image.height());
        simd.run(Cut { image, x, y })
    }
}

struct Cut<'a> {
    image: &'a Plane,
    x: usize,
    y: usize,
}

impl Task for Cut<'_> {
    type Output = Patch;

    #[inline(always)]
    fn run(self) -> Patch {
        let Self { image, x, y } = self;
        let mut patch = Patch { values: [[0; LANES]; SIDE], gradients: [[0; LANES]; SIDE], contrast: 0.0 };
        let mut sum = 0;
        for j in 0..SIDE {
            let pixels = &image.row(y + j - HALF)[x - MARGIN..x - MARGIN + LANES + 2];
            for i in 0..LANES {
                patch.values[j][i] = i16::from(pixels[i + 1]) * ONE as i16;
                patch.gradients[j][i] =
                    (i16::from(pixels[i + 2]) - i16::from(pixels[i])) * (ONE_SLOPE / 2) as i16;
                sum += i32::from(pixels[i + 1]);
            }
        }
        let n = (SIDE * LANES) as i32;
        let mean = sum * ONE / n;
        let mut deviation = 0;
        for row in &patch.values {
            for value in row {
                deviation += (i32::from(*value) - mean).abs();
            }
        }
        patch.contrast = f64::from(deviation) / f64::from(n * ONE);
        patch
    }
}

/// The sums for the patch against `rows` with `offset`, 128 per gray level, added to them. Without `robust` all pixels have
/// their Gaussian weight, otherwise that times `1 - (e / 64)^2`.
///
/// # Panics
/// When a row has fewer than 17 pixels.
pub(crate) fn sums(simd: Simd, patch: &Patch, rows: &[Row<'_>; SIDE], offset: i16, robust: bool) -> Sums {
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = simd.avx2() {
        return scaled(&avx2::normal::sums(token, patch, rows, offset, robust));
    }
    let _ = simd;
    let mut sums = IntegerSums::default();
    for (j, row) in rows.iter().enumerate() {
        let m = (SIDE - j) as i64;
        for (i, gauss) in WEIGHTS[j].iter().enumerate() {
            let [a, b] = [0, 1].map(|k| i32::from(row.pixels[i + k]));
            let right = a * ONE + (b - a) * i32::from(row.fraction);
            let e = saturate(saturate(right + i32::from(offset)) - i32::from(patch.values[j][i]));
            let e = e.clamp(-LIMIT, LIMIT);
            let trust = if robust { saturate(32767 - product(4 * e, 4 * e)) } else { 32767 };
            let weight = product(trust, i32::from(*gauss));
            let g = i32::from(patch.gradients[j][i]);
            let wg = product(weight, g);
            let weight = weight >> 3;
            let [gg, ge, wg] = [wg * g, wg * e, wg].map(i64::from);
            sums.gg[0] += gg;
            sums.gg[1] += m * gg;
            sums.gg[2] += m * (m + 1) / 2 * gg;
            sums.g[0] += wg;
            sums.g[1] += m * wg;
            sums.ge[0] += ge;
            sums.ge[1] += m * ge;
            sums.one += i64::from(weight);
            sums.e += i64::from(weight * e);
            sums.abs += i64::from(weight * e.abs());
        }
    }
    scaled(&sums)
}

fn saturate(value: i32) -> i32 {
    value.clamp(i32::from(i16::MIN), i32::from(i16::MAX))
}

/// The product of two numbers of which one is in units of 1/32768, rounded half up.
fn product(a: i32, b: i32) -> i32 {
    (a * b + (1 << 14)) >> 15
}

/// From integer sums to gray levels and pixels, and from rows counted from below to rows from the middle: `j = 8 - m`.
fn scaled(sums: &IntegerSums) -> Sums {
    let middle = HALF as i64 + 1;
    let moment = |[total, first]: [i64; 2]| middle * total - first;
    let [gg, first, second] = sums.gg;
    let squares = 2 * second - first;
    let per = |value: i64, units: i32| value as f64 / f64::from(units);
    let one_weight = 1 << 12;
    Sums {
        gg: per(gg, ONE_SLOPE * ONE_SLOPE),
        jgg: per(moment([gg, first]), ONE_SLOPE * ONE_SLOPE),
        jjgg: per(middle * middle * gg - 2 * middle * first + squares, ONE_SLOPE * ONE_SLOPE),
        g: per(sums.g[0], ONE_SLOPE),
        jg: per(moment(sums.g), ONE_SLOPE),
        one: per(sums.one, one_weight),
        ge: per(sums.ge[0], ONE_SLOPE * ONE),
        jge: per(moment(sums.ge), ONE_SLOPE * ONE),
        e: per(sums.e, one_weight * ONE),
        abs: per(sums.abs, one_weight * ONE),
    }
}

/// Gaussian weights of the patch in units of 1/32768, the last lane zero.
pub(crate) static WEIGHTS: [[i16; LANES]; SIDE] = weights();

const fn weights() -> [[i16; LANES]; SIDE] {
    let mut table = [[0; LANES]; SIDE];
    let mut row = 0;
    while row < SIDE {
        let mut column = 0;
        while column < SIDE {
            let (dx, dy) = (column.abs_diff(HALF), row.abs_diff(HALF));
            let exponent = (dx * dx + dy * dy) as f64 / (2.0 * SIGMA_PX * SIGMA_PX);
            table[row][column] = (32767.0 * exp_negative(exponent)) as i16;
            column += 1;
        }
        row += 1;
    }
    table
}

/// `exp(-x)` for small positive `x` by its series, for constants.
const fn exp_negative(x: f64) -> f64 {
    let (mut sum, mut term, mut n) = (1.0, 1.0, 1.0);
    while n < 40.0 {
        term *= x / n;
        sum += term;
        n += 1.0;
    }
    1.0 / sum
}
