//! Between two evaluations of a network its answers move with the image: blocks of the present image, made small, are looked for in
//! the one that was evaluated, and each takes the answers from where it was. This follows vehicles as well as the street.

use crate::activation::ActivationMap;
use crate::plane::Plane;
use geometry::GrayImage;
use simd::{Simd, Task};

/// Side of a block, pixels of the small image.
const BLOCK: usize = 8;
/// Side of a quarter of it.
const HALF: usize = BLOCK / 2;
/// Width that a small image has at most.
const MAX_WIDTH: usize = 192;
/// How far blocks are looked for, shares of the small image's width.
const REACH_X: f32 = 0.08;
const REACH_Y: f32 = 0.04;
/// What a pixel of motion costs, gray levels summed over the block: blocks without structure stay.
const COST: u16 = 6;

/// An image made small, to be looked for in another one.
#[derive(Clone, Debug)]
pub(crate) struct Small {
    image: GrayImage,
    /// Sum of the square of pixels, half a block wide, that begins at each pixel.
    sums: Vec<u16>,
}

impl Small {
    /// Of the image whose pyramid has this coarsest level: means of squares of pixels, as few that it is at most [`MAX_WIDTH`] wide.
    pub(crate) fn of(coarsest: &Plane) -> Self {
        let side = coarsest.width().div_ceil(MAX_WIDTH).max(1);
        let image = GrayImage::from_fn(coarsest.width() / side, coarsest.height() / side, |x, y| {
            let rows = (y * side..(y + 1) * side).map(|row| &coarsest.pixels(row)[x * side..(x + 1) * side]);
            let sum: usize = rows.flatten().map(|&value| usize::from(value)).sum();
            (sum / (side * side)) as u8
        });
        let sums = sums(&image);
        Small { image, sums }
    }

    /// Sums of the quarters of the blocks that begin at `n` pixels of a row, quarter after quarter.
    #[inline(always)]
    fn quarters(&self, (x, y): (usize, usize), n: usize) -> [&[u16]; 4] {
        let at = y * self.image.width + x;
        let below = at + HALF * self.image.width;
        [at, at + HALF, below, below + HALF].map(|start| &self.sums[start..start + n])
    }
}

/// Sums of the squares of pixels that begin at each pixel; 0 where they do not fit.
fn sums(image: &GrayImage) -> Vec<u16> {
    let (width, height) = (image.width, image.height);
    let mut sums = vec![0; width * height];
    let mut columns = vec![0_u16; width];
    for y in 0..height.saturating_sub(HALF - 1) {
        columns.fill(0);
        for row in y..y + HALF {
            columns.iter_mut().zip(image.row(row)).for_each(|(sum, &value)| *sum += u16::from(value));
        }
        let line = &mut sums[y * width..(y + 1) * width];
        line.iter_mut().zip(columns.windows(HALF)).for_each(|(sum, columns)| *sum = columns.iter().sum());
    }
    sums
}

/// What a network said of a frame.
#[derive(Clone, Debug)]
pub(crate) struct Answered {
    /// Number of the frame.
    pub(crate) index: u32,
    pub(crate) map: ActivationMap,
    /// Its image.
    pub(crate) small: Small,
}

impl Answered {
    /// The answers for a later image; `None` for one of another size.
    pub(crate) fn moved_to(&self, small: &Small) -> Option<ActivationMap> {
        let (width, height) = (small.image.width, small.image.height);
        if (width, height) != (self.small.image.width, self.small.image.height)
            || width < BLOCK
            || height < BLOCK
        {
            return None;
        }
        let reach = [REACH_X, REACH_Y].map(|share| (share * width as f32).ceil() as usize);
        let motions = Simd::detect().run(Search { image: small, earlier: &self.small, reach });
        let values = self.map.values();
        let scale = [values.width as f32 / width as f32, values.height as f32 / height as f32];
        let cells = |d: isize, scale: f32| (d as f32 * scale + 0.5).floor() as isize;
        let shifts: Vec<_> =
            motions.into_iter().map(|(dx, dy)| (cells(dx, scale[0]), cells(dy, scale[1]))).collect();
        let blocks = |n_cells: usize, scale: f32, length: usize| -> Vec<usize> {
            let pixel = |cell: usize| ((cell as f32 + 0.5) / scale) as usize;
            (0..n_cells).map(|cell| pixel(cell).min(length - 1) / BLOCK).collect()
        };
        let columns = blocks(values.width, scale[0], width);
        let rows = blocks(values.height, scale[1], height);
        Some(self.map.taken_from(|column, row| {
            let (dx, dy) = shifts[rows[row] * width.div_ceil(BLOCK) + columns[column]];
            let source = |cell: usize, d: isize, n: usize| cell.saturating_add_signed(d).min(n - 1);
            (source(column, dx, values.width), source(row, dy, values.height))
        }))
    }
}

