//! Trains a vocabulary: `cargo run --release -p bow --example train -- OUT.dbow [--features N] [--seed S] IMAGES...`
//!
//! Images are taken in the order given, folders are replaced by the images in them, sorted by path. The same as
//! `dsslam vocab train -k 10 -l 5`.

#![allow(clippy::print_stdout)]

use bow::tool::{self, Format, Info};
use bow::{TrainOptions, train};
use features::ExtractorConfig;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let out = PathBuf::from(arguments.next().ok_or("usage: train OUT [--features N] [--seed S] IMAGES...")?);
    let mut extraction = ExtractorConfig { keep: 500, ..ExtractorConfig::default() };
    let mut options = TrainOptions::default();
    let mut images = Vec::new();
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a number"));
        match argument.as_str() {
            "--features" => extraction.keep = value()?.parse()?,
            "--seed" => options.seed = value()?.parse()?,
            path => collect(Path::new(path), &mut images)?,
        }
    }
    println!("{} images", images.len());
    let descriptors = tool::describe_images(images.len(), &extraction, |i| io::load_gray(&images[i]))?;
    println!("{} descriptors", descriptors.iter().map(Vec::len).sum::<usize>());
    let vocabulary = train(&descriptors, &options)?;
    tool::save(&vocabulary, &out, Format::of_name(&out))?;
    println!("{}", Info::of(&vocabulary));
    Ok(())
}

/// Adds an image, or all images below a folder.
fn collect(path: &Path, images: &mut Vec<PathBuf>) -> Result<(), Box<dyn Error>> {
    if !path.is_dir() {
        images.push(path.to_path_buf());
        return Ok(());
    }
    let mut entries = fs::read_dir(path)?.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, std::io::Error>>()?;
    entries.sort();
    for entry in entries {
        let is_image = entry.extension().is_some_and(|ending| ending == "png" || ending == "jpg");
        if entry.is_dir() || is_image {
            collect(&entry, images)?;
        }
    }
    Ok(())
}
