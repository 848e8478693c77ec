//! Frames of a rendered world in any order, at half the size, for tests that drive the library itself. Each is
//! rendered once.

use std::sync::{Arc, LazyLock, OnceLock};

use features::{ExtractorConfig, Rig};
use geometry::{Distortion, GrayImage, Pinhole, Sensor, StereoRig};
use io::LoadedFrame;
use runtime::{FrameFeed, FrameInfo, Setup, Unusable};
use slam::{CameraParams, Params};
use synth::{Preset, World};

/// The town, and the frames of its course that were rendered so far.
static TOWN: LazyLock<(World, Vec<OnceLock<LoadedFrame>>)> = LazyLock::new(|| {
    let world = World::new(Preset::Town, 1, 1);
    let images = (0..world.n_frames()).map(|_| OnceLock::new()).collect();
    (world, images)
});

/// A drive through the town: frames of its course in any order.
pub(crate) struct RenderedFeed {
    order: Vec<usize>,
    /// Seconds from frame to frame.
    period_s: f64,
}

impl RenderedFeed {
    pub(crate) fn new(order: impl IntoIterator<Item = usize>) -> Self {
        RenderedFeed { order: order.into_iter().collect(), period_s: 0.1 }
    }

    /// The same frames with timestamps this far apart.
    pub(crate) fn paced(mut self, period_s: f64) -> Self {
        self.period_s = period_s;
        self
    }

    /// Number of its frames.
    pub(crate) fn len(&self) -> usize {
        self.order.len()
    }

    /// A setup for it, with small frames, loops and the built-in vocabulary.
    pub(crate) fn setup(&self) -> Setup {
        let StereoRig { camera, baseline_m } = TOWN.0.rig();
        let (width, height) = TOWN.0.image_size();
        // The center of the new pixel 0 lies between the old pixels 0 and 1.
        let half = |c: f64| (c - 0.5) / 2.0;
        let camera =
            Pinhole { fx: camera.fx / 2.0, fy: camera.fy / 2.0, cx: half(camera.cx), cy: half(camera.cy) };
        let rig = Rig {
            stereo: StereoRig { camera, baseline_m },
            distortion: Distortion::default(),
            width: width / 2,
            height: height / 2,
        };
        let vocabulary = Arc::new(bow::Vocabulary::built_in().unwrap());
        Setup {
            extractor: ExtractorConfig { keep: 700, ..ExtractorConfig::default() },
            vocabulary: Some(vocabulary),
            ..Setup::new(
                Sensor::Stereo,
                Arc::new(rig),
                Params::of(CameraParams::stereo(40.0 * baseline_m, 10.0)),
            )
        }
    }
}

impl FrameFeed for RenderedFeed {
    fn size_hint(&self) -> Option<usize> {
        Some(self.order.len())
    }

    fn info(&self, i: usize) -> FrameInfo {
        FrameInfo { index: i as u32, timestamp_s: i as f64 * self.period_s }
    }

    fn load(&self, i: usize) -> Result<LoadedFrame, Unusable> {
        let (world, images) = &*TOWN;
        let images = images[self.order[i]].get_or_init(|| {
            let images = world.images(self.order[i]);
            LoadedFrame { left: halved(&images.left), right: Some(halved(&images.right)), depth: None }
        });
        Ok(images.clone())
    }
}

/// The mean of each two by two pixels.
fn halved(image: &GrayImage) -> GrayImage {
    let (width, height) = (image.width / 2, image.height / 2);
    let mut small = GrayImage::new(width, height, 0);
    for y in 0..height {
        for x in 0..width {
            let at = |dx: usize, dy: usize| u32::from(image.data[(2 * y + dy) * image.width + 2 * x + dx]);
            small.data[y * width + x] = ((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1) + 2) / 4) as u8;
        }
    }
    small
}