/// Looks for the blocks of an image in an earlier one of its size.
struct Search<'a> {
    image: &'a Small,
    earlier: &'a Small,
    /// How far, pixels in x and in y.
    reach: [usize; 2],
}

impl Task for Search<'_> {
    type Output = Vec<(isize, isize)>;

    /// Where each block was, relative to where it is; row by row.
    #[inline(always)]
    fn run(self) -> Self::Output {
        // The last block of a row or column overlaps the one before.
        let corners =
            |length: usize| (0..length.div_ceil(BLOCK)).map(move |block| (block * BLOCK).min(length - BLOCK));
        let mut least = Vec::new();
        let mut motions = Vec::new();
        for y in corners(self.image.image.height) {
            for x in corners(self.image.image.width) {
                motions.push(self.motion_of((x, y), &mut least));
            }
        }
        motions
    }
}

impl Search<'_> {
    /// Where the block with this corner was, relative to the corner: the place of the least cost, and of equal ones the corner
    /// itself or the first. A place costs the sum of absolute differences and what its distance costs. The differences of the
    /// quarters' sums, gathered in `least`, are never more than that, which spares most places.
    #[inline(always)]
    fn motion_of(&self, (x, y): (usize, usize), least: &mut Vec<u16>) -> (isize, isize) {
        let Self { image, earlier, reach } = self;
        let from = [x.saturating_sub(reach[0]), y.saturating_sub(reach[1])];
        let n_columns = (x + reach[0]).min(image.image.width - BLOCK) - from[0] + 1;
        let n_rows = (y + reach[1]).min(image.image.height - BLOCK) - from[1] + 1;
        let quarters = image.quarters((x, y), 1).map(|sums| sums[0]);
        least.clear();
        least.resize(n_rows * n_columns, 0);
        for (line, row) in least.chunks_exact_mut(n_columns).zip(from[1]..) {
            for (least, column) in line.iter_mut().zip(from[0] as u16..) {
                *least = distance((x as u16, y as u16), (column, row as u16));
            }
            for (quarter, sums) in quarters.iter().zip(earlier.quarters((from[0], row), n_columns)) {
                for (least, sum) in line.iter_mut().zip(sums) {
                    *least += sum.abs_diff(*quarter);
                }
            }
        }
        // The corner wins among equals. The most promising place is tried early, so that few others are worth a look.
        let lowest = least.iter().copied().min().unwrap_or_default();
        let promising = least.iter().position(|&least| least == lowest).unwrap_or_default();
        let promising = (from[0] + promising % n_columns, from[1] + promising / n_columns);
        let mut best = self.ranked((x, y), (x, y)).min(self.ranked((x, y), promising));
        for (line, row) in least.chunks_exact(n_columns).zip(from[1]..) {
            if u32::from(line.iter().copied().min().unwrap_or_default()) > best.0 {
                continue;
            }
            for (least, column) in line.iter().zip(from[0]..) {
                if u32::from(*least) <= best.0 {
                    best = best.min(self.ranked((x, y), (column, row)));
                }
            }
        }
        let (row, column) = best.2;
        (column as isize - x as isize, row as isize - y as isize)
    }

    /// What a place costs, whether it is another one than the corner, and the place, row first: the less the better.
    #[inline(always)]
    fn ranked(&self, corner: (usize, usize), place: (usize, usize)) -> (u32, bool, (usize, usize)) {
        let difference = difference(&self.image.image, &self.earlier.image, corner, place);
        let [at, to] = [corner, place].map(|(x, y)| (x as u16, y as u16));
        (difference + u32::from(distance(at, to)), place != corner, (place.1, place.0))
    }
}

/// What it costs to be elsewhere.
#[inline(always)]
fn distance(at: (u16, u16), place: (u16, u16)) -> u16 {
    COST * (at.0.abs_diff(place.0) + at.1.abs_diff(place.1))
}

