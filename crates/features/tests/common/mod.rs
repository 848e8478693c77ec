//! Images with known content for the tests of this crate.
#![allow(dead_code, unreachable_pub)]

use dsslam_features::{ExtractorConfig, Rig};
use geometry::{Distortion, GrayImage, Pinhole, StereoRig};
use std::sync::Arc;

pub const WIDTH: usize = 640;
pub const HEIGHT: usize = 240;

/// Brightness, about 0 to 255, at any place of an unlimited textured plane, smooth at the scale of a pixel.
pub fn texture(x: f64, y: f64) -> f64 {
    let octave = |period: f64, seed: u64, strength: f64| strength * value_noise(x / period, y / period, seed);
    20.0 + octave(3.1, 1, 70.0) + octave(7.3, 2, 90.0) + octave(19.0, 3, 60.0)
}

/// Smooth noise in [0, 1] with one random value per whole place (cubic interpolation).
fn value_noise(x: f64, y: f64, seed: u64) -> f64 {
    let (x0, y0) = (x.floor(), y.floor());
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (tx, ty) = (smooth(x - x0), smooth(y - y0));
    let at = |i: i64, j: i64| hash(x0 as i64 + i, y0 as i64 + j, seed);
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    mix(mix(at(0, 0), at(1, 0), tx), mix(at(0, 1), at(1, 1), tx), ty)
}

fn hash(x: i64, y: i64, seed: u64) -> f64 {
    let mixed = geometry::mix_seed(seed, x as u64, y as u64);
    (mixed >> 40) as f64 / f64::from(1 << 24)
}

/// The image whose pixel `(x, y)` shows the texture at `place(x, y)`.
pub fn render(place: impl Fn(f64, f64) -> (f64, f64)) -> GrayImage {
    GrayImage::from_fn(WIDTH, HEIGHT, |x, y| {
        let (u, v) = place(x as f64, y as f64);
        texture(u, v).round().clamp(0.0, 255.0) as u8
    })
}

/// Left and right image of a surface whose disparity at column `x` of the right image and row `y` is `disparity(y)`.
pub fn stereo_pair(disparity: impl Fn(f64) -> f64) -> (GrayImage, GrayImage) {
    (render(|x, y| (x, y)), render(|x, y| (x + disparity(y), y)))
}

/// A camera for these images: disparity 120 px is the nearest that is searched by default.
pub fn rig() -> Arc<Rig> {
    let camera = Pinhole { fx: 600.0, fy: 600.0, cx: WIDTH as f64 / 2.0, cy: HEIGHT as f64 / 2.0 };
    let distortion = Distortion { k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, k3: 0.0 };
    Arc::new(Rig { stereo: StereoRig { camera, baseline_m: 0.5 }, distortion, width: WIDTH, height: HEIGHT })
}

pub fn config() -> ExtractorConfig {
    ExtractorConfig { keep: 1000, ..ExtractorConfig::default() }
}

pub fn median(mut values: Vec<f64>) -> f64 {
    assert!(!values.is_empty());
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Runs with this many threads.
pub fn with_threads<R: Send>(n: usize, f: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads").install(f)
}
