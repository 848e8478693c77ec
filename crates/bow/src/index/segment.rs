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
    /// Which words occur, 64 to a block.
    blocks: Vec<Block>,
    /// The postings of the i-th word that occurs end here, those of the next one follow.
    ends: Vec<u32>,
    postings: Vec<Posting>,
}

/// Which of 64 successive words occur, and how many do before them.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    occurs: u64,
    n_before: u32,
}

impl Segment {
    /// The segment of these places, which must be of different keyframes.
    pub(crate) fn new(mut places: Vec<Place>) -> Self {
        places.sort_by_key(|place| place.keyframe);
        let n_words =
            places.iter().filter_map(|p| p.vector.words().last()).max().map_or(0, |&w| w as usize + 1);
        // Counting sort by word: how many places have it, where its first posting goes, the postings.
        let mut next = vec![0u32; n_words];
        for word in places.iter().flat_map(|place| place.vector.words()) {
            next[*word as usize] += 1;
        }
        let mut blocks = vec![Block::default(); n_words.div_ceil(64)];
        let mut ends = Vec::new();
        let mut end = 0;
        for (word, next) in next.iter_mut().enumerate().filter(|(_, n)| **n > 0) {
            let start = end;
            end += *next;
            *next = start;
            blocks[word / 64].occurs |= 1 << (word % 64);
            ends.push(end);
        }
        for i in 1..blocks.len() {
            blocks[i].n_before = blocks[i - 1].n_before + blocks[i - 1].occurs.count_ones();
        }
        let mut postings = vec![Posting::default(); end as usize];
        for (i, place) in places.iter().enumerate() {
            for (word, weight) in place.vector.iter() {
                let next = &mut next[word as usize];
                postings[*next as usize] = Posting { place: i as u32, weight };
                *next += 1;
            }
        }
        Self { places, blocks, ends, postings }
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
    pub(crate) fn query(
        &self,
        query: &BowVector,
        wanted: impl Fn(usize) -> bool,
        matches: &mut Vec<PlaceMatch>,
    ) {
        // All look-ups first: none of them waits for another one, nor for the postings.
        let lists: Vec<_> = query.iter().map(|(word, weight)| (self.postings_of(word), weight)).collect();
        let mut sums = vec![(0u32, 0.0f64); self.places.len()];
        for (postings, weight) in lists {
            for posting in postings {
                let (shared_words, sum) = &mut sums[posting.place as usize];
                *shared_words += 1;
                *sum += f64::from(weight.min(posting.weight));
            }
        }
        for (i, (shared_words, sum)) in sums.into_iter().enumerate() {
            if shared_words > 0 && wanted(i) {
                matches.push(PlaceMatch {
                    keyframe: self.places[i].keyframe,
                    shared_words,
                    score: to_score(sum),
                });
            }
        }
    }
    fn postings_of(&self, word: u32) -> &[Posting] {
        let bit = 1 << (word % 64);
        let Some(block) = self.blocks.get(word as usize / 64).filter(|block| block.occurs & bit != 0) else {
            return &[];
        };
        let i = (block.n_before + (block.occurs & (bit - 1)).count_ones()) as usize;
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.postings[start as usize..self.ends[i] as usize]
    }
}
