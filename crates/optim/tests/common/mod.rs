//! Synthetic streets for tests and benches: known poses and points, seeded noise.

#![allow(dead_code, missing_docs, unreachable_pub)]

use dsslam_optim::{BundleObservation, BundleProblem, PoseObservation};
use geometry::{Mat6, Pinhole, SE3, StereoRig, Vec2, Vec3, Vec6};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub fn rig() -> StereoRig {
    StereoRig {
        camera: Pinhole { fx: 718.856, fy: 718.856, cx: 607.1928, cy: 185.2157 },
        baseline_m: 386.1448 / 718.856,
    }
}

pub fn random(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Standard normal number (Box and Muller).
pub fn normal(random: &mut ChaCha8Rng) -> f64 {
    let u: f64 = 1.0 - random.random::<f64>();
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * random.random::<f64>()).cos()
}

pub fn normal_vec3(random: &mut ChaCha8Rng, sigma: f64) -> Vec3 {
    Vec3::new(normal(random), normal(random), normal(random)) * sigma
}

/// exp of a random tangent vector with the given sigma in meters and radians.
pub fn small_motion(random: &mut ChaCha8Rng, sigma_m: f64, sigma_rad: f64) -> SE3 {
    let (rho, phi) = (normal_vec3(random, sigma_m), normal_vec3(random, sigma_rad));
    SE3::exp(&Vec6::new(rho.x, rho.y, rho.z, phi.x, phi.y, phi.z))
}

/// A pose whose difference from `b` is measured in meters and radians.
pub fn pose_difference(a: &SE3, b: &SE3) -> (f64, f64) {
    let d = (*a * b.inverse()).log();
    (d.fixed_rows::<3>(0).norm(), d.fixed_rows::<3>(3).norm())
}

#[derive(Clone, Copy, Debug)]
pub struct StreetOptions {
    pub seed: u64,
    pub cameras: usize,
    pub points: usize,
    /// Observations of each point are thinned to at most this many.
    pub max_track: usize,
    pub noise_px: f64,
    /// Share of observations without a right measurement.
    pub mono_share: f64,
}

/// A problem at its true values, with noisy measurements: cameras every 0.8 m along a slow bend, points on its sides.
pub fn street(options: &StreetOptions) -> BundleProblem {
    let mut random = random(options.seed);
    let mut world_from_cam = SE3::identity();
    let advance = SE3::exp(&Vec6::new(0.0, 0.0, 0.8, 0.0, 0.01, 0.0));
    let mut cameras = Vec::new();
    for _ in 0..options.cameras {
        cameras.push(world_from_cam.inverse());
        world_from_cam = world_from_cam * advance;
    }
    let mut problem = BundleProblem {
        rig: rig(),
        fixed: vec![false; cameras.len()],
        cameras,
        points: Vec::new(),
        observations: Vec::new(),
    };
    while problem.points.len() < options.points {
        let home = problem.cameras[random.random_range(0..options.cameras)].inverse();
        let side = if random.random::<bool>() { 1.0 } else { -1.0 };
        let point_cam = Vec3::new(
            side * random.random_range(3.0..12.0),
            random.random_range(-4.0..1.6),
            random.random_range(6.0..35.0),
        );
        let point = problem.points.len() as u32;
        let point_world = home * point_cam;
        let mut seen = Vec::new();
        for (camera, cam_from_world) in problem.cameras.iter().enumerate() {
            let p = *cam_from_world * point_world;
            if p.z < 4.0 || p.z > 40.0 {
                continue;
            }
            let projection = problem.rig.project(&p);
            if (0.0..1241.0).contains(&projection.x) && (0.0..376.0).contains(&projection.y) {
                seen.push((camera as u32, projection));
            }
        }
        if seen.len() < 2 {
            continue;
        }
        let first = random.random_range(0..=seen.len().saturating_sub(options.max_track));
        for &(camera, projection) in seen.iter().skip(first).take(options.max_track) {
            let sigma = 1.2f64.powi(random.random_range(0..4));
            let scale = sigma * options.noise_px;
            let pixel = Vec2::new(
                projection.x + scale * normal(&mut random),
                projection.y + scale * normal(&mut random),
            );
            let right_u = projection.z + scale * normal(&mut random);
            let is_mono = random.random::<f64>() < options.mono_share;
            problem.observations.push(BundleObservation {
                camera,
                point,
                pixel,
                right_u: if is_mono { f64::NAN } else { right_u },
                inv_sigma_sq: 1.0 / (sigma * sigma),
            });
        }
        problem.points.push(point_world);
    }
    problem
}

/// Displaces free cameras and all points.
pub fn displaced(
    problem: &BundleProblem,
    seed: u64,
    sigma_m: f64,
    sigma_rad: f64,
    point_sigma_m: f64,
) -> BundleProblem {
    let mut random = random(seed);
    let mut out = problem.clone();
    for (camera, fixed) in out.cameras.iter_mut().zip(&problem.fixed) {
        if !fixed {
            *camera = small_motion(&mut random, sigma_m, sigma_rad) * *camera;
        }
    }
    for point in &mut out.points {
        *point += normal_vec3(&mut random, point_sigma_m);
    }
    out
}

