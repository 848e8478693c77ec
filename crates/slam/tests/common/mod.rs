//! A corridor of points with descriptors of their own: frames without images, for tests of the SLAM steps.

use std::sync::Arc;

use dsslam_slam::{Mapper, NoProbe, Params, TrackState, Tracked, Tracker};
use features::{Descriptor, Features, Frame, Keypoint, Rig, ScaleLevels};
use geometry::{Distortion, Pinhole, SE3, SO3, StereoRig, Vec3, mix_seed};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(crate) const WIDTH: usize = 1241;
pub(crate) const HEIGHT: usize = 376;

/// A landmark with its appearance and the distance at which it is seen at octave 0.
struct Landmark {
    position: Vec3,
    descriptor: Descriptor,
    finest_m: f64,
}

pub(crate) struct World {
    pub(crate) rig: Arc<Rig>,
    scales: Arc<ScaleLevels>,
    landmarks: Vec<Landmark>,
    noise_px: f64,
    /// Nothing is seen beyond.
    max_depth_m: f64,
    /// Whether there is a right camera.
    pub(crate) stereo: bool,
    /// Error of every measured disparity, pixels.
    pub(crate) disparity_error_px: f64,
}

impl World {
    /// Two walls along z, 8 m to both sides, `length_m` long.
    pub(crate) fn corridor(length_m: f64, noise_px: f64) -> Self {
        World::with_density(length_m, noise_px, 60.0)
    }

    /// A corridor with this many landmarks per meter.
    pub(crate) fn with_density(length_m: f64, noise_px: f64, per_m: f64) -> Self {
        let camera = Pinhole { fx: 707.0912, fy: 707.0912, cx: 601.8873, cy: 183.1104 };
        let stereo = StereoRig { camera, baseline_m: 0.5372 };
        let rig = Arc::new(Rig { stereo, distortion: Distortion::default(), width: WIDTH, height: HEIGHT });
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let landmarks = (0..(length_m * per_m) as usize)
            .map(|_| {
                let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
                let position = Vec3::new(
                    side * rng.random_range(6.0..9.0),
                    rng.random_range(-4.0..1.6),
                    rng.random_range(-10.0..length_m),
                );
                Landmark {
                    position,
                    descriptor: Descriptor(rng.random()),
                    finest_m: rng.random_range(4.0..25.0),
                }
            })
            .collect();
        World {
            rig,
            scales: Arc::new(ScaleLevels::new(8, 1.2)),
            landmarks,
            noise_px,
            max_depth_m: 80.0,
            stereo: true,
            disparity_error_px: 0.0,
        }
    }

    /// Walls 6 to 9 m inside and outside of a ring road through the origin, its center at `x = radius_m`.
    pub(crate) fn ring(radius_m: f64, noise_px: f64, per_m: f64) -> Self {
        let mut world = World::with_density(2.0 * std::f64::consts::PI * radius_m, noise_px, per_m);
        for landmark in &mut world.landmarks {
            let angle = landmark.position.z / radius_m;
            let radius = radius_m + landmark.position.x;
            landmark.position.x = radius_m - radius * angle.cos();
            landmark.position.z = radius * angle.sin();
        }
        world.max_depth_m = 25.0;
        world
    }

    /// A corridor whose points and their looks repeat every `period_m`, `times` times.
    pub(crate) fn repeated_corridor(period_m: f64, times: u32) -> Self {
        let mut world = World::with_density(period_m - 10.0, 0.4, 40.0);
        let once = std::mem::take(&mut world.landmarks);
        for landmark in (0..times).flat_map(|n| once.iter().map(move |l| (n, l))) {
            let (n, landmark) = landmark;
            let offset = Vec3::new(0.0, 0.0, f64::from(n) * period_m);
            world.landmarks.push(Landmark { position: landmark.position + offset, ..*landmark });
        }
        world.max_depth_m = 25.0;
        world
    }

    /// A field of posts, `size_m` wide (along x) and long (along z), whose strip from `right_m` on, 16 m wide, repeats the strip
    /// around `x = 0` in shape and looks, but only for the middle half of its length.
    pub(crate) fn alike_field(size_m: [f64; 2], right_m: f64) -> Self {
        let mut world = World::with_density(size_m[0] * size_m[1], 0.6, 1.5);
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        for landmark in &mut world.landmarks {
            landmark.position.x = rng.random_range(-8.0..size_m[0] - 8.0);
            landmark.position.z = rng.random_range(0.0..size_m[1]);
        }
        let middle = 0.25 * size_m[1]..0.75 * size_m[1];
        let is_in = |l: &Landmark, x: f64| (l.position.x - x).abs() < 8.0 && middle.contains(&l.position.z);
        world.landmarks.retain(|l| !is_in(l, right_m));
        let copies: Vec<Landmark> = (world.landmarks.iter().filter(|l| is_in(l, 0.0)))
            .map(|l| Landmark { position: l.position + Vec3::new(right_m, 0.0, 0.0), ..*l })
            .collect();
        world.landmarks.extend(copies);
        world.max_depth_m = 22.0;
        world
    }

