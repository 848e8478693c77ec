//! A run on threads of its own whose frames are pushed by the caller: for `Live` and `Lockstep` without a feed.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};

use crossbeam::channel::{Receiver, Sender, bounded, unbounded};
use io::LoadedFrame;
use thiserror::Error;

use crate::events::{Event, FrameAnswer, Observer};
use crate::failure::StageFailure;
use crate::feed::{FrameFeed, FrameInfo, FrameMask};
use crate::record::{RunError, RunOutcome, Unusable};
use crate::run::run;
use crate::setup::Setup;

/// A frame on its way to the run.
type Pushed = (FrameInfo, Result<LoadedFrame, Unusable>, Option<FrameMask>);

/// Frames that may wait for the run to take them.
const WAITING: usize = 1;

/// A run by the setup's schedule whose frames are pushed one by one. Its answers come in the order of the frames, each as soon as
/// tracking is done with it; a run in real time also answers for the frames that it skips.
///
/// A value that is dropped without [`Threaded::finish`] ends the run and waits for its threads.
#[derive(Debug)]
pub struct Threaded {
    /// `None` when no more frames come.
    frames: Option<Sender<Pushed>>,
    answers: Receiver<FrameAnswer>,
    stop: Arc<AtomicBool>,
    /// `None` after it was waited for.
    run: Option<JoinHandle<Result<RunOutcome, RunError>>>,
}

/// The run has ended before its last frame; [`Threaded::finish`] says why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the run has ended and takes no more frames")]
pub struct RunEnded;

impl Threaded {
    /// Starts the threads.
    ///
    /// # Errors
    /// [`RunError::Thread`] when the first thread cannot be started.
    pub fn start(setup: Setup) -> Result<Self, RunError> {
        let (frames, pushed) = bounded(WAITING);
        let (to_caller, answers) = unbounded();
        let stop = Arc::new(AtomicBool::new(false));
        let feed = PushedFeed { pushed, state: Mutex::default() };
        let mut answering = Answering(to_caller);
        let stopped = stop.clone();
        let run = Builder::new()
            .name("run".into())
            .spawn(move || run(&feed, &setup, &mut answering, &stopped))
            .map_err(|error| RunError::Thread { stage: "run", reason: error.to_string() })?;
        Ok(Threaded { frames: Some(frames), answers, stop, run: Some(run) })
    }

    /// Hands over the next frame; `images` may also be the reason why there are none, and a mask of this frame takes the place of the
    /// setup's. Waits while the stages are behind, except in real time, where the newest frame replaces one that is still waiting.
    ///
    /// # Errors
    /// When a stage has ended the run.
    pub fn push(
        &self,
        info: FrameInfo,
        images: Result<LoadedFrame, Unusable>,
        mask: Option<FrameMask>,
    ) -> Result<(), RunEnded> {
        let frames = self.frames.as_ref().ok_or(RunEnded)?;
        frames.send((info, images, mask)).map_err(|_| RunEnded)
    }

    /// Waits for the next answer; `None` when the run has ended and all were taken. There is one for each frame that was pushed, so
    /// that asking for more waits for ever.
    pub fn answer(&self) -> Option<FrameAnswer> {
        self.answers.recv().ok()
    }

    /// Lets the stages finish all that was pushed, and returns the results with the answers that nobody has taken.
    ///
    /// # Errors
    /// [`RunError::Thread`] when a thread could not be started.
    pub fn finish(mut self) -> Result<(RunOutcome, Vec<FrameAnswer>), RunError> {
        self.frames = None;
        let outcome = self.join()?;
        Ok((outcome, self.answers.try_iter().collect()))
    }

    fn join(&mut self) -> Result<RunOutcome, RunError> {
        let ended = |stage: StageFailure| RunError::Thread { stage: stage.stage, reason: stage.message };
        let Some(run) = self.run.take() else { return Err(ended(StageFailure::gone("run"))) };
        // Panics of stages are part of the outcome.
        run.join().unwrap_or_else(|_| Err(ended(StageFailure::gone("run"))))
    }
}

impl Drop for Threaded {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.frames = None;
        if self.run.is_some() {
            // Nobody wants the results any more.
            let _ = self.join();
        }
    }
}

/// Frames as they are pushed.
struct PushedFeed {
    pushed: Receiver<Pushed>,
    state: Mutex<PushedState>,
}

#[derive(Default)]
struct PushedState {
    infos: Vec<FrameInfo>,
    /// Images of the newest frame, until they are taken.
    images: Option<Result<LoadedFrame, Unusable>>,
    /// Its mask.
    mask: Option<FrameMask>,
}

impl FrameFeed for PushedFeed {
    fn size_hint(&self) -> Option<usize> {
        None
    }

    fn ends_before(&self, _: usize) -> bool {
        // Waits without the lock, since others ask for earlier frames meanwhile.
        let Ok((info, images, mask)) = self.pushed.recv() else { return true };
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.infos.push(info);
        (state.images, state.mask) = (Some(images), mask);
        false
    }

    fn keeps_pace(&self) -> bool {
        true
    }

    fn info(&self, i: usize) -> FrameInfo {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).infos[i]
    }

    fn load(&self, _: usize) -> Result<LoadedFrame, Unusable> {
        let images = self.state.lock().unwrap_or_else(PoisonError::into_inner).images.take();
        // A run loads each frame once.
        images.unwrap_or(Err(Unusable::Missing("left")))
    }

    fn mask(&self, _: usize) -> Option<FrameMask> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).mask.take()
    }
}

/// Hands answers to the caller.
struct Answering(Sender<FrameAnswer>);

impl Observer for Answering {
    fn event(&mut self, event: &Event) {
        if let Event::Frame(answer) = event {
            // The caller may be gone.
            let _ = self.0.send(answer.as_ref().clone());
        }
    }
}
