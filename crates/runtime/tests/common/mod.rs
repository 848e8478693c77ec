//! A camera before a wall, for tests that drive the runtime itself.
#![allow(
    dead_code,
    clippy::unwrap_used,
    reason = "not every test needs all of it, and stops at the first problem"
)]

use std::sync::Arc;

use dsslam_runtime::{FrameFeed, FrameInfo, Schedule, Setup, Unusable};
use features::{ExtractorConfig, Rig};
use geometry::{Distortion, GrayImage, Pinhole, Sensor, StereoRig};
use io::{ImageError, LoadedFrame};
use slam::{CameraParams, Params};

pub(crate) const WIDTH: usize = 320;
pub(crate) const HEIGHT: usize = 200;

/// What the feed gives for a frame.
#[derive(Clone, Copy)]
pub(crate) enum Kind {
    Good,
    Black,
    Broken,
    NoRight,
    OtherSize,
}

/// A camera that stands still before a wall of blocks, 12 pixels of disparity away.
pub(crate) struct Feed(pub(crate) Vec<Kind>);

impl FrameFeed for Feed {
    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }

    fn info(&self, i: usize) -> FrameInfo {
        FrameInfo { index: i as u32, timestamp_s: i as f64 * 0.1 }
    }

    fn load(&self, i: usize) -> Result<LoadedFrame, Unusable> {
        let black = GrayImage::new(WIDTH, HEIGHT, 0);
        let (left, right) = match self.0[i] {
            Kind::Good => (wall(0), Some(wall(12))),
            Kind::Black => (black.clone(), Some(black)),
            Kind::Broken => return Err(broken()),
            Kind::NoRight => (wall(0), None),
            Kind::OtherSize => (wall(0), Some(GrayImage::new(WIDTH / 2, HEIGHT, 0))),
        };
        Ok(LoadedFrame { left, right, depth: None })
    }
}

pub(crate) fn broken() -> Unusable {
    ImageError::Unreadable { path: "left.png".into(), reason: "unexpected end of file".into() }.into()
}

/// Blocks of random-looking brightness, moved left by `shift` pixels.
pub(crate) fn wall(shift: usize) -> GrayImage {
    let shade = |x: usize, y: usize| {
        let mut h = ((x / 7) as u32).wrapping_mul(0x9E37_79B1) ^ ((y / 6) as u32).wrapping_mul(0x85EB_CA77);
        h ^= h >> 15;
        h = h.wrapping_mul(0x2C1B_3C6D);
        (h >> 24) as u8
    };
    let mut image = GrayImage::new(WIDTH, HEIGHT, 0);
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            image.data[y * WIDTH + x] = shade(x + shift, y);
        }
    }
    image
}

pub(crate) fn setup() -> Setup {
    let camera = Pinhole { fx: 300.0, fy: 300.0, cx: 160.0, cy: 100.0 };
    let stereo = StereoRig { camera, baseline_m: 0.5 };
    let rig = Rig { stereo, distortion: Distortion::default(), width: WIDTH, height: HEIGHT };
    Setup {
        extractor: ExtractorConfig { keep: 500, ..ExtractorConfig::default() },
        schedule: Schedule::Sequential,
        ..Setup::new(Sensor::Stereo, Arc::new(rig), Params::of(CameraParams::stereo(40.0, 10.0)))
    }
}
