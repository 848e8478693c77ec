//! What each tracked frame is worth: remembers the last frames, so that the covariance can be that of the motion since then.

use std::collections::VecDeque;

use features::Frame;
use geometry::{PoseCovariance, SE3, median};
use map::{KeyframeId, Map, MapPoint, PointId};

use super::last_frame::LastFrame;
use super::local_map::LocallyTracked;
use crate::assess::Assessment;
use crate::covariance::{MAX_KEYFRAMES, Sight, Window};
use crate::noise::{Noise, information};
use crate::params::Params;

/// Frames that a covariance looks back.
pub const COVARIANCE_FRAMES: usize = 10;
/// Points that it is made from, evenly taken from all.
const MAX_POINTS: usize = 200;
/// Points that a keyframe must see to be of use.
const MIN_VOTES: usize = 10;
/// Median of the absolute values of a normal distribution of standard deviation 1.
const NORMAL_MEDIAN: f64 = 0.6745;

/// The memory of the last frames.
#[derive(Clone, Debug, Default)]
pub(super) struct Assessor {
    /// The last tracked frames, oldest first, none with a loss behind it.
    past: VecDeque<LastFrame>,
    /// Variances of the residuals in these frames, in units of the expected one.
    variances: VecDeque<f64>,
}

/// A point of the map that is seen by the frame, by the earlier view, or by both.
struct Shared<'a> {
    point: &'a MapPoint,
    /// Feature of the frame.
    now: Option<u32>,
    /// Feature of the earlier view.
    then: Option<u32>,
}

impl Assessor {
    /// Nothing before a loss is looked back to.
    pub(super) fn forget(&mut self) {
        self.past.clear();
        self.variances.clear();
    }

    /// Remembers a tracked frame.
    pub(super) fn remember(&mut self, last: LastFrame) {
        if self.past.len() == COVARIANCE_FRAMES {
            self.past.pop_front();
        }
        self.past.push_back(last);
    }

    /// Judges a tracked frame, before it is remembered.
    pub(super) fn assess(
        &mut self,
        frame: &Frame,
        map: &Map,
        local: &LocallyTracked,
        params: &Params,
    ) -> Assessment {
        let noise = params.noise();
        let Some(ratio_sq) = residual_variance(frame, map, local, noise) else {
            return Assessment::default();
        };
        if self.variances.len() == COVARIANCE_FRAMES {
            self.variances.pop_front();
        }
        self.variances.push_back(ratio_sq);
        let mean_sq = self.variances.iter().sum::<f64>() / self.variances.len() as f64;
        let past = self.past.front().cloned().map(|past| past.refreshed(map));
        let covariance = self.experiment(frame, map, local, params, past.as_ref(), mean_sq);
        Assessment {
            covariance,
            residual_px: Some(noise.sigma_px * ratio_sq.sqrt()),
            quality: 1.0,
            reasons: Vec::new(),
        }
    }

    fn experiment(
        &self,
        frame: &Frame,
        map: &Map,
        local: &LocallyTracked,
        params: &Params,
        past: Option<&LastFrame>,
        mean_sq: f64,
    ) -> Option<PoseCovariance> {
        let past = past?;
        let dump = std::env::var_os("COV_EXP").is_some();
        let base = covariance(
            frame,
            map,
            local,
            past,
            params,
            Variant { keyframes: 4, multiple: false, points: MAX_POINTS },
        )?;
        if dump {
            let mut out = String::new();
            for (name, variant) in [
                ("A", Variant { keyframes: 4, multiple: false, points: 200 }),
                ("B", Variant { keyframes: 4, multiple: true, points: 200 }),
                ("C", Variant { keyframes: 2, multiple: false, points: 200 }),
                ("D", Variant { keyframes: 2, multiple: true, points: 200 }),
                ("E", Variant { keyframes: 4, multiple: false, points: 10000 }),
                ("F", Variant { keyframes: 4, multiple: true, points: 10000 }),
                ("G", Variant { keyframes: 0, multiple: false, points: 10000 }),
            ] {
                if let Some(m) = covariance(frame, map, local, past, params, variant) {
                    let list: Vec<String> = m.iter().map(|v| format!("{v:e}")).collect();
                    out.push_str(&format!(
                        "COV,{},{},{name},{},{mean_sq},{},{}\n",
                        frame.index,
                        past.frame.index,
                        params.camera.feature_sigma_px,
                        local.matches.len(),
                        list.join(",")
                    ));
                }
            }
            eprint!("{out}");
        }
        PoseCovariance::new(base * mean_sq)
    }
}

#[derive(Clone, Copy)]
struct Variant {
    keyframes: usize,
    multiple: bool,
    points: usize,
}

