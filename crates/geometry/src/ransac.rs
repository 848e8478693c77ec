//! Robust estimation by random samples (Fischler and Bolles 1981), seeded, and weighted by the trust in each item.
//!
//! Weights enter three times: samples are drawn in proportion to them, a model's score is the weight of its inliers, each
//! reduced by its error (truncated quadratic loss, MSAC: Torr and Zisserman 2000), and the number of samples follows from
//! the weight of the inliers. The best model so far is refitted to all of its inliers (LO-RANSAC: Chum, Matas, Kittler 2003).

use crate::sampler::{Sampler, usable_weights};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// A model that small samples of numbered items determine.
pub trait Estimator {
    /// What is estimated.
    type Model: Clone;

    /// How many items there are; they are numbered from zero.
    fn n_items(&self) -> usize;

    /// All models that fit the sampled items exactly or best; empty for a degenerate or too small sample.
    fn fit(&self, sample: &[usize]) -> Vec<Self::Model>;

    /// The squared error of an item, in the unit of [`Estimator::threshold_sq`]; an error that is not a number is an outlier's.
    fn error_sq(&self, model: &Self::Model, item: usize) -> f64;

    /// The squared error up to which an item is an inlier.
    fn threshold_sq(&self) -> f64;

    /// A better model from all inliers of `model`, with one weight per item; `None`, the default, where there is no such step.
    fn refit(&self, model: &Self::Model, inliers: &[usize], weights: &[f64]) -> Option<Self::Model> {
        let _ = (model, inliers, weights);
        None
    }
}

/// How to sample, and when to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RansacOptions {
    /// Items in a sample; three by default, enough for P3P and for point sets (the fundamental matrix needs eight).
    pub sample_size: usize,
    /// Most samples to draw.
    pub max_iterations: usize,
    /// Probability, below one, with which at least one sample should have been free of outliers.
    pub confidence: f64,
    /// Seed of the generator, best from [`crate::mix_seed`].
    pub seed: u64,
}

impl Default for RansacOptions {
    fn default() -> Self {
        Self { sample_size: 3, max_iterations: 1000, confidence: 0.99, seed: 0 }
    }
}

/// The best model found, and what speaks for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Consensus<M> {
    /// The model.
    pub model: M,
    /// Items within the threshold, in ascending order.
    pub inliers: Vec<usize>,
    /// Sum over the inliers of `weight * (1 - error^2 / threshold^2)`.
    pub score: f64,
    /// Samples drawn.
    pub iterations: usize,
}

/// The model with the highest score among those of random samples; ties go to the earlier one.
///
/// `weights`, one per item, default to one; a negative one or one that is not finite counts as zero. An item of weight zero is never
/// sampled and adds nothing to a score, but can be an inlier. `None` when fewer items than a sample have a weight, the
/// number of weights is not the number of items, or no sample gave a model with at least a sample's worth of inliers.
pub fn ransac<E: Estimator>(
    estimator: &E,
    weights: Option<&[f64]>,
    options: &RansacOptions,
) -> Option<Consensus<E::Model>> {
    let weights = usable_weights(estimator.n_items(), weights)?;
    let mut sampler = Sampler::new(&weights, options.sample_size)?;
    let scorer = Scorer::new(estimator, &weights);
    let mut generator = ChaCha8Rng::seed_from_u64(options.seed);
    let mut best: Option<Consensus<E::Model>> = None;
    let mut needed = options.max_iterations;
    let mut iterations = 0;
    while iterations < needed {
        iterations += 1;
        for model in estimator.fit(sampler.draw(&mut generator)) {
            let bar = best.as_ref().map_or(0.0, |b| b.score);
            if let Some(found) = scorer.better(model, bar) {
                let found = scorer.locally_optimized(found);
                let good_sample = good_sample_probability(&weights, &found.inliers, options.sample_size);
                needed = samples_needed(good_sample, options.confidence).min(options.max_iterations);
                best = Some(found);
            }
        }
    }
    best.map(|found| Consensus { iterations, ..found })
        .filter(|found| found.inliers.len() >= options.sample_size)
}

