//! Trains a vocabulary from images: `cargo run --release -p bow --example train -- OUT IMAGES...`
//!
//! Images are taken in the order given; a folder stands for the images in it, sorted by path.

#![allow(clippy::print_stdout)]

use bow::tool::{self, Format, Info, TRAINING_FEATURES};
use bow::{TrainOptions, train};
use features::ExtractorConfig;
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let out = arguments.next().ok_or("usage: train OUT IMAGES...")?;
    let images = tool::find_images(&arguments.collect::<Vec<_>>())?;
    let extraction = ExtractorConfig { keep: TRAINING_FEATURES, ..ExtractorConfig::default() };
    let descriptors = tool::describe_images(images.len(), &extraction, |i| io::load_gray(&images[i]))?;
    let vocabulary = train(&descriptors, &TrainOptions::default())?;
    tool::save(&vocabulary, &out, Format::of_name(&out))?;
    println!("{}", Info::of(&vocabulary));
    Ok(())
}
