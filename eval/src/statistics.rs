//! Summary numbers of a list of errors: what every metric of this package ends in.

use serde::{Deserialize, Serialize};

/// Summary of a list of errors, in the unit of the errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Root of the mean square.
    pub rmse: f64,
    /// Arithmetic mean.
    pub mean: f64,
    /// Middle value; the mean of the two middle ones when their number is even.
    pub median: f64,
    /// Standard deviation of the population (divided by n).
    pub std: f64,
    /// Smallest error.
    pub min: f64,
    /// Largest error.
    pub max: f64,
    /// Number of errors.
    pub n: usize,
}

impl Statistics {
    /// Summary of `errors`; `None` when there are none.
    pub fn of(errors: &[f64]) -> Option<Statistics> {
        if errors.is_empty() {
            return None;
        }
        let n = errors.len();
        let count = n as f64;
        let mean = errors.iter().sum::<f64>() / count;
        let mean_square = errors.iter().map(|e| e * e).sum::<f64>() / count;
        let variance = errors.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / count;
        let mut sorted = errors.to_vec();
        sorted.sort_by(f64::total_cmp);
        Some(Statistics {
            rmse: mean_square.sqrt(),
            mean,
            median: median_of_sorted(&sorted),
            std: variance.sqrt(),
            min: sorted[0],
            max: sorted[n - 1],
            n,
        })
    }
}

/// Median of `values` in any order; `None` when there are none.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    (!sorted.is_empty()).then(|| median_of_sorted(&sorted))
}

fn median_of_sorted(sorted: &[f64]) -> f64 {
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[middle] } else { 0.5 * (sorted[middle - 1] + sorted[middle]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_summary() {
        let s = Statistics::of(&[3.0, 1.0, 2.0, 6.0]).unwrap();
        assert_eq!((s.mean, s.median, s.min, s.max, s.n), (3.0, 2.5, 1.0, 6.0, 4));
        assert!((s.rmse - 12.5_f64.sqrt()).abs() < 1e-15);
        assert!((s.std - 3.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!(median(&[5.0, 1.0, 3.0]), Some(3.0));
    }

    #[test]
    fn nothing_has_no_summary() {
        assert_eq!(Statistics::of(&[]), None);
        assert_eq!(median(&[]), None);
    }
}
