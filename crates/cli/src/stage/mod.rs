//! Stage tools: each inspects one step of the pipeline. Each writes a picture and prints its counts.

mod features;
mod input;
mod matching;
mod stereo;

pub(crate) use features::FeaturesArgs;
pub(crate) use input::{Picture, picture};
pub(crate) use matching::MatchArgs;
pub(crate) use stereo::StereoArgs;

use std::path::Path;

use draw::Canvas;

use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::files::folder_of;

/// Largest width of an image that is shown twice as large.
const ZOOMED_WIDTH: usize = 1000;

/// How many pixels of the picture show a pixel of an image of this width: small images would not show their marks.
fn zoom_for(width: usize) -> usize {
    if width <= ZOOMED_WIDTH { 2 } else { 1 }
}

/// Prints a named row.
pub(crate) fn row(name: &str, value: &str) {
    console::say(format!("{name:<12}{value}"));
}

/// Writes the picture and says so.
pub(crate) fn save(file: &Path, picture: &Canvas) -> Result<Exit, Failure> {
    io::create_output_folder(folder_of(file)).or_output()?;
    io::save_png_rgb(file, &picture.image).or_output()?;
    row("picture", &format!("{} ({}x{})", file.display(), picture.image.width, picture.image.height));
    Ok(Exit::Done)
}
