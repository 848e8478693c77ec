//! Everything a run needs beside its frames.

use std::sync::Arc;

use bow::Vocabulary;
use features::{DepthConfig, ExtractorConfig, FeatureMask, FrameBuilder, Rig, StereoConfig};
use geometry::Sensor;
use map::Map;
use slam::{KeyframeDatabase, Params, World};

use crate::faults::Faults;
use crate::fingerprint::Fingerprint;
use crate::lags::Lags;
use crate::rule::Rule;
use crate::selection::Selection;

/// How the stages of a run share time. `Sequential` and `Lockstep` give the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Schedule {
    /// All stages in turn on one thread; only images are decoded ahead.
    Sequential,
    /// Each stage on a thread of its own; what tracking sees depends on frame numbers alone, and whoever is early waits.
    #[default]
    Lockstep,
    /// Each stage on a thread of its own; tracking never waits and sees the newest map.
    Live {
        /// Frames come at the pace of their timestamps, and are skipped while tracking is behind. Otherwise each comes
        /// when tracking is ready for it.
        realtime: bool,
    },
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
    /// Words to recognise places with; without them there are no loops and no relocalisation.
    pub vocabulary: Option<Arc<Vocabulary>>,
    /// A map to go on with, for instance from a file.
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

    /// What makes frames of images, with the mask and the selection of features.
    ///
    /// # Errors
    /// Why the network of the selection cannot be opened.
    pub fn frame_builder(&self, disparity_offset_px: f64) -> Result<FrameBuilder, String> {
        let (rig, extractor) = (self.rig.clone(), self.extractor.clone());
        let builder = FrameBuilder::new(rig, extractor, self.stereo.clone(), self.depth.clone())
            .with_disparity_offset(disparity_offset_px)
            .with_mask(self.mask.clone());
        match &self.selection {
            None => Ok(builder),
            Some(Selection { config, source }) => Ok(builder.with_selection(*config, source.open()?)),
        }
    }

    pub(crate) fn rule(&self) -> Rule {
        Rule { lag: self.lags.lag.max(1), loop_lag: self.lags.loop_lag }
    }

    /// The world that a run begins with.
    pub(crate) fn world(&self) -> World {
        let places = KeyframeDatabase::new(self.vocabulary.clone()).weighted(self.slam.weights.words);
        match &self.start {
            None => World { map: Map::new(), places },
            Some(map) => World { places: places.with_map(map), map: map.clone() },
        }
    }

    /// A number for everything that a run's bits depend on beside its frames and its schedule.
    pub(crate) fn fingerprint(&self) -> u64 {
        let mut print = Fingerprint::default();
        // No result depends on the network's threads.
        let extractor = ExtractorConfig { network_threads: 1, ..self.extractor.clone() };
        print.add(format!("{:?}", (self.sensor, &self.rig, &extractor, &self.stereo)).as_bytes());
        print.add(format!("{:?}", (&self.depth, &self.slam)).as_bytes());
        let selection = self.selection.as_ref().map(|s| (s.config, s.source.identity()));
        print.add(format!("{selection:?}").as_bytes());
        print.add(self.vocabulary.as_ref().map_or(&[][..], |vocabulary| vocabulary.as_bytes()));
        print.add(&self.start.as_ref().map_or(0, Map::digest).to_le_bytes());
        self.mask.iter().flat_map(|mask| mask.bytes()).for_each(|level| print.add(level));
        print.value()
    }
}