/// Robust variance of the residuals of the inliers, in units of the expected one; `None` without inliers.
fn residual_variance(frame: &Frame, map: &Map, local: &LocallyTracked, noise: Noise) -> Option<f64> {
    let stride = local.matches.len().div_ceil(MAX_POINTS).max(1);
    let mut whitened = Vec::with_capacity(3 * MAX_POINTS);
    for &(feature, id) in local.matches.iter().step_by(stride) {
        let Some(point) = map.point(id) else { continue };
        let i = feature as usize;
        let uvr = frame.rig.stereo.project(&(local.cam_from_world * point.position));
        let pixel = frame.pixel(i);
        let root = information(frame, i, noise).sqrt();
        let right = uvr.z - f64::from(frame.right_u[i]);
        let errors = [uvr.x - pixel.x, uvr.y - pixel.y, right];
        whitened.extend(errors.iter().filter(|error| error.is_finite()).map(|error| (error * root).abs()));
    }
    median(&mut whitened).map(|middle| (middle / NORMAL_MEDIAN).powi(2))
}

fn covariance(
    frame: &Frame,
    map: &Map,
    local: &LocallyTracked,
    past: &LastFrame,
    params: &Params,
    variant: Variant,
) -> Option<geometry::Mat6> {
    let mut then: Vec<(PointId, u32)> = past.matches.iter().map(|&(feature, id)| (id, feature)).collect();
    then.sort_unstable();
    let mut now: Vec<PointId> = local.matches.iter().map(|&(_, id)| id).collect();
    now.sort_unstable();
    let in_both = |&(feature, id): &(u32, PointId)| {
        let at = then.binary_search_by_key(&id, |&(id, _)| id).ok();
        (id, Some(feature), at.map(|at| then[at].1))
    };
    let earlier = past.matches.iter().filter(|&&(_, id)| now.binary_search(&id).is_err());
    let all: Vec<(PointId, Option<u32>, Option<u32>)> = local
        .matches
        .iter()
        .map(in_both)
        .chain(earlier.map(|&(feature, id)| (id, None, Some(feature))))
        .collect();
    let stride = all.len().div_ceil(variant.points).max(1);
    let sampled = all.iter().step_by(stride);
    let shared: Vec<Shared<'_>> =
        sampled.filter_map(|&(id, now, then)| Some(Shared { point: map.point(id)?, now, then })).collect();
    let share = shared.len() as f64 / all.len() as f64;
    let past_keyframe =
        map.keyframe(past.pose.keyframe).filter(|kf| kf.frame.is_same(&past.frame)).map(|kf| kf.id);
    let keyframes = most_voted(&shared, past_keyframe, variant.keyframes);
    let mut views: Vec<SE3> = vec![past.cam_from_world(map)];
    views.extend(keyframes.iter().filter_map(|&id| map.keyframe(id).map(|kf| kf.cam_from_world)));
    views.push(local.cam_from_world);
    let last = views.len() - 1;
    let mut window = Window::new(frame.rig.stereo, views);
    let noise = params.noise();
    let sight = |view: usize, frame: &Frame, feature: u32| Sight {
        view,
        information: information(frame, feature as usize, noise),
        stereo: frame.has_depth(feature as usize),
    };
    let mut sights = Vec::with_capacity(MAX_KEYFRAMES + 2);
    for shared in &shared {
        sights.clear();
        sights.extend(shared.then.map(|feature| sight(0, &past.frame, feature)));
        for (view, &id) in (1..).zip(&keyframes) {
            let (Some(feature), Some(kf)) = (shared.point.feature_in(id), map.keyframe(id)) else { continue };
            sights.push(sight(view, &kf.frame, feature));
        }
        if variant.multiple {
            let own = usize::from(shared.then.is_some());
            let n = sights.len() - own;
            if n > 0 {
                let factor = shared.point.n_observations() as f64 / n as f64;
                sights[own..].iter_mut().for_each(|s| s.information *= factor.max(1.0));
            }
        }
        sights.extend(shared.now.map(|feature| sight(last, frame, feature)));
        window.add(&shared.point.position, &sights);
    }
    if params.camera.sensor.is_scale_free() && keyframes.len() >= 2 {
        window.hold_distance(1, 2);
    }
    window.marginal_of_last().map(|m| m * share)
}

/// The keyframes that see most of the points, ties by id.
fn most_voted(shared: &[Shared<'_>], but: Option<KeyframeId>, n: usize) -> Vec<KeyframeId> {
    let observations = shared.iter().flat_map(|shared| shared.point.observations());
    let mut seen: Vec<KeyframeId> = observations.map(|o| o.keyframe).filter(|&id| Some(id) != but).collect();
    seen.sort_unstable();
    let mut votes: Vec<(usize, KeyframeId)> =
        seen.chunk_by(|a, b| a == b).map(|same| (same.len(), same[0])).collect();
    votes.retain(|&(votes, _)| votes >= MIN_VOTES);
    votes.sort_by_key(|&(votes, id)| (std::cmp::Reverse(votes), id));
    votes.iter().take(n).map(|&(_, id)| id).collect()
}
