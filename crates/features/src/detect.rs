//! Corners of one pyramid level: FAST over whole rows, non-maximum suppression, two thresholds per cell.

use crate::kernels::fast::{self, RADIUS};
use crate::plane::{Plane, SLACK};
use crate::quadtree::Corner;
use simd::Simd;

/// Distance in pixels that corners keep from the edge of their level.
pub(crate) const EDGE: usize = 16;
/// Wanted side of the cells that choose their threshold, in pixels.
const CELL: usize = 30;

/// Scratch memory of the detection on one level.
#[derive(Debug, Default)]
pub(crate) struct Detector {
    scores: [Vec<u8>; 3],
    places: Vec<u16>,
    column_of: Vec<u16>,
    has_strong: Vec<bool>,
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
    /// Corners of `level`: local maxima of the FAST score; in cells of about 30 pixels that have a corner of at least
    /// `initial` only such corners, elsewhere all of at least `minimum`. First the strong ones row by row, then the weak ones
    /// by row of cells.
    ///
    /// The weak threshold is tried only where it is needed. A maximum is one among all neighbors of the image, so that the
    /// result is that of a single pass at the lower threshold.
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
        let cells = Cells::new(right - left, bottom - top);
        self.column_of.clear();
        self.column_of.extend((left..right).map(|x| ((x - left) / cells.width) as u16));
        for scores in &mut self.scores {
            scores.resize(level.width() + SLACK, 0);
        }
        let minimum = minimum.max(1);
        let initial = initial.max(minimum);
        self.scan(simd, level, [left, top, right, bottom], initial, corners);
        self.has_strong.clear();
        self.has_strong.resize(cells.columns * cells.rows, false);
        for corner in &*corners {
            let row = (usize::from(corner.y) - top) / cells.height;
            let column = self.column_of[usize::from(corner.x) - left];
            self.has_strong[row * cells.columns + usize::from(column)] = true;
        }
        if initial > minimum {
            self.scan_weak_cells(simd, level, &cells, [left, top, right, bottom], minimum, corners);
        }
    }

    /// Scans the runs of cells without a strong corner.
    fn scan_weak_cells(
        &mut self,
        simd: Simd,
        level: &Plane,
        cells: &Cells,
        [left, top, right, bottom]: [usize; 4],
        minimum: u8,
        corners: &mut Vec<Corner>,
    ) {
        for row in 0..cells.rows {
            let y0 = top + row * cells.height;
            let y1 = (y0 + cells.height).min(bottom);
            let mut column = 0;
            while column < cells.columns {
                let strong = &self.has_strong[row * cells.columns..(row + 1) * cells.columns];
                let n_same = strong[column..].iter().take_while(|&&s| s == strong[column]).count();
                let x0 = left + column * cells.width;
                let x1 = (x0 + n_same * cells.width).min(right);
                if !strong[column] && x0 < x1 && y0 < y1 {
                    self.scan(simd, level, [x0, y0, x1, y1], minimum, corners);
                }
                column += n_same;
            }
        }
    }

    /// Appends the local maxima of at least `threshold` in `[x0, x1) x [y0, y1)`.
    fn scan(
        &mut self,
        simd: Simd,
        level: &Plane,
        [x0, y0, x1, y1]: [usize; 4],
        threshold: u8,
        corners: &mut Vec<Corner>,
    ) {
        // Scores are needed one pixel farther all around.
        for y in y0 - 1..=y1 {
            let [newest, middle, above] = [y, y + 2, y + 1].map(|y| y % 3);
            fast::score_row(
                simd,
                &rows_around(level, y),
                x0 - 1,
                x1 + 1,
                threshold,
                &mut self.scores[newest],
            );
            if y > y0 {
                let [above, middle, below] = [above, middle, newest].map(|i| self.scores[i].as_slice());
                fast::local_maxima(simd, [above, middle, below], x0, x1, &mut self.places);
                let corner = |&x: &u16| Corner { x, y: (y - 1) as u16, score: middle[usize::from(x)] };
                corners.extend(self.places.iter().map(corner));
            }
        }
    }
}

/// The division of a region into cells.
#[derive(Clone, Copy, Debug)]
struct Cells {
    columns: usize,
    rows: usize,
    width: usize,
    height: usize,
}

impl Cells {
    fn new(width: usize, height: usize) -> Self {
        let (columns, rows) = ((width / CELL).max(1), (height / CELL).max(1));
        Self { columns, rows, width: width.div_ceil(columns), height: height.div_ceil(rows) }
    }
}
