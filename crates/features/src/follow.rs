//! Between two evaluations of a network its answers move with the image: blocks of the present image, made small, are looked for in
//! the one that was evaluated, and each takes the answers from where it was. This follows vehicles as well as the street.

use crate::activation::ActivationMap;
use crate::plane::Plane;
use geometry::GrayImage;

/// Side of a block, pixels of the small image.
const BLOCK: usize = 8;
/// Width that a small image has at most.
const MAX_WIDTH: usize = 192;
/// How far blocks are looked for, shares of the small image's width.
const REACH_X: f32 = 0.08;
const REACH_Y: f32 = 0.04;
/// What a pixel of motion costs, gray levels summed over the block: blocks without structure stay.
const COST: u32 = 6;

/// An image made small, to be looked for in another one.
#[derive(Clone, Debug)]
pub(crate) struct Small(GrayImage);

impl Small {
    /// Of the image whose pyramid has this coarsest level: means of squares of pixels, as few that it is at most [`MAX_WIDTH`] wide.
    pub(crate) fn of(coarsest: &Plane) -> Self {
        let side = coarsest.width().div_ceil(MAX_WIDTH).max(1);
        Small(GrayImage::from_fn(coarsest.width() / side, coarsest.height() / side, |x, y| {
            let rows = (y * side..(y + 1) * side).map(|row| &coarsest.pixels(row)[x * side..(x + 1) * side]);
            let sum: usize = rows.flatten().map(|&value| usize::from(value)).sum();
            (sum / (side * side)) as u8
        }))
    }
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
        let (small, earlier) = (&small.0, &self.small.0);
        let (width, height) = (small.width, small.height);
        if (width, height) != (earlier.width, earlier.height) || width < BLOCK || height < BLOCK {
            return None;
        }
        let reach = [REACH_X, REACH_Y].map(|share| (share * width as f32).ceil() as isize);
        let (columns, rows) = (width.div_ceil(BLOCK), height.div_ceil(BLOCK));
        let motion: Vec<(isize, isize)> = (0..rows * columns)
            .map(|i| {
                // The last block of a row or column overlaps the one before.
                let corner = |block: usize, length: usize| (block * BLOCK).min(length - BLOCK);
                motion_of(small, earlier, (corner(i % columns, width), corner(i / columns, height)), reach)
            })
            .collect();
        let values = self.map.values();
        let scale = [values.width as f32 / width as f32, values.height as f32 / height as f32];
        let from = |column: usize, row: usize| {
            let place = |cell: usize, scale: f32, length: usize| {
                (((cell as f32 + 0.5) / scale) as usize).min(length - 1) / BLOCK
            };
            let (dx, dy) = motion[place(row, scale[1], height) * columns + place(column, scale[0], width)];
            let source = |cell: usize, d: isize, scale: f32, length: usize| {
                (cell as f32 + d as f32 * scale).round().clamp(0.0, (length - 1) as f32) as usize
            };
            (source(column, dx, scale[0], values.width), source(row, dy, scale[1], values.height))
        };
        Some(self.map.taken_from(from))
    }
}

/// Where the block of `image` with this corner was in `earlier`, relative to the corner: the least sum of absolute differences.
fn motion_of(
    image: &GrayImage,
    earlier: &GrayImage,
    (x, y): (usize, usize),
    [reach_x, reach_y]: [isize; 2],
) -> (isize, isize) {
    let at_rest = difference(image, earlier, (x, y), (x, y), u32::MAX);
    let (mut best, mut motion) = (at_rest, (0, 0));
    for dy in -reach_y..=reach_y {
        let Some(row) = y.checked_add_signed(dy).filter(|row| row + BLOCK <= earlier.height) else {
            continue;
        };
        for dx in -reach_x..=reach_x {
            let Some(column) = x.checked_add_signed(dx).filter(|column| column + BLOCK <= earlier.width)
            else {
                continue;
            };
            let cost = COST * (dx.unsigned_abs() + dy.unsigned_abs()) as u32;
            if cost < best {
                let found = cost + difference(image, earlier, (x, y), (column, row), best - cost);
                if found < best {
                    (best, motion) = (found, (dx, dy));
                }
            }
        }
    }
    motion
}

/// Sum of the absolute differences of two blocks; ends early when it is at least `limit`.
fn difference(a: &GrayImage, b: &GrayImage, at_a: (usize, usize), at_b: (usize, usize), limit: u32) -> u32 {
    let mut sum = 0;
    for i in 0..BLOCK {
        let line = |image: &GrayImage, (x, y): (usize, usize)| -> [u8; BLOCK] {
            let row = &image.row(y + i)[x..x + BLOCK];
            std::array::from_fn(|j| row[j])
        };
        let (line_a, line_b) = (line(a, at_a), line(b, at_b));
        sum += line_a.iter().zip(line_b).map(|(p, q)| u32::from(p.abs_diff(q))).sum::<u32>();
        if sum >= limit {
            break;
        }
    }
    sum
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
    fn an_image_of_another_size_takes_nothing() {
        let mut other = Plane::default();
        other.copy_from(&GrayImage::new(300, 96, 90));
        assert_eq!(answered(&plane(0)).moved_to(&Small::of(&other)), None);
    }
}
