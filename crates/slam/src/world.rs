//! What tracking and loop closing read: the map, and where its keyframes look alike.

use std::sync::Arc;

use bow::Vocabulary;
use features::Frame;
use map::Map;

use crate::keyframe_database::KeyframeDatabase;
use crate::refine::RefinedCalibration;

/// The shared state, owned by the [`Mapper`](crate::Mapper). A clone is a cheap snapshot.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// Keyframes and points.
    pub map: Map,
    /// KeyframeDatabase of its keyframes.
    pub places: KeyframeDatabase,
    /// The calibration that the images tell; `None`: as it was given.
    pub calibration: Option<Arc<RefinedCalibration>>,
}

impl World {
    /// A frame, as it was extracted, by the calibration of this world.
    pub(crate) fn calibrated(&self, frame: &Arc<Frame>) -> Arc<Frame> {
        self.calibration.as_ref().map_or_else(|| frame.clone(), |calibration| calibration.apply(frame, None))
    }

    /// An empty map whose places will be described in the words of a vocabulary, if there is one.
    pub fn new(vocabulary: Option<Arc<Vocabulary>>) -> Self {
        World { places: KeyframeDatabase::new(vocabulary), ..World::default() }
    }

    /// A map from elsewhere, its place descriptions recomputed.
    pub fn from_map(map: Map, vocabulary: Option<Arc<Vocabulary>>) -> Self {
        let places = KeyframeDatabase::new(vocabulary).with_map(&map);
        World { map, places, calibration: None }
    }
}
