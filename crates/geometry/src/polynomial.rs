//! Where a polynomial first changes its sign: the limits of lens models.

/// The smallest root between zero and `end` at which the polynomial `c[0] + c[1] x + c[2] x^2 + ...`, positive at zero, turns
/// negative; `None` when it does not.
///
/// Between two neighboring roots of its derivative a polynomial is monotone, so that halving finds its only root there.
pub(crate) fn first_sign_change(coefficients: &[f64], end: f64) -> Option<f64> {
    let mut start = 0.0;
    for stop in roots_of_derivative(coefficients, end).into_iter().chain([end]) {
        if value(coefficients, stop) < 0.0 {
            return Some(halving(coefficients, start, stop));
        }
        start = stop;
    }
    None
}

/// Roots with a change of sign of the derivative between zero and `end`, ascending.
fn roots_of_derivative(coefficients: &[f64], end: f64) -> Vec<f64> {
    if coefficients.len() < 3 {
        return Vec::new();
    }
    let derivative: Vec<f64> = coefficients.iter().enumerate().skip(1).map(|(i, c)| c * i as f64).collect();
    let mut roots = Vec::new();
    let mut start = 0.0;
    for stop in roots_of_derivative(&derivative, end).into_iter().chain([end]) {
        if (value(&derivative, start) < 0.0) != (value(&derivative, stop) < 0.0) {
            roots.push(halving(&derivative, start, stop));
        }
        start = stop;
    }
    roots
}

/// The change of sign between two places of different sign.
fn halving(coefficients: &[f64], mut start: f64, mut stop: f64) -> f64 {
    /// Enough for every bit of a double.
    const ROUNDS: usize = 100;
    let negative_at_start = value(coefficients, start) < 0.0;
    for _ in 0..ROUNDS {
        let middle = 0.5 * (start + stop);
        if (value(coefficients, middle) < 0.0) == negative_at_start { start = middle } else { stop = middle }
    }
    start
}

/// Horner's rule.
fn value(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_change_of_sign_is_found() {
        // (1 - x)(2 - x)(3 - x) and (1 - x / 4)^2 (2 - x): a double root does not change the sign.
        let cases: [(&[f64], f64, Option<f64>); 5] = [
            (&[6.0, -11.0, 6.0, -1.0], 10.0, Some(1.0)),
            (&[6.0, -11.0, 6.0, -1.0], 0.9, None),
            (&[2.0, -2.0, 0.625, -0.0625], 10.0, Some(2.0)),
            (&[1.0, 0.0, 1.0], 10.0, None),
            (&[1.0, -0.5], 10.0, Some(2.0)),
        ];
        for (coefficients, end, expected) in cases {
            let found = first_sign_change(coefficients, end);
            let close = match (found, expected) {
                (Some(a), Some(b)) => f64::abs(a - b) < 1e-12,
                (a, b) => a == b,
            };
            assert!(close, "{coefficients:?}: {found:?}, expected {expected:?}");
        }
    }
}
