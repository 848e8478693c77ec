//! Everything a run needs beside its frames.

use std::sync::Arc;

use bow::Vocabulary;
use features::{
    ActivationSource, DepthConfig, ExtractorConfig, FeatureMask, FrameBuilder, Rig, SelectionConfig,
    StereoConfig,
};
use geometry::Sensor;
use map::Map;
use slam::{KeyframeDatabase, Params, World};

use crate::faults::Faults;
use crate::lags::Lags;
use crate::network;
use crate::rule::Rule;

/// How the stages of a run are scheduled. `Sequential` and `Lockstep` give the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Schedule {
    /// All stages in turn on one thread; only images are decoded ahead.
    Sequential,
    /// Each stage on a thread of its own; what tracking sees depends on frame numbers alone, and the stage that is ahead waits.
    #[default]
    Lockstep,
    /// Each stage on a thread of its own; tracking never waits and sees the newest map.
    Live {
        /// Frames come at the pace of their timestamps, and are skipped while tracking is behind. Otherwise each comes
        /// when tracking is ready for it.
        realtime: bool,
    },
}

/// How features are selected.
#[derive(Clone, Debug)]
pub struct Selection {
    /// By what features are chosen, and how many are kept.
    pub config: SelectionConfig,
    /// Where the activation maps come from: an opened network.
    pub source: Arc<dyn ActivationSource>,
    /// A number for what the maps depend on beside the image.
    pub identity: u64,
}

/// Camera and parameters of a run.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Which images are used.
    pub sensor: Sensor,
    /// The camera; its width and height are those that every image must have.
    pub rig: Arc<Rig>,
    /// Feature extraction.
    pub extractor: ExtractorConfig,
    /// Where features may be taken; `None`: everywhere.
    pub mask: Option<Arc<FeatureMask>>,
    /// How features are chosen among what is extracted; without it all are kept.
    pub selection: Option<Selection>,
    /// Stereo association.
    pub stereo: StereoConfig,
    /// Depth association.
    pub depth: DepthConfig,
    /// Tracking, mapping and loop closing.
    pub slam: Params,
    /// Words to recognize places with; without them there are no loops and no relocalization.
    pub vocabulary: Option<Arc<Vocabulary>>,
    /// A map to resume from, for instance from a file.
    pub start: Option<Map>,
    /// How stages share time.
    pub schedule: Schedule,
    /// When tracking sees what mapping has done.
    pub lags: Lags,
    /// Test aids.
    pub faults: Faults,
}

impl Setup {
    /// A setup with the defaults of everything that is neither camera nor SLAM.
    pub fn new(sensor: Sensor, rig: Arc<Rig>, slam: Params) -> Self {
        Setup {
            sensor,
            rig,
            extractor: ExtractorConfig::default(),
            mask: None,
            selection: None,
            stereo: StereoConfig::default(),
            depth: DepthConfig::default(),
            slam,
            vocabulary: None,
            start: None,
            schedule: Schedule::default(),
            lags: Lags::default(),
            faults: Faults::default(),
        }
    }

    /// What makes frames of images, with the mask and the selection of features. A network gets a thread of its own.
    pub fn frame_builder(&self, disparity_offset_px: f64) -> FrameBuilder {
        let (rig, extractor) = (self.rig.clone(), self.extractor.clone());
        let builder = FrameBuilder::new(rig, extractor, self.stereo.clone(), self.depth.clone())
            .with_disparity_offset(disparity_offset_px)
            .with_mask(self.mask.clone());
        match &self.selection {
            None => builder,
            Some(Selection { config, source, .. }) => {
                builder.with_selection(*config, network::evaluator(source, self.faults.of("network")))
            }
        }
    }

    pub(crate) fn rule(&self) -> Rule {
        Rule { lag: self.lags.lag.max(1), loop_lag: self.lags.loop_lag }
    }

    /// The world that a run begins with.
    pub(crate) fn world(&self) -> World {
        let places = KeyframeDatabase::new(self.vocabulary.clone()).weighted(self.slam.weights.words);
        match &self.start {
            None => World { places, ..World::default() },
            Some(map) => World { places: places.with_map(map), map: map.clone(), calibration: None },
        }
    }

    /// A number for everything that a run's bits depend on beside its frames and its schedule.
    pub(crate) fn fingerprint(&self) -> u64 {
        let mut print = Fingerprint::default();
        // No result depends on the network's threads.
        let extractor = ExtractorConfig { network_threads: 1, ..self.extractor.clone() };
        print.add(format!("{:?}", (self.sensor, &self.rig, &extractor, &self.stereo)).as_bytes());
        print.add(format!("{:?}", (&self.depth, &self.slam)).as_bytes());
        let selection = self.selection.as_ref().map(|s| (s.config, s.identity));
        print.add(format!("{selection:?}").as_bytes());
        print.add(self.vocabulary.as_ref().map_or(&[][..], |vocabulary| vocabulary.as_bytes()));
        print.add(&self.start.as_ref().map_or(0, Map::digest).to_le_bytes());
        self.mask.iter().flat_map(|mask| mask.bytes()).for_each(|level| print.add(level));
        print.value()
    }
}

/// FNV-1a over bytes.
pub(crate) struct Fingerprint(u64);

impl Default for Fingerprint {
    fn default() -> Self {
        Fingerprint(0xcbf2_9ce4_8422_2325)
    }
}

impl Fingerprint {
    /// Adds a part; its length counts, so that parts cannot run into each other.
    pub(crate) fn add(&mut self, part: &[u8]) {
        for byte in (part.len() as u64).to_le_bytes().iter().chain(part) {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    /// The number.
    pub(crate) fn value(&self) -> u64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_do_not_run_into_each_other() {
        let of = |parts: [&[u8]; 2]| {
            let mut print = Fingerprint::default();
            parts.iter().for_each(|part| print.add(part));
            print.value()
        };
        assert_ne!(of([b"ab", b"c"]), of([b"a", b"bc"]));
        assert_eq!(of([b"ab", b"c"]), of([b"ab", b"c"]));
    }
}
