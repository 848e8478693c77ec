//! Images of two topics that were taken at one time.

/// Pairs of two lists of stamps.
#[derive(Clone, Debug, PartialEq)]
pub struct Paired {
    /// Positions in the first list and in the second one, by time.
    pub pairs: Vec<(usize, usize)>,
    /// Of the first list, those without a partner.
    pub alone: usize,
    /// Largest difference between the stamps of a pair, nanoseconds.
    pub widest_ns: u64,
}

/// Pairs each stamp of `first` with the nearest one of `second` that is at most `tolerance_ns` away; both rise. Each is used once: of two
/// that want the same partner the nearer one gets it.
#[must_use]
pub fn pair(first: &[i64], second: &[i64], tolerance_ns: u64) -> Paired {
    let mut partner: Vec<Option<(usize, u64)>> = vec![None; second.len()];
    for (i, stamp) in first.iter().enumerate() {
        let after = second.partition_point(|other| other < stamp);
        let near = after.saturating_sub(1)..second.len().min(after + 1);
        let nearest = near.map(|j| (stamp.abs_diff(second[j]), j)).min();
        if let Some((distance, j)) = nearest.filter(|(distance, _)| *distance <= tolerance_ns)
            && partner[j].is_none_or(|(_, known)| distance < known)
        {
            partner[j] = Some((i, distance));
        }
    }
    let found = || {
        partner.iter().enumerate().filter_map(|(j, partner)| partner.map(|(i, distance)| (i, j, distance)))
    };
    let pairs: Vec<(usize, usize)> = found().map(|(i, j, _)| (i, j)).collect();
    let widest_ns = found().map(|(_, _, distance)| distance).max().unwrap_or(0);
    Paired { alone: first.len() - pairs.len(), pairs, widest_ns }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_within_the_tolerance_once_each() {
        let paired = pair(&[0, 100, 200, 300], &[1, 98, 150, 305], 10);
        assert_eq!(paired, Paired { pairs: vec![(0, 0), (1, 1), (3, 3)], alone: 1, widest_ns: 5 });
        assert_eq!(pair(&[0, 4], &[3], 5).pairs, [(1, 0)], "the nearer one gets it");
        assert_eq!(pair(&[], &[3], 5), Paired { pairs: vec![], alone: 0, widest_ns: 0 });
    }
}
