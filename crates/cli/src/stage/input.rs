//! What the stage tools look at: an image file, or a frame of a sequence with its camera.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use dsslam::{Config, Input, InputOptions};
use features::{Extractor, ExtractorConfig};
use geometry::GrayImage;
use io::{LoadedFrame, Sensor};
use runtime::FrameInfo;

/// A frame, and where its picture goes.
#[derive(Debug, Args)]
pub(crate) struct FrameArgs {
    /// Frame number in the sequence [default: the first].
    #[arg(long, value_name = "N")]
    pub(super) frame: Option<u32>,
    /// The picture to write (PNG).
    #[arg(short, long, value_name = "PNG")]
    pub(super) out: PathBuf,
}

/// An image to look at.
pub(crate) struct Picture {
    /// Where it comes from.
    pub(crate) name: String,
    /// Its pixels, reduced and rectified as those of a run are.
    pub(crate) image: GrayImage,
    /// What extracts its features, where `input.mask` allows it.
    pub(crate) extractor: Extractor,
    /// The settings of its features.
    pub(crate) settings: ExtractorConfig,
}

/// An image, or a sequence of which frames are taken.
pub(super) struct Frames {
    /// What has been opened.
    pub(super) input: Input,
}

/// An image file, or the left image of a sequence's frame.
pub(crate) fn picture(path: &Path, frame: Option<u32>, config: &Config) -> Result<Picture> {
    if path.is_dir() {
        return Frames::open(path, None, config)?.picture(frame);
    }
    if let Some(number) = frame {
        bail!("{}: found an image, but --frame {number} needs a sequence", path.display());
    }
    let input = Input::image(path, config)?;
    Ok(Picture { name: path.display().to_string(), ..Frames { input }.picture(None)? })
}

impl Frames {
    /// Opens a sequence with a sensor, or with the configuration's or the best that it offers.
    pub(super) fn open(dir: &Path, sensor: Option<Sensor>, config: &Config) -> Result<Self> {
        let mut options = InputOptions::default();
        options.sensor = sensor;
        Ok(Self { input: Input::open(dir, config, &options)? })
    }

    /// The frame of this number, the first one by default: what is known of it, and its images.
    pub(super) fn load(&self, number: Option<u32>) -> Result<(FrameInfo, LoadedFrame)> {
        let (feed, sequence) = (self.input.feed(), self.input.sequence());
        let n = sequence.frames.len();
        let position = match number {
            None => 0,
            Some(number) => (0..n).find(|&i| feed.info(i).index == number).with_context(|| {
                let ends = sequence.frames.first().zip(sequence.frames.last());
                let (first, last) = ends.map(|(a, b)| (a.index, b.index)).unwrap_or_default();
                format!("{}: frame {number} does not exist, expected {first} to {last}", sequence.name)
            })?,
        };
        let frame = feed.load(position).map_err(|reason| anyhow!(reason))?;
        Ok((feed.info(position), frame))
    }

    /// The left image of a frame.
    pub(super) fn picture(&self, number: Option<u32>) -> Result<Picture> {
        let (info, frame) = self.load(number)?;
        let (extractor, settings) = (self.input.extractor()?, self.input.features());
        Ok(Picture { name: self.name_of(info), image: frame.left, extractor, settings })
    }

    /// Sequence and frame as text.
    pub(super) fn name_of(&self, info: FrameInfo) -> String {
        format!("{} frame {}", self.input.sequence().name, info.index)
    }
}
