//! The known key nearest to an unknown one.

use strsim::osa_distance;

/// The nearest of `known` if it is near enough to be meant: by the whole path, or by the last part alone when somebody
/// wrote it without its section. Ties go to the first in the table.
pub(super) fn find_nearest<'a>(given: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let name = |key: &str| key.rsplit('.').next().unwrap_or_default().to_string();
    let given_name = name(given);
    known
        .map(|key| {
            let whole = osa_distance(given, key);
            // A wrong section costs one more than a right one.
            let by_name = osa_distance(&given_name, &name(key)) + 1;
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
    fn nearest_key() {
        let known = || ["features.keep", "features.levels", "tracking.min_inliers", "seed"].into_iter();
        assert_eq!(find_nearest("features.levles", known()), Some("features.levels"));
        assert_eq!(find_nearest("featuers.keep", known()), Some("features.keep"));
        assert_eq!(find_nearest("min_inliers", known()), Some("tracking.min_inliers"));
        assert_eq!(find_nearest("sead", known()), Some("seed"));
        assert_eq!(find_nearest("utterly.different", known()), None);
    }
}
