//! The section `weights` of the configuration.

use features::Frame;
use map::MapPoint;
use serde::{Deserialize, Serialize};
use settings::{Entry, Section, flag};

/// Where the activation of features counts, beside their selection: the section `weights` of the configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Weights {
    /// In samples and scores of RANSAC.
    pub ransac: bool,
    /// In optimization, as a factor on the information of an observation.
    pub optimisation: bool,
    /// In bags of words.
    pub words: bool,
}

impl Default for Weights {
    fn default() -> Self {
        Self { ransac: true, optimisation: false, words: true }
    }
}

#[rustfmt::skip]
impl Section for Weights {
    const KEYS: &'static [Entry] = &[
        flag("weights.ransac", "samples and scores of RANSAC are weighted by activation and by the belief in points").expert(),
        flag("weights.optimisation", "observations are weighted by activation in optimization").expert(),
        flag("weights.words", "bag-of-words entries of a frame count as far as its features will be there another day").expert(),
    ];
}

impl Weights {
    /// The weight of feature `i` in RANSAC.
    pub(crate) fn of_sample(self, frame: &Frame, i: usize) -> f64 {
        if self.ransac { f64::from(frame.activation[i]) } else { 1.0 }
    }

    /// The weight of a point in RANSAC: less than 1 if it is more likely to move than to stand.
    pub(crate) fn of_point(self, point: &MapPoint) -> f64 {
        if self.ransac { (2.0 * point.trust()).min(1.0) } else { 1.0 }
    }
}
