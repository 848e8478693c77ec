//! `dsslam run`: SLAM on a dataset, a video or a camera. Everything that can be checked is checked before the first image is processed.

use std::path::Path;
use std::sync::Arc;

use io::{Config, ImageSize, OpenOptions, Sequence, open_sequence_with};
use runtime::{FrameFeed, Preparation, SequenceFeed};

use crate::args::RunArgs;
use crate::clock::StopWatch;
use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::job::{self, Job};
use crate::network;
use crate::places;
use crate::results::ResultsFolder;
use crate::setup;
use crate::show;
use crate::stop;
use crate::summary::Context;
use crate::video::{self, Opened};
use crate::video_feed::VideoFeed;

/// Runs SLAM on the sequence that the arguments name.
///
/// # Errors
/// A configuration, a dataset or an output folder that cannot be used.
pub(crate) fn run(args: &RunArgs) -> Result<Exit, Failure> {
    let watch = StopWatch::start();
    let mut config = args.settings.load_with(&no_loops(args)).or_input()?;
    let source = Source::open(args, &config)?;
    let sequence = source.sequence().clone();
    let mut notices = sequence.warnings.clone();
    if let Some(calibration) = &sequence.calibration {
        notices.extend(config.apply_calibration(calibration));
    }
    let rate_source =
        sequence.calibration.as_ref().map_or(sequence.name.as_str(), |calibration| &calibration.source);
    notices.extend(sequence.frame_rate_hz.and_then(|rate| config.apply_frame_rate(rate, rate_source)));
    let size = source.image_size(&config).or_input()?;
    let mut setup = setup::from_config(&config, sequence.sensor, size, &args.sequence).or_input()?;
    let preparation = Preparation::new(&sequence, config.input.scale);
    let wanted = setup::wanted_mask(&config, size).or_input()?;
    setup.mask = preparation.mask(&setup.extractor, wanted.as_ref()).map(Arc::new);
    setup.selection =
        network::selection(&config.features.with_sensor(sequence.sensor), &args.network).or_input()?;
    places::complete(&mut setup, args, sequence.sensor)?;
    if video::is_camera(&args.sequence) && setup.calibration_frames > 0 {
        setup.calibration_frames = 0;
        notices.push(
            "stereo.calibration_frames: a camera cannot be seen twice, so there is no calibration pass"
                .to_owned(),
        );
    }
    let replay = places::journal(args).or_input()?;
    let extras = places::extras(args).or_output()?;
    let viewer = show::viewer(&args.show)?;
    let stop = stop::on_signal();
    let folder = ResultsFolder::create(args.out.as_deref(), Path::new(""), &sequence.name).or_output()?;
    for notice in &notices {
        console::note(console::warning(notice));
    }
    let feed = source.feed(&sequence, preparation, args.max_frames.map(|n| n as usize));
    let job = Job {
        feed: feed.as_ref(),
        config_yaml: config.to_yaml(),
        ground_truth: sequence.ground_truth.as_ref(),
        body_from_left: sequence.body_from_left,
        context: Context {
            sequence: sequence.name.clone(),
            sensor: sequence.sensor,
            seed: setup.slam.seed,
            schedule: job::schedule_name(&setup, replay.is_some()),
            notices,
        },
        setup,
        replay,
        folder,
        extras,
        show: args.show.clone(),
        viewer,
        json: args.json,
        watch,
    };
    job::execute(job, &stop).map(|(_, exit)| exit)
}

/// What `--no-loops` overrides.
fn no_loops(args: &RunArgs) -> Vec<String> {
    args.no_loops.then(|| "loops.enabled=false".to_owned()).into_iter().collect()
}

/// Where the frames come from.
enum Source {
    Folder(Box<Sequence>),
    Video(Box<Opened>),
}

impl Source {
    /// Opens a folder, a video or a camera with the sensor of the arguments, else of the configuration, else what there is.
    fn open(args: &RunArgs, config: &Config) -> Result<Self, Failure> {
        let options = OpenOptions {
            sensor: args.sensor.or(config.input.sensor),
            association_tolerance_s: config.input.association_tolerance_s,
            calibration: args.calib.clone(),
            frame_rate_hz: config.camera.fps,
        };
        let path = args.sequence.as_path();
        if video::is_video(path) || video::is_camera(path) {
            return Ok(Self::Video(Box::new(Opened::new(path, &options).or_input()?)));
        }
        Ok(Self::Folder(Box::new(open_sequence_with(path, &options).or_input()?)))
    }

    fn sequence(&self) -> &Sequence {
        match self {
            Self::Folder(sequence) => sequence,
            Self::Video(opened) => opened.sequence(),
        }
    }

    /// Size of the raw images of one camera, compared with the configuration.
    fn image_size(&self, config: &Config) -> anyhow::Result<ImageSize> {
        match self {
            Self::Folder(sequence) => setup::image_size(sequence, config),
            Self::Video(opened) => {
                setup::check_size(opened.video.size, &opened.path, config)?;
                Ok(opened.video.size)
            }
        }
    }

    fn feed<'a>(
        self,
        sequence: &'a Sequence,
        preparation: Preparation,
        max_frames: Option<usize>,
    ) -> Box<dyn FrameFeed + 'a> {
        match self {
            Self::Folder(_) => Box::new(SequenceFeed::prepared(sequence, preparation, max_frames)),
            Self::Video(opened) => Box::new(VideoFeed::new(*opened, preparation, max_frames)),
        }
    }
}