    /// The frame seen from `world_from_cam`; noise and flipped bits depend on `index` only.
    pub(crate) fn frame(&self, index: u32, world_from_cam: &SE3) -> Arc<Frame> {
        let cam_from_world = world_from_cam.inverse();
        let mut rng = ChaCha8Rng::seed_from_u64(mix_seed(3, u64::from(index), 0));
        let mut features = Features::default();
        let mut right_u = Vec::new();
        for landmark in &self.landmarks {
            let point = cam_from_world * landmark.position;
            if point.z < 1.0 || point.z > self.max_depth_m {
                continue;
            }
            let uvr = self.rig.stereo.project(&point);
            let octave =
                ((landmark.finest_m / point.norm()).ln() / 1.2_f64.ln()).round().clamp(0.0, 7.0) as u8;
            let sigma = self.noise_px * f64::from(self.scales.scales[usize::from(octave)]);
            let mut noisy = |value: f64| (value + sigma * rng.random_range(-1.7..1.7)) as f32;
            let (x, y, right) = (noisy(uvr.x), noisy(uvr.y), noisy(uvr.z - self.disparity_error_px));
            if !(16.0..WIDTH as f32 - 16.0).contains(&x) || !(16.0..HEIGHT as f32 - 16.0).contains(&y) {
                continue;
            }
            let mut descriptor = landmark.descriptor;
            for _ in 0..12 {
                descriptor.0[rng.random_range(0..4)] ^= 1 << rng.random_range(0..64);
            }
            features.keypoints.push(Keypoint { x, y, octave, angle_deg: 10.0, response: 50.0 });
            features.descriptors.push(descriptor);
            right_u.push(if self.stereo && right < x { right } else { f32::NAN });
        }
        let (rig, scales) = (self.rig.clone(), self.scales.clone());
        Arc::new(Frame::new(index, f64::from(index) * 0.1, rig, scales, features, right_u))
    }

    /// A frame without a single feature.
    pub(crate) fn black(&self, index: u32) -> Arc<Frame> {
        let (rig, scales) = (self.rig.clone(), self.scales.clone());
        Arc::new(Frame::new(index, f64::from(index) * 0.1, rig, scales, Features::default(), Vec::new()))
    }
}

/// A gentle slalom down the corridor, 0.8 m per frame.
pub(crate) fn slalom(i: u32) -> SE3 {
    let z = 0.8 * f64::from(i);
    let yaw = 0.05 * (z / 12.0).sin();
    SE3::new(SO3::exp(&Vec3::new(0.0, yaw, 0.0)), Vec3::new(1.2 * (z / 25.0).sin(), 0.0, z))
}

/// Tracker and mapper taking turns, as in the sequential schedule.
pub(crate) struct Pair {
    pub(crate) tracker: Tracker,
    pub(crate) mapper: Mapper,
}

impl Pair {
    pub(crate) fn new(params: &Params) -> Self {
        Pair::with_world(params, dsslam_slam::World::default())
    }

    pub(crate) fn with_world(params: &Params, world: dsslam_slam::World) -> Self {
        Pair { tracker: Tracker::new(params.clone()), mapper: Mapper::new(params.clone(), world) }
    }

    pub(crate) fn step(&mut self, frame: &Arc<Frame>) -> Tracked {
        let tracked = self.tracker.track(frame, self.mapper.world(), true, &mut NoProbe);
        self.mapper.count(&tracked.counts);
        if let Some(request) = &tracked.keyframe {
            let id = self.mapper.insert(request, &mut NoProbe).expect("the reference is in the map");
            self.mapper.refine(id, &mut NoProbe);
        }
        tracked
    }

    /// Pose of a frame that was just tracked.
    pub(crate) fn world_from_cam(&self, tracked: &Tracked) -> Option<SE3> {
        if tracked.state == TrackState::Started {
            return Some(SE3::identity());
        }
        Some(tracked.pose?.cam_from_world(&self.mapper.world().map)?.inverse())
    }
}
