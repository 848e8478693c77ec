//! Which places are familiar from several images in a row: one image finds its place among many that look alike, images of a drive
//! past it find it again and again.

use crate::index::PlaceMatch;

/// What of the familiarity before an image still counts with it.
const KEPT: f64 = 0.9;

/// How familiar each place is: the score of the present image plus a share of how familiar the place or one of its neighbors was
/// before, whichever was most. What looks like the image by chance is not beside what looked like the image before.
///
/// A recursive filter over the places in the sense of FAB-MAP's motion model (Cummins and Newman, IJRR 2008), with sums of scores in
/// the place of probabilities. It needs the images so far only.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Familiarity {
    /// By keyframe.
    before: Vec<f64>,
}

/// A place and how familiar it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Familiar {
    /// The keyframe.
    pub keyframe: u32,
    /// Sum of weighted scores, at least 0.
    pub familiarity: f64,
}

impl Familiarity {
    /// Takes what the next image looks like and returns these places, the most familiar first, of equals the lower id.
    ///
    /// `neighbors` are the keyframes from which one may have come to a keyframe since the image before. A place that is not
    /// among `found` is forgotten.
    pub fn advance<N: IntoIterator<Item = u32>>(
        &mut self,
        found: &[PlaceMatch],
        neighbors: impl Fn(u32) -> N,
    ) -> Vec<Familiar> {
        let before = |keyframe: u32| self.before.get(keyframe as usize).copied().unwrap_or(0.0);
        let mut now: Vec<Familiar> = found
            .iter()
            .map(|&PlaceMatch { keyframe, score, .. }| {
                let most = neighbors(keyframe).into_iter().map(before).fold(before(keyframe), f64::max);
                Familiar { keyframe, familiarity: score + KEPT * most }
            })
            .collect();
        let len = now.iter().map(|place| place.keyframe as usize + 1).max().unwrap_or(0);
        self.before.clear();
        self.before.resize(len, 0.0);
        now.iter().for_each(|place| self.before[place.keyframe as usize] = place.familiarity);
        now.sort_unstable_by(|a, b| {
            b.familiarity.total_cmp(&a.familiarity).then(a.keyframe.cmp(&b.keyframe))
        });
        now
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.before.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(scores: &[(u32, f64)]) -> Vec<PlaceMatch> {
        scores.iter().map(|&(keyframe, score)| PlaceMatch { keyframe, shared_words: 1, score }).collect()
    }

    fn beside(keyframe: u32) -> std::ops::RangeInclusive<u32> {
        keyframe.saturating_sub(1)..=keyframe + 1
    }

    #[test]
    fn a_place_on_the_way_wins_over_one_that_looks_more_alike() {
        let mut familiarity = Familiarity::default();
        for (at, by_chance) in [(4, 30), (5, 17), (6, 40)] {
            familiarity.advance(&found(&[(at, 0.2), (by_chance, 0.25)]), beside);
        }
        let now = familiarity.advance(&found(&[(50, 0.3), (7, 0.2)]), beside);
        let expected = 0.2 * (1.0 + 0.9 + 0.81 + 0.729);
        assert_eq!(now.iter().map(|f| f.keyframe).collect::<Vec<_>>(), [7, 50]);
        assert!((now[0].familiarity - expected).abs() < 1e-12 && (now[1].familiarity - 0.3).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_found_is_forgotten() {
        let mut familiarity = Familiarity::default();
        familiarity.advance(&found(&[(4, 0.9)]), beside);
        familiarity.advance(&found(&[(9, 0.1)]), beside);
        assert_eq!(familiarity.advance(&found(&[(4, 0.2)]), beside)[0].familiarity, 0.2);
        familiarity.clear();
        assert_eq!(familiarity, Familiarity::default());
    }

    #[test]
    fn equals_come_in_the_order_of_their_ids() {
        let now = Familiarity::default().advance(&found(&[(8, 0.5), (3, 0.5), (5, 0.5)]), beside);
        assert_eq!(now.iter().map(|f| f.keyframe).collect::<Vec<_>>(), [3, 5, 8]);
        assert!(Familiarity::default().advance(&[], beside).is_empty());
    }
}
