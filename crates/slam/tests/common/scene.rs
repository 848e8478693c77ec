//! A scene of landmarks and cameras without noise, small enough to say what each step must answer.

use std::sync::Arc;

use bow::Vocabulary;
use features::{Descriptor, Features, Frame, Keypoint, Rig, ScaleLevels};
use geometry::{Distortion, Pinhole, SE3, SO3, StereoRig, Vec3};
use map::{Batch, KeyframeId, Map, NewKeyframe, NewPoint, Observation, Parent, PointId};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{CameraParams, Mapper, Params, World};

/// Focal length, pixels.
pub(crate) const FOCAL_PX: f64 = 500.0;
/// Distance of the two cameras of the rig, meters.
pub(crate) const BASELINE_M: f64 = 0.5;
/// Octave of every feature that is not asked for otherwise.
pub(crate) const OCTAVE: u8 = 2;

/// How a landmark shows in a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shot {
    pub(crate) landmark: usize,
    pub(crate) octave: u8,
    /// Added to the true pixel.
    pub(crate) shift_px: [f64; 2],
    /// Whether the right camera sees it too.
    pub(crate) stereo: bool,
    /// Added to the column in the right image, beside the shift.
    pub(crate) right_px: f64,
    /// Bits of the descriptor that differ from the landmark's.
    pub(crate) flipped: u32,
    pub(crate) angle_deg: f32,
}

/// A landmark as it is.
pub(crate) fn shot(landmark: usize) -> Shot {
    Shot {
        landmark,
        octave: OCTAVE,
        shift_px: [0.0, 0.0],
        stereo: true,
        right_px: 0.0,
        flipped: 0,
        angle_deg: 10.0,
    }
}

/// Landmarks with looks of their own.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) landmarks: Vec<Vec3>,
    pub(crate) looks: Vec<Descriptor>,
}

impl Scene {
    /// `n` landmarks that cameras near the origin see when they look along z: 6 m wide, 4 m high, 8 to 12 m ahead.
    pub(crate) fn wall(n: usize) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut coordinate = |low: f64, high: f64| random.random_range(low..high);
        let landmarks = (0..n)
            .map(|_| Vec3::new(coordinate(-3.0, 3.0), coordinate(-2.0, 2.0), coordinate(8.0, 12.0)))
            .collect();
        Scene::at(landmarks)
    }

    /// Landmarks at these places.
    pub(crate) fn at(landmarks: Vec<Vec3>) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(6);
        let looks = landmarks.iter().map(|_| Descriptor(random.random())).collect();
        Scene { landmarks, looks }
    }

    pub(crate) fn len(&self) -> usize {
        self.landmarks.len()
    }

    /// A frame with one feature for each shot, in their order.
    ///
    /// # Panics
    /// When a landmark is behind the camera.
    pub(crate) fn frame(&self, index: u32, cam_from_world: &SE3, shots: &[Shot]) -> Arc<Frame> {
        let rig = rig();
        let mut features = Features::default();
        let mut right_u = Vec::new();
        for shot in shots {
            let point = *cam_from_world * self.landmarks[shot.landmark];
            assert!(point.z > 0.0, "landmark {} is behind the camera", shot.landmark);
            let uvr = rig.stereo.project(&point);
            let (x, y) = ((uvr.x + shot.shift_px[0]) as f32, (uvr.y + shot.shift_px[1]) as f32);
            let (octave, angle_deg) = (shot.octave, shot.angle_deg);
            features.keypoints.push(Keypoint { x, y, octave, angle_deg, response: 50.0 });
            features.descriptors.push(flipped(self.looks[shot.landmark], shot.flipped));
            right_u.push(if shot.stereo {
                (uvr.z + shot.shift_px[0] + shot.right_px) as f32
            } else {
                f32::NAN
            });
        }
        let scales = Arc::new(ScaleLevels::new(8, 1.2));
        Arc::new(Frame::new(index, 0.1 * f64::from(index), Arc::new(rig), scales, features, right_u))
    }

    /// A frame of all landmarks, in their order.
    pub(crate) fn whole(&self, index: u32, cam_from_world: &SE3) -> Arc<Frame> {
        self.frame(index, cam_from_world, &(0..self.len()).map(shot).collect::<Vec<Shot>>())
    }

    /// A map of keyframes at these poses that all see all landmarks: feature, landmark and point have one number.
    pub(crate) fn map(&self, poses: &[SE3]) -> Map {
        let mut map = Map::new();
        for (index, pose) in (0..).zip(poses) {
            let frame = self.whole(index, pose);
            if index == 0 {
                let all = (0..).zip(self.landmarks.iter().copied());
                add(&mut map, frame, pose, &[], &all.collect::<Vec<_>>());
            } else {
                let all: Vec<(u32, u32)> = (0..self.len() as u32).map(|i| (i, i)).collect();
                add(&mut map, frame, pose, &all, &[]);
            }
        }
        map
    }
}

