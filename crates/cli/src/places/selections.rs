//! The three selections of 500 features that are compared, for ORB and for dense learned features.

use std::sync::Arc;

use anyhow::{Context, Result};
use bow::{Transformed, Vocabulary};
use dsfeat::Network;
use dsslam::Config;
use features::{
    ActivationMap, Contender, Descriptor, Extractor, ExtractorConfig, Keypoint, SelectionConfig,
    SelectionRule, Spread, select,
};
use geometry::{GrayImage, Raster, Vec2};

use super::args::{PlacesArgs, Selection};
use super::sight::{Look, Sight};
use super::xfeat::{DenseFeatures, DenseKeypoint, DenseNetwork};

/// Turns an image into what each selection keeps of it.
pub(super) struct Describer {
    pub(super) selections: Vec<(Selection, SelectionConfig)>,
    /// `trad` needs none.
    network: Option<Network>,
    extractor: Extractor,
    dense: Option<DenseNetwork>,
    words: Words,
}

/// How images are put into words.
struct Words {
    vocabulary: Arc<Vocabulary>,
    /// Whether a word counts as far as its features will be there another day.
    weighted: bool,
}

impl Describer {
    /// Opens the networks that the selections need.
    ///
    /// # Errors
    /// A model or a library that cannot be used.
    pub(super) fn new(args: &PlacesArgs, config: &Config, selections: &[Selection]) -> Result<Self> {
        let settings = &config.features;
        let needed = selections.iter().any(|selection| *selection != Selection::Trad);
        let network = needed.then(|| dsslam::load_network(&args.network.options(), settings)).transpose()?;
        let dense = match &args.features_model {
            None => None,
            Some(file) => {
                let model =
                    std::fs::read(file).with_context(|| format!("{}: cannot be read", file.display()))?;
                let library = args.network.onnxruntime.as_deref();
                let network = DenseNetwork::load(&model, library, settings.network_threads);
                Some(network.with_context(|| file.display().to_string())?)
            }
        };
        let rule = |&selection: &Selection| {
            let rule = match selection {
                Selection::Trad => SelectionRule::Response,
                Selection::Seman => SelectionRule::Semantic,
                Selection::Ours => SelectionRule::Places,
            };
            let spread = if args.cells { Spread::Cells } else { Spread::Anywhere };
            (selection, SelectionConfig { rule, keep: args.keep as usize, spread })
        };
        let candidates =
            ExtractorConfig { selection: SelectionRule::Activation, keep: 1, ..settings.clone() };
        let extractor = Extractor::new(candidates);
        let selections = selections.iter().map(rule).collect();
        let vocabulary = dsslam::vocabulary(args.vocab.as_deref())?;
        let words = Words { vocabulary, weighted: config.weights.words };
        Ok(Self { selections, network, extractor, dense, words })
    }

    /// What each selection keeps of an image, in their order.
    ///
    /// # Errors
    /// A failure of a network.
    pub(super) fn describe(&mut self, image: &GrayImage) -> Result<Vec<Sight>> {
        let dense = self.dense.as_mut().map(|network| network.describe(image)).transpose()?;
        let mut sights = Vec::with_capacity(self.selections.len());
        let answers = self.network.as_ref().map(|network| network.answers(image)).transpose()?;
        for (_, config) in &self.selections {
            let map = match &answers {
                Some(answers) if config.rule != SelectionRule::Response => answers.map.clone(),
                // Full activation over the whole image.
                _ => ActivationMap::new(Raster::new(1, 1, 1.0), image.width, image.height)
                    .context("the image is empty")?,
            };
            sights.push(match &dense {
                None => sparse(&mut self.extractor, image, &map, config, &self.words)?,
                Some(features) => learned(features, (image.width, image.height), &map, config),
            });
        }
        Ok(sights)
    }
}

impl Words {
    fn of(&self, descriptors: &[Descriptor], lasting: &[f32]) -> Transformed {
        self.vocabulary.transform(descriptors, self.weighted.then_some(lasting))
    }
}

/// Dense features that a selection keeps, and what the whole image looks like where it is trusted.
fn learned(
    features: &DenseFeatures,
    size: (usize, usize),
    map: &ActivationMap,
    config: &SelectionConfig,
) -> Sight {
    let contender = |k: &DenseKeypoint| Contender { x: k.x, y: k.y, response: (k.score * 255.0) as u8 };
    let contenders: Vec<Contender> = features.keypoints.iter().map(contender).collect();
    let kept = select(&contenders, map, config, size);
    let trusted = |x: f32, y: f32| match config.rule {
        SelectionRule::Activation => map.at(x, y),
        SelectionRule::Places => map.at(x, y) * map.lasting_at(x, y),
        SelectionRule::Semantic => f32::from(u8::from(map.lasting_at(x, y) >= 0.5)),
        SelectionRule::Response => 1.0,
    };
    Sight {
        pixels: kept.iter().map(|&i| Vec2::new(contenders[i].x.into(), contenders[i].y.into())).collect(),
        trust: kept.iter().map(|&i| f64::from(map.at(contenders[i].x, contenders[i].y))).collect(),
        look: Look::Dense {
            descriptors: kept.iter().map(|&i| features.keypoints[i].descriptor).collect(),
            mean: Box::new(features.weighted_mean(trusted)),
        },
    }
}

/// ORB features that a selection keeps, with their words.
fn sparse(
    extractor: &mut Extractor,
    image: &GrayImage,
    map: &ActivationMap,
    config: &SelectionConfig,
    words: &Words,
) -> Result<Sight> {
    let features::Selected { features, activation, lasting, .. } =
        extractor.extract_selected(image, config, map)?;
    let described = words.of(&features.descriptors, &lasting);
    Ok(Sight {
        pixels: features.keypoints.iter().map(Keypoint::pixel).collect(),
        trust: activation.into_iter().map(f64::from).collect(),
        look: Look::Sparse {
            keypoints: features.keypoints,
            descriptors: features.descriptors,
            bow: Arc::new(described.bow),
            direct: described.direct,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_what_is_not_trusted_count_only_if_they_are_to() {
        let vocabulary = Arc::new(Vocabulary::built_in().expect("part of the program"));
        let descriptors = [Descriptor([0x3c3c_0f0f_55aa; 4]), Descriptor([0xa5a5_ffff_1234; 4])];
        let of = |weighted: bool, descriptors: &[Descriptor], activation: &[f32]| {
            Words { vocabulary: vocabulary.clone(), weighted }.of(descriptors, activation).bow
        };
        let alone = of(false, &descriptors[..1], &[1.0]);
        assert_eq!(of(true, &descriptors, &[1.0, 0.0]), alone);
        assert_eq!(of(false, &descriptors, &[1.0, 0.0]), of(true, &descriptors, &[0.5, 0.5]));
        assert_ne!(of(false, &descriptors, &[1.0, 0.0]), alone);
    }
}
