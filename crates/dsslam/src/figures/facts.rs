//! What calibration, times, layout, ground truth and start map say.

use eval::TIMESTAMP_TOLERANCE_S;
use features::Rig;
use geometry::{CameraModel, ImageSize, SE3, Sensor};
use io::{RawCamera, SequenceKind};

use super::sight::{self, Sight};
use crate::Session;

/// Everything that is shown and doubted.
#[derive(Clone, Debug)]
pub(crate) struct Facts {
    pub(super) sensor: Sensor,
    pub(super) layout: &'static str,
    /// Where the camera was read.
    pub(super) source: String,
    /// The camera that SLAM sees, after reduction and rectification.
    pub(super) rig: Rig,
    /// The cameras as they are calibrated, the left one first.
    pub(super) cameras: Vec<RawCamera>,
    pub(super) is_rectified: bool,
    pub(super) units_per_meter: f64,
    /// `None` where frames come as a stream.
    pub(super) times: Option<Times>,
    /// Frames with a true pose; `None` without ground truth.
    pub(super) with_truth: Option<usize>,
    /// The camera of the start map.
    pub(super) map_rig: Option<Rig>,
    /// Frames that were looked at.
    pub(super) sights: Vec<Sight>,
}

/// Times of all frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Times {
    pub(super) n: usize,
    pub(super) span_s: f64,
    /// Median time from frame to frame, seconds; `None` for a single frame.
    pub(super) step_s: Option<f64>,
    pub(super) longest_step_s: f64,
    /// Whether no file gives them.
    pub(super) are_invented: bool,
}

impl Facts {
    pub(crate) fn gather(session: &Session) -> Self {
        let (input, setup) = (session.input(), session.setup());
        let (sequence, feed, rig) = (input.sequence(), input.feed(), &*setup.rig);
        let raw = sequence.raw_calibration.as_ref();
        let times = feed.size_hint().filter(|_| sequence.kind != SequenceKind::Video).map(|n| {
            let times_s: Vec<f64> = (0..n).map(|i| feed.info(i).timestamp_s).collect();
            let with_truth = sequence.ground_truth.as_ref().map(|truth| {
                let has = |time: &&f64| truth.find_nearest(**time, TIMESTAMP_TOLERANCE_S).is_some();
                times_s.iter().filter(has).count()
            });
            (Times::of(&times_s, sequence.times == io::Times::Invented), with_truth)
        });
        let (times, with_truth) = times.map_or((None, None), |(times, with_truth)| (Some(times), with_truth));
        let calibration = sequence.calibration.as_ref();
        let source = calibration.map(|calibration| calibration.source.clone());
        Self {
            sensor: setup.sensor,
            layout: sequence.kind.name(),
            source: source.unwrap_or_else(|| input.config().provenance("camera.fx").to_string()),
            rig: rig.clone(),
            cameras: raw.map_or_else(|| vec![camera_of(rig)], |raw| raw.cameras.clone()),
            is_rectified: !sequence.rectification.is_empty(),
            units_per_meter: setup.depth.units_per_meter,
            with_truth,
            map_rig: setup.start.as_ref().and_then(|map| Some((*map.keyframes().next()?.frame.rig).clone())),
            sights: times.as_ref().map_or(Vec::new(), |times| sight::look(feed, setup, times.n)),
            times,
        }
    }
}

/// The camera that SLAM sees.
pub(super) fn camera_of(rig: &Rig) -> RawCamera {
    let model = CameraModel::Pinhole { camera: rig.stereo.camera, distortion: rig.distortion };
    let size = ImageSize { width: rig.width, height: rig.height };
    RawCamera { model, size, body_from_cam: SE3::identity() }
}

impl Times {
    pub(super) fn of(times_s: &[f64], are_invented: bool) -> Self {
        let mut steps: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let ends = times_s.first().zip(times_s.last());
        Self {
            n: times_s.len(),
            span_s: ends.map_or(0.0, |(first, last)| last - first),
            longest_step_s: steps.iter().copied().fold(0.0, f64::max),
            step_s: geometry::median(&mut steps),
            are_invented,
        }
    }
}
