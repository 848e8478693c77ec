//! Random samples without replacement, drawn in proportion to weights.

use rand::Rng;

/// Draws samples of a fixed size; every draw picks among the items not yet drawn, in proportion to their weights.
pub(crate) struct Sampler<'a> {
    weights: &'a [f64],
    /// Sum of the weights of this item and all earlier ones.
    cumulative: Vec<f64>,
    sample: Vec<usize>,
    size: usize,
}

/// One weight per item, with zero for what is negative or not finite; `None` when the lengths differ.
pub(crate) fn usable_weights(n_items: usize, weights: Option<&[f64]>) -> Option<Vec<f64>> {
    match weights {
        None => Some(vec![1.0; n_items]),
        Some(given) if given.len() == n_items => {
            Some(given.iter().map(|&w| if w.is_finite() && w > 0.0 { w } else { 0.0 }).collect())
        }
        Some(_) => None,
    }
}

impl<'a> Sampler<'a> {
    /// A sampler over finite weights that are not negative; `None` when fewer than `size` of them are positive or `size` is zero.
    pub(crate) fn new(weights: &'a [f64], size: usize) -> Option<Self> {
        let mut sum = 0.0;
        let cumulative: Vec<f64> = weights
            .iter()
            .map(|w| {
                sum += w;
                sum
            })
            .collect();
        let n_positive = weights.iter().filter(|&&w| w > 0.0).count();
        let usable = size > 0 && n_positive >= size && sum.is_finite();
        usable.then(|| Self { weights, cumulative, sample: Vec::with_capacity(size), size })
    }

    /// The next sample, in the order of drawing.
    pub(crate) fn draw(&mut self, generator: &mut impl Rng) -> &[usize] {
        self.sample.clear();
        while self.sample.len() < self.size {
            // One try among all items; after a repetition, an exact draw among the rest. Together: the exact conditional law.
            let item = Some(self.draw_any(generator)).filter(|item| !self.sample.contains(item));
            let item = item.unwrap_or_else(|| self.draw_rest(generator));
            self.sample.push(item);
        }
        &self.sample
    }

    fn draw_any(&self, generator: &mut impl Rng) -> usize {
        let total = self.cumulative.last().copied().unwrap_or(0.0);
        let target = generator.random::<f64>() * total;
        let item = self.cumulative.partition_point(|&sum| sum <= target);
        // Rounding can reach the total: then the last item with a weight.
        if item < self.weights.len() { item } else { self.last_where(|_| true) }
    }

    fn draw_rest(&self, generator: &mut impl Rng) -> usize {
        let free = |item: &usize| !self.sample.contains(item);
        let total: f64 = (0..self.weights.len()).filter(free).map(|i| self.weights[i]).sum();
        let mut target = generator.random::<f64>() * total;
        for item in (0..self.weights.len()).filter(free) {
            if target < self.weights[item] {
                return item;
            }
            target -= self.weights[item];
        }
        self.last_where(free)
    }

    fn last_where(&self, allowed: impl Fn(&usize) -> bool) -> usize {
        (0..self.weights.len()).rev().find(|i| self.weights[*i] > 0.0 && allowed(i)).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    fn counts_of_pairs(weights: &[f64], n_draws: usize) -> Vec<Vec<f64>> {
        let mut sampler = Sampler::new(weights, 2).unwrap();
        let mut generator = ChaCha8Rng::seed_from_u64(7);
        let mut counts = vec![vec![0.0; weights.len()]; weights.len()];
        for _ in 0..n_draws {
            let sample = sampler.draw(&mut generator);
            counts[sample[0]][sample[1]] += 1.0 / n_draws as f64;
        }
        counts
    }

    #[test]
    fn ordered_pairs_follow_the_law_of_successive_draws() {
        let weights = [5.0, 1.0, 0.0, 3.0, 1.0];
        let observed = counts_of_pairs(&weights, 200_000);
        for (i, wi) in weights.iter().enumerate() {
            for (j, wj) in weights.iter().enumerate() {
                let expected = if i == j { 0.0 } else { wi / 10.0 * wj / (10.0 - wi) };
                // Five standard deviations of a binomial frequency.
                let tolerance = 5.0 * (expected * (1.0 - expected) / 200_000.0).sqrt();
                assert!(
                    (observed[i][j] - expected).abs() <= tolerance,
                    "{i} {j}: {} {expected}",
                    observed[i][j]
                );
            }
        }
    }

    #[test]
    fn one_overwhelming_weight_does_not_stall_the_draw() {
        let weights = [1e300, 1e-300, 0.0, 1e-300];
        let mut sampler = Sampler::new(&weights, 3).unwrap();
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..100 {
            let mut sample = sampler.draw(&mut generator).to_vec();
            sample.sort_unstable();
            assert_eq!(sample, [0, 1, 3]);
        }
    }

    #[test]
    fn too_few_positive_weights_are_refused() {
        assert!(Sampler::new(&[1.0, 0.0, 1.0], 3).is_none());
        assert!(Sampler::new(&[1.0], 0).is_none());
        assert!(Sampler::new(&[f64::MAX, f64::MAX], 2).is_none());
        assert_eq!(usable_weights(3, Some(&[1.0, f64::NAN, -2.0])), Some(vec![1.0, 0.0, 0.0]));
        assert_eq!(usable_weights(3, Some(&[1.0])), None);
    }
}
