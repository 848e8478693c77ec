//! Bilinear reduction of an image, in integers: weights of 11 bits across, 15 bits down, each rounded half up.

#[cfg(target_arch = "x86_64")]
use crate::kernels::avx2;
use crate::plane::{Plane, SLACK};
use simd::Simd;

/// Weight of a whole pixel across.
const ONE_X: i32 = 1 << 11;
/// Weight of a whole row.
const ONE_Y: f64 = (1 << 15) as f64;

/// Where the pixels of one row or column of the result come from.
#[derive(Clone, Copy, Debug)]
struct Tap {
    /// The first of the two source pixels.
    first: u32,
    /// Weight of the second, the first has the rest.
    weight: i16,
}

/// Eight pixels of the result: `base` and `shuffle` give the pairs of source pixels, `weights` their weights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub(crate) base: u32,
    pub(crate) shuffle: [u8; 16],
    pub(crate) weights: [i16; 16],
}

/// A row of the result in steps of eight pixels, an even number of steps.
#[derive(Debug, Default)]
pub(crate) struct Blocks {
    list: Vec<Block>,
    reach: usize,
}

impl Blocks {
    /// The steps for these columns; none when eight pixels of the result need more than 16 of the source.
    fn new(columns: &[Tap]) -> Self {
        let mut list = Vec::with_capacity(columns.len().div_ceil(16) * 2);
        for eight in columns.chunks(8) {
            let base = eight[0].first;
            let mut block = Block { base, shuffle: [0; 16], weights: [0; 16] };
            for (i, tap) in eight.iter().enumerate() {
                let place = (tap.first - base) as usize;
                if place > 14 {
                    return Self::default();
                }
                block.shuffle[2 * i] = place as u8;
                block.shuffle[2 * i + 1] = place as u8 + 1;
                block.weights[2 * i] = ONE_X as i16 - tap.weight;
                block.weights[2 * i + 1] = tap.weight;
            }
            list.push(block);
        }
        if list.len() % 2 == 1 {
            list.push(Block { base: 0, shuffle: [0; 16], weights: [0; 16] });
        }
        let reach = list.iter().map(|b| b.base as usize + 16).max().unwrap_or(0);
        Self { list, reach }
    }

    /// The steps.
    pub(crate) fn list(&self) -> &[Block] {
        &self.list
    }

    /// Bytes of the source that are read: the largest `base` plus 16.
    pub(crate) fn reach(&self) -> usize {
        self.reach
    }
}

/// Precomputed sampling of one reduction and its row buffers.
#[derive(Debug, Default)]
pub(crate) struct Resizer {
    source: (usize, usize),
    target: (usize, usize),
    columns: Vec<Tap>,
    blocks: Blocks,
    rows: Vec<Tap>,
    lines: [Vec<i16>; 2],
}

impl Resizer {
    /// Writes `source`, reduced to `width` by `height`, to `target`; pixel centers correspond.
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
            self.blocks = Blocks::new(&self.columns);
            self.rows = taps(source.height(), height, ONE_Y);
            self.lines = std::array::from_fn(|_| vec![0; width + SLACK]);
        }
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
                    resize_row(simd, source.row(wanted[i]), &self.columns, &self.blocks, &mut self.lines[i]);
                    held[i] = wanted[i];
                }
            }
            blend_rows(simd, &self.lines, tap.weight, width, target.row_mut(y));
        }
    }
}

/// Sampling positions of `to` centers spread over `from` pixels.
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
fn resize_row(simd: Simd, source: &[u8], columns: &[Tap], blocks: &Blocks, line: &mut [i16]) {
    #[cfg(target_arch = "x86_64")]
    if let (Some(token), false) = (simd.avx2(), blocks.list.is_empty()) {
        return avx2::resize::resize_row(token, source, blocks, line);
    }
    let _ = (simd, blocks);
    for (value, tap) in line.iter_mut().zip(columns) {
        let [a, b] = [0, 1].map(|i| i32::from(source[tap.first as usize + i]));
        let weight = i32::from(tap.weight);
        *value = ((a * (ONE_X - weight) + b * weight + 8) >> 4) as i16;
    }
}

/// The weighted mean of two lines as bytes.
fn blend_rows(simd: Simd, lines: &[Vec<i16>; 2], weight: i16, width: usize, row: &mut [u8]) {
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = simd.avx2() {
        return avx2::resize::blend_rows(token, lines, weight, width, row);
    }
    let _ = simd;
    for (pixel, (a, b)) in row[..width].iter_mut().zip(lines[0].iter().zip(&lines[1])) {
        let difference = i32::from(*b) - i32::from(*a);
        let value = i32::from(*a) + ((difference * i32::from(weight) + (1 << 14)) >> 15);
        *pixel = ((value + 64) >> 7) as u8;
    }
}
