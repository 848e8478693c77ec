//! Small maps and records to test with.

use std::sync::Arc;

use features::{Descriptor, Features, Frame, Keypoint, Rig, ScaleLevels};
use geometry::{Distortion, Pinhole, SE3, SO3, Sensor, StereoRig, Vec3};
use map::{Batch, KeyframeId, Map, NewKeyframe, NewPoint, Observation, Parent, PointId};

use crate::{Camera, Counts, FramePose, FrameRecord, FrameState, Pose, Record, Start, TruePosition, Trust};

/// A camera looking along z, `x` meters to the right of the origin.
pub(super) fn camera_at(x: f64) -> SE3 {
    SE3::new(SO3::identity(), Vec3::new(-x, 0.0, 0.0))
}

/// A frame of 16 features.
pub(super) fn frame(index: u32) -> Arc<Frame> {
    let camera = Pinhole { fx: 500.0, fy: 500.0, cx: 320.0, cy: 240.0 };
    let stereo = StereoRig { camera, baseline_m: 0.5 };
    let rig = Rig { stereo, distortion: Distortion::default(), width: 640, height: 480 };
    let keypoint =
        |i: u8| Keypoint { x: 30.0 * f32::from(i), y: 100.0, octave: 0, angle_deg: 0.0, response: 1.0 };
    let features =
        Features { keypoints: (0..16).map(keypoint).collect(), descriptors: vec![Descriptor([7; 4]); 16] };
    let scales = Arc::new(ScaleLevels::new(8, 1.2));
    Arc::new(Frame::new(index, 0.1 * f64::from(index), Arc::new(rig), scales, features, vec![f32::NAN; 16]))
}

/// Inserts a keyframe of frame `index` at `x` meters that sees these points and makes `n_new` others 10 m in front of it.
pub(super) fn insert(map: &mut Map, index: u32, x: f64, seen: &[u32], n_new: u32) -> KeyframeId {
    let keyframe = NewKeyframe {
        frame: frame(index),
        cam_from_world: camera_at(x),
        matches: (8..).zip(seen).map(|(feature, point)| (feature, PointId(*point))).collect(),
        parent: Parent::Closest,
    };
    let id = map.next_keyframe_id();
    let point = |i: u32| NewPoint {
        position: Vec3::new(x + f64::from(i), 1.0, 10.0),
        observations: vec![Observation { keyframe: id, feature: i }],
    };
    let points = (0..n_new).map(point).collect();
    map.insert(Batch { keyframe: Some(keyframe), points }).expect("a valid batch").keyframe.expect("inserted")
}

/// Keyframes of frames 0, 5, 10 ... a meter apart; each makes four points that the next one sees, too.
pub(super) fn row(n: u32) -> Map {
    let mut map = Map::new();
    for k in 0..n {
        let seen: Vec<u32> = (4 * k.saturating_sub(1)..4 * k).collect();
        insert(&mut map, 5 * k, f64::from(k), &seen, 4);
    }
    map
}

/// Positions that lie on no line and in no plane, meters, so that an alignment with them is unique.
pub(super) fn bent_path(frame: u32) -> Vec3 {
    Vec3::new(f64::from(frame), f64::from(frame % 3), f64::from(frame % 2))
}

/// A start whose true positions are those of [`bent_path`], elsewhere and turned by 90 degrees about z.
pub(super) fn start(n: u32, sensor: Sensor) -> Record {
    let truth = |frame: u32| {
        let at = bent_path(frame);
        TruePosition { frame, position: [7.0 - at.y, at.x, 3.0 + at.z] }
    };
    Record::Start(Start {
        program_version: "0".to_owned(),
        sequence: "row".to_owned(),
        sensor,
        camera: Camera { focal: [500.0; 2], center: [320.0, 240.0], size: [640, 480] },
        n_frames: n,
        truth: (0..n).map(truth).collect(),
    })
}

/// A tracked frame at `x` meters whose pose refers to a keyframe at `keyframe_x`.
pub(super) fn tracked(index: u32, x: f64, keyframe: Option<u32>, keyframe_x: f64) -> Record {
    let cam_from_keyframe = camera_at(x) * camera_at(keyframe_x).inverse();
    Record::Frame(FrameRecord {
        index,
        timestamp_s: 0.1 * f64::from(index),
        state: FrameState::Tracked,
        reason: String::new(),
        pose: Some(FramePose {
            keyframe,
            cam_from_keyframe: Pose::from(&cam_from_keyframe),
            scale: 1.0,
            world_from_cam: Pose::from(&camera_at(x).inverse()),
        }),
        trust: Some(Trust { quality: 0.5, sigma: Some([0.01, 0.02]) }),
        counts: Counts { features: 16, ..Counts::default() },
        stages: Vec::new(),
    })
}
