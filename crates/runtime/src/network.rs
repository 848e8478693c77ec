//! The network on a thread of its own: it sees an image while the frame is tracked and the next one is extracted.

use std::fmt;
use std::sync::Arc;
use std::thread::{Builder, JoinHandle};

use crossbeam::channel::{Receiver, Sender, bounded};
use features::{ActivationError, ActivationMap, ActivationSource, Evaluator, InTurn};
use geometry::GrayImage;

use crate::faults::StageFaults;

type Answer = Result<ActivationMap, ActivationError>;

/// Evaluates on a thread of its own, which ends when this is dropped.
struct Beside {
    /// `None` when it is dropped.
    images: Option<Sender<GrayImage>>,
    answers: Receiver<Answer>,
    /// Evaluations that were started and not waited for.
    n_started: usize,
    thread: Option<JoinHandle<()>>,
}

/// An evaluator by this source: on a thread of its own, or, where none can be started, in turn. Both give the same answers.
pub(crate) fn evaluator(source: &Arc<dyn ActivationSource>, faults: StageFaults) -> Box<dyn Evaluator> {
    match Beside::start(source.clone(), faults) {
        Ok(beside) => Box::new(beside),
        Err(_) => Box::new(InTurn::new(source.clone())),
    }
}

impl Beside {
    fn start(source: Arc<dyn ActivationSource>, mut faults: StageFaults) -> std::io::Result<Self> {
        let (images, seen) = bounded::<GrayImage>(1);
        let (answer, answers) = bounded(1);
        let work = move || {
            for image in seen {
                faults.step();
                if answer.send(source.activation(&image)).is_err() {
                    return;
                }
            }
        };
        let thread = Some(Builder::new().name("network".into()).spawn(work)?);
        Ok(Beside { images: Some(images), answers, n_started: 0, thread })
    }
}

impl Evaluator for Beside {
    fn start(&mut self, image: &GrayImage) {
        // What nobody has waited for makes room for this one.
        while self.n_started > 0 {
            let _ = self.finish();
        }
        if let Some(images) = &self.images {
            // A thread that has ended says so to whoever waits.
            let _ = images.send(image.clone());
            self.n_started += 1;
        }
    }

    fn finish(&mut self) -> Answer {
        self.n_started = self.n_started.saturating_sub(1);
        self.answers.recv().unwrap_or_else(|_| Err(ActivationError::Failed("its thread has ended".into())))
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        self.images = None;
        if let Some(thread) = self.thread.take() {
            // One answer at most waits, and there is room for it. A panic was reported to whoever waited.
            let _ = thread.join();
        }
    }
}

impl fmt::Debug for Beside {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Beside").field("n_started", &self.n_started).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faults::Faults;
    use geometry::Raster;

    /// Answers with the brightness of the first pixel.
    #[derive(Debug)]
    struct Brightness;

    impl ActivationSource for Brightness {
        fn activation(&self, image: &GrayImage) -> Answer {
            let value = f32::from(image.at(0, 0)) / 255.0;
            ActivationMap::new(Raster::new(1, 1, value), image.width, image.height)
                .ok_or(ActivationError::Unknown)
        }
    }

    fn beside(faults: &Faults) -> Box<dyn Evaluator> {
        let source: Arc<dyn ActivationSource> = Arc::new(Brightness);
        evaluator(&source, faults.of("network"))
    }

    fn of(brightness: u8) -> Answer {
        Brightness.activation(&GrayImage::new(4, 3, brightness))
    }

    #[test]
    fn answers_are_those_of_the_image_that_was_started_last() {
        let mut evaluator = beside(&Faults { delays: Some(3), ..Faults::default() });
        for brightness in [9, 70, 200] {
            evaluator.start(&GrayImage::new(4, 3, brightness));
            assert_eq!(evaluator.finish(), of(brightness));
        }
        evaluator.start(&GrayImage::new(4, 3, 1));
        evaluator.start(&GrayImage::new(4, 3, 2));
        assert_eq!(evaluator.finish(), of(2), "the first was forgotten");
        evaluator.start(&GrayImage::new(4, 3, 3));
        drop(evaluator);
    }

    #[test]
    fn a_thread_that_panics_is_an_error_and_nobody_waits_for_ever() {
        let mut evaluator = beside(&Faults { panic_at: Some(("network", 1)), ..Faults::default() });
        evaluator.start(&GrayImage::new(4, 3, 9));
        assert_eq!(evaluator.finish(), of(9));
        for _ in 0..2 {
            evaluator.start(&GrayImage::new(4, 3, 9));
            assert_eq!(evaluator.finish(), Err(ActivationError::Failed("its thread has ended".into())));
        }
    }
}
