//! Scan conversion of one band of rows. Each pixel has 2x2 samples with their own depth test and opacity test; color is computed once for
//! the two samples of a pixel in a row, from up to four bilinear look-ups along the long axis of the footprint.

use crate::camera::{Prepared, SAMPLES, WIDTH};
use crate::kernel::LANES;
use crate::library::Library;
use crate::lookup::Lookup;
use crate::mesh::SurfaceKind;

/// Samples of a block, within which texture coordinates are interpolated.
const BLOCK: i32 = (LANES * SAMPLES) as i32;
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
    /// Gray value times 256.
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
        let [c, dx, dy] = self.polygon.planes.inv_z.map(|k| k * self.polygon.bias);
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

    /// Mean tone (gray value times 256) of each pixel of a row of the band.
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
        if polygon.outline.bottom <= f64::from(self.first) || polygon.outline.top >= f64::from(last) {
            return;
        }
        let from = (polygon.outline.top.ceil().max(f64::from(self.first))) as i32;
        let to = (polygon.outline.bottom.ceil().min(f64::from(last))) as i32;
        for row in from..to {
            let (left, right) = polygon.outline.columns(row);
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
        let (base, dx) = stretch.inv_z();
        let ends = [stretch.from, stretch.to - 1].map(|x| (base + dx * f64::from(x)) as f32);
        let block = self.block(stretch);
        // A little generous; the exact test follows.
        if ends[0].max(ends[1]) * 1.000_01 <= self.farthest[block] {
            return;
        }
        let first = stretch.from & !1;
        let (start, step) = ((base + dx * f64::from(first)) as f32, dx as f32);
        let inv_z: [f32; BLOCK as usize] = std::array::from_fn(|k| start + step * k as f32);
        let at = self.index(stretch.row, first);
        let samples = at..at + (stretch.to - first) as usize;
        let Some(seen) = compare(&inv_z, &self.inv_z[samples.clone()]) else { return };
        let polygon = stretch.polygon;
        let pairs = (stretch.from >> 1, (stretch.to + 1) >> 1);
        let lookup = Lookup::new(polygon, stretch.row, pairs, library);
        let draw =
            Drawing { samples, inv_z: &inv_z, skip: (stretch.from - first) as usize, number: stretch.number };
        match (polygon.surface.kind, seen) {
            (SurfaceKind::CutOut, _) => self.fill(&draw, &lookup, &lookup.opacity(pairs.1 - pairs.0)),
            (_, Seen::Whole) if draw.skip == 0 => self.cover(draw, &lookup),
            _ => self.fill(&draw, &lookup, &[[true; 2]; LANES]),
        }
        self.farthest[block] = least(self.inv_z_of(block));
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

    /// Writes an opaque stretch that is nearer than everything there.
    fn cover(&mut self, draw: Drawing<'_>, lookup: &Lookup<'_>) {
        let n = draw.samples.len();
        self.inv_z[draw.samples.clone()].copy_from_slice(&draw.inv_z[..n]);
        self.polygon[draw.samples.clone()].fill(draw.number);
        let tones = lookup.tones(n.div_ceil(2));
        for (two, tone) in self.tone[draw.samples].chunks_mut(2).zip(&tones) {
            two.fill(*tone);
        }
    }

    /// Tests and writes the samples one by one; `opaque` says which samples of each pair are hit.
    fn fill(&mut self, draw: &Drawing<'_>, lookup: &Lookup<'_>, opaque: &[[bool; 2]; LANES]) {
        let n = draw.samples.len();
        let tones = lookup.tones(n.div_ceil(2));
        let inv_z = &mut self.inv_z[draw.samples.clone()];
        let tone = &mut self.tone[draw.samples.clone()];
        let seen = &mut self.polygon[draw.samples.clone()];
        for k in draw.skip..n {
            if draw.inv_z[k] > inv_z[k] && opaque[k / 2][k % 2] {
                (inv_z[k], tone[k], seen[k]) = (draw.inv_z[k], tones[k / 2], draw.number);
            }
        }
    }
}

/// A stretch while it is drawn.
struct Drawing<'a> {
    /// Indices into the band's buffers, from an even sample on.
    samples: std::ops::Range<usize>,
    /// Inverse depth of each of these samples.
    inv_z: &'a [f32; BLOCK as usize],
    /// 1 when the first of them does not belong to the polygon.
    skip: usize,
    number: u32,
}

/// How much of `ours` is nearer than what is there; `None` when nothing is. Without branches, so that many are compared at once.
fn compare(ours: &[f32], there: &[f32]) -> Option<Seen> {
    let (mut any, mut all) = (0, 1);
    for (ours, there) in ours.iter().zip(there) {
        let nearer = u32::from(ours > there);
        any |= nearer;
        all &= nearer;
    }
    (any == 1).then_some(if all == 1 { Seen::Whole } else { Seen::Partly })
}

/// The least of some numbers, in eight strands.
fn least(values: &[f32]) -> f32 {
    let less = |a: f32, b: f32| if a < b { a } else { b };
    let eights = values.chunks_exact(8);
    let mut strands = [f32::INFINITY; 8];
    let rest = eights.remainder().iter().fold(f32::INFINITY, |low, v| less(*v, low));
    for eight in eights {
        for (strand, value) in strands.iter_mut().zip(eight) {
            *strand = less(*value, *strand);
        }
    }
    strands.iter().fold(rest, |low, v| less(*v, low))
}
