//! What a program for training, converting and describing vocabularies calls: files in and out, facts for printing. Prints nothing itself.

use crate::block::Block;
use crate::error::{FormatError, VocabularyError};
use crate::format::{binary, layout::VERSION, text};
use crate::vocabulary::Vocabulary;
use features::{Descriptor, Extractor, ExtractorConfig};
use geometry::GrayImage;
use rayon::prelude::*;
use std::ffi::OsStr;
use std::fmt;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// The two file formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Our own.
    Binary,
    /// ORB-SLAM2's.
    Text,
}

impl Format {
    /// The format to write a file of this name in: text for the ending `.txt`, otherwise our own.
    pub fn of_name(path: &Path) -> Self {
        let is_text = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("txt"));
        if is_text { Self::Text } else { Self::Binary }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Binary => write!(f, "DSSLAM, version {VERSION}"),
            Self::Text => f.write_str("ORB-SLAM2 text"),
        }
    }
}

/// Opens a vocabulary in either format, which its first bytes tell.
///
/// A file of our own format is mapped into memory: while it is in use it must not be changed in place, only replaced, as
/// [`save`] does.
///
/// # Errors
/// [`VocabularyError`], naming the file.
pub fn open(path: &Path) -> Result<Vocabulary, VocabularyError> {
    open_with_format(path).map(|(vocabulary, _)| vocabulary)
}

/// As [`open`], with the format that was found.
///
/// # Errors
/// As [`open`].
pub fn open_with_format(path: &Path) -> Result<(Vocabulary, Format), VocabularyError> {
    let block = Block::of_file(path).map_err(|error| VocabularyError::unreadable(path, &error))?;
    let (result, format) = if text::is_text(block.bytes()) {
        (parse_text(block.bytes()), Format::Text)
    } else {
        (Vocabulary::from_block(block), Format::Binary)
    };
    let vocabulary =
        result.map_err(|problem| VocabularyError::Format { path: path.to_path_buf(), problem })?;
    Ok((vocabulary, format))
}

fn parse_text(bytes: &[u8]) -> Result<Vocabulary, FormatError> {
    let text = str::from_utf8(bytes).map_err(|error| {
        let before = &bytes[..error.valid_up_to()];
        let line = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
        let found = binary::describe_head(&bytes[error.valid_up_to()..]);
        FormatError::Line { line, found, expected: "text".into() }
    })?;
    Vocabulary::from_text(text)
}

/// Writes a vocabulary, so that a file of this name is whole whatever happens.
///
/// # Errors
/// [`VocabularyError::Unwritable`].
pub fn save(vocabulary: &Vocabulary, path: &Path, format: Format) -> Result<(), VocabularyError> {
    match format {
        Format::Binary => ::io::write_durable(path, vocabulary.as_bytes()),
        Format::Text => ::io::write_durable(path, vocabulary.to_text().as_bytes()),
    }
    .map_err(VocabularyError::Unwritable)
}

/// What a conversion did.
#[derive(Clone, Debug, PartialEq)]
pub struct Conversion {
    /// Format that was read.
    pub from: Format,
    /// Format that was written.
    pub to: Format,
    /// The vocabulary.
    pub info: Info,
}

/// Reads a vocabulary in either format and writes it in the one that the name of `output` asks for.
///
/// # Errors
/// [`VocabularyError`], naming the file concerned.
pub fn convert(input: &Path, output: &Path) -> Result<Conversion, VocabularyError> {
    let (vocabulary, from) = open_with_format(input)?;
    let to = Format::of_name(output);
    save(&vocabulary, output, to)?;
    Ok(Conversion { from, to, info: Info::of(&vocabulary) })
}

/// Facts about a vocabulary.
#[derive(Clone, Debug, PartialEq)]
pub struct Info {
    /// Most children of a node.
    pub branching: u32,
    /// Most steps from the root to a word.
    pub levels: u32,
    /// Number of nodes.
    pub n_nodes: u32,
    /// Number of words.
    pub n_words: u32,
    /// Number of words of each level, from the root's on.
    pub words_by_level: Vec<u32>,
    /// Least and greatest weight of a word.
    pub weight_range: (f32, f32),
    /// Images it was trained on, 0 when unknown.
    pub n_images: u64,
    /// Descriptors it was trained on, 0 when unknown.
    pub n_descriptors: u64,
    /// Seed of the training.
    pub seed: u64,
    /// Bytes in our own format.
    pub n_bytes: usize,
}

