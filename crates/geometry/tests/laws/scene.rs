//! Made scenes that two cameras see, for the tests of two-view reconstruction.

use crate::support::{generator, motion_error, noise, random_vec3};
use dsslam_geometry::{
    Pinhole, SE3, SO3, TwoView, TwoViewFailure, TwoViewMatches, TwoViewOptions, TwoViewReconstruction, Vec2,
    Vec3, angle_between,
};
use rand::Rng;

pub(crate) const CAMERA: Pinhole = Pinhole { fx: 520.0, fy: 515.0, cx: 320.0, cy: 240.0 };
pub(crate) const RECONSTRUCTION: TwoViewReconstruction = TwoViewReconstruction {
    first: CAMERA,
    second: CAMERA,
    options: TwoViewOptions {
        sigma_px: 1.0,
        max_iterations: 1000,
        min_matches: 100,
        min_points: 50,
        min_share: 0.9,
        min_parallax_deg: 1.0,
        min_point_parallax_deg: 0.36,
        max_second_share: 0.8,
        max_direction_sigma_deg: 2.0,
    },
};

/// Points seen by two cameras; matches below `n_outliers` are wrong.
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) second_from_first: SE3,
    pub(crate) points: Vec<Vec3>,
    pub(crate) first: Vec<Vec2>,
    pub(crate) second: Vec<Vec2>,
    pub(crate) weights: Option<Vec<f64>>,
}

pub(crate) fn pixel(rng: &mut impl Rng) -> Vec2 {
    Vec2::new(rng.random_range(0.0..640.0), rng.random_range(0.0..480.0))
}

impl Scene {
    /// `n` points at the depths that `depth` gives for their rays, noise of half a pixel.
    pub(crate) fn new(
        seed: u64,
        n: usize,
        second_from_first: SE3,
        mut depth: impl FnMut(&Vec3, f64) -> f64,
    ) -> Self {
        let mut rng = generator(seed);
        let mut scene = Self {
            second_from_first,
            points: Vec::new(),
            first: Vec::new(),
            second: Vec::new(),
            weights: None,
        };
        while scene.points.len() < n {
            let ray = CAMERA.unproject(&pixel(&mut rng));
            let point = ray * depth(&ray, rng.random_range(0.0..1.0));
            let seen = CAMERA.project(&(second_from_first * point));
            if (0.0..640.0).contains(&seen.x) && (0.0..480.0).contains(&seen.y) {
                let mut blurred = |p: Vec2| p + Vec2::from_fn(|_, _| noise(&mut rng, 0.5));
                scene.first.push(blurred(CAMERA.project(&point)));
                scene.second.push(blurred(seen));
                scene.points.push(point);
            }
        }
        scene
    }

    /// Depths of 3 to 12 units.
    pub(crate) fn general(seed: u64, n: usize) -> Self {
        Self::new(seed, n, sideways(seed), |_, share| 3.0 + 9.0 * share)
    }

    /// A wall that recedes to one side.
    pub(crate) fn planar(seed: u64, n: usize) -> Self {
        let normal = Vec3::new(0.2, 0.1, 1.0).normalize();
        // Not towards the wall, which would bring its second solution into view.
        let mut motion = sideways(seed);
        motion.translation.z = 0.05;
        Self::new(seed, n, motion, |ray, _| 4.0 / normal.dot(ray))
    }

    pub(crate) fn with_outliers(mut self, seed: u64, n_outliers: usize) -> Self {
        let mut rng = generator(seed);
        self.second[..n_outliers].fill_with(|| pixel(&mut rng));
        self
    }

    pub(crate) fn reconstruct(&self) -> Result<TwoView, TwoViewFailure> {
        self.reconstruct_with(&RECONSTRUCTION, 7)
    }

    pub(crate) fn reconstruct_with(
        &self,
        by: &TwoViewReconstruction,
        seed: u64,
    ) -> Result<TwoView, TwoViewFailure> {
        let weights = self.weights.as_deref();
        by.reconstruct(&TwoViewMatches { first: &self.first, second: &self.second, weights }, seed)
    }

    /// Angles of the motion's errors in degrees: of the turn and of the direction.
    pub(crate) fn errors_deg(&self, found: &TwoView) -> (f64, f64) {
        let motion = &found.second_from_first;
        let (turn, _) = motion_error(motion, &self.second_from_first);
        let direction = angle_between(&motion.translation, &self.second_from_first.translation);
        (turn.to_degrees(), direction.to_degrees())
    }

    /// Median error of the points from `start` on, relative to their depth, after the baseline has its true length.
    pub(crate) fn median_point_error(&self, found: &TwoView, start: usize) -> f64 {
        let unit = self.second_from_first.translation.norm();
        let pairs = found.points.iter().zip(&self.points).skip(start);
        let mut errors: Vec<f64> = pairs
            .filter_map(|(found, point)| Some((found.as_ref()? * unit - point).norm() / point.z))
            .collect();
        errors.sort_by(f64::total_cmp);
        errors[errors.len() / 2]
    }
}

/// A unit to the right, with a little of everything else.
pub(crate) fn sideways(seed: u64) -> SE3 {
    let mut rng = generator(seed + 1000);
    let turn = SO3::exp(&random_vec3(&mut rng, 0.05));
    SE3::new(turn, Vec3::new(-1.0, 0.0, 0.0) + random_vec3(&mut rng, 0.25))
}
