//! How much a perfect network could bring: a rendered sequence run with features selected by the renderer's exact masks (0 on
//! what moves, 1 elsewhere) in place of a network, and without any selection, with the same number of features.
//!
//! `cargo run --release -p dsslam-tests --example oracle_selection -- SEQUENCE [KEEP] [MAX_FRAMES]`
#![allow(clippy::print_stdout, reason = "a program for people")]

use std::collections::BTreeMap;
use std::error::Error;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use eval::{Alignment, Association};
use features::{
    ActivationError, ActivationMap, ActivationSource, ExtractorConfig, Rig, SelectionConfig, SelectionRule,
    Spread,
};
use geometry::{GrayImage, Raster};
use io::{Sequence, StampedPose, Trajectory};
use runtime::{RunOutcome, Selection, SequenceFeed, Setup, Silent};

/// Pixels of an image per value of its activation map, in both directions.
const CELL: usize = 8;
/// Candidates among which the selection chooses.
const CANDIDATES: usize = 2000;

type Failure = Box<dyn Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, numbers @ ..] = &arguments[..] else {
        return Err("usage: oracle_selection SEQUENCE [KEEP] [MAX_FRAMES]".into());
    };
    let keep = numbers.first().map_or(Ok(500), |n| n.parse())?;
    let max_frames = numbers.get(1).map(|n| n.parse()).transpose()?;
    let sequence = io::open_sequence(Path::new(path), Some(io::Sensor::Stereo))?;
    let truth = sequence.ground_truth.clone().ok_or("the sequence has no true poses")?;
    let feed = SequenceFeed::new(&sequence, max_frames);
    let masks = Arc::new(Masks::read(&sequence, max_frames)?);
    println!("{}: {keep} features, ATE (SE3)", sequence.name);
    let none = setup(&sequence, keep)?;
    report("no selection", &run(&feed, &none)?, &truth)?;
    let config = SelectionConfig { rule: SelectionRule::Semantic, keep, spread: Spread::Cells };
    for (name, rule) in [
        ("masks, nothing on what moves", SelectionRule::Semantic),
        ("masks, least there", SelectionRule::Activation),
    ] {
        let selection = Some(Selection {
            config: SelectionConfig { rule, ..config },
            source: masks.clone(),
            identity: 1,
        });
        report(name, &run(&feed, &Setup { selection, ..setup(&sequence, CANDIDATES)? })?, &truth)?;
    }
    Ok(())
}

/// The default setup with this number of features or candidates, without a calibration pass.
fn setup(sequence: &Sequence, keep: usize) -> Result<Setup, Failure> {
    let calibration = sequence.calibration.clone().ok_or("the sequence has no calibration")?;
    let image = io::load_gray(&sequence.frames[0].left)?;
    let close_depth_m = 40.0 * calibration.rig.baseline_m;
    let (width, height) = (image.width, image.height);
    let rig = Rig { stereo: calibration.rig, distortion: calibration.distortion, width, height };
    let params = slam::Params::stereo(close_depth_m, 10.0);
    Ok(Setup {
        extractor: ExtractorConfig { keep, fast_initial: 12, ..ExtractorConfig::default() },
        vocabulary: Some(Arc::new(bow::Vocabulary::built_in()?)),
        ..Setup::new(runtime::Sensor::Stereo, Arc::new(rig), params)
    })
}

fn run(feed: &SequenceFeed, setup: &Setup) -> Result<RunOutcome, Failure> {
    Ok(runtime::run(feed, setup, &mut Silent, &AtomicBool::new(false))?)
}

fn report(name: &str, outcome: &RunOutcome, truth: &Trajectory) -> Result<(), Failure> {
    let stamped = |record: &runtime::FrameRecord| {
        let world_from_cam = record.world_from_cam?;
        Some(StampedPose { timestamp_s: record.timestamp_s, world_from_cam })
    };
    let poses: Vec<StampedPose> = outcome.frames.iter().filter_map(stamped).collect();
    let estimate = Trajectory { poses };
    let pairs = eval::associate(&estimate, truth, Association::Timestamp { tolerance_s: 0.001 })?;
    let ate = eval::ate(&pairs.est, &pairs.gt, Alignment::Se3)?;
    let drift = eval::kitti_drift(&ate.aligned(&pairs.est), &pairs.gt, &[50.0, 100.0])?;
    println!(
        "{name:<30} {:.4} m, t_rel over 50 and 100 m {:.3} %, {} of {} frames with a pose, loops {}",
        ate.error_m.rmse,
        drift.t_rel_percent.unwrap_or(f64::NAN),
        estimate.poses.len(),
        outcome.frames.len(),
        outcome.loops.len()
    );
    Ok(())
}

/// The masks of a sequence, found by the hash of their image.
#[derive(Clone, Debug)]
struct Masks {
    maps: BTreeMap<u64, ActivationMap>,
}

impl Masks {
    fn read(sequence: &Sequence, max_frames: Option<usize>) -> Result<Self, Failure> {
        let mut maps = BTreeMap::new();
        for frame in sequence.frames.iter().take(max_frames.unwrap_or(usize::MAX)) {
            let folder = frame.left.parent().and_then(Path::parent).ok_or("an image without a folder")?;
            let name = frame.left.file_name().ok_or("an image without a name")?;
            let mask = io::load_gray(&folder.join("masks").join(name))?;
            maps.insert(hash(&io::load_gray(&frame.left)?), still(&mask).ok_or("an empty mask")?);
        }
        Ok(Masks { maps })
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