/// Sum of the absolute differences of two blocks.
#[inline(always)]
fn difference(a: &GrayImage, b: &GrayImage, at_a: (usize, usize), at_b: (usize, usize)) -> u32 {
    let (a, b) = (block(a, at_a), block(b, at_b));
    let mut sum = 0;
    for i in 0..a.len() {
        sum += u32::from(a[i].abs_diff(b[i]));
    }
    sum
}

/// The pixels of a block.
#[inline(always)]
fn block(image: &GrayImage, (x, y): (usize, usize)) -> [u8; BLOCK * BLOCK] {
    let mut pixels = [0; BLOCK * BLOCK];
    for (i, line) in pixels.chunks_exact_mut(BLOCK).enumerate() {
        line.copy_from_slice(&image.row(y + i)[x..x + BLOCK]);
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Raster;

    /// A textured image of which everything lies `shift` pixels to the right of where it is without.
    fn plane(shift: isize) -> Plane {
        let texture =
            |x: isize, y: usize| geometry::mix_seed(1, (x.div_euclid(4)) as u64, (y / 4) as u64) as u8;
        let mut plane = Plane::default();
        plane.copy_from(&GrayImage::from_fn(320, 96, |x, y| texture(x as isize - shift, y)));
        plane
    }

    fn map() -> ActivationMap {
        let values = Raster::from_fn(160, 48, |x, _| if (60..90).contains(&x) { 0.0 } else { 1.0 });
        ActivationMap::new(values.clone(), 1000, 300).unwrap().with_lasting(values).unwrap()
    }

    fn answered(plane: &Plane) -> Answered {
        Answered { index: 0, map: map(), small: Small::of(plane) }
    }

    #[test]
    fn answers_move_with_the_image() {
        let answered = answered(&plane(0));
        assert_eq!(answered.moved_to(&Small::of(&plane(0))), Some(map()), "nothing moved");
        // 16 of 320 pixels are 8 of 160 cells.
        let moved = answered.moved_to(&Small::of(&plane(16))).unwrap();
        for row in 0..48 {
            let low: Vec<usize> = (0..160).filter(|&x| moved.values().at(x, row) < 0.5).collect();
            assert_eq!((low.first(), low.last()), (Some(&68), Some(&97)), "row {row}");
        }
        assert_eq!(moved.at(500.0, 100.0), moved.lasting_at(500.0, 100.0));
    }

    #[test]
    fn an_image_without_structure_leaves_them_where_they_are() {
        let mut flat = Plane::default();
        flat.copy_from(&GrayImage::new(320, 96, 90));
        assert_eq!(answered(&flat).moved_to(&Small::of(&flat)), Some(map()));
    }

    #[test]
    fn places_that_are_spared_are_none_of_the_best() {
        let noise = |seed: u64, step: usize| {
            let value =
                move |x: usize, y: usize| geometry::mix_seed(seed, (x / step) as u64, (y / step) as u64);
            let mut plane = Plane::default();
            plane.copy_from(&GrayImage::from_fn(130, 61, |x, y| (value(x, y) % 61) as u8));
            Small::of(&plane)
        };
        for step in [1, 3, 9] {
            let (image, earlier) = (noise(5, step), noise(6 + step as u64 % 2, step));
            let search = || Search { image: &image, earlier: &earlier, reach: [11, 6] };
            let cost = |corner, place| search().ranked(corner, place);
            let mut expected = Vec::new();
            for y in [0, 8, 16, 24, 32, 40, 48, 53] {
                for x in (0..16).map(|i| 8 * i).chain([122]) {
                    let columns = || x.max(11) - 11..=(x + 11).min(122);
                    let places =
                        (y.max(6) - 6..=(y + 6).min(53)).flat_map(|v| columns().map(move |u| (u, v)));
                    let (_, _, (v, u)) = places.map(|place| cost((x, y), place)).min().unwrap();
                    expected.push((u as isize - x as isize, v as isize - y as isize));
                }
            }
            assert_eq!(Simd::detect().run(search()), expected, "{step}");
            assert_eq!(Simd::scalar().run(search()), expected, "{step}");
            assert!(expected.iter().any(|&motion| motion != (0, 0)));
        }
    }

    #[test]
    fn an_image_of_another_size_takes_nothing() {
        let mut other = Plane::default();
        other.copy_from(&GrayImage::new(300, 96, 90));
        assert_eq!(answered(&plane(0)).moved_to(&Small::of(&other)), None);
    }
}
