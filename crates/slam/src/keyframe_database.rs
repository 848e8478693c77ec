//! Which keyframes look alike: bag-of-words vectors and direct indices of the map's keyframes (ORB-SLAM's
//! KeyFrameDatabase).

use std::fmt;
use std::sync::Arc;

use bow::{BowVector, DirectIndex, PlaceIndex, PlaceMatch, Transformed, Vocabulary};
use features::Frame;
use map::{KeyframeId, Map};

/// Direct indices that share one allocation.
const CHUNK: usize = 64;

/// What the vocabulary says about the keyframes of a map. A clone is a cheap snapshot that later changes leave alone.
#[derive(Clone, Default)]
pub struct KeyframeDatabase {
    /// Without one, no place is ever recognized.
    vocabulary: Option<Arc<Vocabulary>>,
    /// Whether bag-of-words entries count as far as features will be there another day.
    weighted: bool,
    index: PlaceIndex,
    /// By id of the keyframe; `None` for keyframes that do not exist.
    direct: Vec<Arc<Vec<Option<Arc<DirectIndex>>>>>,
}

/// A keyframe that shares words with an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Alike {
    pub(crate) keyframe: KeyframeId,
    pub(crate) shared_words: u32,
    /// From 0 to 1.
    pub(crate) score: f64,
}

impl Alike {
    /// As the place index has it.
    pub(crate) fn as_match(&self) -> PlaceMatch {
        PlaceMatch { keyframe: self.keyframe.0, shared_words: self.shared_words, score: self.score }
    }
}

impl fmt::Debug for KeyframeDatabase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("KeyframeDatabase").field("keyframes", &self.index.len()).finish_non_exhaustive()
    }
}

impl KeyframeDatabase {
    /// No places yet, in the words of a vocabulary; without one, no place will ever be recognized.
    pub fn new(vocabulary: Option<Arc<Vocabulary>>) -> Self {
        KeyframeDatabase { vocabulary, ..KeyframeDatabase::default() }
    }

    /// The same; features of what is added from now on count as far as they will be there another day if `weighted`.
    #[must_use]
    pub fn weighted(self, weighted: bool) -> Self {
        KeyframeDatabase { weighted, ..self }
    }

    /// The same with all keyframes of a map added.
    #[must_use]
    pub fn with_map(mut self, map: &Map) -> Self {
        map.keyframes().for_each(|keyframe| self.add(keyframe.id, &keyframe.frame));
        self
    }

    /// Vector and direct index of a frame, features weighted by what the network says of another day if that counts; `None`
    /// without a vocabulary.
    pub fn describe(&self, frame: &Frame) -> Option<Transformed> {
        let weights = self.weighted.then_some(&frame.lasting[..]);
        self.vocabulary.as_ref().map(|v| v.transform(&frame.descriptors, weights))
    }

    /// Vector and direct index of a keyframe.
    pub fn of(&self, keyframe: KeyframeId) -> Option<(&Arc<BowVector>, &DirectIndex)> {
        let id = keyframe.0 as usize;
        let direct = self.direct.get(id / CHUNK)?.get(id % CHUNK)?.as_ref()?;
        Some((self.index.vector(keyframe.0)?, direct))
    }

    /// All `wanted` keyframes that share a word with an image: best score first, of equals the older one.
    pub(crate) fn alike(&self, bow: &BowVector, wanted: impl Fn(KeyframeId) -> bool) -> Vec<Alike> {
        let found = self.index.query(bow, |id| !wanted(KeyframeId(id)));
        let alike = |m: PlaceMatch| Alike {
            keyframe: KeyframeId(m.keyframe),
            shared_words: m.shared_words,
            score: m.score,
        };
        found.into_iter().map(alike).collect()
    }

    /// Adds a keyframe; one that is there already stays as it is.
    pub(crate) fn add(&mut self, keyframe: KeyframeId, frame: &Frame) {
        let Some(Transformed { bow, direct }) = self.describe(frame) else { return };
        if self.index.add(keyframe.0, Arc::new(bow)).is_ok() {
            self.set_direct(keyframe, Some(Arc::new(direct)));
        }
    }

    /// Forgets a keyframe.
    pub(crate) fn remove(&mut self, keyframe: KeyframeId) {
        if self.index.remove(keyframe.0) {
            self.set_direct(keyframe, None);
        }
    }

    fn set_direct(&mut self, keyframe: KeyframeId, direct: Option<Arc<DirectIndex>>) {
        let id = keyframe.0 as usize;
        while self.direct.len() <= id / CHUNK {
            self.direct.push(Arc::new(vec![None; CHUNK]));
        }
        Arc::make_mut(&mut self.direct[id / CHUNK])[id % CHUNK] = direct;
    }
}

#[cfg(test)]
#[path = "../tests/steps/keyframe_database.rs"]
mod tests;