impl Info {
    /// The facts about this vocabulary.
    pub fn of(vocabulary: &Vocabulary) -> Self {
        let tree = vocabulary.tree();
        let origin = vocabulary.origin();
        let mut words_by_level = Vec::new();
        let mut weight_range = (f32::INFINITY, 0.0f32);
        let mut level = 0..1;
        while !level.is_empty() {
            let words = level.clone().filter(|&node| tree.children(node).is_empty());
            words_by_level.push(words.clone().count() as u32);
            for word in words {
                let weight = tree.weights[word];
                weight_range = (weight_range.0.min(weight), weight_range.1.max(weight));
            }
            level = level.end..tree.first_child[level.end] as usize;
        }
        Self {
            branching: vocabulary.branching(),
            levels: vocabulary.levels(),
            n_nodes: vocabulary.n_nodes(),
            n_words: vocabulary.n_words(),
            words_by_level,
            weight_range,
            n_images: origin.n_images,
            n_descriptors: origin.n_descriptors,
            seed: origin.seed,
            n_bytes: vocabulary.as_bytes().len(),
        }
    }
}

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "branching    {}", self.branching)?;
        writeln!(f, "levels       {}", self.levels)?;
        writeln!(f, "nodes        {}", self.n_nodes)?;
        let by_level: Vec<String> = self.words_by_level.iter().map(u32::to_string).collect();
        writeln!(f, "words        {} (by level: {})", self.n_words, by_level.join(" "))?;
        writeln!(
            f,
            "weights      TF-IDF, {:.3} to {:.3}; L1 score",
            self.weight_range.0, self.weight_range.1
        )?;
        match (self.n_images, self.n_descriptors) {
            (0, _) => writeln!(f, "trained on   unknown")?,
            (n, m) => writeln!(f, "trained on   {n} images, {m} descriptors, seed {}", self.seed)?,
        }
        write!(f, "size         {:.2} MB", self.n_bytes as f64 / 1e6)
    }
}

/// Features per image that training takes unless told otherwise.
pub const TRAINING_FEATURES: usize = 500;

/// The images that these paths stand for, in order: a folder stands for the `.png`, `.jpg` and `.jpeg` files in it and in
/// its folders, sorted by name.
///
/// # Errors
/// [`VocabularyError::Unreadable`] for a folder that cannot be listed. Files are not opened.
pub fn find_images(paths: &[PathBuf]) -> Result<Vec<PathBuf>, VocabularyError> {
    let mut images = Vec::new();
    for path in paths {
        if path.is_dir() {
            images.extend(find_images(
                &list(path).map_err(|error| VocabularyError::unreadable(path, &error))?,
            )?);
        } else {
            images.push(path.clone());
        }
    }
    Ok(images)
}

/// The folders and images in a folder, sorted.
fn list(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let is_image = |path: &Path| {
        let ending = path.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
        matches!(ending.as_deref(), Some("png" | "jpg" | "jpeg"))
    };
    let mut paths = fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.path()))
        .filter(|path| path.as_ref().map_or(true, |path| path.is_dir() || is_image(path)))
        .collect::<io::Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}

/// The descriptors of images `0..n`, for training; images are loaded and extracted in parallel, the result is in order.
///
/// # Errors
/// That of the first image, in order, that cannot be loaded.
pub fn describe_images<E: Send>(
    n: usize,
    config: &ExtractorConfig,
    load: impl Fn(usize) -> Result<GrayImage, E> + Sync,
) -> Result<Vec<Vec<Descriptor>>, E> {
    let results: Vec<Result<_, E>> = (0..n)
        .into_par_iter()
        .map_init(
            || Extractor::new(config.clone()),
            |extractor, i| Ok(extractor.extract(&load(i)?).descriptors),
        )
        .collect();
    results.into_iter().collect()
}
