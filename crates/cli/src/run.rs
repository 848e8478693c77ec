//! `dsslam run`: SLAM on a dataset. Everything that can be checked is checked before the first image is processed.

use std::path::Path;

use io::{Config, OpenOptions, Sequence, open_sequence_with};
use runtime::SequenceFeed;

use crate::args::RunArgs;
use crate::clock::StopWatch;
use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::job::{self, Job};
use crate::places;
use crate::results::ResultsFolder;
use crate::setup;
use crate::show;
use crate::stop;
use crate::summary::Context;

/// Runs SLAM on the sequence that the arguments name.
///
/// # Errors
/// A configuration, a dataset or an output folder that cannot be used.
pub(crate) fn run(args: &RunArgs) -> Result<Exit, Failure> {
    let watch = StopWatch::start();
    let mut config = Config::load(args.config.as_deref(), &overrides(args)).or_input()?;
    let sequence = open(args, &config)?;
    let mut notices = sequence.warnings.clone();
    if let Some(calibration) = &sequence.calibration {
        notices.extend(config.apply_calibration(calibration));
    }
    let size = setup::image_size(&sequence, &config).or_input()?;
    let mut setup = setup::from_config(&config, sequence.sensor, size, &args.sequence).or_input()?;
    places::complete(&mut setup, args, sequence.sensor)?;
    let replay = places::journal(args).or_input()?;
    let extras = places::extras(args).or_output()?;
    let viewer = show::viewer(&args.show)?;
    let stop = stop::on_signal();
    let folder = ResultsFolder::create(args.out.as_deref(), Path::new(""), &sequence.name).or_output()?;
    for notice in &notices {
        console::note(console::warning(notice));
    }
    let feed = SequenceFeed::new(&sequence, args.max_frames.map(|n| n as usize));
    let job = Job {
        feed: &feed,
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
        watch,
    };
    job::execute(job, &stop).map(|(_, exit)| exit)
}

/// The keys that the arguments override.
fn overrides(args: &RunArgs) -> Vec<String> {
    let no_loops = args.no_loops.then(|| "loops.enabled=false".to_owned());
    args.overrides.iter().cloned().chain(no_loops).collect()
}

/// The sequence with the sensor of the arguments, else of the configuration, else what the folder offers.
fn open(args: &RunArgs, config: &Config) -> Result<Sequence, Failure> {
    let options = OpenOptions {
        sensor: args.sensor.map(io::Sensor::from).or(config.input.sensor),
        association_tolerance_s: config.input.association_tolerance_s,
    };
    open_sequence_with(&args.sequence, &options).or_input()
}
