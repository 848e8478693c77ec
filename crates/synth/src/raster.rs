//! Scan conversion of one band of rows. Each pixel has 2x2 samples with their own depth test and opacity test; colour is computed once for
//! the two samples of a pixel in a row, from up to four bilinear look-ups along the long axis of the footprint.

use crate::camera::{Prepared, SAMPLES, WIDTH};
use crate::library::Library;
use crate::lookup::Lookup;
use crate::mesh::SurfaceKind;

/// Samples of a block, within which texture coordinates are interpolated; even.
const BLOCK: i32 = 32;
/// Samples of a row, and its blocks.
const STRIDE: usize = WIDTH * SAMPLES;
const BLOCKS: usize = STRIDE.div_ceil(BLOCK as usize);

/// Sample buffers of a band of rows.
pub(crate) struct Band {
    first: i32,
    rows: usize,
    inv_z: Vec<f32>,
    /// Least inverse depth of each block.
    farthest: Vec<f32>,
    /// Grey value times 256.
    tone: Vec<u16>,
    /// Number of the polygon seen.
    polygon: Vec<u32>,
}

/// How much of a stretch is nearer than what is there.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Seen {
    Whole,
    Partly,
}

/// A stretch of one row: its polygon, row and samples `from..to`.
struct Stretch<'a> {
    polygon: &'a Prepared,
    number: u32,
    row: i32,
    from: i32,
    to: i32,
}

impl Stretch<'_> {
    /// Inverse depth at sample `x` as the depth test sees it: constant and factor of `x`.
    fn inv_z(&self) -> (f64, f64) {
        let [c, dx, dy] = self.polygon.inv_z.map(|k| k * self.polygon.bias);
        (c + dy * f64::from(self.row), dx)
    }
}

impl Band {
    /// Buffers for at most `rows` pixel rows.
    pub(crate) fn new(rows: usize) -> Self {
        let n = rows * SAMPLES * STRIDE;
        let farthest = vec![0.0; rows * SAMPLES * BLOCKS];
        Self { first: 0, rows: 0, inv_z: vec![0.0; n], farthest, tone: vec![0; n], polygon: vec![0; n] }
    }

