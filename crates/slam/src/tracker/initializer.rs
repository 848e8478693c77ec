//! The start of a monocular map: two views, matched from a reference frame on, reconstructed and adjusted.

use std::fmt;
use std::sync::Arc;

use features::{Candidate, Frame, ProjectionQuery};
use geometry::{
    SE3, TwoViewFailure, TwoViewMatches, TwoViewOptions, TwoViewReconstruction, Vec2, Vec3, median,
};
use optim::{BundleOptions, BundleProblem, CHI2_MONO, refine_bundle};

use crate::params::Params;
use crate::problem::observation;
use crate::search::{consistent_in_rotation, search};
use crate::seed::SeedPurpose;

/// Features that a frame needs to take part.
const MIN_FEATURES: usize = 100;
/// Matches below which the search restarts with the current frame.
const MIN_MATCHES: usize = 100;
/// Points that the finished pair must have.
const MIN_POINTS: usize = 100;
/// Half window around the place where a feature was last seen, pixels at octave 0.
const RADIUS_PX: f32 = 100.0;
/// Coarsest octave whose features take part: positions of coarser ones are too rough.
const MAX_OCTAVE: u8 = 2;
/// Largest descriptor distance, and largest ratio of the best to the second-best one.
const MAX_DISTANCE: u32 = 50;
const MAX_RATIO: f32 = 0.9;
/// Least parallax in units of the noise of the features.
const MIN_PARALLAX_NOISES: f64 = 11.0;
/// Iterations of the adjustment of both views.
const ITERATIONS: usize = 20;

/// Two views that start a monocular map, the first camera at `first_from_world`.
#[derive(Clone, Debug)]
pub struct InitialPair {
    /// The first frame.
    pub first: Arc<Frame>,
    /// Its pose; the unit of length is the median depth of the points in it.
    pub first_from_world: SE3,
    /// Pose of the second frame.
    pub second_from_world: SE3,
    /// Feature in the first frame, feature in the second, position in the world.
    pub points: Vec<(u32, u32, Vec3)>,
}

/// Why a pair of frames does not start a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoPair {
    /// The frame has too few features.
    TooFewFeatures {
        /// Features of the frame.
        found: usize,
        /// Features needed.
        needed: usize,
    },
    /// The frame is the first of a pair.
    First,
    /// Too few features of the first frame are found again; the present frame becomes the first.
    TooFewMatches {
        /// Matches found.
        found: usize,
        /// Matches needed.
        needed: usize,
    },
    /// No reliable motion between the two frames yet.
    TwoView(TwoViewFailure),
    /// The features are placed too badly for what the camera has moved.
    TooNoisy {
        /// Parallax that enough matches reach, pixels.
        parallax_px: f64,
        /// Parallax needed, pixels.
        needed_px: f64,
    },
    /// Too few points survive the adjustment.
    TooFewPoints {
        /// Points left.
        found: usize,
        /// Points needed.
        needed: usize,
    },
}

impl NoPair {
    /// The reason in a few words without numbers.
    pub fn cause(&self) -> &'static str {
        match self {
            NoPair::TooFewFeatures { .. } => "too few features",
            NoPair::First => "the first of two views was chosen",
            NoPair::TooFewMatches { .. } => "too few matches with the first view",
            NoPair::TwoView(failure) => failure.cause(),
            NoPair::TooNoisy { .. } => "too little parallax for the noise of the features",
            NoPair::TooFewPoints { .. } => "too few points survive the adjustment of both views",
        }
    }
}

impl fmt::Display for NoPair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoPair::TooFewFeatures { found, needed } => {
                write!(f, "the frame has {found} features, {needed} needed")
            }
            NoPair::First => f.write_str("the first of two views was chosen"),
            NoPair::TooFewMatches { found, needed } => {
                write!(f, "too few matches with the first view: {found} of {needed}; choosing a new one")
            }
            NoPair::TwoView(failure) => write!(f, "{failure}"),
            NoPair::TooNoisy { parallax_px, needed_px } => write!(
                f,
                "too little parallax for the noise of the features: {parallax_px:.1} of {needed_px:.1} pixels"
            ),
            NoPair::TooFewPoints { found, needed } => {
                write!(f, "too few points after the adjustment of both views: {found} of {needed}")
            }
        }
    }
}

