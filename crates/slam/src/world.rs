//! What tracking and loop closing read: the map, and where its keyframes look alike.

use std::sync::Arc;

use bow::Vocabulary;
use map::Map;

use crate::keyframe_database::KeyframeDatabase;

/// The shared state, owned by the [`Mapper`](crate::Mapper). A clone is a cheap snapshot.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// Keyframes and points.
    pub map: Map,
    /// KeyframeDatabase of its keyframes.
    pub places: KeyframeDatabase,
}

impl World {
    /// An empty map whose places will be described in the words of a vocabulary, if there is one.
    pub fn new(vocabulary: Option<Arc<Vocabulary>>) -> Self {
        World { map: Map::new(), places: KeyframeDatabase::new(vocabulary) }
    }

    /// A map from elsewhere, its place descriptions recomputed.
    pub fn from_map(map: Map, vocabulary: Option<Arc<Vocabulary>>) -> Self {
        let places = KeyframeDatabase::new(vocabulary).with_map(&map);
        World { map, places }
    }
}