    /// Empties the band and moves it to pixel rows `first..first + rows`.
    pub(crate) fn start(&mut self, first: usize, rows: usize) {
        (self.first, self.rows) = ((first * SAMPLES) as i32, rows * SAMPLES);
        self.inv_z.fill(0.0);
        self.farthest.fill(0.0);
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

    /// Number of the polygon that most samples of a pixel see; among equals the nearest.
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

    /// Draws a polygon; `number` is what [`Band::winner`] will say of it.
    pub(crate) fn draw(&mut self, polygon: &Prepared, number: u32, library: &Library) {
        let last = self.first + self.rows as i32;
        if polygon.bottom <= f64::from(self.first) || polygon.top >= f64::from(last) {
            return;
        }
        let from = (polygon.top.ceil().max(f64::from(self.first))) as i32;
        let to = (polygon.bottom.ceil().min(f64::from(last))) as i32;
        for row in from..to {
            let (left, right) = polygon.columns(row);
            let mut x = left;
            while x < right {
                // Stretches end where blocks end: textures are cut at the same columns whatever the outline.
                let end = ((x / BLOCK + 1) * BLOCK).min(right);
                self.draw_stretch(&Stretch { polygon, number, row, from: x, to: end }, library);
                x = end;
            }
        }
    }

    fn draw_stretch(&mut self, stretch: &Stretch<'_>, library: &Library) {
        let Some(seen) = self.compare(stretch) else { return };
        let polygon = stretch.polygon;
        let pairs = (stretch.from >> 1, (stretch.to + 1) >> 1);
        let lookup = Lookup::new(polygon, stretch.row, pairs, library);
        let cut_out = polygon.kind == SurfaceKind::CutOut;
        match (cut_out, seen, lookup.has_detail()) {
            (false, Seen::Whole, false) => self.cover::<false>(stretch, &lookup),
            (false, Seen::Whole, true) => self.cover::<true>(stretch, &lookup),
            (false, Seen::Partly, false) => self.fill::<false, false>(stretch, &lookup),
            (false, Seen::Partly, true) => self.fill::<false, true>(stretch, &lookup),
            (true, _, false) => self.fill::<true, false>(stretch, &lookup),
            (true, _, true) => self.fill::<true, true>(stretch, &lookup),
        }
        let block = self.block(stretch);
        self.farthest[block] = self.inv_z_of(block).iter().fold(f32::INFINITY, |low, z| low.min(*z));
    }

    /// Number of the block of a row that holds a stretch.
    fn block(&self, stretch: &Stretch<'_>) -> usize {
        (stretch.row - self.first) as usize * BLOCKS + (stretch.from / BLOCK) as usize
    }

    fn inv_z_of(&self, block: usize) -> &[f32] {
        let (row, column) = (block / BLOCKS * STRIDE, block % BLOCKS * BLOCK as usize);
        &self.inv_z[row + column..row + (column + BLOCK as usize).min(STRIDE)]
    }

    fn index(&self, row: i32, x: i32) -> usize {
        (row - self.first) as usize * STRIDE + x as usize
    }

    /// Compares the stretch with what is there: `None` when all of it is hidden.
    fn compare(&self, stretch: &Stretch<'_>) -> Option<Seen> {
        let (base, dx) = stretch.inv_z();
        let ends = [stretch.from, stretch.to - 1].map(|x| (base + dx * f64::from(x)) as f32);
        // A little generous; the exact test follows.
        if ends[0].max(ends[1]) * 1.000_01 <= self.farthest[self.block(stretch)] {
            return None;
        }
        let (start, step) = ((base + dx * f64::from(stretch.from & !1)) as f32, dx as f32);
        let at = self.index(stretch.row, stretch.from & !1);
        let there = &self.inv_z[at..at + (stretch.to - (stretch.from & !1)) as usize];
        // Without a branch, so that several samples are compared at once.
        let (mut any, mut all) = (false, true);
        for (k, there) in there.iter().enumerate() {
            let nearer = start + step * k as f32 > *there;
            any |= nearer;
            all &= nearer;
        }
        let whole = all && stretch.from & 1 == 0;
        any.then_some(if whole { Seen::Whole } else { Seen::Partly })
    }

    /// Writes an opaque stretch that is nearer than everything there.
    #[inline(always)]
    fn cover<const DETAIL: bool>(&mut self, stretch: &Stretch<'_>, lookup: &Lookup<'_>) {
        let (base, dx) = stretch.inv_z();
        let (start, step) = ((base + dx * f64::from(stretch.from)) as f32, dx as f32);
        let at = self.index(stretch.row, stretch.from);
        let samples = at..at + (stretch.to - stretch.from) as usize;
        for (k, z) in self.inv_z[samples.clone()].iter_mut().enumerate() {
            *z = start + step * k as f32;
        }
        self.polygon[samples.clone()].fill(stretch.number);
        for (pair, tones) in self.tone[samples].chunks_mut(2).enumerate() {
            tones.fill(lookup.tone::<DETAIL>(pair));
        }
    }

    /// Tests and writes the samples, pair by pair.
    #[inline(always)]
    fn fill<const CUT_OUT: bool, const DETAIL: bool>(&mut self, stretch: &Stretch<'_>, lookup: &Lookup<'_>) {
        let (base, dx) = stretch.inv_z();
        let first = stretch.from & !1;
        let (start, step) = ((base + dx * f64::from(first)) as f32, dx as f32);
        let at = self.index(stretch.row, first);
        let n = (stretch.to - first) as usize;
        let skip = (stretch.from - first) as usize;
        let inv_z = &mut self.inv_z[at..at + n];
        let tone = &mut self.tone[at..at + n];
        let seen = &mut self.polygon[at..at + n];
        for pair in 0..n.div_ceil(2) {
            let mut color = None;
            for k in 2 * pair..(2 * pair + 2).min(n) {
                let z = start + step * k as f32;
                if k < skip || z <= inv_z[k] || (CUT_OUT && !lookup.is_opaque(k)) {
                    continue;
                }
                let value = *color.get_or_insert_with(|| lookup.tone::<DETAIL>(pair));
                (inv_z[k], tone[k], seen[k]) = (z, value, stretch.number);
            }
        }
    }
}
