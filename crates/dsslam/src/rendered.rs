//! A rendered world as something to run on: its frames are rendered when they are asked for.

use std::path::Path;

use geometry::Distortion;
use io::{
    Calibration, DatasetError, ImageSize, LoadedFrame, Sensor, Sequence, SequenceKind, StampedPose,
    Trajectory,
};
use runtime::{FrameFeed, FrameInfo, Preparation, Unusable};
use synth::World;

/// The first frames of a world.
#[derive(Debug)]
pub(crate) struct RenderedFeed {
    pub(crate) world: World,
    /// How many frames there are.
    pub(crate) len: usize,
    /// Whose images there are.
    pub(crate) sensor: Sensor,
    pub(crate) preparation: Preparation,
}

impl FrameFeed for RenderedFeed {
    fn size_hint(&self) -> Option<usize> {
        Some(self.len)
    }

    fn info(&self, i: usize) -> FrameInfo {
        FrameInfo::new(i, self.world.timestamp_s(i))
    }

    fn load(&self, i: usize) -> Result<LoadedFrame, Unusable> {
        let images = self.world.images(i);
        let right = (self.sensor == Sensor::Stereo).then_some(images.right);
        let frame = LoadedFrame { left: images.left, right, depth: None };
        self.preparation.apply(frame, Path::new(self.world.preset().name()))
    }
}

/// Size of the images of a world.
pub(crate) fn image_size(world: &World) -> ImageSize {
    let (width, height) = world.image_size();
    ImageSize { width, height }
}

/// The first `len` frames of a world as a sequence with its exact poses; its list of files is empty.
///
/// # Errors
/// A sensor that needs images of depth.
pub(crate) fn sequence(world: &World, len: usize, sensor: Sensor) -> Result<Sequence, DatasetError> {
    let name = world.preset().name();
    if sensor == Sensor::Rgbd {
        let reason = "rendered frames have a left and a right image, and no depth";
        return Err(DatasetError::unavailable(name.as_ref(), sensor, reason));
    }
    let pose =
        |i: usize| StampedPose { timestamp_s: world.timestamp_s(i), world_from_cam: world.world_from_cam(i) };
    let source = "the renderer".to_owned();
    Ok(Sequence {
        calibration: Some(Calibration { rig: world.rig(), distortion: Distortion::default(), source }),
        ground_truth: Some(Trajectory { poses: (0..len).map(pose).collect() }),
        ..Sequence::new(name, SequenceKind::Rendered, sensor)
    })
}
