//! When the network is evaluated, and by which of its answers a frame goes.
//!
//! Every frame by its own, which it waits for; or every N-th image beside everything else: its answers serve the frames after it,
//! moved with the image, and no frame but the first waits for an evaluation of itself.

use std::fmt::Debug;
use std::sync::Arc;

use geometry::GrayImage;

use crate::activation::{ActivationError, ActivationMap, ActivationSource};
use crate::extractor::{Extractor, Selected};
use crate::follow::{Answered, Small};
use crate::selection::SelectionConfig;

/// Evaluates one image after the other, if it can while other work goes on.
pub trait Evaluator: Debug + Send {
    /// Starts on an image. What was started before it and was not waited for is forgotten.
    fn start(&mut self, image: &GrayImage);

    /// Waits for the activation map of the image that was started last.
    ///
    /// # Errors
    /// Why there is none.
    fn finish(&mut self) -> Result<ActivationMap, ActivationError>;
}

/// Evaluates at once, on the calling thread.
#[derive(Debug)]
pub struct InTurn {
    source: Arc<dyn ActivationSource>,
    answer: Result<ActivationMap, ActivationError>,
}

impl InTurn {
    /// An evaluator by this source.
    #[must_use]
    pub fn new(source: Arc<dyn ActivationSource>) -> Self {
        InTurn { source, answer: Err(ActivationError::Unknown) }
    }
}

impl Evaluator for InTurn {
    fn start(&mut self, image: &GrayImage) {
        self.answer = self.source.activation(image);
    }

    fn finish(&mut self) -> Result<ActivationMap, ActivationError> {
        self.answer.clone()
    }
}

/// How features are selected.
#[derive(Debug)]
pub(crate) struct Selection {
    config: SelectionConfig,
    evaluator: Box<dyn Evaluator>,
    /// Frames from one evaluation to the next; 1: each frame has its own.
    every: u32,
    /// The last evaluation that is over.
    last: Option<Answered>,
    /// The one that goes on: number and image of its frame.
    started: Option<(u32, Small)>,
    /// The present image, if its answers may serve other ones.
    small: Option<Small>,
}

impl Selection {
    pub(crate) fn new(config: SelectionConfig, evaluator: Box<dyn Evaluator>, every: u32) -> Self {
        Selection { config, evaluator, every, last: None, started: None, small: None }
    }

    /// Extracts the features of an image and selects among them.
    ///
    /// # Errors
    /// Those of the evaluator, for this image or the one that was evaluated beside the frames before.
    pub(crate) fn select(
        &mut self,
        extractor: &mut Extractor,
        index: u32,
        image: &GrayImage,
    ) -> Result<Selected, ActivationError> {
        let waits = self.last.is_none() && self.started.is_none();
        if waits {
            self.evaluator.start(image);
        }
        let config = self.config;
        let map = extractor.detect(image, |pyramid| {
            self.small = pyramid.levels().last().filter(|_| self.every > 1).map(Small::of);
            if waits { self.own(index) } else { self.moved(index, image) }
        })?;
        Ok(extractor.keep(map, &config, image))
    }

    /// Starts the evaluation of the image whose features were selected just now, if one is due.
    pub(crate) fn evaluate_if_due(&mut self, index: u32, image: &GrayImage) {
        let is_due = self.last.as_ref().is_some_and(|last| index.wrapping_sub(last.index) >= self.every);
        if is_due && let Some(small) = self.small.take() {
            self.evaluator.start(image);
            self.started = Some((index, small));
        }
    }

    /// The answers for the present image, which was started just now.
    fn own(&mut self, index: u32) -> Result<ActivationMap, ActivationError> {
        let map = self.evaluator.finish()?;
        self.last = self.small.take().map(|small| Answered { index, map: map.clone(), small });
        Ok(map)
    }

