//! The known key nearest to an unknown one.

/// Number of insertions, deletions, substitutions and swaps of neighbors between two words (optimal string
/// alignment distance).
fn edit_distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().collect();
    let b: Vec<char> = b.chars().collect();
    let mut before_last: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let substituted = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = substituted.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(before_last[j - 2] + 1);
            }
            row.push(best);
        }
        before_last = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

/// The nearest of `known` if it is near enough to be meant: by the whole path, or by the last part alone when somebody
/// wrote it without its section. Ties go to the first in the table.
pub(super) fn find_nearest<'a>(given: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let name = |key: &str| key.rsplit('.').next().unwrap_or_default().to_string();
    let given_name = name(given);
    known
        .map(|key| {
            let whole = edit_distance(given, key);
            // A wrong section costs one more than a right one.
            let by_name = edit_distance(&given_name, &name(key)) + 1;
            let longest_allowed = (name(key).chars().count() / 2).max(1);
            (whole.min(by_name), longest_allowed, key)
        })
        .filter(|&(distance, allowed, _)| distance <= allowed)
        .min_by_key(|&(distance, _, _)| distance)
        .map(|(_, _, key)| key)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances() {
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("levels", "levels"), 0);
        assert_eq!(edit_distance("levles", "levels"), 1);
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("abc", ""), 3);
    }

    #[test]
    fn nearest_key() {
        let known = || ["features.keep", "features.levels", "tracking.min_inliers", "seed"].into_iter();
        assert_eq!(find_nearest("features.levles", known()), Some("features.levels"));
        assert_eq!(find_nearest("featuers.keep", known()), Some("features.keep"));
        assert_eq!(find_nearest("min_inliers", known()), Some("tracking.min_inliers"));
        assert_eq!(find_nearest("sead", known()), Some("seed"));
        assert_eq!(find_nearest("utterly.different", known()), None);
    }
}
