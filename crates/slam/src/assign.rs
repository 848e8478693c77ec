//! One point to one feature: resolves what several queries found in the same frame.

use features::WindowMatch;

/// Matches `(feature, query)` sorted by feature: of all queries that want a feature the one with the smallest
/// descriptor distance gets it, ties go to the lower query index. `accept` judges each query's find alone.
pub(crate) fn one_to_one(
    finds: &[Option<WindowMatch>],
    n_features: usize,
    accept: impl Fn(usize, &WindowMatch) -> bool,
) -> Vec<(u32, usize)> {
    let mut winner: Vec<Option<(u32, usize)>> = vec![None; n_features];
    for (query, find) in finds.iter().enumerate() {
        let Some(find) = find else { continue };
        if !accept(query, find) {
            continue;
        }
        let slot = &mut winner[find.best.feature as usize];
        if slot.is_none_or(|(distance, _)| find.best.distance < distance) {
            *slot = Some((find.best.distance, query));
        }
    }
    winner
        .iter()
        .enumerate()
        .filter_map(|(feature, slot)| slot.map(|(_, query)| (feature as u32, query)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use features::Candidate;

    fn find(feature: u32, distance: u32) -> Option<WindowMatch> {
        Some(WindowMatch { best: Candidate { feature, distance, octave: 0 }, second: None })
    }

    #[test]
    fn the_nearest_descriptor_wins_and_ties_go_to_the_lower_query() {
        let finds = [find(3, 40), None, find(3, 20), find(1, 7), find(1, 7), find(3, 20)];
        assert_eq!(one_to_one(&finds, 5, |_, _| true), vec![(1, 3), (3, 2)]);
    }

    #[test]
    fn refused_finds_leave_the_feature_to_others() {
        let finds = [find(0, 60), find(0, 10)];
        assert_eq!(one_to_one(&finds, 1, |query, _| query == 0), vec![(0, 0)]);
    }
}
