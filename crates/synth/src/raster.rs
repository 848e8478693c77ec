//! Scan conversion of one band of rows. Each pixel has 2x2 samples with their own depth test and opacity test; colour is computed once for
//! the two samples of a pixel in a row, from up to four bilinear look-ups along the long axis of the footprint.

use crate::camera::{Prepared, SAMPLES, WIDTH};
use crate::library::Library;
use crate::lookup::Lookup;
use crate::mesh::SurfaceKind;

/// Samples between two exact perspective divisions; even.
const CHUNK: i32 = 32;
/// Samples whose depth is compared at once.
const LANES: usize = 8;
const STRIDE: usize = WIDTH * SAMPLES;

/// Sample buffers of a band of rows.
pub(crate) struct Band {
    first: i32,
    rows: usize,
    inv_z: Vec<f32>,
    /// Grey value times 256.
    tone: Vec<u16>,
    /// Number of the polygon seen.
    polygon: Vec<u32>,
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
                // Stretches start at even samples, except the first.
                let end = ((x & !1) + CHUNK).min(right);
                self.draw_stretch(&Stretch { polygon, number, row, from: x, to: end }, library);
                x = end;
            }
        }
    }

    fn draw_stretch(&mut self, stretch: &Stretch<'_>, library: &Library) {
        if !self.is_visible(stretch) {
            return;
        }
        let polygon = stretch.polygon;
        let pairs = (stretch.from >> 1, (stretch.to + 1) >> 1);
        let lookup = Lookup::new(polygon, stretch.row, pairs, library);
        match (polygon.kind == SurfaceKind::CutOut, lookup.has_detail()) {
            (false, false) => self.fill::<false, false>(stretch, &lookup),
            (false, true) => self.fill::<false, true>(stretch, &lookup),
            (true, false) => self.fill::<true, false>(stretch, &lookup),
            (true, true) => self.fill::<true, true>(stretch, &lookup),
        }
    }

    fn index(&self, row: i32, x: i32) -> usize {
        (row - self.first) as usize * STRIDE + x as usize
    }

    /// Whether any sample of the stretch is nearer than what is there.
    fn is_visible(&self, stretch: &Stretch<'_>) -> bool {
        let (base, dx) = stretch.inv_z();
        let (start, step) = ((base + dx * f64::from(stretch.from)) as f32, dx as f32);
        let at = self.index(stretch.row, stretch.from);
        let there = &self.inv_z[at..at + (stretch.to - stretch.from) as usize];
        // A little generous; the exact test follows. Eight at a time without a branch.
        let nearer = |from: usize, there: &[f32; LANES]| {
            let z = start + step * from as f32;
            let hits: [bool; LANES] = std::array::from_fn(|k| (z + step * k as f32) * 1.000_01 > there[k]);
            hits.iter().fold(false, |any, hit| any | hit)
        };
        let mut from = 0;
        let eights = there.chunks_exact(LANES);
        let mut rest = [f32::INFINITY; LANES];
        rest[..eights.remainder().len()].copy_from_slice(eights.remainder());
        for eight in eights {
            if eight.try_into().is_ok_and(|eight| nearer(from, eight)) {
                return true;
            }
            from += LANES;
        }
        nearer(from, &rest)
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
