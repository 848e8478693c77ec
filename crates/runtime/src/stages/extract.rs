//! From decoded images to a frame with features, or the reason why there is none. Needs no map.

use std::sync::Arc;

use crossbeam::channel::{Receiver, Sender};
use features::{ActivationError, BuiltFrame, FrameBuilder};
use geometry::Sensor;
use io::{ImageSize, LoadedFrame};

use crate::events::SourceImages;
use crate::feed::{FrameInfo, FrameMask};

use crate::record::Unusable;
use crate::run::{Job, Plan};
use crate::stages::fetch::{Extracted, Fetched, Passing};

/// The stage that extracts features.
pub(crate) struct ExtractStage {
    sensor: Sensor,
    /// Size of the camera's images.
    size: ImageSize,
    builder: FrameBuilder,
    /// Where features may be taken in frames without a mask of their own.
    mask: FrameMask,
    /// Whether an observer wants details.
    details: bool,
}

impl ExtractStage {
    pub(crate) fn new(plan: &Plan) -> Self {
        let builder = plan.setup.frame_builder(plan.disparity_offset_px);
        let rig = &plan.setup.rig;
        let size = ImageSize { width: rig.width, height: rig.height };
        let (sensor, mask, details) = (plan.setup.sensor, plan.setup.mask.clone(), plan.details);
        ExtractStage { sensor, size, builder, mask, details }
    }

    /// Makes a frame of images.
    pub(crate) fn extract(&mut self, fetched: Fetched) -> Extracted {
        let Passing { n, info, content, mut watch } = fetched;
        let content = content.and_then(|(images, mask)| {
            let images = self.usable(images)?;
            self.builder.set_mask(mask.unwrap_or_else(|| self.mask.clone()));
            let (frame, map) = watch.time("extract", |_| self.build(info, &images))?;
            let seen = self
                .details
                .then(|| SourceImages { image: Arc::new(images.left), activation: map.map(Arc::new) });
            Ok((Arc::new(frame), seen))
        });
        Passing { n, info, content, watch }
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

    fn build(&mut self, info: FrameInfo, images: &LoadedFrame) -> Result<BuiltFrame, ActivationError> {
        let (FrameInfo { index, timestamp_s }, left) = (info, &images.left);
        match (self.sensor, &images.right, &images.depth) {
            (Sensor::Stereo, Some(right), _) => self.builder.stereo(index, timestamp_s, left, right),
            (Sensor::Rgbd, _, Some(depth)) => self.builder.rgbd(index, timestamp_s, left, depth),
            _ => self.builder.mono(index, timestamp_s, left),
        }
    }
}

/// Extracts features until no more frames come or the reader is gone.
pub(crate) fn extract(job: &Job<'_>, fetched: &Receiver<Fetched>, to_track: &Sender<Extracted>) {
    let mut stage = ExtractStage::new(&job.plan);
    let mut faults = job.plan.faults("extract");
    for fetched in fetched {
        faults.step();
        if to_track.send(stage.extract(fetched)).is_err() {
            return;
        }
    }
}
