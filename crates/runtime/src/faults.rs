//! Test aids: delays and failures at the boundaries of stages. A run never needs them.

use std::time::Duration;

use geometry::mix_seed;

/// What to disturb in a run; nothing by default. Results must not depend on delays, and a failure must name its stage.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Seed of random pauses of up to a few milliseconds before each step of each stage.
    pub delays: Option<u64>,
    /// The stage that panics, and at which of its steps, counted from 0.
    pub panic_at: Option<(&'static str, usize)>,
}

/// Longest pause, microseconds.
const LONGEST_PAUSE_US: u64 = 8000;

/// The faults of one stage.
#[derive(Debug)]
pub(crate) struct StageFaults {
    stage: &'static str,
    faults: Faults,
    step: usize,
}

impl Faults {
    /// Those of a stage.
    pub(crate) fn of(&self, stage: &'static str) -> StageFaults {
        StageFaults { stage, faults: self.clone(), step: 0 }
    }
}

impl StageFaults {
    /// To be called before each step of the stage.
    ///
    /// # Panics
    /// At the step asked for.
    pub(crate) fn step(&mut self) {
        let step = self.step;
        self.step += 1;
        if let Some(seed) = self.faults.delays {
            let name = self.stage.bytes().fold(0, |name, byte| (name << 8) | u64::from(byte));
            let random = mix_seed(seed, step as u64, name);
            // A third of the steps waits: others then overtake.
            if random.is_multiple_of(3) {
                std::thread::sleep(Duration::from_micros((random >> 8) % LONGEST_PAUSE_US));
            }
        }
        assert!(self.faults.panic_at != Some((self.stage, step)), "asked to fail at step {step}");
    }
}
