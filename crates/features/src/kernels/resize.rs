//! Bilinear reduction of an image, in integers: weights of 11 bits across, 15 bits down, each rounded half up.

use crate::kernels::Simd;
use crate::plane::{Plane, SLACK};

/// Weight of a whole pixel across.
const ONE_X: i32 = 1 << 11;
/// Weight of a whole row.
const ONE_Y: f64 = (1 << 15) as f64;

/// Where the pixels of one row or column of the result come from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tap {
    /// The first of the two source pixels.
    pub(crate) first: u32,
    /// Weight of the second, the first has the rest.
    pub(crate) weight: i16,
}

/// Precomputed sampling of one reduction and its row buffers.
#[derive(Debug, Default)]
pub(crate) struct Resizer {
    source: (usize, usize),
    target: (usize, usize),
    columns: Vec<Tap>,
    rows: Vec<Tap>,
    lines: [Vec<i16>; 2],
}

impl Resizer {
    /// Writes `source`, reduced to `width` by `height`, to `target`; pixel centres correspond.
    pub(crate) fn run(
        &mut self,
        simd: Simd,
        source: &Plane,
        (width, height): (usize, usize),
        target: &mut Plane,
    ) {
        target.resize(width, height);
        if self.source != (source.width(), source.height()) || self.target != (width, height) {
            self.source = (source.width(), source.height());
            self.target = (width, height);
            self.columns = taps(source.width(), width, f64::from(ONE_X));
            self.rows = taps(source.height(), height, ONE_Y);
            self.lines = std::array::from_fn(|_| vec![0; width + SLACK]);
        }
        let _ = simd;
        let mut held = [usize::MAX; 2];
        for y in 0..height {
            let tap = self.rows[y];
            let first = tap.first as usize;
            let wanted = [first, (first + 1).min(source.height() - 1)];
            if held[1] == wanted[0] {
                self.lines.swap(0, 1);
                held.swap(0, 1);
            }
            for i in 0..2 {
                if held[i] != wanted[i] {
                    resize_row(source.row(wanted[i]), &self.columns, &mut self.lines[i]);
                    held[i] = wanted[i];
                }
            }
            let row = &mut target.row_mut(y)[..width];
            blend_rows(&self.lines[0], &self.lines[1], tap.weight, row);
        }
    }
}

/// Sampling positions of `to` centres spread over `from` pixels.
fn taps(from: usize, to: usize, one: f64) -> Vec<Tap> {
    let step = from as f64 / to as f64;
    let last = from.saturating_sub(2) as f64;
    let tap = |i: usize| {
        let position = ((i as f64 + 0.5) * step - 0.5).clamp(0.0, from as f64 - 1.0);
        let first = position.floor().min(last);
        let weight = ((position - first) * one).round().min(one.min(32767.0)) as i16;
        Tap { first: first as u32, weight }
    };
    (0..to).map(tap).collect()
}

/// One source row at the columns of the result, in units of 1/128.
fn resize_row(source: &[u8], columns: &[Tap], line: &mut [i16]) {
    for (value, tap) in line.iter_mut().zip(columns) {
        let [a, b] = [0, 1].map(|i| i32::from(source[tap.first as usize + i]));
        let weight = i32::from(tap.weight);
        *value = ((a * (ONE_X - weight) + b * weight + 8) >> 4) as i16;
    }
}

/// The weighted mean of two lines as bytes.
fn blend_rows(first: &[i16], second: &[i16], weight: i16, row: &mut [u8]) {
    for (pixel, (a, b)) in row.iter_mut().zip(first.iter().zip(second)) {
        let difference = i32::from(*b) - i32::from(*a);
        let value = i32::from(*a) + ((difference * i32::from(weight) + (1 << 14)) >> 15);
        *pixel = ((value + 64) >> 7) as u8;
    }
}
