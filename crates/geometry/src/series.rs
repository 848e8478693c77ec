//! The scalar functions inside the exponential maps, stable for every angle.
//!
//! All of them are Stumpff functions `c_n(x) = sum_k (-x)^k / (2k + n)!` of the squared angle `x`, which obey
//! `c_n = 1/n! - x c_{n+2}`. For example `c_1 = sin(a)/a` and `c_2 = (1 - cos(a))/a^2`.

/// Below this squared angle the power series is summed; above it the closed forms lose at most a few bits.
const SERIES_LIMIT_SQ: f64 = 1.0;

/// `c_1(x) = sin(a) / a` with `x = a^2`.
#[inline]
pub(crate) fn c1(x: f64) -> f64 {
    if x < 1e-8 {
        1.0 - x / 6.0
    } else {
        let a = x.sqrt();
        a.sin() / a
    }
}

/// `c_2(x) = (1 - cos(a)) / a^2` with `x = a^2`.
#[inline]
pub(crate) fn c2(x: f64) -> f64 {
    let half = c1(0.25 * x);
    0.5 * half * half
}

/// `c_3(x) = (a - sin(a)) / a^3` with `x = a^2`.
#[inline]
pub(crate) fn c3(x: f64) -> f64 {
    if x < SERIES_LIMIT_SQ { stumpff_series(3, x) } else { (1.0 - c1(x)) / x }
}

/// `c_4(x) = (a^2 / 2 + cos(a) - 1) / a^4` with `x = a^2`.
#[inline]
pub(crate) fn c4(x: f64) -> f64 {
    if x < SERIES_LIMIT_SQ { stumpff_series(4, x) } else { (0.5 - c2(x)) / x }
}

/// `c_5(x) = (a^3 / 6 - a + sin(a)) / a^5` with `x = a^2`.
#[inline]
pub(crate) fn c5(x: f64) -> f64 {
    if x < SERIES_LIMIT_SQ { stumpff_series(5, x) } else { (1.0 / 6.0 - c3(x)) / x }
}

/// `(1 - (a/2) cot(a/2)) / a^2` with `x = a^2`: the quadratic coefficient of the inverse left Jacobian of SO(3).
///
/// Regular at `a = pi`; it has a pole at `a = 2 pi`.
#[inline]
pub(crate) fn half_cotangent(x: f64) -> f64 {
    if x < 0.01 {
        // Bernoulli numbers: |B_2k| / (2k)!.
        1.0 / 12.0 + x * (1.0 / 720.0 + x * (1.0 / 30_240.0 + x * (1.0 / 1_209_600.0 + x / 47_900_160.0)))
    } else {
        let half = 0.5 * x.sqrt();
        (1.0 - half / half.tan()) / x
    }
}

/// `sum_k (-x)^k / (2k + n)!` by Horner's scheme, exact to rounding for `0 <= x < 1`.
fn stumpff_series(n: u32, x: f64) -> f64 {
    const TERMS: u32 = 9;
    let mut sum = 1.0;
    for k in (1..TERMS).rev() {
        let m = f64::from(2 * k + n);
        sum = 1.0 - x / (m * (m - 1.0)) * sum;
    }
    (1..=n).fold(sum, |value, m| value / f64::from(m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stumpff_functions_obey_their_recurrence_on_both_sides_of_the_switch() {
        for x in [0.0, 1e-12, 1e-9, 1e-8, 1.1e-8, 1e-3, 0.5, 0.999_999, 1.0, 1.000_001, 4.0, 9.8] {
            assert!((c1(x) - (1.0 - x * c3(x))).abs() < 4e-16, "c1 at {x}");
            assert!((c2(x) - (0.5 - x * c4(x))).abs() < 4e-16, "c2 at {x}");
            assert!((c3(x) - (1.0 / 6.0 - x * c5(x))).abs() < 4e-16, "c3 at {x}");
        }
    }

    #[test]
    fn values_at_zero_are_inverse_factorials() {
        assert_eq!((c1(0.0), c2(0.0), c4(0.0)), (1.0, 0.5, 1.0 / 24.0));
        assert!((c3(0.0) - 1.0 / 6.0).abs() < 1e-17 && (c5(0.0) - 1.0 / 120.0).abs() < 1e-18);
    }

    #[test]
    fn half_cotangent_is_continuous_at_the_switch_and_known_at_pi() {
        let (below, above) = (half_cotangent(0.01 - 1e-15), half_cotangent(0.01));
        assert!((below - above).abs() < 1e-13);
        let pi_sq = std::f64::consts::PI.powi(2);
        assert!((half_cotangent(pi_sq) - 1.0 / pi_sq).abs() < 1e-15);
    }
}
