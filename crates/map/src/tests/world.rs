//! Small frames, poses and maps to test with.

use std::sync::Arc;

use features::{Descriptor, Features, Frame, Keypoint, Rig, ScaleLevels};
use geometry::{Distortion, Pinhole, SE3, StereoRig, Vec3, Vec6};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{Batch, KeyframeId, Map, NewKeyframe, NewPoint, Observation, Parent, PointId};

/// Features of every frame that these tests make.
pub(super) const N_FEATURES: u32 = 40;

pub(super) fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// A frame of features with these octaves and descriptors, without depth.
pub(super) fn frame_of(index: u32, features: &[(u8, Descriptor)]) -> Arc<Frame> {
    let camera = Pinhole { fx: 500.0, fy: 500.0, cx: 320.0, cy: 240.0 };
    let distortion = Distortion { k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, k3: 0.0 };
    let stereo = StereoRig { camera, baseline_m: 0.5 };
    let rig = Rig { stereo, distortion, width: 640, height: 480 };
    let keypoints = (0_u8..).zip(features).map(|(i, f)| Keypoint {
        x: 10.0 * f32::from(i),
        y: 100.0,
        octave: f.0,
        angle_deg: 0.0,
        response: 1.0,
    });
    let features =
        Features { keypoints: keypoints.collect(), descriptors: features.iter().map(|f| f.1).collect() };
    let right_u = vec![f32::NAN; features.keypoints.len()];
    let scales = Arc::new(ScaleLevels::new(8, 1.2));
    Arc::new(Frame::new(index, 0.1 * f64::from(index), Arc::new(rig), scales, features, right_u))
}

/// A frame of [`N_FEATURES`] features of random octaves and descriptors.
pub(super) fn frame(index: u32) -> Arc<Frame> {
    let mut random = generator(u64::from(index));
    let features: Vec<(u8, Descriptor)> =
        (0..N_FEATURES).map(|_| (random.random_range(0..8), Descriptor(random.random()))).collect();
    frame_of(index, &features)
}

/// A moderate random motion, meters and radians.
pub(super) fn random_pose(random: &mut impl Rng) -> SE3 {
    SE3::exp(&Vec6::from_fn(|i, _| random.random_range(-1.0..1.0) * if i < 3 { 5.0 } else { 0.5 }))
}

pub(super) fn random_position(random: &mut impl Rng) -> Vec3 {
    Vec3::from_fn(|_, _| random.random_range(-20.0..20.0))
}

pub(super) fn at(keyframe: u32, feature: u32) -> Observation {
    Observation { keyframe: KeyframeId(keyframe), feature }
}

/// A new point with observations given as (keyframe, feature).
pub(super) fn new_point(observations: &[(u32, u32)]) -> NewPoint {
    let mut random = generator(observations.iter().map(|&(k, f)| u64::from(k * N_FEATURES + f)).sum());
    let observations = observations.iter().map(|&(k, f)| at(k, f)).collect();
    NewPoint { position: random_position(&mut random), observations }
}

pub(super) fn new_keyframe(map: &Map, matches: &[(u32, u32)]) -> NewKeyframe {
    let index = map.next_keyframe_id().0;
    NewKeyframe {
        frame: frame(index),
        cam_from_world: random_pose(&mut generator(1_000 + u64::from(index))),
        matches: matches.iter().map(|&(feature, point)| (feature, PointId(point))).collect(),
        parent: Parent::Closest,
    }
}

/// Inserts a keyframe with matches given as (feature, point) and new points as lists of (keyframe, feature).
pub(super) fn add(map: &mut Map, matches: &[(u32, u32)], points: &[&[(u32, u32)]]) -> KeyframeId {
    let keyframe = Some(new_keyframe(map, matches));
    let points = points.iter().map(|o| new_point(o)).collect();
    map.insert(Batch { keyframe, points }).expect("valid batch").keyframe.expect("inserted")
}

/// A map of `n` keyframes in a row: each creates four points, which the next two keyframes observe too.
pub(super) fn row_of_keyframes(n: u32) -> Map {
    let mut map = Map::new();
    for k in 0..n {
        let first = 4 * k.saturating_sub(2);
        let matches: Vec<(u32, u32)> = (first..4 * k).map(|p| (10 + p - first, p)).collect();
        let observations: Vec<[(u32, u32); 1]> = (0..4).map(|f| [(k, f)]).collect();
        let points: Vec<&[(u32, u32)]> = observations.iter().map(|o| &o[..]).collect();
        add(&mut map, &matches, &points);
    }
    assert_eq!(map.check(), Ok(()));
    map
}

pub(super) fn ids(list: &[u32]) -> Vec<KeyframeId> {
    list.iter().map(|&k| KeyframeId(k)).collect()
}

/// Runs a mutation that must be refused with this error, and leave the map as it is.
pub(super) fn refused<T: std::fmt::Debug>(
    map: &mut Map,
    mutation: impl FnOnce(&mut Map) -> Result<T, crate::MapError>,
) -> crate::MapError {
    let before = (map.digest(), map.revision());
    let error = mutation(map).expect_err("refused");
    assert_eq!((map.digest(), map.revision()), before, "a refused mutation leaves an equal map");
    error
}

/// Largest distance between corresponding positions and camera centers of two maps, meters.
pub(super) fn largest_gap(a: &Map, b: &Map) -> f64 {
    let points = a.points().zip(b.points()).map(|(p, q)| (p.position - q.position).norm());
    let centers = a.keyframes().zip(b.keyframes()).map(|(p, q)| (p.center() - q.center()).norm());
    points.chain(centers).fold(0.0, f64::max)
}
