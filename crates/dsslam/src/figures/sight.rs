//! A look at a few frames: brightness, corners, depth, and whether left and right images show the same rows at the same moment.

use features::{Extractor, ExtractorConfig, Features, Keypoint, SelectionRule, match_brute_force};
use geometry::{DepthImage, GrayImage};
use io::LoadedFrame;
use runtime::{FrameFeed, Setup};

/// Frames that are looked at, spread over the sequence.
const N_SIGHTS: usize = 5;
/// Frames that are tried where one cannot be read.
const N_TRIES: usize = 3;
/// Corners looked for in each image.
const N_FEATURES: usize = 1000;
/// Largest distance of descriptors, bits, and largest ratio of the best to the second-best one.
const MAX_DISTANCE: u32 = 50;
const MAX_RATIO: f32 = 0.8;
/// Rows of a match that agree, pixels: what corners of coarse octaves are off by.
const ROW_PX: f32 = 2.5;
/// Disparity that has a sign, pixels.
const SIGN_PX: f32 = 0.5;
/// Pixels between samples of a depth image.
const DEPTH_STEP: usize = 8;
/// Width over height from which an image of one camera may hold two.
const WIDE: usize = 2;
/// Share of matches on their rows below which the neighboring right images are looked at, too.
const SUSPICIOUS: f64 = 0.8;

/// What one frame shows.
#[derive(Clone, Debug, Default)]
pub(super) struct Sight {
    pub(super) left: Look,
    pub(super) right: Option<Look>,
    pub(super) pairing: Option<Pairing>,
    /// Of a wide image of one camera: its left half as a left image, its right half as a right one.
    pub(super) halves: Option<Pairing>,
    /// Depths seen, meters.
    pub(super) depths_m: Vec<f64>,
    /// Share of the depth image that holds a depth.
    pub(super) with_depth: Option<f64>,
}

/// What one image shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Look {
    /// Mean, 0 to 255.
    pub(super) brightness: f64,
    pub(super) corners: usize,
}

/// Corners of the left image found again in the right one, wherever that is.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Pairing {
    pub(super) matches: usize,
    /// Matches whose rows agree.
    pub(super) on_row: usize,
    /// Median of right row minus left row, pixels, and the matches near it.
    pub(super) median_rows_px: f64,
    pub(super) near_median: usize,
    /// Matches on their row with a positive and with a negative disparity.
    pub(super) positive: usize,
    pub(super) negative: usize,
    /// Matches on their row with the right image of the frame before and after; `None` where nobody looked.
    pub(super) neighbors: Option<[usize; 2]>,
}

/// Looks at a few of `n` frames.
pub(super) fn look(feed: &dyn FrameFeed, setup: &Setup, n: usize) -> Vec<Sight> {
    let config =
        ExtractorConfig { keep: N_FEATURES, selection: SelectionRule::Response, ..setup.extractor.clone() };
    let mut extractor = Extractor::new(config);
    let count = N_SIGHTS.min(n);
    let places = (0..count).map(|k| (2 * k + 1) * n / (2 * count));
    places
        .filter_map(|place| {
            let tried = (place..n).take(N_TRIES);
            let (i, frame) = tried.filter_map(|i| Some((i, feed.load(i).ok()?))).next()?;
            Some(Sight::of(&frame, i, feed, setup, n, &mut extractor))
        })
        .collect()
}

impl Sight {
    fn of(
        frame: &LoadedFrame,
        i: usize,
        feed: &dyn FrameFeed,
        setup: &Setup,
        n: usize,
        extractor: &mut Extractor,
    ) -> Self {
        let left = extractor.extract(&frame.left);
        let mut sight = Self { left: Look::at(&frame.left, &left), ..Self::default() };
        if let Some(image) = &frame.right {
            let right = extractor.extract(image);
            sight.right = Some(Look::at(image, &right));
            let (mut pairing, disparities) = Pairing::of(&left, &right);
            if pairing.share() < SUSPICIOUS && i > 0 && i + 1 < n {
                let mut beside = |j: usize| {
                    let image = feed.load(j).ok()?.right?;
                    Some(Pairing::of(&left, &extractor.extract(&image)).0.on_row)
                };
                pairing.neighbors = beside(i - 1).zip(beside(i + 1)).map(<[usize; 2]>::from);
            }
            let bf = setup.rig.stereo.bf();
            sight.depths_m = disparities.iter().map(|&disparity| bf / f64::from(disparity)).collect();
            sight.pairing = Some(pairing);
        }
        if let Some(depth) = &frame.depth {
            let (depths_m, share) = sampled(depth, setup.depth.units_per_meter);
            (sight.depths_m, sight.with_depth) = (depths_m, Some(share));
        }
        if frame.right.is_none() && frame.depth.is_none() && frame.left.width >= WIDE * frame.left.height {
            let [first, second] = halves(&left, frame.left.width / 2);
            sight.halves = Some(Pairing::of(&first, &second).0);
        }
        sight
    }
}

