//! A target that never fails: the crate `mcap` panics where it is used, or merely dropped, after an error of its target.

use std::io::{Error, ErrorKind, Result, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// The first error of a target, to be asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct FirstError(Arc<Mutex<Option<Error>>>);

/// Writes until the first error, which it keeps to itself; what comes after it is dropped.
#[derive(Debug)]
pub(super) struct Held<W> {
    target: W,
    error: FirstError,
}

impl FirstError {
    /// What has been written so far.
    ///
    /// # Errors
    /// The first error, at every call.
    pub(super) fn check(&self) -> Result<()> {
        match &*self.0.lock().unwrap_or_else(PoisonError::into_inner) {
            None => Ok(()),
            Some(error) => Err(Error::new(error.kind(), error.to_string())),
        }
    }
}

impl<W: Write> Held<W> {
    pub(super) fn new(target: W, error: FirstError) -> Self {
        Held { target, error }
    }

    pub(super) fn into_target(self) -> W {
        self.target
    }

    fn attempt<T>(&mut self, instead: T, act: impl FnOnce(&mut W) -> Result<T>) -> Result<T> {
        let mut held = self.error.0.lock().unwrap_or_else(PoisonError::into_inner);
        if held.is_some() {
            return Ok(instead);
        }
        match act(&mut self.target) {
            // Whoever writes tries again.
            Err(error) if error.kind() != ErrorKind::Interrupted => {
                *held = Some(error);
                Ok(instead)
            }
            done => done,
        }
    }
}

impl<W: Write> Write for Held<W> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.attempt(bytes.len(), |target| match target.write(bytes) {
            Ok(0) if !bytes.is_empty() => Err(ErrorKind::WriteZero.into()),
            written => written,
        })
    }

    fn flush(&mut self) -> Result<()> {
        self.attempt((), W::flush)
    }
}
