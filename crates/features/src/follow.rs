//! Between two evaluations of a network its answers move with the image: blocks of the present image, made small, are looked for in
//! the one that was evaluated, and each takes the answers from where it was. This follows vehicles as well as the street.

use crate::activation::ActivationMap;
use crate::plane::Plane;
use geometry::GrayImage;

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
const COST: u32 = 6;

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

    /// Sums of the four quarters of a block.
    fn quarters(&self, (x, y): (usize, usize)) -> [u16; 4] {
        let at = y * self.image.width + x;
        let below = at + HALF * self.image.width;
        [self.sums[at], self.sums[at + HALF], self.sums[below], self.sums[below + HALF]]
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
        let reach = [REACH_X, REACH_Y].map(|share| (share * width as f32).ceil() as isize);
        let (columns, rows) = (width.div_ceil(BLOCK), height.div_ceil(BLOCK));
        let motion: Vec<(isize, isize)> = (0..rows * columns)
            .map(|i| {
                // The last block of a row or column overlaps the one before.
                let corner = |block: usize, length: usize| (block * BLOCK).min(length - BLOCK);
                motion_of(
                    small,
                    &self.small,
                    (corner(i % columns, width), corner(i / columns, height)),
                    reach,
                )
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

/// Where the block of `image` with this corner was in `earlier`, relative to the corner: the least sum of absolute differences. It is
/// nowhere less than the differences of the quarters' sums, which spares most blocks.
fn motion_of(
    image: &Small,
    earlier: &Small,
    (x, y): (usize, usize),
    [reach_x, reach_y]: [isize; 2],
) -> (isize, isize) {
    let quarters = image.quarters((x, y));
    let (mut best, mut motion) = (difference(&image.image, &earlier.image, (x, y), (x, y), u32::MAX), (0, 0));
    let range = |at: usize, reach: isize, length: usize| {
        (-reach).max(-(at as isize))..=reach.min((length - BLOCK - at) as isize)
    };
    for dy in range(y, reach_y, earlier.image.height) {
        for dx in range(x, reach_x, earlier.image.width) {
            let cost = COST * (dx.unsigned_abs() + dy.unsigned_abs()) as u32;
            let place = (x.saturating_add_signed(dx), y.saturating_add_signed(dy));
            let pairs = quarters.iter().zip(earlier.quarters(place));
            let least = cost + pairs.map(|(a, b)| u32::from(a.abs_diff(b))).sum::<u32>();
            if least < best {
                let found = cost + difference(&image.image, &earlier.image, (x, y), place, best - cost);
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