impl Look {
    fn at(image: &GrayImage, features: &Features) -> Self {
        let sum: u64 = image.data.iter().map(|&level| u64::from(level)).sum();
        let brightness = sum as f64 / image.data.len().max(1) as f64;
        Self { brightness, corners: features.keypoints.len() }
    }
}

impl Pairing {
    /// The pairing, and the positive disparities of matches on their row, pixels.
    fn of(left: &Features, right: &Features) -> (Self, Vec<f32>) {
        let pairs = match_brute_force(&left.descriptors, &right.descriptors, MAX_DISTANCE, MAX_RATIO);
        let apart = pairs.iter().map(|&(i, j)| {
            let (l, r) = (&left.keypoints[i as usize], &right.keypoints[j as usize]);
            (l.x - r.x, r.y - l.y)
        });
        Self::of_shifts(&apart.collect::<Vec<_>>())
    }

    /// Of matches given as disparity and right row minus left row, pixels.
    pub(super) fn of_shifts(shifts: &[(f32, f32)]) -> (Self, Vec<f32>) {
        let mut rows: Vec<f64> = shifts.iter().map(|&(_, rows)| f64::from(rows)).collect();
        let median_rows_px = geometry::median(&mut rows).unwrap_or(0.0);
        let near = |rows: f64| (rows - median_rows_px).abs() <= f64::from(ROW_PX);
        let on_row: Vec<f32> =
            shifts.iter().filter(|(_, rows)| rows.abs() <= ROW_PX).map(|&(disparity, _)| disparity).collect();
        let positive: Vec<f32> = on_row.iter().copied().filter(|&d| d > SIGN_PX).collect();
        let pairing = Self {
            matches: shifts.len(),
            on_row: on_row.len(),
            median_rows_px,
            near_median: rows.iter().filter(|&&rows| near(rows)).count(),
            positive: positive.len(),
            negative: on_row.iter().filter(|&&d| d < -SIGN_PX).count(),
            neighbors: None,
        };
        (pairing, positive)
    }

    /// Share of the matches whose rows agree; 1 without any.
    pub(super) fn share(&self) -> f64 {
        if self.matches == 0 { 1.0 } else { self.on_row as f64 / self.matches as f64 }
    }
}

/// Features of the left and of the right half of an image, places counted from the edge of each.
fn halves(all: &Features, half: usize) -> [Features; 2] {
    [false, true].map(|is_right| {
        let edge = half as f32;
        let of_half = |keypoint: &Keypoint| (keypoint.x >= edge) == is_right;
        let both = all.keypoints.iter().zip(&all.descriptors).filter(|(keypoint, _)| of_half(keypoint));
        let moved = |k: &Keypoint| Keypoint { x: if is_right { k.x - edge } else { k.x }, ..*k };
        let (keypoints, descriptors) = both.map(|(k, descriptor)| (moved(k), *descriptor)).unzip();
        Features { keypoints, descriptors }
    })
}

/// Depths of a grid of pixels, meters, and the share of them that have one.
fn sampled(depth: &DepthImage, units_per_meter: f64) -> (Vec<f64>, f64) {
    let rows = (0..depth.height).step_by(DEPTH_STEP);
    let units: Vec<u16> = rows.flat_map(|y| depth.row(y).iter().step_by(DEPTH_STEP)).copied().collect();
    let known = units.iter().filter(|&&units| units > 0);
    let depths_m: Vec<f64> = known.map(|&units| f64::from(units) / units_per_meter).collect();
    let share = depths_m.len() as f64 / units.len().max(1) as f64;
    (depths_m, share)
}
