//! Matches that agree in how far the image turned.

/// Histogram bins over the full circle: 12 degrees each.
const BINS: usize = 30;

/// Which of the matches, given the angle differences of their keypoints in degrees, lie in the three fullest of 30 bins.
///
/// The second and third bin count only with at least a tenth of the first one's matches; of equal bins the one with the
/// smaller angle is taken; NaN agrees with nothing. ORB-SLAM2 means the same but divides by the bin number instead of the
/// bin width, so that its bins are too coarse (its issue 64).
pub fn consistent_rotations(deltas_deg: &[f32]) -> Vec<bool> {
    let width_deg = 360.0 / BINS as f32;
    let bin_of =
        |delta: f32| delta.is_finite().then(|| (delta.rem_euclid(360.0) / width_deg).round() as usize % BINS);
    let mut counts = [0u32; BINS];
    for bin in deltas_deg.iter().filter_map(|&d| bin_of(d)) {
        counts[bin] += 1;
    }
    let mut order: [usize; BINS] = std::array::from_fn(|i| i);
    order.sort_by_key(|&bin| (u32::MAX - counts[bin], bin));
    let fullest = counts[order[0]];
    let mut accepted = [false; BINS];
    for &bin in &order[..3] {
        accepted[bin] = counts[bin] > 0 && counts[bin] * 10 >= fullest;
    }
    deltas_deg.iter().map(|&d| bin_of(d).is_some_and(|bin| accepted[bin])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outliers_of_a_common_rotation_are_dropped() {
        let mut deltas = vec![30.0; 100];
        deltas.extend([200.0, 210.0, 90.0]);
        let kept = consistent_rotations(&deltas);
        assert!(kept[..100].iter().all(|&k| k));
        assert!(kept[100..].iter().all(|&k| !k));
    }

    #[test]
    fn differences_wrap_around() {
        let deltas = [-2.0, 358.0, 1.0, 720.0, -361.0, 3.0];
        assert!(consistent_rotations(&deltas).iter().all(|&k| k));
    }

    #[test]
    fn bins_are_twelve_degrees_wide() {
        // Five groups 24 degrees apart: two of them must go, with the coarse bins of the original they would be merged.
        let deltas: Vec<f32> = (0..5).flat_map(|i| vec![24.0 * i as f32; 10]).collect();
        assert_eq!(consistent_rotations(&deltas).iter().filter(|&&k| k).count(), 30);
    }

    #[test]
    fn second_bin_needs_a_tenth_of_the_first() {
        let with = |n: usize| {
            let mut deltas = vec![0.0; 100];
            deltas.extend(vec![90.0; n]);
            consistent_rotations(&deltas)[100]
        };
        assert!(!with(9));
        assert!(with(10));
    }

    #[test]
    fn nothing_and_nan() {
        assert!(consistent_rotations(&[]).is_empty());
        assert_eq!(consistent_rotations(&[f32::NAN, 5.0]), [false, true]);
    }
}
