//! From decoded images to a frame with features, or the reason why there is none. Needs no map.

use std::sync::Arc;

use features::{Frame, FrameBuilder};
use geometry::Sensor;
use io::{ImageSize, LoadedFrame};

use crate::details::Seen;
use crate::feed::{FrameInfo, FrameMask};
use crate::fetch::Fetched;
use crate::job::Plan;
use crate::record::Unusable;
use crate::timings::Stopwatch;

/// A frame on its way to tracking.
pub(crate) struct Extracted {
    /// Position in the feed.
    pub(crate) n: usize,
    pub(crate) info: FrameInfo,
    pub(crate) frame: Result<Arc<Frame>, Unusable>,
    /// What the features were found in, if an observer wants details.
    pub(crate) seen: Option<Seen>,
    pub(crate) watch: Stopwatch,
}

/// The stage that extracts features.
pub(crate) struct ExtractStage {
    sensor: Sensor,
    /// Size of the camera's images.
    size: ImageSize,
    /// Why there is no builder: the network cannot be opened.
    builder: Result<FrameBuilder, Unusable>,
    /// Where features may be taken in frames without a mask of their own.
    mask: FrameMask,
    /// Whether an observer wants details.
    details: bool,
}

impl ExtractStage {
    pub(crate) fn new(plan: &Plan) -> Self {
        let mut builder = plan.setup.frame_builder(plan.disparity_offset_px).map_err(Unusable::Network);
        if let (true, Ok(builder)) = (plan.details, &mut builder) {
            builder.keep_activation_maps();
        }
        let rig = &plan.setup.rig;
        let size = ImageSize { width: rig.width, height: rig.height };
        let (sensor, mask, details) = (plan.setup.sensor, plan.setup.mask.clone(), plan.details);
        ExtractStage { sensor, size, builder, mask, details }
    }

    /// Makes a frame of images.
    pub(crate) fn extract(&mut self, fetched: Fetched) -> Extracted {
        let Fetched { n, info, images, decode_ms, mask } = fetched;
        let mut watch = Stopwatch::new(info.index);
        watch.add("decode", decode_ms);
        let mut seen = None;
        let frame = images.and_then(|images| self.usable(images)).and_then(|images| {
            let builder = self.builder.as_mut().map_err(|reason| reason.clone())?;
            builder.set_mask(mask.unwrap_or_else(|| self.mask.clone()));
            let frame = watch.time("extract", |_| build(builder, self.sensor, info, &images));
            let frame = frame.map_err(Unusable::Network)?;
            seen = self.details.then(|| Seen {
                image: Arc::new(images.left),
                activation: builder.take_activation_map().map(Arc::new),
            });
            Ok(Arc::new(frame))
        });
        Extracted { n, info, frame, seen, watch }
    }

    /// Whether the images are there and fit the camera.
    fn usable(&self, images: LoadedFrame) -> Result<LoadedFrame, Unusable> {
        let check = |image: &'static str, width: usize, height: usize| {
            let (found, expected) = (ImageSize { width, height }, self.size);
            if found == expected { Ok(()) } else { Err(Unusable::Size { image, found, expected }) }
        };
        check("left", images.left.width, images.left.height)?;
        match self.sensor {
            Sensor::Stereo => {
                let right = images.right.as_ref().ok_or(Unusable::Missing("right"))?;
                check("right", right.width, right.height)?;
            }
            Sensor::Rgbd => {
                let depth = images.depth.as_ref().ok_or(Unusable::Missing("depth"))?;
                check("depth", depth.width, depth.height)?;
            }
            Sensor::Mono => {}
        }
        Ok(images)
    }
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
