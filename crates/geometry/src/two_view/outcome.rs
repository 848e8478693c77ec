//! Of all motions on trial the best one, and how far it is ahead of the others.

use super::candidate::{Candidate, same_motion};
use super::models::Models;
use super::{TwoView, TwoViewModel, Views};

/// The best motion.
pub(super) struct Outcome {
    pub(super) best: Candidate,
    /// The most that another motion explains of what the best one does.
    pub(super) second_share: f64,
    /// The model that led to it; of two the one that explained more matches.
    pub(super) model: TwoViewModel,
    /// Matches with a weight that this model explained.
    pub(super) n_inliers: usize,
}

impl Outcome {
    /// The candidate with the highest score, of equals the first; `None` when there is none.
    pub(super) fn new(views: &Views<'_>, models: &Models, mut candidates: Vec<Candidate>) -> Option<Self> {
        // `max_by` takes the last of equals; from the end, that is the first.
        let by_score = |a: &(usize, &Candidate), b: &(usize, &Candidate)| a.1.score.total_cmp(&b.1.score);
        let (place, _) = candidates.iter().enumerate().rev().max_by(by_score)?;
        let best = candidates.remove(place);
        let explained = |model| (models.n_inliers(views, model), model);
        let (mut second_share, mut origin) = (0.0, explained(best.model));
        for other in &candidates {
            if !same_motion(&other.motion, &best.motion) {
                second_share = f64::max(second_share, best.share_of(other));
            } else if explained(other.model).0 > origin.0 {
                origin = explained(other.model);
            }
        }
        let (n_inliers, model) = origin;
        Some(Self { best, second_share, model, n_inliers })
    }

    pub(super) fn into_two_view(self) -> TwoView {
        let Self { best, second_share, model, n_inliers } = self;
        let mut depths: Vec<f64> = best.points.iter().flatten().map(|point| point.z).collect();
        depths.sort_by(f64::total_cmp);
        TwoView {
            second_from_first: best.motion,
            model,
            n_inliers,
            n_consistent: best.n_consistent,
            n_points: best.n_points,
            second_share,
            parallax_deg: best.parallax_deg,
            direction_sigma_deg: best.direction_sigma_deg,
            median_depth: depths.get(depths.len() / 2).copied().unwrap_or(0.0),
            points: best.points,
        }
    }
}
