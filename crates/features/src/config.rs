//! The section `features` of the configuration.

use geometry::Sensor;
use serde::{Deserialize, Serialize};
use settings::{Entry, Section, between, choice, flag, integer, optional_integer, real};

use crate::selection::{SelectionConfig, SelectionRule, Spread};

/// How features are extracted and chosen: the section `features` of the configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ExtractorConfig {
    /// Most features per image.
    pub keep: usize,
    /// The same with a single camera, whose maps need more of them; `None`: `keep`.
    pub keep_mono: Option<usize>,
    /// By what they are chosen.
    pub selection: SelectionRule,
    /// Features among which a network chooses.
    pub candidates: usize,
    /// Whether those that a network chooses are spread over the image.
    pub spread: Spread,
    /// Threads of the network; no result depends on them.
    pub network_threads: usize,
    /// How large it sees the image.
    pub network_size: NetworkSize,
    /// Frames from one of its evaluations to the next. Above 1 no frame waits for its own: the answers of the last evaluation that is
    /// over move with the image.
    pub network_every: u32,
    /// Pyramid levels.
    pub levels: usize,
    /// Ratio between levels.
    pub scale_factor: f64,
    /// FAST threshold that a cell uses when it has such corners.
    pub fast_initial: u8,
    /// FAST threshold for cells that have none.
    pub fast_minimum: u8,
    /// Whether positions are refined below a pixel of their level.
    pub subpixel: bool,
    /// Whether the tracker places features where the map's points look the same as before.
    pub align: Align,
}

impl Default for ExtractorConfig {
    fn default() -> Self {
        Self {
            keep: 2000,
            keep_mono: None,
            selection: SelectionRule::Response,
            candidates: 2000,
            spread: Spread::Cells,
            network_threads: 1,
            network_size: NetworkSize::Large,
            network_every: 1,
            levels: 8,
            scale_factor: 1.2,
            fast_initial: 20,
            fast_minimum: 7,
            subpixel: true,
            align: Align::Mono,
        }
    }
}

/// With which cameras the tracker places features where the map's points look the same as before.
///
/// One camera knows a point's depth from such places alone and gains by it. With a measured depth the motion from frame to frame gets
/// smoother, but on real pairs the trajectory gets no better.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Align {
    /// With none.
    Never,
    /// With a single camera.
    #[default]
    Mono,
    /// With all.
    Always,
}

impl Align {
    /// Their words in the configuration.
    pub const WORDS: &[&str] = &["never", "mono", "always"];
}

/// How large a network sees an image whose size it leaves open; the proportions are the image's own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NetworkSize {
    /// As many pixels as 416 x 128.
    #[default]
    Large,
    /// As many pixels as 320 x 96, for small computers.
    Small,
}

impl NetworkSize {
    /// Their words in the configuration.
    pub const WORDS: &[&str] = &["large", "small"];

    /// Number of pixels.
    pub fn pixels(self) -> usize {
        match self {
            NetworkSize::Large => 416 * 128,
            NetworkSize::Small => 320 * 96,
        }
    }
}

#[rustfmt::skip]
impl Section for ExtractorConfig {
    const KEYS: &'static [Entry] = &[
        integer("features.keep", "", [50, 100_000], "keypoints kept per image"),
        optional_integer("features.keep_mono", "", [50, 100_000], "keypoints kept per image of a single camera, whose maps need more; absent: keep"),
        choice("features.selection", SelectionRule::WORDS, "criterion by which keypoints are kept; the first two evaluate the network"),
        integer("features.candidates", "", [50, 100_000], "keypoints from which activation or semantic choose").expert(),
        choice("features.spread", Spread::WORDS, "where activation or semantic keep the best: in each cell, or anywhere in the image").expert(),
        choice("features.network_size", NetworkSize::WORDS, "pixels of the network's input: as many as 416 x 128, or as 320 x 96").expert(),
        integer("features.network_every", "frames", [1, 10], "frames from one evaluation of the network to the next; above 1 it runs beside the rest, and its answers move with the image").expert(),
        integer("features.network_threads", "", [1, 64], "threads of the network; results do not depend on it").expert(),
        integer("features.levels", "", [1, 16], "levels of the image pyramid").expert(),
        real("features.scale_factor", "", between(1.01, 2.0), "size ratio of neighboring pyramid levels").expert(),
        integer("features.fast_initial", "gray levels", [1, 255], "FAST threshold tried first in a cell").expert(),
        integer("features.fast_minimum", "gray levels", [1, 255], "FAST threshold of a cell where the first finds nothing").expert(),
        flag("features.subpixel", "refine the position of keypoints below one pixel").expert(),
        choice("features.align", Align::WORDS, "with which cameras keypoints are placed where the map's points look the same as before").expert(),
    ];
}

impl ExtractorConfig {
    /// The settings with this sensor: `keep` is the number kept with it, `align` no longer depends on it.
    #[must_use]
    pub fn with_sensor(&self, sensor: Sensor) -> Self {
        let keep = match sensor {
            Sensor::Mono => self.keep_mono.unwrap_or(self.keep),
            Sensor::Stereo | Sensor::Rgbd => self.keep,
        };
        let aligns = self.align == Align::Always || (self.align == Align::Mono && sensor == Sensor::Mono);
        Self { keep, align: if aligns { Align::Always } else { Align::Never }, ..self.clone() }
    }

    /// How a network chooses; `None` where none takes part.
    pub fn choice(&self) -> Option<SelectionConfig> {
        let Self { selection: rule, keep, spread, .. } = *self;
        (rule != SelectionRule::Response).then_some(SelectionConfig { rule, keep, spread })
    }

    /// Features extracted: all that are kept, or the candidates of a network.
    pub(crate) fn n_extracted(&self) -> usize {
        if self.choice().is_some() { self.candidates.max(self.keep) } else { self.keep }
    }

    /// The ratio between levels as scales are computed with it.
    pub(crate) fn level_ratio(&self) -> f32 {
        self.scale_factor as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_camera_keeps_features_of_its_own_number() {
        let config = ExtractorConfig { keep: 500, keep_mono: Some(1500), ..ExtractorConfig::default() };
        assert_eq!([Sensor::Mono, Sensor::Stereo].map(|s| config.with_sensor(s).keep), [1500, 500]);
        let config = ExtractorConfig { keep_mono: None, ..config };
        assert_eq!(config.with_sensor(Sensor::Mono).keep, 500, "absent: as many as of the others");
    }

    #[test]
    fn a_network_chooses_among_the_candidates() {
        let plain = ExtractorConfig { keep: 500, candidates: 900, ..ExtractorConfig::default() };
        assert_eq!((plain.n_extracted(), plain.choice()), (500, None));
        let chosen = ExtractorConfig { selection: SelectionRule::Semantic, ..plain };
        assert_eq!((chosen.n_extracted(), chosen.choice().map(|c| c.keep)), (900, Some(500)));
    }
}
