//! What every optimization tells about itself.

/// Outcome of a least-squares solve. Costs are half the sum of the (robust) whitened squared residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Cost at the initial values, over the observations and the loss of `final_cost`.
    pub initial_cost: f64,
    /// Cost at the returned values.
    pub final_cost: f64,
    /// Linear systems solved, rejected steps included.
    pub iterations: usize,
    /// Observations within their chi-square limit at the returned values.
    pub n_inliers: usize,
    /// Why the solver stopped.
    pub stop: StopReason,
}

/// Why a solver stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The last step changed cost or values by less than the tolerance.
    Converged,
    /// The iteration limit was reached while the cost still fell.
    IterationLimit,
    /// No step lowers the cost, however strong the damping.
    NoDescent,
    /// Nothing to optimize: too few observations, or nothing free.
    NoData,
}
