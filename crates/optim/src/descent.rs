//! Levenberg-Marquardt: what all descents have in common.

use crate::report::StopReason;
use crate::robust::NEGLIGIBLE_DECREASE;

/// Damping is kept within these bounds; at the upper one no step is left to try.
const MIN_DAMPING: f64 = 1e-12;
const MAX_DAMPING: f64 = 1e12;

/// When a descent ends, and how it begins.
#[derive(Clone, Copy)]
pub(crate) struct Descent {
    pub(crate) max_iterations: usize,
    /// It ends once a step promises to change the cost by less than this part of it.
    pub(crate) tolerance: f64,
    /// Damping of the first step.
    pub(crate) initial_damping: f64,
}

/// A step that was tried, and taken if the cost fell.
pub(crate) struct Attempt {
    /// Cost before.
    pub(crate) cost: f64,
    pub(crate) decrease: f64,
    /// Decrease by the quadratic model.
    pub(crate) predicted: f64,
}

impl Descent {
    /// Tries steps with the damping that `attempt` is given, which answers `None` where the damped system is not positive definite;
    /// returns the number of steps. The damping follows Nielsen's rule.
    pub(crate) fn run(self, mut attempt: impl FnMut(f64) -> Option<Attempt>) -> (usize, StopReason) {
        let (mut lambda, mut growth) = (self.initial_damping, 2.0);
        for iteration in 1..=self.max_iterations {
            let mut is_down = false;
            if let Some(Attempt { cost, decrease, predicted }) = attempt(lambda) {
                is_down = decrease > 0.0;
                if is_down {
                    let gain = decrease / predicted;
                    lambda = (lambda * (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 3.0)).max(MIN_DAMPING);
                    growth = 2.0;
                }
                if predicted <= (self.tolerance * cost).max(NEGLIGIBLE_DECREASE) {
                    return (iteration, StopReason::Converged);
                }
            }
            if !is_down {
                lambda *= growth;
                growth *= 2.0;
                if !(lambda < MAX_DAMPING) {
                    return (iteration, StopReason::NoDescent);
                }
            }
        }
        (self.max_iterations, StopReason::IterationLimit)
    }
}