/// Weighs models against all items.
struct Scorer<'a, E> {
    estimator: &'a E,
    weights: &'a [f64],
    /// Weight of this item and all later ones: the most that they can still add to a score.
    remaining: Vec<f64>,
}

impl<'a, E: Estimator> Scorer<'a, E> {
    fn new(estimator: &'a E, weights: &'a [f64]) -> Self {
        let mut remaining = weights.to_vec();
        for i in (1..remaining.len()).rev() {
            remaining[i - 1] += remaining[i];
        }
        Self { estimator, weights, remaining }
    }

    /// The model with its score, if that is above the bar; gives up as soon as it cannot be.
    fn better(&self, model: E::Model, bar: f64) -> Option<Consensus<E::Model>> {
        let threshold_sq = self.estimator.threshold_sq();
        let mut inliers = Vec::new();
        let mut score = 0.0;
        for (item, (weight, remaining)) in self.weights.iter().zip(&self.remaining).enumerate() {
            if score + remaining < bar {
                return None;
            }
            let error_sq = self.estimator.error_sq(&model, item);
            if error_sq <= threshold_sq {
                score += weight * (1.0 - error_sq / threshold_sq);
                inliers.push(item);
            }
        }
        (score > bar).then_some(Consensus { model, inliers, score, iterations: 0 })
    }

    /// Refits to the inliers as long as that raises the score.
    fn locally_optimized(&self, start: Consensus<E::Model>) -> Consensus<E::Model> {
        const MAX_ROUNDS: usize = 4;
        let mut best = start;
        for _ in 0..MAX_ROUNDS {
            let refitted = self.estimator.refit(&best.model, &best.inliers, self.weights);
            match refitted.and_then(|model| self.better(model, best.score)) {
                Some(better) => best = better,
                None => break,
            }
        }
        best
    }
}

/// The probability that a sample drawn by weight without replacement has inliers only.
///
/// Exact for equal weights. Otherwise each draw is taken to remove its expected weight from inliers and total.
fn good_sample_probability(weights: &[f64], inliers: &[usize], sample_size: usize) -> f64 {
    let total: f64 = weights.iter().sum();
    let inlier_weight: f64 = inliers.iter().map(|&i| weights[i]).sum();
    if inlier_weight <= 0.0 {
        return 0.0;
    }
    let drawn = inliers.iter().map(|&i| weights[i] * weights[i]).sum::<f64>() / inlier_weight;
    let mut probability = 1.0;
    for k in 0..sample_size {
        let removed = k as f64 * drawn;
        if total - removed <= 0.0 {
            break;
        }
        probability *= ((inlier_weight - removed) / (total - removed)).max(0.0);
    }
    probability
}

/// Samples after which, with the given confidence, one was good.
fn samples_needed(good_sample: f64, confidence: f64) -> usize {
    if good_sample >= 1.0 {
        return 1;
    }
    let needed = (1.0 - confidence).ln() / (-good_sample).ln_1p();
    // A number that is too large or not a number means: no limit.
    if needed.is_finite() { needed.ceil().max(1.0) as usize } else { usize::MAX }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probability_of_a_good_sample_is_exact_for_equal_weights() {
        let expected = (5.0 * 4.0 * 3.0) / (10.0 * 9.0 * 8.0);
        assert!((good_sample_probability(&[0.3; 10], &[0, 2, 4, 6, 8], 3) - expected).abs() < 1e-15);
        assert!(good_sample_probability(&[1.0; 10], &[0, 1], 3) == 0.0);
    }

    #[test]
    fn number_of_samples_agrees_with_the_textbook_table() {
        // Hartley and Zisserman, table 4.3 (confidence 0.99).
        for (size, outliers, expected) in
            [(2, 0.5, 17), (3, 0.3, 11), (4, 0.5, 72), (7, 0.4, 163), (8, 0.5, 1177)]
        {
            let good: f64 = (1.0_f64 - outliers).powi(size);
            assert_eq!(samples_needed(good, 0.99), expected);
        }
        assert_eq!(samples_needed(1.0, 0.99), 1);
        assert_eq!(samples_needed(0.0, 0.99), usize::MAX);
        assert_eq!(samples_needed(0.5, 1.0), usize::MAX);
    }
}
