//! Lattice noise for textures and smooth functions of time: pure functions of a seed, equal on every machine.

/// Mixes two lattice coordinates and a seed into 32 well spread bits.
pub(crate) fn hash(x: i32, y: i32, seed: u32) -> u32 {
    let mut h = seed ^ (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77);
    h ^= h >> 15;
    h = h.wrapping_mul(0x2c1b_3c6d);
    h ^= h >> 12;
    h = h.wrapping_mul(0x297a_2d39);
    h ^ (h >> 15)
}

/// Number in [0, 1) of a lattice point.
pub(crate) fn unit(x: i32, y: i32, seed: u32) -> f32 {
    (hash(x, y, seed) >> 8) as f32 / (1 << 24) as f32
}

/// Number in [-1, 1) of a lattice point.
pub(crate) fn signed(x: i32, y: i32, seed: u32) -> f32 {
    2.0 * unit(x, y, seed) - 1.0
}

/// Largest integer not above `x`; faster than the library's where the processor has no instruction for it.
fn floor(x: f32) -> i32 {
    let i = x as i32;
    i - i32::from(i as f32 > x)
}

/// Smooth value noise in [-1, 1) that repeats after `period` lattice cells in both directions.
pub(crate) fn value(x: f32, y: f32, period: [i32; 2], seed: u32) -> f32 {
    let (x0, y0) = (floor(x), floor(y));
    let smooth = |t: f32| t * t * (3.0 - 2.0 * t);
    let (fx, fy) = (smooth(x - x0 as f32), smooth(y - y0 as f32));
    let (xa, ya) = (x0.rem_euclid(period[0]), y0.rem_euclid(period[1]));
    let (xb, yb) = ((xa + 1) % period[0], (ya + 1) % period[1]);
    let top = signed(xa, ya, seed) * (1.0 - fx) + signed(xb, ya, seed) * fx;
    let bottom = signed(xa, yb, seed) * (1.0 - fx) + signed(xb, yb, seed) * fx;
    top * (1.0 - fy) + bottom * fy
}

/// Sum of `octaves` of [`value`], each twice as fine; amplitude falls by `gain` per octave, the result stays in about [-1, 1].
///
/// `x` and `y` are in cells of the coarsest octave, which repeats after `period` cells.
pub(crate) fn octaves(x: f32, y: f32, period: [i32; 2], octaves: u32, gain: f32, seed: u32) -> f32 {
    let (mut sum, mut total, mut amplitude, mut scale) = (0.0, 0.0, 1.0, 1);
    for octave in 0..octaves {
        let s = scale as f32;
        let cells = [period[0] * scale, period[1] * scale];
        sum += amplitude * value(x * s, y * s, cells, seed.wrapping_add(octave.wrapping_mul(0x51ed_270b)));
        total += amplitude;
        amplitude *= gain;
        scale *= 2;
    }
    // Neighboring octaves partly cancel; 1.6 brings the typical range back to [-1, 1].
    1.6 * sum / total
}

/// Multi-octave noise baked once, for the many drawings that need it everywhere: a square that repeats, at 2 cm per texel.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    values: Vec<f32>,
}

impl Tile {
    const SIZE: i32 = 512;
    /// Meters per texel.
    const TEXEL_M: f32 = 0.02;

    /// Structure from 1.3 m down to 4 cm.
    pub(crate) fn new(seed: u32) -> Self {
        let cells = 8;
        let scale = cells as f32 / Self::SIZE as f32;
        let at = |i: i32| {
            let (x, y) = (i % Self::SIZE, i / Self::SIZE);
            octaves(x as f32 * scale, y as f32 * scale, [cells; 2], 6, 0.85, seed)
        };
        Self { values: (0..Self::SIZE * Self::SIZE).map(at).collect() }
    }

    /// Noise at a place in meters, shifted by `key`; in about [-1, 1].
    pub(crate) fn at(&self, x: f32, y: f32, key: u32) -> f32 {
        let shift = hash(key as i32, 1, 77);
        let wrap = |v: f32, by: u32| ((v / Self::TEXEL_M) as i32).wrapping_add(by as i32) & (Self::SIZE - 1);
        self.values[(wrap(y, shift >> 16) * Self::SIZE + wrap(x, shift & 0xffff)) as usize]
    }
}

/// Smooth, seemingly random function of one variable: a sum of sines with seeded phases.
#[derive(Clone, Debug)]
pub(crate) struct Wander {
    /// Amplitude, angular frequency and phase of each sine.
    terms: Vec<[f64; 3]>,
}

impl Wander {
    /// `amplitude` bounds the value; `frequencies` are in cycles per unit of the argument.
    pub(crate) fn new(amplitude: f64, frequencies: &[f64], seed: u64) -> Self {
        let share = amplitude / frequencies.len().max(1) as f64;
        let phase = |i: usize| f64::from(unit(i as i32, 77, seed as u32 ^ (seed >> 32) as u32));
        let terms = frequencies
            .iter()
            .enumerate()
            .map(|(i, f)| [share, std::f64::consts::TAU * f, std::f64::consts::TAU * phase(i)])
            .collect();
        Self { terms }
    }

    /// Value at `x`.
    pub(crate) fn at(&self, x: f64) -> f64 {
        self.terms.iter().map(|[a, w, p]| a * (w * x + p).sin()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_repeats_after_its_period_and_stays_in_range() {
        for i in 0..200 {
            let (x, y) = (i as f32 * 0.137, i as f32 * 0.071);
            let n = octaves(x, y, [8, 4], 4, 0.5, 9);
            assert!((n - octaves(x + 8.0, y + 4.0, [8, 4], 4, 0.5, 9)).abs() < 1e-3);
            assert!(n.abs() <= 1.6);
        }
    }

    #[test]
    fn lattice_values_are_spread_evenly() {
        let n = 20_000;
        let mean = (0..n).map(|i| f64::from(unit(i % 200, i / 200, 3))).sum::<f64>() / f64::from(n);
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
    }

    #[test]
    fn a_wander_is_smooth_and_bounded() {
        let w = Wander::new(0.3, &[0.1, 0.7, 1.9], 5);
        for i in 0..500 {
            let x = f64::from(i) * 0.031;
            assert!(w.at(x).abs() <= 0.3);
            // The derivative is at most amplitude times angular frequency.
            assert!((w.at(x + 0.01) - w.at(x)).abs() < 0.3 * std::f64::consts::TAU * 1.9 * 0.01);
        }
        assert!((0..500).any(|i| w.at(f64::from(i) * 0.37).abs() > 0.15));
    }
}