    /// The last answers, moved to the present image, or its own where that cannot be.
    fn moved(&mut self, index: u32, image: &GrayImage) -> Result<ActivationMap, ActivationError> {
        if let Some((index, small)) = self.started.take() {
            let map = self.evaluator.finish()?;
            self.last = Some(Answered { index, map, small });
        }
        let moved =
            self.last.as_ref().zip(self.small.as_ref()).and_then(|(last, small)| last.moved_to(small));
        match moved {
            Some(map) => Ok(map),
            None => {
                self.evaluator.start(image);
                self.own(index)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::ExtractorConfig;
    use crate::selection::{SelectionRule, Spread};
    use geometry::Raster;
    use std::sync::Mutex;

    const CONFIG: SelectionConfig =
        SelectionConfig { rule: SelectionRule::Activation, keep: 60, spread: Spread::Cells };

    /// Answers with the brightness of the image's first pixel, but for the one that fails.
    #[derive(Debug)]
    struct Brightness {
        seen: Arc<Mutex<Vec<u8>>>,
        fails: Option<u8>,
    }

    impl ActivationSource for Brightness {
        fn activation(&self, image: &GrayImage) -> Result<ActivationMap, ActivationError> {
            let brightness = image.at(0, 0);
            self.seen.lock().unwrap().push(brightness);
            if self.fails == Some(brightness) {
                return Err(ActivationError::Failed("asked to".into()));
            }
            let values = Raster::new(40, 20, f32::from(brightness) / 255.0);
            Ok(ActivationMap::new(values, image.width, image.height).unwrap())
        }
    }

    /// The first pixel of the `n`-th image is `n`, the rest a texture that stays.
    fn image(n: u32, width: usize) -> GrayImage {
        GrayImage::from_fn(width, 96, |x, y| match (x, y) {
            (0, 0) => n as u8,
            _ => geometry::mix_seed(3, x as u64 / 5, y as u64 / 5) as u8,
        })
    }

    /// The images by whose answers those of `frames`, number and width, go; `None`: there was no answer.
    fn served_by(every: u32, frames: &[(u32, usize)], fails: Option<u8>) -> (Vec<Option<u8>>, Vec<u8>) {
        let seen = Arc::<Mutex<Vec<u8>>>::default();
        let source = Arc::new(Brightness { seen: seen.clone(), fails });
        let mut selection = Selection::new(CONFIG, Box::new(InTurn::new(source)), every);
        let mut extractor = Extractor::new(ExtractorConfig { levels: 2, ..ExtractorConfig::default() });
        let mut serve = |&(n, width): &(u32, usize)| {
            let image = image(n, width);
            let selected = selection.select(&mut extractor, n, &image);
            if selected.is_ok() {
                selection.evaluate_if_due(n, &image);
            }
            selected.ok().map(|selected| (selected.map.at(50.0, 50.0) * 255.0).round() as u8)
        };
        let served = frames.iter().map(&mut serve).collect();
        let seen = seen.lock().unwrap().clone();
        (served, seen)
    }

    fn frames(n: u32) -> Vec<(u32, usize)> {
        (0..n).map(|n| (n, 320)).collect()
    }

    #[test]
    fn every_frame_goes_by_its_own_answers_or_by_the_last_ones_that_need_no_waiting() {
        let own: Vec<u8> = (0..6).collect();
        assert_eq!(served_by(1, &frames(6), None), (own.iter().copied().map(Some).collect(), own));
        let (served, seen) = served_by(2, &frames(7), None);
        assert_eq!(served, [0, 0, 0, 2, 2, 4, 4].map(Some));
        assert_eq!(seen, [0, 2, 4, 6]);
        assert_eq!(served_by(3, &frames(7), None).0, [0, 0, 0, 0, 3, 3, 3].map(Some));
    }

    #[test]
    fn after_a_gap_the_next_image_is_evaluated() {
        let (served, seen) = served_by(2, &[(0, 320), (1, 320), (7, 320), (8, 320)], None);
        assert_eq!((served, seen), ([0, 0, 0, 7].map(Some).to_vec(), vec![0, 7]));
    }

    #[test]
    fn an_image_of_another_size_has_its_own_answers() {
        let (served, seen) = served_by(2, &[(0, 320), (1, 300), (2, 300), (3, 300), (4, 300)], None);
        assert_eq!((served, seen), ([0, 1, 1, 1, 3].map(Some).to_vec(), vec![0, 1, 3]));
    }

    #[test]
    fn what_failed_beside_is_an_error_of_the_frame_that_needs_it_and_older_answers_serve_on() {
        let (served, seen) = served_by(2, &frames(6), Some(2));
        assert_eq!(served, [Some(0), Some(0), Some(0), None, Some(0), Some(4)]);
        assert_eq!(seen, [0, 2, 4]);
    }
}
