//! From decoded images to a frame with features, or the reason why there is none. Needs no map.

use std::sync::Arc;

use features::{Frame, FrameBuilder};
use geometry::Sensor;
use io::LoadedFrame;

use crate::details::Seen;
use crate::feed::FrameInfo;
use crate::fetch::Fetched;
use crate::job::Job;
use crate::setup::Setup;
use crate::timings::Stopwatch;

/// A frame on its way to tracking.
pub(crate) struct Extracted {
    /// Position in the feed.
    pub(crate) n: usize,
    pub(crate) info: FrameInfo,
    pub(crate) frame: Result<Arc<Frame>, String>,
    /// What the features were found in, if an observer wants details.
    pub(crate) seen: Option<Seen>,
    pub(crate) watch: Stopwatch,
}

/// The stage that extracts features.
pub(crate) struct ExtractStage<'a> {
    setup: &'a Setup,
    /// Why there is no builder: the network cannot be opened.
    builder: Result<FrameBuilder, String>,
    /// Whether an observer wants details.
    details: bool,
}

impl<'a> ExtractStage<'a> {
    pub(crate) fn new(job: &Job<'a>) -> Self {
        let mut builder = job.setup.frame_builder(job.disparity_offset_px);
        if let (true, Ok(builder)) = (job.details, &mut builder) {
            builder.keep_activation_maps();
        }
        ExtractStage { setup: job.setup, builder, details: job.details }
    }

    /// Makes a frame of images.
    pub(crate) fn extract(&mut self, fetched: Fetched) -> Extracted {
        let Fetched { n, info, images, decode_ms } = fetched;
        let mut watch = Stopwatch::new(info.index);
        watch.add("decode", decode_ms);
        let mut seen = None;
        let frame = images.and_then(|images| usable(images, self.setup)).and_then(|images| {
            let builder = self.builder.as_mut().map_err(|reason| reason.clone())?;
            let frame = watch.time("extract", |_| build(builder, self.setup.sensor, info, &images))?;
            seen = self.details.then(|| Seen {
                image: Arc::new(images.left),
                activation: builder.take_activation_map().map(Arc::new),
            });
            Ok(Arc::new(frame))
        });
        Extracted { n, info, frame, seen, watch }
    }
}

/// Whether the images fit the camera and each other.
fn usable(images: LoadedFrame, setup: &Setup) -> Result<LoadedFrame, String> {
    let expected = (setup.rig.width, setup.rig.height);
    let check = |name: &str, width: usize, height: usize| {
        if (width, height) == expected {
            return Ok(());
        }
        Err(format!(
            "the {name} image is {width} x {height} pixels, expected {} x {}",
            expected.0, expected.1
        ))
    };
    check("left", images.left.width, images.left.height)?;
    match setup.sensor {
        Sensor::Stereo => {
            let right = images.right.as_ref().ok_or("there is no right image")?;
            check("right", right.width, right.height)?;
        }
        Sensor::Rgbd => {
            let depth = images.depth.as_ref().ok_or("there is no depth image")?;
            check("depth", depth.width, depth.height)?;
        }
        Sensor::Mono => {}
    }
    Ok(images)
}

fn build(
    builder: &mut FrameBuilder,
    sensor: Sensor,
    info: FrameInfo,
    images: &LoadedFrame,
) -> Result<Frame, String> {
    match (sensor, &images.right, &images.depth) {
        (Sensor::Stereo, Some(right), _) => builder.stereo(info.index, info.timestamp_s, &images.left, right),
        (Sensor::Rgbd, _, Some(depth)) => builder.rgbd(info.index, info.timestamp_s, &images.left, depth),
        _ => builder.mono(info.index, info.timestamp_s, &images.left),
    }
}
