//! The test suite of the whole: one program, so that a rendered sequence is shared and linking is paid for once.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test stops at the first problem")]

mod architecture;
mod bad_config;
mod bad_euroc;
mod bad_images;
mod bad_sequence;
mod documents;
mod end_to_end;
mod english;
mod evaluation;
mod event_stream;
mod figures;
mod fuzzing;
mod map_file;
mod outputs;
mod program;
mod pushed;
mod real_data;
mod rendered_feed;
mod schedules;
mod schedules_of_the_program;
mod selection;
mod sensors;
mod sequence;
mod videos;
mod viewing;
mod vocabulary;
mod watching;

use std::path::{Path, PathBuf};

/// The repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}
