//! How much a perfect network could bring, and how much of it the network brings: a rendered sequence run with the configuration
//! `kitti` and features selected by the renderer's exact masks (0 on what moves, 1 elsewhere), by a network that answers 1
//! everywhere, by the built-in network, and by response alone. Only what gives the activation differs; the refinement of the
//! calibration is off.
//!
//! `cargo run --release -p dsslam-tests --example oracle_selection -- SEQUENCE [MAX_FRAMES [KEY=VALUE ...]]`
#![allow(clippy::print_stdout, reason = "a program for people")]

use std::collections::BTreeMap;
use std::error::Error;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use dsslam::{Config, Input, InputOptions, NetworkOptions};
use eval::{Estimate, Evaluation, EvaluationOptions};
use features::{ActivationError, ActivationMap, ActivationSource};
use geometry::{GrayImage, Raster};
use io::{Sequence, Trajectory};
use runtime::{Preparation, RunOutcome, Selection, SequenceFeed, Setup, Silent};

/// Pixels of an image per value of its activation map, in both directions.
const CELL: usize = 8;
/// Above every run, so that only the features differ.
const COMMON: &str = "mapping.refine_calibration=false";

type Failure = Box<dyn Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, rest @ ..] = &arguments[..] else {
        return Err("usage: oracle_selection SEQUENCE [MAX_FRAMES [KEY=VALUE ...]]".into());
    };
    let (max_frames, given) = match rest {
        [number, given @ ..] => (Some(number.parse()?), given),
        [] => (None, rest),
    };
    let sequence = io::open_sequence(Path::new(path), Some(io::Sensor::Stereo))?;
    let truth = sequence.ground_truth.clone().ok_or("the sequence has no true poses")?;
    let feed = SequenceFeed::prepared(&sequence, Preparation::new(&sequence, 1.0), max_frames);
    let masks = Arc::new(Masks::read(&sequence, max_frames)?);
    println!("{}: {:.1} % of the pixels move", sequence.name, 100.0 * masks.share_moving);
    let network = Arc::new(dsfeat::Network::load(dsfeat::BUILT_IN, None, 1)?);
    let sources: [(&str, Arc<dyn ActivationSource>); 3] =
        [("exact masks", masks), ("ones", Arc::new(Ones)), ("activation", network)];
    let mut errors = Vec::new();
    for (name, source) in sources {
        let setup = setup(Path::new(path), given, Some(source))?;
        errors.push(report(name, &run(&feed, &setup)?, &truth)?);
    }
    for keep in ["500", "2000"] {
        let response = ["features.selection=response".to_owned(), format!("features.keep={keep}")];
        let setup = setup(Path::new(path), &[given, &response].concat(), None)?;
        report(&format!("response {keep}"), &run(&feed, &setup)?, &truth)?;
    }
    let [oracle, ones, activation] = errors[..] else { return Ok(()) };
    println!(
        "of what the masks gain over ones, the network recovers {:.2}",
        (ones - activation) / (ones - oracle)
    );
    Ok(())
}

/// The setup of the configuration with these settings above it, as the program has it, but for what gives the activation.
fn setup(path: &Path, given: &[String], source: Option<Arc<dyn ActivationSource>>) -> Result<Setup, Failure> {
    let config = Config::load(Some(Path::new("kitti")), &[&[COMMON.to_owned()], given].concat())?;
    let mut options = InputOptions::default();
    options.sensor = Some(io::Sensor::Stereo);
    let mut setup = Input::open(path, &config, &options)?.setup(&NetworkOptions::default())?;
    let choice = config.features.choice();
    setup.selection = source.zip(choice).map(|(source, config)| Selection { config, source, identity: 1 });
    setup.vocabulary = Some(dsslam::vocabulary(None)?);
    Ok(setup)
}

fn run(feed: &SequenceFeed, setup: &Setup) -> Result<RunOutcome, Failure> {
    Ok(runtime::run(feed, setup, &mut Silent, &AtomicBool::new(false))?)
}

/// Prints the figures of a run and returns its ATE, meters.
fn report(name: &str, outcome: &RunOutcome, truth: &Trajectory) -> Result<f64, Failure> {
    let estimate =
        Estimate::new(outcome.frames.iter().map(|frame| (frame.timestamp_s, frame.world_from_cam)));
    let evaluation = Evaluation::of(&estimate, truth, &EvaluationOptions::default())?;
    let ate = evaluation.ate_m.rmse;
    println!(
        "{name:<14} ATE {ate:.4} m, {} of {} frames lost, loops {}",
        evaluation.coverage.n_lost,
        outcome.frames.len(),
        outcome.loops.len()
    );
    Ok(ate)
}

/// A network that trusts everything.
#[derive(Clone, Copy, Debug)]
struct Ones;

impl ActivationSource for Ones {
    fn activation(&self, image: &GrayImage) -> Result<ActivationMap, ActivationError> {
        ActivationMap::new(Raster::new(1, 1, 1.0), image.width, image.height).ok_or(ActivationError::Unknown)
    }
}

/// The masks of a sequence, found by the hash of their image.
#[derive(Clone, Debug)]
struct Masks {
    maps: BTreeMap<u64, ActivationMap>,
    /// Share of the pixels of all frames.
    share_moving: f64,
}

impl Masks {
    fn read(sequence: &Sequence, max_frames: Option<usize>) -> Result<Self, Failure> {
        let (mut maps, mut moving, mut all) = (BTreeMap::new(), 0, 0);
        for frame in sequence.frames.iter().take(max_frames.unwrap_or(usize::MAX)) {
            let folder = frame.left.parent().and_then(Path::parent).ok_or("an image without a folder")?;
            let name = frame.left.file_name().ok_or("an image without a name")?;
            let mask = io::load_gray(&folder.join("masks").join(name))?;
            moving += mask.data.iter().filter(|&&label| label == synth::LABEL_MOVING).count();
            all += mask.data.len();
            maps.insert(hash(&io::load_gray(&frame.left)?), still(&mask).ok_or("an empty mask")?);
        }
        Ok(Masks { maps, share_moving: moving as f64 / all.max(1) as f64 })
    }
}

/// 1 where nothing of a cell, or of the cells beside it, moves.
fn still(mask: &GrayImage) -> Option<ActivationMap> {
    let (columns, rows) = (mask.width.div_ceil(CELL), mask.height.div_ceil(CELL));
    let values = Raster::from_fn(columns, rows, |i, j| {
        let range = |at: usize, len: usize| {
            (CELL * at).saturating_sub(CELL / 2)..(CELL * (at + 1) + CELL / 2).min(len)
        };
        let moves = range(j, mask.height)
            .any(|y| range(i, mask.width).any(|x| mask.get(x, y) == Some(synth::LABEL_MOVING)));
        if moves { 0.0 } else { 1.0 }
    });
    ActivationMap::new(values, mask.width, mask.height)
}

fn hash(image: &GrayImage) -> u64 {
    let mut hasher = DefaultHasher::new();
    image.data.hash(&mut hasher);
    hasher.finish()
}

impl ActivationSource for Masks {
    fn activation(&self, image: &GrayImage) -> Result<ActivationMap, ActivationError> {
        self.maps.get(&hash(image)).cloned().ok_or(ActivationError::Unknown)
    }
}
