//! A part of the place index that never changes: for every word the places that have it.

use crate::index::PlaceMatch;
use crate::vector::{BowVector, to_score};
use std::sync::Arc;

/// A keyframe and its vector.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) keyframe: u32,
    pub(crate) vector: Arc<BowVector>,
}

impl Place {
    /// The place as a match, if it shares a word with `query`.
    pub(crate) fn compare(&self, query: &BowVector) -> Option<PlaceMatch> {
        let (shared_words, score) = query.overlap(&self.vector);
        (shared_words > 0).then_some(PlaceMatch { keyframe: self.keyframe, shared_words, score })
    }
}

/// A word in one place.
#[derive(Clone, Copy, Debug, Default)]
struct Posting {
    place: u32,
    weight: f32,
}

/// The inverted file of some places.
#[derive(Debug)]
pub(crate) struct Segment {
    /// Ascending keyframes.
    places: Vec<Place>,
    /// Words that occur, ascending.
    words: Vec<u32>,
    /// The postings of `words[i]` end here, those of the next word follow.
    ends: Vec<u32>,
    postings: Vec<Posting>,
}

impl Segment {
    /// The segment of these places, which must be of different keyframes.
    pub(crate) fn new(mut places: Vec<Place>) -> Self {
        places.sort_by_key(|place| place.keyframe);
        let n_words = places.iter().filter_map(|p| p.vector.words().last()).max().map_or(0, |&w| w as usize + 1);
        // Counting sort by word: how many places have it, where its first posting goes, the postings.
        let mut next = vec![0u32; n_words];
        for word in places.iter().flat_map(|place| place.vector.words()) {
            next[*word as usize] += 1;
        }
        let (mut words, mut ends) = (Vec::new(), Vec::new());
        let mut end = 0;
        for (word, next) in next.iter_mut().enumerate().filter(|(_, n)| **n > 0) {
            let start = end;
            end += *next;
            *next = start;
            words.push(word as u32);
            ends.push(end);
        }
        let mut postings = vec![Posting::default(); end as usize];
        for (i, place) in places.iter().enumerate() {
            for (word, weight) in place.vector.iter() {
                let next = &mut next[word as usize];
                postings[*next as usize] = Posting { place: i as u32, weight };
                *next += 1;
            }
        }
        Self { places, words, ends, postings }
    }

    /// Its places, ascending keyframes.
    pub(crate) fn places(&self) -> &[Place] {
        &self.places
    }

    /// Where a keyframe stands among the places.
    pub(crate) fn find(&self, keyframe: u32) -> Option<usize> {
        self.places.binary_search_by_key(&keyframe, |place| place.keyframe).ok()
    }

    /// Adds the places that share a word with `query` and are wanted.
    pub(crate) fn query(&self, query: &BowVector, wanted: impl Fn(usize) -> bool, matches: &mut Vec<PlaceMatch>) {
        let mut sums = vec![(0u32, 0.0f64); self.places.len()];
        let mut at = 0;
        for (word, weight) in query.iter() {
            at += gallop(&self.words[at..], word);
            if self.words.get(at) != Some(&word) {
                continue;
            }
            let start = if at == 0 { 0 } else { self.ends[at - 1] };
            for posting in &self.postings[start as usize..self.ends[at] as usize] {
                let (shared_words, sum) = &mut sums[posting.place as usize];
                *shared_words += 1;
                *sum += f64::from(weight.min(posting.weight));
            }
        }
        for (i, (shared_words, sum)) in sums.into_iter().enumerate() {
            if shared_words > 0 && wanted(i) {
                matches.push(PlaceMatch { keyframe: self.places[i].keyframe, shared_words, score: to_score(sum) });
            }
        }
    }
}

/// How many of the ascending words are below `word`; fast when they are few.
fn gallop(words: &[u32], word: u32) -> usize {
    let mut step = 1;
    while step < words.len() && words[step] < word {
        step *= 2;
    }
    let start = step / 2;
    let end = (step + 1).min(words.len());
    start + words[start..end].partition_point(|&w| w < word)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn galloping_finds_the_partition_point(mut words in prop::collection::vec(0u32..200, 0..60), word in 0u32..200) {
            words.sort_unstable();
            prop_assert_eq!(gallop(&words, word), words.partition_point(|&w| w < word));
        }
    }
}
