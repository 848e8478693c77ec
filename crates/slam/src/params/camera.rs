//! What follows from the camera: its sensor, its frame rate, and how far its depths are trusted.

use geometry::Sensor;

/// Residuals of rectified stereo on real drives have a standard deviation of 0.35 px at octave 0; twice that leaves room
/// for what a chi-square test should not call an outlier.
const STEREO_SIGMA_PX: f64 = 0.7;
/// Rolling shutters, motion blur and depth that is not quite of the same moment: as ORB-SLAM2.
const RGBD_SIGMA_PX: f64 = 1.0;
/// delta of 1.4 times the noise that features of a blurred hand-held camera have, 0.55 px: on six variants of TUM fr1/desk, by which
/// it was chosen, the ATE is 0.975 times that of a limit three times as wide. On drives, whose noise is 0.2 px, narrower is worse.
const RGBD_HUBER: f64 = 0.1;
/// As RGB-D: nothing but the rows and columns of one image.
const MONO_SIGMA_PX: f64 = 1.0;

/// Parameters that follow from the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraParams {
    /// Which images a frame has. With one camera maps start from two views, and their unit of length is free.
    pub sensor: Sensor,
    /// Features nearer than this depth count as close, meters.
    pub close_depth_m: f64,
    /// Standard deviation of a feature's position at octave 0, pixels; errors are judged in units of it.
    pub feature_sigma_px: f64,
    /// delta^2 of Huber's loss in bundle adjustment as a part of the 95 % limit; below 1 its last round is robust, too.
    pub huber: f64,
    /// Half window of the search around the predicted position, pixels at octave 0.
    pub motion_radius_px: f32,
    /// Factor on the local map's search window.
    pub local_radius_factor: f32,
    /// A keyframe is due after this many frames without one (the frame rate, that is one second).
    pub max_keyframe_gap: u32,
    /// Frames that could start a map, one after another, lost, before a new sub-map is started.
    pub max_lost_frames: u32,
    /// [`TrackingParams::keyframe_ratio`](super::TrackingParams) where that is absent.
    pub keyframe_ratio: f64,
    /// [`MappingParams::neighbors`](super::MappingParams) where that is absent.
    pub neighbours: usize,
    /// Length of a meter in the map: 1 where lengths are meters.
    pub unit: f64,
    /// Drift that is expected, meters per meter of path (standard deviation).
    pub drift_sigma: f64,
    /// Maximum plausible drift when places are looked for, meters per meter of path.
    pub max_drift: f64,
    /// Added to it: how far two views of one place can be apart, meters.
    pub prior_margin_m: f64,
}

impl CameraParams {
    /// Of rectified stereo; `close_depth_m` is usually 35 to 40 baselines.
    pub fn stereo(close_depth_m: f64, frame_rate_hz: f64) -> Self {
        let one_second = frame_rate_hz.round().max(1.0) as u32;
        Self {
            sensor: Sensor::Stereo,
            close_depth_m,
            feature_sigma_px: STEREO_SIGMA_PX,
            huber: 1.0,
            motion_radius_px: 7.0,
            local_radius_factor: 1.0,
            max_keyframe_gap: one_second,
            max_lost_frames: one_second,
            keyframe_ratio: 0.75,
            neighbours: 10,
            unit: 1.0,
            drift_sigma: 0.01,
            max_drift: 0.05,
            prior_margin_m: close_depth_m,
        }
    }

    /// Of RGB-D: wider windows, since hand-held cameras turn faster.
    pub fn rgbd(close_depth_m: f64, frame_rate_hz: f64) -> Self {
        Self {
            sensor: Sensor::Rgbd,
            feature_sigma_px: RGBD_SIGMA_PX,
            huber: RGBD_HUBER,
            motion_radius_px: 15.0,
            local_radius_factor: 3.0,
            drift_sigma: 0.02,
            max_drift: 0.1,
            ..Self::stereo(close_depth_m, frame_rate_hz)
        }
    }

    /// Of one camera without depth.
    pub fn mono(frame_rate_hz: f64) -> Self {
        Self {
            sensor: Sensor::Mono,
            feature_sigma_px: MONO_SIGMA_PX,
            motion_radius_px: 15.0,
            keyframe_ratio: 0.9,
            neighbours: 20,
            // The unit is the first scene's median depth, of the order of ten meters.
            unit: 0.1,
            drift_sigma: 0.1,
            max_drift: f64::INFINITY,
            prior_margin_m: 0.0,
            ..Self::stereo(f64::INFINITY, frame_rate_hz)
        }
    }

    /// Of this sensor; depth does not count with one camera.
    pub fn new(sensor: Sensor, close_depth_m: f64, frame_rate_hz: f64) -> Self {
        match sensor {
            Sensor::Stereo => Self::stereo(close_depth_m, frame_rate_hz),
            Sensor::Rgbd => Self::rgbd(close_depth_m, frame_rate_hz),
            Sensor::Mono => Self::mono(frame_rate_hz),
        }
    }
}
