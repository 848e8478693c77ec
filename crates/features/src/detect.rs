//! Corners of one pyramid level: one FAST pass, non-maximum suppression, two thresholds per cell.

use crate::kernels::Simd;
use crate::kernels::fast::{self, RADIUS};
use crate::plane::{Plane, SLACK};
use crate::quadtree::Corner;

/// Distance in pixels that corners keep from the edge of their level.
pub(crate) const EDGE: usize = 16;
/// Wanted side of the cells that choose their threshold, in pixels.
const CELL: usize = 30;

/// Scratch memory of the detection on one level.
#[derive(Debug, Default)]
pub(crate) struct Detector {
    scores: [Vec<u8>; 3],
    all: Vec<Corner>,
    cells: Vec<bool>,
}

/// The region `[x0, x1) x [y0, y1)` in which corners may lie; `None` when the level is too small.
pub(crate) fn region(level: &Plane) -> Option<[u16; 4]> {
    let (x1, y1) = (level.width().checked_sub(EDGE)?, level.height().checked_sub(EDGE)?);
    let fits = x1 > EDGE && y1 > EDGE && x1 <= usize::from(u16::MAX) && y1 <= usize::from(u16::MAX);
    fits.then_some([EDGE as u16, EDGE as u16, x1 as u16, y1 as u16])
}

/// The seven rows around row `y`.
pub(crate) fn rows_around(level: &Plane, y: usize) -> [&[u8]; 7] {
    std::array::from_fn(|i| level.row(y + i - RADIUS))
}

impl Detector {
    /// Corners of `level` row by row: local maxima of the FAST score; in cells with a corner of at least `initial` only
    /// such corners, elsewhere all of at least `minimum`.
    pub(crate) fn run(
        &mut self,
        simd: Simd,
        level: &Plane,
        initial: u8,
        minimum: u8,
        corners: &mut Vec<Corner>,
    ) {
        corners.clear();
        let Some([x0, y0, x1, y1]) = region(level) else { return };
        let [left, top, right, bottom] = [x0, y0, x1, y1].map(usize::from);
        let minimum = minimum.max(1);
        for scores in &mut self.scores {
            scores.clear();
            scores.resize(level.width() + SLACK, 0);
        }
        self.all.clear();
        // One pixel more all around, so that the maxima are those of the whole image.
        for y in top - 1..=bottom {
            self.scores.rotate_left(1);
            let rows = rows_around(level, y);
            fast::score_row(simd, &rows, left - 1, right + 1, minimum, &mut self.scores[2]);
            if y > top {
                let [above, middle, below] = &self.scores;
                fast::local_maxima(simd, [above, middle, below], left, right, |x, score| {
                    self.all.push(Corner { x: x as u16, y: (y - 1) as u16, score });
                });
            }
        }
        self.choose([left, top, right, bottom], initial, corners);
    }

    /// Keeps the weak corners only of cells that have no strong one.
    fn choose(&mut self, [left, top, right, bottom]: [usize; 4], initial: u8, corners: &mut Vec<Corner>) {
        let (width, height) = (right - left, bottom - top);
        let n_columns = (width / CELL).max(1);
        let n_rows = (height / CELL).max(1);
        let cell_width = width.div_ceil(n_columns);
        let cell_height = height.div_ceil(n_rows);
        let cell = |c: &Corner| {
            let column = (usize::from(c.x) - left) / cell_width;
            (usize::from(c.y) - top) / cell_height * n_columns + column
        };
        self.cells.clear();
        self.cells.resize(n_columns * n_rows, false);
        for corner in self.all.iter().filter(|c| c.score >= initial) {
            self.cells[cell(corner)] = true;
        }
        let kept = self.all.iter().filter(|c| c.score >= initial || !self.cells[cell(c)]);
        corners.extend(kept);
    }
}
