//! What a selection keeps of the candidates of an image, and what it drops.

use anyhow::Result;
use dsfeat::{Answers, Network};
use features::{Features, Keypoint, SelectionConfig};

use crate::args::NetworkArgs;
use crate::stage::Picture;

/// The candidates of an image, chosen among by an activation network.
pub(crate) struct Selected {
    /// The network.
    pub(crate) network: Network,
    /// How it chooses.
    pub(crate) rule: SelectionConfig,
    /// What it says of the image.
    pub(crate) answers: Answers,
    /// The features kept.
    pub(crate) kept: Features,
    /// The others.
    pub(crate) dropped: Vec<Keypoint>,
}

impl Selected {
    /// Selects; the settings must not be those of a selection without a network.
    ///
    /// # Errors
    /// A network that cannot be used.
    pub(crate) fn of(picture: &mut Picture, args: &NetworkArgs) -> Result<Self> {
        let Picture { image, extractor, settings, .. } = picture;
        let (network, rule) = dsslam::open_network(settings, &args.options())?;
        let candidates = extractor.extract(image).keypoints;
        let answers = network.answers(image)?;
        let kept = extractor.extract_selected(image, &rule, &answers.map)?.features;
        let dropped = without(&candidates, &kept.keypoints);
        Ok(Self { network, rule, answers, kept, dropped })
    }

    /// Mean activation at features, 0 without any.
    pub(crate) fn mean_activation(&self, features: &[Keypoint]) -> f64 {
        let sum: f64 = features.iter().map(|k| f64::from(self.answers.map.at(k.x, k.y))).sum();
        sum / (features.len().max(1)) as f64
    }
}

/// Those of `all` that are not in `some`; both in the same order.
fn without(all: &[Keypoint], some: &[Keypoint]) -> Vec<Keypoint> {
    let mut some = some.iter().peekable();
    all.iter().filter(|k| some.next_if(|s| s == k).is_none()).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_kept_is_dropped() {
        let at = |x: f32| Keypoint { x, y: 1.0, ..Keypoint::default() };
        let all = [at(1.0), at(2.0), at(3.0), at(4.0)];
        assert_eq!(without(&all, &[at(2.0), at(4.0)]), [at(1.0), at(3.0)]);
        assert_eq!(without(&all, &[]), all);
        assert!(without(&all, &all).is_empty());
    }
}
