//! `dsslam inspect vocab`: trains a vocabulary from images, describes one, converts between the two file formats.

use std::path::PathBuf;

use anyhow::anyhow;
use bow::tool::{self, Format, Info};
use bow::{TrainOptions, Vocabulary, VocabularyError};
use features::{Descriptor, ExtractorConfig};
use indicatif::ProgressBar;

use crate::args::{VocabAction, VocabTrainArgs};
use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::files::folder_of;

/// Trains, describes or converts.
///
/// # Errors
/// Images or a vocabulary that cannot be used are a fault of the input, a file that cannot be written one of the output.
pub(crate) fn run(action: &VocabAction) -> Result<Exit, Failure> {
    match action {
        VocabAction::Train(args) => train(args),
        VocabAction::Info { file: None } => {
            let vocabulary = Vocabulary::built_in().or_input()?;
            describe("built in", Format::Binary, &vocabulary);
            Ok(Exit::Done)
        }
        VocabAction::Info { file: Some(file) } => {
            let (vocabulary, format) = tool::open_with_format(file).map_err(failure)?;
            describe(&file.display().to_string(), format, &vocabulary);
            Ok(Exit::Done)
        }
        VocabAction::Convert { input, output } => {
            let done = tool::convert(input, output).map_err(failure)?;
            let (from, to) = (input.display(), output.display());
            console::say(format!("{to} ({}) from {from} ({})", done.to, done.from));
            console::say(done.info.to_string());
            Ok(Exit::Done)
        }
    }
}

/// Trains on the images in the order given and writes the file. What would make the work useless is looked at first.
fn train(args: &VocabTrainArgs) -> Result<Exit, Failure> {
    io::create_output_folder(folder_of(&args.out)).or_output()?;
    let images = tool::find_images(&args.images).map_err(failure)?;
    if images.is_empty() {
        let places: Vec<String> = args.images.iter().map(|path| path.display().to_string()).collect();
        return Err(anyhow!("{}: no images found, expected .png, .jpg or .jpeg files", places.join(", ")))
            .or_input();
    }
    let bar = console::bar(Some(images.len() as u64), "{bar:24} {pos}/{len} images  {msg}");
    let descriptors = describe_images(&images, args.keep as usize, &bar)?;
    bar.set_message("building the tree");
    let options = TrainOptions {
        branching: args.branching,
        levels: args.levels,
        seed: args.seed,
        ..TrainOptions::default()
    };
    let vocabulary = bow::train(&descriptors, &options).or_input()?;
    bar.finish_and_clear();
    let format = Format::of_name(&args.out);
    tool::save(&vocabulary, &args.out, format).map_err(failure)?;
    describe(&args.out.display().to_string(), format, &vocabulary);
    Ok(Exit::Done)
}

/// The descriptors of each image. All images are decoded before the first that is broken is reported.
fn describe_images(
    images: &[PathBuf],
    keep: usize,
    bar: &ProgressBar,
) -> Result<Vec<Vec<Descriptor>>, Failure> {
    let extraction = ExtractorConfig { keep, ..ExtractorConfig::default() };
    tool::describe_images(images.len(), &extraction, |i| {
        let image = io::load_gray(&images[i]);
        bar.inc(1);
        image
    })
    .or_input()
}

/// Prints what there is to know about a vocabulary.
fn describe(origin: &str, format: Format, vocabulary: &Vocabulary) {
    let sha256 = dsslam::sha256(vocabulary.as_bytes());
    console::say(format!("vocabulary   {origin}"));
    console::say(format!("format       {format}"));
    console::say(Info::of(vocabulary).to_string());
    console::say(format!("SHA-256      {sha256} (in DSSLAM's format)"));
}

/// An unwritable file is a fault of the output, everything else of the input.
fn failure(error: VocabularyError) -> Failure {
    let exit = if matches!(error, VocabularyError::Unwritable(_)) { Exit::Output } else { Exit::Input };
    Failure { exit, error: error.into() }
}
