//! Something to run on, opened: a folder of images, a video, a camera or a rendered world, with the configuration that it leaves in
//! force. This is the only way from a path and a configuration to frames and a [`Setup`].

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use features::{Extractor, ExtractorConfig, FeatureMask, Rig};
use io::{Config, FeatureSettings, ImageSize, OpenOptions, Sensor, Sequence};
use runtime::{FrameFeed, Preparation, SequenceFeed, Setup};
use synth::World;

use crate::video::{self, Opened};
use crate::video_feed::VideoFeed;
use crate::{Error, NetworkOptions, network, rendered, setup};

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
    /// Number of frames after which the run ends; `None`: all.
    pub max_frames: Option<usize>,
}

/// Frames with their camera and the configuration in force.
pub struct Input {
    path: PathBuf,
    sequence: Sequence,
    config: Config,
    /// Of the raw images of one camera.
    size: ImageSize,
    preparation: Preparation,
    feed: Box<dyn FrameFeed + Send>,
    notices: Vec<String>,
}

impl fmt::Debug for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Input").field("sequence", &self.sequence.name).field("size", &self.size).finish()
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
        if video::is_video(path) || video::is_camera(path) {
            let opened = Opened::new(path, &opening)?;
            let (sequence, size) = (opened.video.sequence.clone(), opened.video.size);
            let (config, notices) = in_force(config, &sequence);
            setup::check_size(size, path, &config)?;
            let preparation = Preparation::new(&sequence, config.input.scale);
            let feed = Box::new(VideoFeed::new(opened, preparation.clone(), max_frames));
            return Ok(Self { path: path.to_path_buf(), sequence, config, size, preparation, feed, notices });
        }
        Self::files(path, io::open_sequence_with(path, &opening)?, config, max_frames)
    }

    /// An image file as a sequence of one frame.
    ///
    /// # Errors
    /// A file that is not an image, or of another size than the configuration's camera.
    pub fn image(file: &Path, config: &Config) -> Result<Self, Error> {
        Self::files(file, Sequence::of_image(file), config, None)
    }

    fn files(
        path: &Path,
        sequence: Sequence,
        config: &Config,
        max_frames: Option<usize>,
    ) -> Result<Self, Error> {
        let (config, notices) = in_force(config, &sequence);
        let size = setup::image_size(&sequence, &config)?;
        let preparation = Preparation::new(&sequence, config.input.scale);
        let feed = Box::new(SequenceFeed::prepared(&sequence, preparation.clone(), max_frames));
        Ok(Self { path: path.to_path_buf(), sequence, config, size, preparation, feed, notices })
    }

    /// A rendered world, whose frames are rendered when they are asked for.
    ///
    /// # Errors
    /// A sensor other than stereo and mono.
    pub fn rendered(world: World, config: &Config, options: &InputOptions) -> Result<Self, Error> {
        let sensor = options.sensor.or(config.input.sensor).unwrap_or(Sensor::Stereo);
        let len = options.max_frames.map_or(world.n_frames(), |max| max.min(world.n_frames()));
        let sequence = rendered::sequence(&world, len, sensor)?;
        let (path, size) = (PathBuf::from(&sequence.name), rendered::image_size(&world));
        let (config, notices) = in_force(config, &sequence);
        setup::check_size(size, &path, &config)?;
        let preparation = Preparation::new(&sequence, config.input.scale);
        let feed = Box::new(rendered::RenderedFeed::new(world, len, sensor, preparation.clone()));
        Ok(Self { path, sequence, config, size, preparation, feed, notices })
    }

    /// Name, sensor, calibration and ground truth; the list of files is empty where frames are not files.
    pub fn sequence(&self) -> &Sequence {
        &self.sequence
    }

    /// The configuration in force: with the camera and the frame rate of the dataset.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// What the user should know before the run.
    pub fn notices(&self) -> &[String] {
        &self.notices
    }

    /// Whether the frames come from a camera: they cannot be had twice.
    pub fn is_camera(&self) -> bool {
        video::is_camera(&self.path)
    }

    /// The frames, reduced and rectified.
    pub fn feed(&self) -> &dyn FrameFeed {
        self.feed.as_ref()
    }

    /// Where features may be taken: not where `input.mask` is 0, nor in a border that rectification leaves; `None`: everywhere.
    ///
    /// # Errors
    /// A mask that is not an image, or has another size than the images.
    pub fn mask(&self, extractor: &ExtractorConfig) -> Result<Option<FeatureMask>, Error> {
        let wanted = setup::wanted_mask(&self.config, self.size)?;
        Ok(self.preparation.mask(extractor, wanted.as_ref()))
    }

    /// The settings of features in force, those of the sensor.
    pub fn features(&self) -> FeatureSettings {
        self.config.features.with_sensor(self.sequence.sensor)
    }

    /// What extracts features of the left image; with a network that selects among them, its candidates.
    ///
    /// # Errors
    /// As [`Input::mask`].
    pub fn extractor(&self) -> Result<Extractor, Error> {
        let config = setup::extractor(&self.features());
        let mask = self.mask(&config)?;
        Ok(Extractor::new(config).with_mask(mask.map(Arc::new)))
    }

    /// The camera after reduction and rectification.
    ///
    /// # Errors
    /// A camera that nobody gives.
    pub fn rig(&self) -> Result<Rig, Error> {
        setup::rig(&self.config, self.sequence.sensor, self.size, &self.path)
    }

    /// Camera, parameters, mask and network of a run, without vocabulary.
    ///
    /// # Errors
    /// A camera that nobody gives, a mask or a network that cannot be used.
    pub fn setup(&self, options: &NetworkOptions) -> Result<Setup, Error> {
        let mut setup = setup::from_config(&self.config, self.sequence.sensor, self.rig()?);
        setup.mask = self.mask(&setup.extractor)?.map(Arc::new);
        setup.selection = network::selection(&self.features(), options)?;
        Ok(setup)
    }
}

/// The configuration with what the sequence knows better, its camera and its frame rate; and what the user should know of it.
fn in_force(config: &Config, sequence: &Sequence) -> (Config, Vec<String>) {
    let mut config = config.clone();
    let mut notices = sequence.warnings.clone();
    if let Some(calibration) = &sequence.calibration {
        notices.extend(config.apply_calibration(calibration));
    }
    let source = sequence.calibration.as_ref().map_or(&sequence.name, |calibration| &calibration.source);
    notices.extend(sequence.frame_rate_hz.and_then(|rate| config.apply_frame_rate(rate, source)));
    (config, notices)
}
