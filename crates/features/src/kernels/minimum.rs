//! Minima of the costs along a row.

use simd::{Simd, Task};

/// Places nearer than this to the best belong to the same minimum.
const SAME_MINIMUM: usize = 3;

/// Index of the lowest cost, the last of equals (the smallest disparity); 0 when there are none.
pub(crate) fn last_minimum(simd: Simd, costs: &[u16]) -> usize {
    simd.run(Last { costs })
}

/// Index of the lowest cost, the last of equals, and how far behind it the minimum lies, within half a place; `None` at the
/// ends and when the cost is not below `uniqueness` times that of every other minimum.
pub(crate) fn distinct_minimum(simd: Simd, costs: &[u16], uniqueness: f32) -> Option<(usize, f32)> {
    simd.run(Distinct { costs, uniqueness })
}

struct Last<'a> {
    costs: &'a [u16],
}

impl Task for Last<'_> {
    type Output = usize;

    #[inline(always)]
    fn run(self) -> usize {
        let mut lowest = u16::MAX;
        for &cost in self.costs {
            lowest = lowest.min(cost);
        }
        self.costs.iter().rposition(|&c| c == lowest).unwrap_or(0)
    }
}

struct Distinct<'a> {
    costs: &'a [u16],
    uniqueness: f32,
}

impl Task for Distinct<'_> {
    type Output = Option<(usize, f32)>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { costs, uniqueness } = self;
        let best = Last { costs }.run();
        if best == 0 || best + 1 >= costs.len() {
            return None;
        }
        let before = lowest_vertex(&costs[..(best + 1).saturating_sub(SAME_MINIMUM)]);
        let behind = lowest_vertex(&costs[(best + SAME_MINIMUM).min(costs.len())..]);
        let distinct = f32::from(costs[best]) < uniqueness * before.min(behind);
        distinct.then(|| (best, vertex(costs[best - 1], costs[best], costs[best + 1])))
    }
}

/// The least cost of the minima inside of `costs`, between the places too: in periodic structures the whole places may all lie
/// beside the minimum.
#[inline(always)]
fn lowest_vertex(costs: &[u16]) -> f32 {
    let Some(n) = costs.len().checked_sub(2) else { return f32::MAX };
    let mut lowest = i32::MAX;
    let neighbours = costs[..n].iter().zip(&costs[1..=n]).zip(&costs[2..]);
    for ((before, middle), after) in neighbours {
        let [before, middle, after] = [i32::from(*before), i32::from(*middle), i32::from(*after)];
        let is_minimum = (middle <= before) & (middle <= after);
        let twice = if is_minimum { 2 * middle - (before - after).abs() } else { i32::MAX };
        lowest = lowest.min(twice);
    }
    if lowest == i32::MAX { f32::MAX } else { 0.5 * lowest as f32 }
}

/// Position of the minimum between three costs, the middle one lowest, of two lines of equal and opposite slope (the form of
/// sums of absolute differences); within half a place.
#[inline(always)]
fn vertex(before: u16, middle: u16, after: u16) -> f32 {
    let (before, middle, after) = (f32::from(before), f32::from(middle), f32::from(after));
    let rise = before.max(after) - middle;
    if rise > 0.0 { 0.5 * (before - after) / rise } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_minimum_lies_between_the_places() {
        // Lines of slope 100 that meet a quarter behind place 4.
        let costs: Vec<u16> = (0..9).map(|i| (100.0 * (i as f32 - 4.25).abs() + 7.0) as u16).collect();
        let (best, fraction) = distinct_minimum(Simd::detect(), &costs, 0.9).unwrap();
        assert_eq!(best, 4);
        assert!((fraction - 0.25).abs() < 0.01);
    }

    #[test]
    fn ends_and_rivals_are_refused() {
        let find = |costs: &[u16]| distinct_minimum(Simd::detect(), costs, 0.8).map(|m| m.0);
        assert_eq!(find(&[]), None);
        assert_eq!(find(&[5]), None);
        assert_eq!(find(&[1, 5, 9, 9, 9, 9]), None);
        assert_eq!(find(&[9, 9, 9, 9, 5, 1]), None);
        assert_eq!(find(&[900, 100, 900, 900, 900, 900, 900, 120, 900]), None);
        assert_eq!(find(&[900, 100, 900, 900, 900, 900, 900, 130, 900]), Some(1));
        // The rival's minimum lies between two places of 200 each.
        assert_eq!(find(&[900, 100, 900, 900, 900, 900, 900, 200, 200, 900]), None);
        // Part of the same minimum.
        assert_eq!(find(&[900, 100, 110, 120, 900, 900, 900]), Some(1));
    }

    proptest! {
        #[test]
        fn forms_are_equal(costs in proptest::collection::vec(0u16..500, 0..80), uniqueness in 0.5f32..1.2) {
            let [scalar, vector] = [Simd::scalar(), Simd::detect()];
            prop_assert_eq!(last_minimum(scalar, &costs), last_minimum(vector, &costs));
            let find = |simd| distinct_minimum(simd, &costs, uniqueness);
            prop_assert_eq!(find(scalar), find(vector));
        }
    }
}
