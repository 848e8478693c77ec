//! The configuration: layers, defaults, the camera in force, and the exact message for each mistake.

#![allow(clippy::unwrap_used)]

mod calibration;
mod errors;
mod keys;
mod layers;
mod support;
