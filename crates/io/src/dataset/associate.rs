//! Pairs of images that were taken at nearly the same time.

/// One-to-one association of two increasing lists of times, as TUM's tool does it: all pairs nearer than the tolerance,
/// smallest difference first (ties by the first time, then the second), each time used once. Returns for each time of
/// `first` the position in `second`.
pub fn associate(first: &[f64], second: &[f64], tolerance_s: f64) -> Vec<Option<usize>> {
    let mut candidates = Vec::new();
    for (a, &time) in first.iter().enumerate() {
        let begin = second.partition_point(|&other| other <= time - tolerance_s);
        for (b, &other) in second.iter().enumerate().skip(begin).take_while(|&(_, &t)| t < time + tolerance_s)
        {
            candidates.push(((time - other).abs(), a, b));
        }
    }
    candidates.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)).then(x.2.cmp(&y.2)));
    let mut partners = vec![None; first.len()];
    let mut taken = vec![false; second.len()];
    for (_, a, b) in candidates {
        if partners[a].is_none() && !taken[b] {
            partners[a] = Some(b);
            taken[b] = true;
        }
    }
    partners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smallest_difference_wins_and_each_is_used_once() {
        let partners = associate(&[0.0, 0.010, 1.0], &[0.012, 0.015, 2.0], 0.02);
        assert_eq!(partners, [Some(1), Some(0), None]);
    }

    #[test]
    fn the_tolerance_is_exclusive() {
        assert_eq!(associate(&[0.0], &[0.25], 0.25), [None]);
        assert_eq!(associate(&[0.0], &[0.25], 0.26), [Some(0)]);
        assert_eq!(associate(&[0.25], &[0.0], 0.25), [None]);
    }

    #[test]
    fn ties_go_to_the_earlier_time() {
        assert_eq!(associate(&[1.0, 2.0], &[1.5], 0.75), [Some(0), None]);
        assert_eq!(associate(&[1.5], &[1.0, 2.0], 0.75), [Some(0)]);
    }

    #[test]
    fn moving_both_clocks_changes_nothing() {
        let first: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.03125).collect();
        let second: Vec<f64> =
            (0..50).map(|i| f64::from(i * i % 7) * 0.001953125 + f64::from(i) * 0.0625).collect();
        let moved = |times: &[f64]| times.iter().map(|t| t + 1024.0).collect::<Vec<_>>();
        let partners = associate(&first, &second, 0.02);
        assert!(partners.iter().flatten().count() > 10);
        assert_eq!(associate(&moved(&first), &moved(&second), 0.02), partners);
    }
}