/// The first view, and where its features were last seen.
#[derive(Clone, Debug)]
pub(super) struct Initializer {
    first: Arc<Frame>,
    last_seen: Vec<Vec2>,
}

impl Initializer {
    /// Begins with `frame`; the answer says that a single frame starts no map.
    fn begin(slot: &mut Option<Initializer>, frame: &Arc<Frame>) -> NoPair {
        let last_seen = (0..frame.len()).map(|i| frame.pixel(i)).collect();
        *slot = Some(Initializer { first: frame.clone(), last_seen });
        NoPair::First
    }

    /// Tries `frame` as the second view of the first one in `slot`.
    ///
    /// # Errors
    /// Why there is no pair yet; `slot` then holds what the next frame continues with.
    pub(super) fn advance(
        slot: &mut Option<Initializer>,
        frame: &Arc<Frame>,
        first_from_world: SE3,
        params: &Params,
    ) -> Result<InitialPair, NoPair> {
        if frame.len() < MIN_FEATURES {
            *slot = None;
            return Err(NoPair::TooFewFeatures { found: frame.len(), needed: MIN_FEATURES });
        }
        let Some(waiting) = slot else { return Err(Initializer::begin(slot, frame)) };
        let matches = waiting.match_with(frame);
        if matches.len() < MIN_MATCHES {
            let reason = NoPair::TooFewMatches { found: matches.len(), needed: MIN_MATCHES };
            Initializer::begin(slot, frame);
            return Err(reason);
        }
        let pair = waiting.reconstruct(frame, &matches, first_from_world, params)?;
        *slot = None;
        Ok(pair)
    }

    /// Matches `(feature of the first, feature of the second)`; remembers where they were seen.
    fn match_with(&mut self, frame: &Frame) -> Vec<(u32, u32)> {
        let first = &self.first;
        let fine = |&i: &usize| first.keypoints[i].octave <= MAX_OCTAVE;
        let asked = (0..first.len()).filter(fine).map(|i| {
            let query = ProjectionQuery {
                x: self.last_seen[i].x as f32,
                y: self.last_seen[i].y as f32,
                right_u: f32::NAN,
                radius_px: RADIUS_PX,
                min_octave: first.keypoints[i].octave,
                max_octave: first.keypoints[i].octave,
                descriptor: first.descriptors[i],
            };
            (i as u32, query)
        });
        let found = search(frame, asked, &vec![true; frame.len()], |_, find| {
            let clear = |second: Candidate| (find.best.distance as f32) < MAX_RATIO * second.distance as f32;
            find.best.distance <= MAX_DISTANCE && find.second.is_none_or(clear)
        });
        let kept = consistent_in_rotation(frame, found, |&i| first.keypoints[i as usize].angle_deg);
        for &(second, first) in &kept {
            self.last_seen[first as usize] = frame.pixel(second as usize);
        }
        kept.into_iter().map(|(second, first)| (first, second)).collect()
    }

    fn reconstruct(
        &self,
        second: &Arc<Frame>,
        matches: &[(u32, u32)],
        first_from_world: SE3,
        params: &Params,
    ) -> Result<InitialPair, NoPair> {
        let first = &self.first;
        let pixels_first: Vec<Vec2> = matches.iter().map(|m| first.pixel(m.0 as usize)).collect();
        let pixels_second: Vec<Vec2> = matches.iter().map(|m| second.pixel(m.1 as usize)).collect();
        let trust = |&(i, j): &(u32, u32)| {
            let (i, j) = (i as usize, j as usize);
            first.inv_sigma_sq(i) * params.weights.of_sample(first, i) * params.weights.of_sample(second, j)
        };
        let weights: Vec<f64> = matches.iter().map(trust).collect();
        let reconstruction = TwoViewReconstruction {
            first: first.rig.stereo.camera,
            second: second.rig.stereo.camera,
            options: TwoViewOptions::default(),
        };
        let views = TwoViewMatches { first: &pixels_first, second: &pixels_second, weights: Some(&weights) };
        let seed = SeedPurpose::InitialPair.seed(params.seed, second.index, 0);
        let found = reconstruction.reconstruct(&views, seed).map_err(NoPair::TwoView)?;
        let with_point: Vec<(u32, u32, Vec3)> = matches
            .iter()
            .zip(&found.points)
            .filter_map(|(&(i, j), point)| Some((i, j, (*point)?)))
            .collect();
        let Adjusted { second_from_first, points, chi_sq } =
            adjust_pair([first, second], found.second_from_first, &with_point, params);
        let noise_px = params.camera.feature_sigma_px
            * noise(chi_sq, with_point.len(), matches.len() - found.n_consistent);
        let parallax_px = found.parallax_deg.to_radians() * second.rig.stereo.camera.fx;
        clear_of_noise(parallax_px, noise_px)?;
        if points.len() < MIN_POINTS {
            return Err(NoPair::TooFewPoints { found: points.len(), needed: MIN_POINTS });
        }
        Ok(in_unit(first, second_from_first, &points, first_from_world))
    }
}

