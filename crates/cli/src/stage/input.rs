//! What the stage tools look at: an image file, or a frame of a sequence with its camera.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use features::{ExtractorConfig, Rig};
use geometry::GrayImage;
use io::{Config, LoadedFrame, OpenOptions, Sensor, Sequence};
use runtime::{FrameFeed, Preparation, SequenceFeed, Setup};

use crate::setup;

/// A frame, and where its picture goes.
#[derive(Debug, Args)]
pub(crate) struct FrameArgs {
    /// Number of the sequence's frame; by default its first.
    #[arg(long, value_name = "N")]
    pub(super) frame: Option<u32>,
    /// The picture to write (PNG).
    #[arg(short, long, value_name = "PNG")]
    pub(super) out: PathBuf,
}

/// An image to look at.
pub(super) struct Picture {
    /// Where it comes from.
    pub(super) name: String,
    /// Its pixels, rectified where the sequence's are.
    pub(super) image: GrayImage,
}

/// A sequence of which frames are taken.
pub(super) struct Frames {
    sequence: Sequence,
    /// `input.scale`.
    scale: f64,
    /// Camera and parameters, or why there are none.
    pub(super) setup: Result<Setup>,
}

/// The parameters of extraction.
pub(super) fn extractor(config: &Config) -> ExtractorConfig {
    setup::extractor(&config.features)
}

/// An image file, or the left image of a sequence's frame.
pub(super) fn picture(path: &Path, frame: Option<u32>, config: Config) -> Result<Picture> {
    if path.is_dir() {
        return Frames::open(path, None, config)?.picture(frame);
    }
    if let Some(number) = frame {
        bail!("{}: found an image, and --frame {number} needs a sequence", path.display());
    }
    Ok(Picture { name: path.display().to_string(), image: io::load_gray(path)? })
}

impl Frames {
    /// Opens a sequence with a sensor, or with the configuration's or the best that it offers.
    pub(super) fn open(dir: &Path, sensor: Option<Sensor>, mut config: Config) -> Result<Self> {
        let options = OpenOptions {
            sensor: sensor.or(config.input.sensor),
            association_tolerance_s: config.input.association_tolerance_s,
            calibration: None,
            frame_rate_hz: config.camera.fps,
        };
        let sequence = io::open_sequence_with(dir, &options)?;
        if let Some(calibration) = &sequence.calibration {
            config.apply_calibration(calibration);
        }
        let setup = setup::image_size(&sequence, &config)
            .and_then(|size| setup::from_config(&config, sequence.sensor, size, dir));
        Ok(Self { sequence, scale: config.input.scale, setup })
    }

    /// The camera; `None` where neither the sequence nor the configuration gives it.
    pub(super) fn rig(&self) -> Option<&Rig> {
        self.setup.as_ref().ok().map(|setup| &*setup.rig)
    }

    /// The frame of this number, the first one by default: its position among the frames, and its images.
    pub(super) fn load(&self, number: Option<u32>) -> Result<(usize, LoadedFrame)> {
        let frames = &self.sequence.frames;
        let position = match number {
            None => 0,
            Some(number) => frames.iter().position(|frame| frame.index == number).with_context(|| {
                let ends = frames.first().zip(frames.last()).map(|(a, b)| (a.index, b.index));
                let (first, last) = ends.unwrap_or_default();
                format!("{}: found no frame {number}, it has frames {first} to {last}", self.sequence.name)
            })?,
        };
        let preparation = Preparation::new(&self.sequence, self.scale);
        let feed = SequenceFeed::prepared(&self.sequence, preparation, None);
        let frame = feed.load(position).map_err(|reason| anyhow!(reason))?;
        Ok((position, frame))
    }

    /// The left image of a frame.
    pub(super) fn picture(&self, number: Option<u32>) -> Result<Picture> {
        let (position, frame) = self.load(number)?;
        Ok(Picture { name: self.name_of(position), image: frame.left })
    }

    /// Sequence and frame in words.
    pub(super) fn name_of(&self, position: usize) -> String {
        format!("{} frame {}", self.sequence.name, self.sequence.frames[position].index)
    }

    /// Time of a frame, seconds.
    pub(super) fn timestamp_s(&self, position: usize) -> f64 {
        self.sequence.frames[position].timestamp_s
    }
}
