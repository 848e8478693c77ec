//! A field of painted boards that all face the camera, which never turns: images of it are scaled pictures, cheap to draw.

use std::sync::{Arc, OnceLock};

use bow::Vocabulary;
use dsslam_runtime::{FrameFeed, FrameInfo, Setup, Unusable};
use features::{ExtractorConfig, Rig};
use geometry::{Distortion, GrayImage, Pinhole, Sensor, StereoRig, Vec3, mix_seed};
use io::LoadedFrame;
use slam::{CameraParams, Params};

const WIDTH: usize = 400;
const HEIGHT: usize = 250;
const FOCAL_PX: f64 = 250.0;
const BASELINE_M: f64 = 0.5;
/// How far apart the two places are that look alike.
pub(crate) const SIDE_M: f64 = 15.0;
/// Half of their width.
const ALIKE_M: f64 = 6.0;
/// Where along z they begin and end.
const ALIKE_Z_M: [f64; 2] = [0.0, 40.0];
/// Nothing is seen beyond.
const VIEW_M: f64 = 22.0;
const STEP_M: f64 = 0.65;
/// How long both sides are, and how far the first one is driven once more.
const FAR_M: f64 = 60.0;
const AGAIN_M: f64 = 45.0;
/// Boards per square meter.
const DENSITY: f64 = 0.25;
/// Fields of a board's picture along each side.
const FIELDS: usize = 3;

struct Board {
    center: Vec3,
    half_m: f64,
    seed: u64,
}

/// A drive and its images, drawn when they are asked for.
pub(crate) struct Drive {
    boards: Vec<Board>,
    /// Where the camera is, frame after frame.
    pub(crate) centers: Vec<Vec3>,
    images: Vec<OnceLock<LoadedFrame>>,
}

/// A number from 0 to 1 of its own for each `n` and `purpose`.
fn random(n: u64, purpose: u64) -> f64 {
    (mix_seed(7, n, purpose) >> 11) as f64 / (1u64 << 53) as f64
}

fn boards() -> Vec<Board> {
    let (x, z) = ([-15.0, SIDE_M + 15.0], [-15.0, 110.0]);
    let n = (DENSITY * (x[1] - x[0]) * (z[1] - z[0])) as u64;
    let board = |i: u64| {
        let between = |ends: [f64; 2], purpose| ends[0] + (ends[1] - ends[0]) * random(i, purpose);
        let center = Vec3::new(between(x, 0), between([-2.5, 2.5], 1), between(z, 2));
        Board { center, half_m: between([0.25, 0.6], 3), seed: i }
    };
    let is_at = |b: &Board, x: f64| {
        (b.center.x - x).abs() < ALIKE_M && (ALIKE_Z_M[0]..ALIKE_Z_M[1]).contains(&b.center.z)
    };
    let mut boards: Vec<Board> = (0..n).map(board).filter(|b| !is_at(b, SIDE_M)).collect();
    let copy = |b: &Board| Board { center: b.center + Vec3::new(SIDE_M, 0.0, 0.0), ..*b };
    let copies: Vec<Board> = boards.iter().filter(|b| is_at(b, 0.0)).map(copy).collect();
    boards.extend(copies);
    boards.sort_by(|a, b| b.center.z.total_cmp(&a.center.z));
    boards
}

/// Up one side, far ahead, around and down the other side, around and up the first side once more.
fn centers() -> Vec<Vec3> {
    let (radius, straight) = (0.5 * SIDE_M, FAR_M);
    let arc = std::f64::consts::PI * radius;
    let round = 2.0 * (straight + arc);
    let at = |s: f64| {
        // Half a round further everything is turned about the middle.
        let (half, s) = (s % round >= 0.5 * round, s % (0.5 * round));
        let (x, z) = if s < straight {
            (-radius, s - 0.5 * straight)
        } else {
            let angle = (s - straight) / radius;
            (-radius * angle.cos(), 0.5 * straight + radius * angle.sin())
        };
        let sign = if half { -1.0 } else { 1.0 };
        Vec3::new(radius + sign * x, 0.0, 0.5 * straight + sign * z)
    };
    let n = ((round + AGAIN_M) / STEP_M) as usize;
    (0..n).map(|i| at(i as f64 * STEP_M)).collect()
}

