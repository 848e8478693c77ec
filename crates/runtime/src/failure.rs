//! A panic in a stage becomes a value that names the stage; nothing that was computed before is lost.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use thiserror::Error;

/// A stage that panicked. Always a bug; the run ended there, with everything that was computed until then.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("the stage `{stage}` failed: {message}")]
pub struct StageFailure {
    /// Name of the stage, which is that of its thread.
    pub stage: &'static str,
    /// What the panic said.
    pub message: String,
}

impl StageFailure {
    /// A stage that ended although it was needed.
    pub(crate) fn gone(stage: &'static str) -> Self {
        StageFailure { stage, message: "ended too early".into() }
    }
}

/// Why a stage ends before its work is done.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Halt {
    /// The other end of a channel is gone; the reason stands there.
    Gone,
    /// A service that runs in turn failed.
    Failed(StageFailure),
}

/// How mapping ended early.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MapEnd {
    /// Whether the map is as an operation left it; not after a panic in the middle of one.
    pub(crate) is_whole: bool,
    /// The reason, if it is known here.
    pub(crate) failure: Option<StageFailure>,
}

/// Runs a piece of mapping.
pub(crate) fn map_caught(work: impl FnOnce() -> Result<(), Halt>) -> Result<(), MapEnd> {
    match caught("map", work) {
        Ok(Ok(())) => Ok(()),
        Ok(Err(Halt::Gone)) => Err(MapEnd { is_whole: true, failure: None }),
        Ok(Err(Halt::Failed(failure))) => Err(MapEnd { is_whole: true, failure: Some(failure) }),
        Err(failure) => Err(MapEnd { is_whole: false, failure: Some(failure) }),
    }
}

/// Runs `work`; a panic in it becomes the failure of `stage`.
pub(crate) fn caught<T>(stage: &'static str, work: impl FnOnce() -> T) -> Result<T, StageFailure> {
    catch_unwind(AssertUnwindSafe(work))
        .map_err(|payload| StageFailure { stage, message: message(payload.as_ref()) })
}

fn message(payload: &(dyn Any + Send)) -> String {
    let literal = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    literal
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "panic without a message".into())
}