/// The camera of all frames: 640 x 480 pixels.
pub(crate) fn rig() -> Rig {
    let camera = Pinhole { fx: FOCAL_PX, fy: FOCAL_PX, cx: 320.0, cy: 240.0 };
    let stereo = StereoRig { camera, baseline_m: BASELINE_M };
    Rig { stereo, distortion: Distortion::default(), width: 640, height: 480 }
}

/// The pose of a camera at a place, looking along z.
pub(crate) fn at(x: f64, y: f64, z: f64) -> SE3 {
    SE3::new(SO3::identity(), Vec3::new(-x, -y, -z))
}

/// The first `n` bits flipped.
pub(crate) fn flipped(descriptor: Descriptor, n: u32) -> Descriptor {
    let mut words = descriptor.0;
    for bit in 0..n {
        words[bit as usize / 64] ^= 1 << (bit % 64);
    }
    Descriptor(words)
}

/// Inserts a keyframe with matches `(feature, point)` and new points `(feature, position)`, under the keyframe that
/// shares most points.
pub(crate) fn add(
    map: &mut Map,
    frame: Arc<Frame>,
    cam_from_world: &SE3,
    matches: &[(u32, u32)],
    new: &[(u32, Vec3)],
) -> KeyframeId {
    add_under(map, frame, cam_from_world, matches, new, Parent::Closest)
}

/// [`add`] with a parent.
pub(crate) fn add_under(
    map: &mut Map,
    frame: Arc<Frame>,
    cam_from_world: &SE3,
    matches: &[(u32, u32)],
    new: &[(u32, Vec3)],
    parent: Parent,
) -> KeyframeId {
    let keyframe = map.next_keyframe_id();
    let point = |&(feature, position): &(u32, Vec3)| NewPoint {
        position,
        observations: vec![Observation { keyframe, feature }],
    };
    let points = new.iter().map(point).collect();
    let matches = matches.iter().map(|&(feature, point)| (feature, PointId(point))).collect();
    let keyframe = NewKeyframe { frame, cam_from_world: *cam_from_world, matches, parent };
    let inserted = map.insert(Batch { keyframe: Some(keyframe), points }).expect("a valid batch");
    assert_eq!(map.check(), Ok(()));
    inserted.keyframe.expect("a keyframe")
}

/// Stereo parameters: close is nearer than 20 m, ten frames a second.
pub(crate) fn params() -> Params {
    Params::of(CameraParams::stereo(20.0, 10.0))
}

/// A mapper that continues with a map, without a vocabulary.
pub(crate) fn mapper(map: Map, params: &Params) -> Mapper {
    Mapper::new(params.clone(), World { map, ..World::default() })
}

/// A map with all its keyframes described in the words of the built-in vocabulary.
pub(crate) fn described(map: Map) -> World {
    World::from_map(map, Some(Arc::new(Vocabulary::built_in().expect("it is part of the program"))))
}

/// Distance in pose: meters and radians together.
pub(crate) fn gap(a: &SE3, b: &SE3) -> f64 {
    (*a * b.inverse()).log().norm()
}

/// A map of keyframes at these poses, each under the one before and with `shared` points in common with it; others share
/// none. All frames look the same, and points are anywhere: for tests of graphs.
pub(crate) fn chain(poses: &[SE3], shared: u32) -> Map {
    let scene = Scene::wall(2 * shared as usize);
    let mut map = Map::new();
    for (k, pose) in (0..).zip(poses) {
        let next = map.next_point_id().0;
        let old: Vec<(u32, u32)> =
            if k == 0 { Vec::new() } else { (0..shared).map(|i| (i, next - shared + i)).collect() };
        let new: Vec<(u32, Vec3)> = (shared..2 * shared).map(|i| (i, scene.landmarks[i as usize])).collect();
        let frame = scene.whole(k, &SE3::identity());
        add(&mut map, frame, pose, &old, &new);
    }
    map
}

/// Poses of `n` cameras along x, `step_m` apart.
pub(crate) fn line(n: u32, step_m: f64) -> Vec<SE3> {
    (0..n).map(|k| at(step_m * f64::from(k), 0.0, 0.0)).collect()
}

/// Pose `k` of `n` on a circle, looking along it.
pub(crate) fn on_circle(k: u32, n: u32, radius_m: f64) -> SE3 {
    let angle = std::f64::consts::TAU * f64::from(k) / f64::from(n);
    let center = Vec3::new(radius_m * (1.0 - angle.cos()), 0.0, radius_m * angle.sin());
    SE3::new(SO3::exp(&Vec3::new(0.0, angle, 0.0)), center).inverse()
}
