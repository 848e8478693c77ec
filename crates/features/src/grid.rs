//! Features sorted by image cell: a window query reads one contiguous piece of memory per row of cells.

use crate::frame::Bounds;
use crate::keypoint::Keypoint;
use std::ops::RangeInclusive;

/// Cells across.
const COLUMNS: usize = 64;
/// Cells down.
const ROWS: usize = 48;

/// What a window query tests, beside each other in memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) x: f32,
    pub(crate) y: f32,
    pub(crate) right_u: f32,
    pub(crate) feature: u32,
    pub(crate) octave: u8,
}

/// 64 x 48 cells over the undistorted image.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    bounds: Bounds,
    per_pixel: (f32, f32),
    /// `starts[cell]..starts[cell + 1]` are the entries of a cell.
    starts: Vec<u32>,
    entries: Vec<Entry>,
}

impl Grid {
    /// Sorts the features into cells; those outside of `bounds` go to the nearest cell. Order inside a cell: by index.
    pub(crate) fn new(bounds: Bounds, keypoints: &[Keypoint], right_u: &[f32]) -> Self {
        let per_pixel = (
            COLUMNS as f32 / (bounds.max_x - bounds.min_x).max(1.0),
            ROWS as f32 / (bounds.max_y - bounds.min_y).max(1.0),
        );
        let empty = Entry { x: 0.0, y: 0.0, right_u: f32::NAN, feature: 0, octave: 0 };
        let mut grid = Self {
            bounds,
            per_pixel,
            starts: vec![0; COLUMNS * ROWS + 1],
            entries: vec![empty; keypoints.len()],
        };
        let cells: Vec<usize> =
            keypoints.iter().map(|k| grid.row(k.y) * COLUMNS + grid.column(k.x)).collect();
        for &cell in &cells {
            grid.starts[cell + 1] += 1;
        }
        for cell in 0..COLUMNS * ROWS {
            grid.starts[cell + 1] += grid.starts[cell];
        }
        let mut next = grid.starts.clone();
        for (i, (keypoint, &cell)) in keypoints.iter().zip(&cells).enumerate() {
            let place = next[cell] as usize;
            next[cell] += 1;
            let Keypoint { x, y, octave, .. } = *keypoint;
            grid.entries[place] = Entry { x, y, right_u: right_u[i], feature: i as u32, octave };
        }
        grid
    }

    /// All entries of the cells that touch the window `[x0, x1] x [y0, y1]`, one slice per row of cells.
    #[inline(always)]
    pub(crate) fn window(&self, x0: f32, x1: f32, y0: f32, y1: f32) -> impl Iterator<Item = &[Entry]> {
        self.rows(y0, y1).map(move |row| self.row_entries(row, x0, x1))
    }

    /// The rows of cells that touch the pixels from `y0` to `y1`.
    #[inline(always)]
    pub(crate) fn rows(&self, y0: f32, y1: f32) -> RangeInclusive<usize> {
        self.row(y0)..=self.row(y1)
    }

    /// The pixels `[y0, y1]` of a row of cells; the first and last row reach to infinity.
    #[inline(always)]
    pub(crate) fn row_span(&self, row: usize) -> (f32, f32) {
        let edge = |row: usize| self.bounds.min_y + row as f32 / self.per_pixel.1;
        let first = if row == 0 { f32::NEG_INFINITY } else { edge(row) };
        let last = if row == ROWS - 1 { f32::INFINITY } else { edge(row + 1) };
        (first, last)
    }

    /// Entries of one row of cells, in those that touch `[x0, x1]`.
    #[inline(always)]
    pub(crate) fn row_entries(&self, row: usize, x0: f32, x1: f32) -> &[Entry] {
        let start = self.starts[row * COLUMNS + self.column(x0)];
        let end = self.starts[row * COLUMNS + self.column(x1) + 1];
        &self.entries[start as usize..end.max(start) as usize]
    }

    #[inline(always)]
    fn column(&self, x: f32) -> usize {
        (((x - self.bounds.min_x) * self.per_pixel.0) as usize).min(COLUMNS - 1)
    }

    #[inline(always)]
    fn row(&self, y: f32) -> usize {
        (((y - self.bounds.min_y) * self.per_pixel.1) as usize).min(ROWS - 1)
    }
}