/// The noisy stereo problem whose cost an independent solver has found: 20 cameras, 3000 points, sigma 0.5 px.
pub fn reference_problem() -> BundleProblem {
    let options =
        StreetOptions { seed: 20, cameras: 20, points: 3000, max_track: 8, noise_px: 0.5, mono_share: 0.2 };
    let mut truth = street(&options);
    truth.fixed[0] = true;
    displaced(&truth, 21, 0.05, 0.005, 0.2)
}

/// A frame at a known pose with `n` observations, of which the share `outliers` is anywhere in the image.
pub fn frame(
    seed: u64,
    n: usize,
    noise_px: f64,
    outliers: f64,
    mono_share: f64,
) -> (SE3, Vec<PoseObservation>) {
    let mut random = random(seed);
    let cam_from_world = small_motion(&mut random, 5.0, 0.5);
    let world_from_cam = cam_from_world.inverse();
    let rig = rig();
    let mut observations = Vec::new();
    for i in 0..n {
        let (u, v) = (random.random_range(0.0..1241.0), random.random_range(0.0..376.0));
        let depth = random.random_range(5.0..50.0);
        let point_cam = rig.unproject(u, v, depth);
        let sigma = 1.2f64.powi(random.random_range(0..8));
        let mut projection = rig.project(&point_cam) + normal_vec3(&mut random, sigma * noise_px);
        if (i as f64) < outliers * n as f64 {
            let x = random.random_range(0.0..1241.0);
            projection = Vec3::new(x, random.random_range(0.0..376.0), x - random.random_range(2.0..80.0));
        }
        let is_mono = random.random::<f64>() < mono_share;
        observations.push(PoseObservation {
            point_world: world_from_cam * point_cam,
            pixel: Vec2::new(projection.x, projection.y),
            right_u: if is_mono { f64::NAN } else { projection.z },
            inv_sigma_sq: 1.0 / (sigma * sigma),
        });
    }
    (cam_from_world, observations)
}

/// Squared whitened error straight from the rig's projection; `None` behind the camera.
pub fn chi_sq(rig: &StereoRig, cam_from_world: &SE3, point: &Vec3, o: &BundleObservation) -> Option<f64> {
    let p = *cam_from_world * *point;
    (p.z > 0.0).then(|| {
        let residual = residual(rig, cam_from_world, point, o);
        residual.norm_squared()
    })
}

/// Whitened residual straight from the rig's projection; the third is 0 without a right measurement.
pub fn residual(rig: &StereoRig, cam_from_world: &SE3, point: &Vec3, o: &BundleObservation) -> Vec3 {
    let projection = rig.project(&(*cam_from_world * *point));
    let right = if o.right_u.is_nan() { 0.0 } else { projection.z - o.right_u };
    Vec3::new(projection.x - o.pixel.x, projection.y - o.pixel.y, right) * o.inv_sigma_sq.sqrt()
}

/// Half the sum of the squared or Huber errors, straight from the definitions.
pub fn cost(
    rig: &StereoRig,
    cameras: &[SE3],
    points: &[Vec3],
    observations: &[BundleObservation],
    robust: bool,
) -> f64 {
    let mut sum = 0.0;
    for o in observations {
        let s = chi_sq(rig, &cameras[o.camera as usize], &points[o.point as usize], o).expect("in front");
        let delta_sq = if o.right_u.is_nan() { 5.991f64 } else { 7.815 };
        sum += if robust && s > delta_sq { 2.0 * (delta_sq * s).sqrt() - delta_sq } else { s };
    }
    0.5 * sum
}

/// Numeric J^T J and J^T r of a pose under left perturbations, central differences.
pub fn numeric_normal(
    rig: &StereoRig,
    cam_from_world: &SE3,
    observations: &[PoseObservation],
) -> (Mat6, Vec6) {
    let (mut hessian, mut gradient) = (Mat6::zeros(), Vec6::zeros());
    for o in observations {
        let at =
            |step: Vec6| residual(rig, &(SE3::exp(&step) * *cam_from_world), &o.point_world, &as_bundle(o));
        let rows: [Vec3; 6] = std::array::from_fn(|k| {
            let mut step = Vec6::zeros();
            step[k] = 1e-6;
            (at(step) - at(-step)) / 2e-6
        });
        let r = at(Vec6::zeros());
        for i in 0..6 {
            gradient[i] += rows[i].dot(&r);
            for j in 0..6 {
                hessian[(i, j)] += rows[i].dot(&rows[j]);
            }
        }
    }
    (hessian, gradient)
}

/// A pose's observation as one of camera 0 and point 0.
pub fn as_bundle(o: &PoseObservation) -> BundleObservation {
    let PoseObservation { pixel, right_u, inv_sigma_sq, .. } = *o;
    BundleObservation { camera: 0, point: 0, pixel, right_u, inv_sigma_sq }
}
