//! A small map whose errors are known.

use std::sync::Arc;

use features::{Descriptor, Features, Frame, Keypoint, Rig, ScaleLevels};
use geometry::{Distortion, Pinhole, SE3, StereoRig, Vec2, Vec3, Vec6};
use map::{Batch, KeyframeId, Map, NewKeyframe, NewPoint, Observation, Parent};

pub(super) const CAMERA: Pinhole = Pinhole { fx: 60.0, fy: 61.0, cx: 39.5, cy: 29.25 };
pub(super) const SIZE: (usize, usize) = (80, 60);
pub(super) const N_POINTS: u32 = 9;
/// How far the features of the second keyframe lie from the projections: 0.5 px.
const DISPLACED: Vec2 = Vec2::new(0.3, -0.4);

pub(super) fn rig(distortion: Distortion) -> Arc<Rig> {
    let stereo = StereoRig { camera: CAMERA, baseline_m: 0.5 };
    Arc::new(Rig { stereo, distortion, width: SIZE.0, height: SIZE.1 })
}

pub(super) fn position(i: u32) -> Vec3 {
    let i = f64::from(i);
    Vec3::new(i - 4.0, (2.0 * i).sin(), 9.0 + i.cos())
}

pub(super) fn cam_from_world(keyframe: u32) -> SE3 {
    let k = f64::from(keyframe);
    SE3::exp(&Vec6::new(-0.3 * k, 0.05 * k, 0.1 * k, 0.02 * k, -0.03 * k, 0.05 * k))
}

/// A frame whose first [`N_POINTS`] features show the points, and one more that shows none.
fn frame(rig: &Arc<Rig>, index: u32, keyframe: u32) -> Arc<Frame> {
    let displaced = if keyframe == 1 { DISPLACED } else { Vec2::zeros() };
    let pixel = |i| CAMERA.project(&(cam_from_world(keyframe) * position(i))) + displaced;
    let pixels = (0..N_POINTS).map(pixel).chain([Vec2::new(1.0, 2.0)]);
    let keypoint = |p: Vec2| Keypoint { x: p.x as f32, y: p.y as f32, ..Keypoint::default() };
    let keypoints: Vec<Keypoint> = pixels.map(keypoint).collect();
    let n = keypoints.len();
    let features = Features { keypoints, descriptors: vec![Descriptor::default(); n] };
    let scales = Arc::new(ScaleLevels::new(8, 1.2));
    let time = 0.1 * f64::from(index);
    Arc::new(Frame::new(index, time, Arc::clone(rig), scales, features, vec![f32::NAN; n]))
}

pub(super) fn insert(map: &mut Map, rig: &Arc<Rig>, index: u32, parent: Parent, points: Vec<NewPoint>) {
    let keyframe = map.next_keyframe_id().0;
    let frame = frame(rig, index, keyframe);
    let cam_from_world = cam_from_world(keyframe);
    let keyframe = NewKeyframe { frame, cam_from_world, matches: Vec::new(), parent };
    map.insert(Batch { keyframe: Some(keyframe), points }).unwrap();
}

/// Point `i` seen by these keyframes.
pub(super) fn seen_by(i: u32, keyframes: &[u32]) -> NewPoint {
    let observation = |&k: &u32| Observation { keyframe: KeyframeId(k), feature: i };
    NewPoint { position: position(i), observations: keyframes.iter().map(observation).collect() }
}

/// Keyframes of the frames 0, 4 and 8 see all points but the last, which only the third one sees.
pub(super) fn street_of(rig: &Arc<Rig>) -> Map {
    let mut map = Map::new();
    insert(&mut map, rig, 0, Parent::Closest, Vec::new());
    insert(&mut map, rig, 4, Parent::Closest, Vec::new());
    let last = N_POINTS - 1;
    let mut points: Vec<NewPoint> = (0..last).map(|i| seen_by(i, &[0, 1, 2])).collect();
    points.push(seen_by(last, &[2]));
    insert(&mut map, rig, 8, Parent::Closest, points);
    assert_eq!(map.check(), Ok(()));
    map
}

pub(super) fn street() -> Map {
    street_of(&rig(Distortion::default()))
}
