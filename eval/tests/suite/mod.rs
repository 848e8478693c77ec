//! What the package must do.

mod bad_input;
mod command;
mod devkit;
mod evaluation;
mod evo;
mod evo_values;
mod laws;
#[cfg(unix)]
mod suites;
mod support;