/// Standard deviation of the features' positions, in units of the expected one, where points have the squared errors `chi_sq` in both
/// views together and `outliers` more matches agree with nothing. Of the four coordinates of a point one tells its noise.
fn noise(chi_sq: f64, points: usize, outliers: usize) -> f64 {
    let all = chi_sq + CHI2_MONO * outliers as f64;
    (all / (points + outliers).max(1) as f64).sqrt()
}

/// Whether the parallax, pixels, stands out of the noise of the features.
fn clear_of_noise(parallax_px: f64, noise_px: f64) -> Result<(), NoPair> {
    let needed_px = MIN_PARALLAX_NOISES * noise_px;
    if parallax_px < needed_px { Err(NoPair::TooNoisy { parallax_px, needed_px }) } else { Ok(()) }
}

/// Two views after their adjustment.
struct Adjusted {
    second_from_first: SE3,
    /// The points that agree with the motion in both views.
    points: Vec<(u32, u32, Vec3)>,
    /// Sum of the squared errors of all points, in units of the expected noise, each at most the limit of outliers.
    chi_sq: f64,
}

/// Bundle adjustment of the two views.
fn adjust_pair(
    frames: [&Frame; 2],
    second_from_first: SE3,
    points: &[(u32, u32, Vec3)],
    params: &Params,
) -> Adjusted {
    let noise = params.noise();
    let observations = (0..).zip(points).flat_map(|(point, &(i, j, _))| {
        [(0, i), (1, j)]
            .map(|(camera, feature)| observation(frames[camera as usize], feature, camera, point, noise))
    });
    let problem = BundleProblem {
        rig: frames[0].rig.stereo,
        cameras: vec![SE3::identity(), second_from_first],
        fixed: vec![true, false],
        points: points.iter().map(|p| p.2).collect(),
        observations: observations.collect(),
    };
    let options = BundleOptions { max_iterations: ITERATIONS, huber: Some(1.0), ..Default::default() };
    let solution = refine_bundle(&problem, &options);
    let moved = points.iter().zip(&solution.points).map(|(&(i, j, _), &position)| (i, j, position));
    // The observations come in pairs, as the points do.
    let fitting =
        moved.zip(solution.inliers.chunks(2)).filter(|(_, agree)| agree.iter().all(|&agrees| agrees));
    Adjusted {
        second_from_first: solution.cameras[1].normalized(),
        points: fitting.map(|(point, _)| point).collect(),
        chi_sq: solution.chi_sq.iter().map(|chi_sq| chi_sq.min(CHI2_MONO)).sum(),
    }
}

/// The pair in the world, lengths in units of the points' median depth.
fn in_unit(
    first: &Arc<Frame>,
    second_from_first: SE3,
    points: &[(u32, u32, Vec3)],
    first_from_world: SE3,
) -> InitialPair {
    let mut depths: Vec<f64> = points.iter().map(|p| p.2.z).collect();
    let unit = median(&mut depths).unwrap_or(1.0);
    let motion = SE3::new(second_from_first.rotation, second_from_first.translation / unit);
    let world_from_first = first_from_world.inverse();
    InitialPair {
        first: first.clone(),
        first_from_world,
        second_from_world: (motion * first_from_world).normalized(),
        points: points.iter().map(|&(i, j, point)| (i, j, world_from_first * (point / unit))).collect(),
    }
}

#[cfg(test)]
#[path = "../../tests/steps/initializer.rs"]
mod tests;
