//! Something to run on, opened: a folder of images, a video, a camera or a rendered world, with the configuration that it leaves in
//! force.

use std::fmt;
use std::path::{Path, PathBuf};

use features::{Extractor, ExtractorConfig, Rig};
use io::{Clock, OpenOptions, Sensor, Sequence, Variant};
use runtime::{FrameFeed, SequenceFeed, Setup};
use synth::World;

use crate::bag_input::{BagFeed, OpenedBag};
use crate::intake::Intake;
use crate::rendered::{self, RenderedFeed};
use crate::video::{self, Opened};
use crate::video_feed::VideoFeed;
use crate::{Config, Error, NetworkOptions};

/// How a folder, a video or a camera is opened.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct InputOptions {
    /// The sensor to use; `None`: that of the configuration, else the richest that there is.
    pub sensor: Option<Sensor>,
    /// Calibration file of the cameras; `None`: the one in the folder, if there is one.
    pub calibration: Option<PathBuf>,
    /// Ground truth, in any format of [`io::read_trajectory`] and of the same body as the dataset's own (KITTI: camera 0); `None`:
    /// the dataset's own, if there is one. Not for videos.
    pub ground_truth: Option<PathBuf>,
    /// Topics of a bag; `None`: those that names and types suggest. A bag's poses are taken as ground truth where `ground_truth` names their
    /// topic.
    pub topics: Option<bag::Roles>,
    /// Number of frames after which the run ends; `None`: all.
    pub max_frames: Option<usize>,
    /// A variant of the frames, with the camera and the ground truth that belong to it. For folders of images only.
    pub variant: Variant,
}

/// Frames with their camera and the configuration in force.
pub struct Input {
    intake: Intake,
    feed: Box<dyn FrameFeed + Send>,
    clock: Clock,
}

impl fmt::Debug for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Input").field("intake", &self.intake).finish_non_exhaustive()
    }
}

impl Input {
    /// Opens a folder of images, a video or a camera such as `/dev/video0`; no frame is read but the size of one.
    ///
    /// # Errors
    /// A path without images, a broken calibration, images of another size than the camera's.
    pub fn open(path: &Path, config: &Config, options: &InputOptions) -> Result<Self, Error> {
        let opening = OpenOptions {
            sensor: options.sensor.or(config.input.sensor),
            association_tolerance_s: config.input.association_tolerance_s,
            calibration: options.calibration.clone(),
            frame_rate_hz: config.camera.fps,
            ground_truth: options.ground_truth.clone(),
        };
        let max_frames = options.max_frames;
        if bag::is_bag(path) {
            let opened = OpenedBag::new(path, &opening, options.topics.as_ref())?;
            let intake = Intake::new(path, opened.sequence.clone(), Some(opened.size), config)?;
            let clock = Clock::of_stamps(opened.stamps());
            let units = intake.config.camera.depth_units_per_metre;
            let feed = Box::new(BagFeed::new(opened, intake.preparation.clone(), max_frames, units));
            return Ok(Self { intake, feed, clock });
        }
        if video::is_video(path) || video::is_camera(path) {
            if options.variant != Variant::default() {
                return Err(Error::Variant { path: path.to_path_buf() });
            }
            if options.ground_truth.is_some() {
                return Err(Error::GroundTruth { path: path.to_path_buf() });
            }
            let opened = Opened::new(path, &opening)?;
            let (sequence, size) = (opened.video.sequence.clone(), opened.video.size);
            let intake = Intake::new(path, sequence, Some(size), config)?;
            let clock = Clock::default();
            let feed = Box::new(VideoFeed::new(opened, intake.preparation.clone(), max_frames));
            return Ok(Self { intake, feed, clock });
        }
        let sequence = io::open_sequence_with(path, &opening)?;
        Self::files(path, sequence, config, (max_frames, options.variant))
    }

    /// An image file as a sequence of one frame.
    ///
    /// # Errors
    /// A file that is not an image, or of another size than the configuration's camera.
    pub fn image(file: &Path, config: &Config) -> Result<Self, Error> {
        Self::files(file, Sequence::of_image(file), config, (None, Variant::default()))
    }

    fn files(
        path: &Path,
        sequence: Sequence,
        config: &Config,
        (max_frames, variant): (Option<usize>, Variant),
    ) -> Result<Self, Error> {
        let mut sequence = sequence;
        sequence.frames.truncate(max_frames.unwrap_or(usize::MAX));
        let intake = Intake::new(path, sequence, None, config)?.varied(variant);
        let feed = SequenceFeed::prepared(&intake.sequence, intake.preparation.clone(), max_frames);
        let clock = Clock::of(&intake.sequence.frames);
        Ok(Self { intake, feed: Box::new(feed), clock })
    }

    /// A rendered world, whose frames are rendered when they are asked for.
    ///
    /// # Errors
    /// A sensor other than stereo and mono.
    pub fn rendered(world: World, config: &Config, options: &InputOptions) -> Result<Self, Error> {
        let sensor = options.sensor.or(config.input.sensor).unwrap_or(Sensor::Stereo);
        let len = options.max_frames.map_or(world.n_frames(), |max| max.min(world.n_frames()));
        let sequence = rendered::sequence(&world, len, sensor)?;
        let (name, size) = (PathBuf::from(&sequence.name), rendered::image_size(&world));
        let intake = Intake::new(&name, sequence, Some(size), config)?;
        let feed = Box::new(RenderedFeed { world, len, sensor, preparation: intake.preparation.clone() });
        Ok(Self { intake, feed, clock: Clock::default() })
    }

    /// The stamps of the frames, exactly as they were read, where they are known beforehand.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// What was opened.
    pub fn path(&self) -> &Path {
        &self.intake.path
    }

    /// The frames, reduced and rectified.
    pub fn feed(&self) -> &dyn FrameFeed {
        self.feed.as_ref()
    }

    /// Name, sensor, calibration and ground truth; the list of files is empty where frames are not files.
    pub fn sequence(&self) -> &Sequence {
        &self.intake.sequence
    }

    /// The configuration in force: with the camera and the frame rate of the dataset.
    pub fn config(&self) -> &Config {
        &self.intake.config
    }

    /// What the user should know before the run.
    pub fn notices(&self) -> &[String] {
        &self.intake.notices
    }

    /// Whether the frames come from a camera: they cannot be had twice.
    pub fn is_camera(&self) -> bool {
        video::is_camera(&self.intake.path)
    }

    /// The settings of features in force, those of the sensor.
    pub fn features(&self) -> ExtractorConfig {
        self.intake.features()
    }

    /// What extracts features of the left image where the configuration's mask allows it; with a network that selects among
    /// features, its candidates.
    ///
    /// # Errors
    /// A mask that is not an image, or has another size than the images.
    pub fn extractor(&self) -> Result<Extractor, Error> {
        self.intake.extractor()
    }

    /// The camera after reduction and rectification.
    ///
    /// # Errors
    /// A missing camera.
    pub fn rig(&self) -> Result<Rig, Error> {
        self.intake.rig()
    }

    /// Camera, parameters, mask and network of a run, without vocabulary.
    ///
    /// # Errors
    /// A camera that nobody gives, a mask or a network that cannot be used.
    pub fn setup(&self, options: &NetworkOptions) -> Result<Setup, Error> {
        self.intake.setup(options)
    }

    pub(crate) fn intake(&self) -> &Intake {
        &self.intake
    }
}