impl Drive {
    pub(crate) fn new() -> Self {
        let centers = centers();
        let images = centers.iter().map(|_| OnceLock::new()).collect();
        Drive { boards: boards(), centers, images }
    }

    /// A camera whose path is believed three times less than others': after half a round the wrong place is within its drift. Loops
    /// as early as possible, since the drive is short.
    pub(crate) fn setup(&self) -> Setup {
        let camera = Pinhole { fx: FOCAL_PX, fy: FOCAL_PX, cx: WIDTH as f64 / 2.0, cy: HEIGHT as f64 / 2.0 };
        let stereo = StereoRig { camera, baseline_m: BASELINE_M };
        let rig = Rig { stereo, distortion: Distortion::default(), width: WIDTH, height: HEIGHT };
        let mut slam = Params::of(CameraParams::stereo(12.0, 10.0));
        slam.camera.drift_sigma = 0.03;
        slam.tracking.min_inliers = 15;
        slam.loops.min_gap = 6;
        slam.loops.consistency = 1;
        slam.loops.min_inliers = 30;
        slam.loops.essential_weight = 40;
        Setup {
            extractor: ExtractorConfig { keep: 800, ..ExtractorConfig::default() },
            vocabulary: Some(Arc::new(Vocabulary::built_in().unwrap())),
            ..Setup::new(Sensor::Stereo, Arc::new(rig), slam)
        }
    }

    fn draw(&self, center: &Vec3) -> GrayImage {
        let mut image = GrayImage::new(WIDTH, HEIGHT, 128);
        for board in &self.boards {
            let seen = board.center - center;
            if (1.0..VIEW_M).contains(&seen.z) {
                board.draw(&seen, &mut image);
            }
        }
        image
    }
}

impl Board {
    /// Paints it where it is `seen` from the camera, each pixel the mean of four.
    fn draw(&self, seen: &Vec3, image: &mut GrayImage) {
        let size_px = 2.0 * self.half_m * FOCAL_PX / seen.z;
        let left = WIDTH as f64 / 2.0 + FOCAL_PX * (seen.x - self.half_m) / seen.z;
        let top = HEIGHT as f64 / 2.0 + FOCAL_PX * (seen.y - self.half_m) / seen.z;
        let range = |from: f64, end: usize| {
            let from_px = from.ceil().clamp(0.0, end as f64) as usize;
            from_px..((from + size_px).ceil().clamp(0.0, end as f64) as usize)
        };
        let shade = |x: f64, y: f64| {
            let field = |v: f64, from: f64| {
                (((v - from) / size_px * FIELDS as f64).max(0.0) as usize).min(FIELDS - 1)
            };
            let n = field(y, top) * FIELDS + field(x, left);
            mix_seed(self.seed, n as u64, 4) % 256
        };
        for y in range(top, HEIGHT) {
            for x in range(left, WIDTH) {
                let at = |dx: f64, dy: f64| shade(x as f64 + dx, y as f64 + dy);
                let sum = at(-0.25, -0.25) + at(0.25, -0.25) + at(-0.25, 0.25) + at(0.25, 0.25);
                image.data[y * WIDTH + x] = (sum / 4) as u8;
            }
        }
    }
}

impl FrameFeed for Drive {
    fn size_hint(&self) -> Option<usize> {
        Some(self.centers.len())
    }

    fn info(&self, i: usize) -> FrameInfo {
        FrameInfo { index: i as u32, timestamp_s: i as f64 * 0.1 }
    }

    fn load(&self, i: usize) -> Result<LoadedFrame, Unusable> {
        let images = self.images[i].get_or_init(|| {
            let left = self.centers[i];
            let right = left + Vec3::new(BASELINE_M, 0.0, 0.0);
            LoadedFrame { left: self.draw(&left), right: Some(self.draw(&right)), depth: None }
        });
        Ok(images.clone())
    }
}
