//! Chi-square limits and Huber's loss.

/// Chi-square, 2 degrees of freedom, 95 %.
pub const CHI2_MONO: f64 = 5.991;
/// Chi-square, 3 degrees of freedom, 95 %.
pub const CHI2_STEREO: f64 = 7.815;
/// Chi-square, 6 degrees of freedom, 95 %.
pub const CHI2_SE3: f64 = 12.592;
/// Chi-square, 7 degrees of freedom, 95 %.
pub const CHI2_SIM3: f64 = 14.067;

/// Cap of the whitened squared error (1000 sigma): what lies beyond, or behind the camera where no residual exists, counts
/// this much and pulls nothing. So the cost has no step where a point crosses the image plane, and none crosses for gain.
pub(crate) const MAX_CHI_SQ: f64 = 1e6;

/// A step that promises less than this, in whitened units, ends a descent whatever the tolerance: rounding is near.
pub(crate) const NEGLIGIBLE_DECREASE: f64 = 1e-15;

/// Loss applied to the whitened squared error of one observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// Plain least squares.
    Squared,
    /// Huber: quadratic up to delta, linear beyond.
    Huber,
}

impl Loss {
    /// rho(s) for the squared error `chi_sq`; the cost is half of it. Huber (1964): s, beyond delta 2 delta sqrt(s) - delta^2.
    #[inline(always)]
    pub fn rho(self, chi_sq: f64, delta_sq: f64) -> f64 {
        match self {
            Loss::Huber if chi_sq > delta_sq => 2.0 * (delta_sq * chi_sq).sqrt() - delta_sq,
            _ => chi_sq,
        }
    }

    /// rho'(s): the weight of the observation in iteratively re-weighted least squares.
    #[inline(always)]
    pub fn weight(self, chi_sq: f64, delta_sq: f64) -> f64 {
        match self {
            Loss::Huber if chi_sq > delta_sq => (delta_sq / chi_sq).sqrt(),
            _ => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn huber_is_continuous_with_its_weight_as_derivative() {
        for s in [0.1, 3.0, CHI2_MONO, 6.5, 40.0, 1e5] {
            let h = 1e-6 * s;
            let slope = (Loss::Huber.rho(s + h, CHI2_MONO) - Loss::Huber.rho(s - h, CHI2_MONO)) / (2.0 * h);
            assert!((slope - Loss::Huber.weight(s, CHI2_MONO)).abs() < 1e-5, "s = {s}: {slope}");
        }
        assert_eq!(Loss::Squared.rho(1e5, CHI2_MONO), 1e5);
    }
}
