//! RANSAC weighted by activation against RANSAC without weights, on the same matches of stereo frames: iterations needed and
//! inliers found at equal confidence, for the fundamental matrix, PnP and Sim3. On a rendered sequence with masks also the
//! share of matches on what moves, and how many models follow it instead of the scene.
//!
//! `cargo run --release -p dsslam-tests --example weighted_ransac -- SEQUENCE [MODEL.onnx]`
#![allow(clippy::print_stdout, reason = "a program for people")]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use features::{
    ActivationMap, DepthConfig, ExtractorConfig, Frame, FrameBuilder, Rig, StereoConfig, match_brute_force,
};
use geometry::{
    Consensus, FundamentalEstimator, GrayImage, Pinhole, PnpEstimator, RansacOptions, SightedPoints,
    SimilarityEstimator, Vec2, Vec3, mix_seed, ransac,
};
use io::Sequence;

/// Frames between the two of a pair.
const STEP: usize = 3;
/// Pairs start at every N-th frame.
const EVERY: usize = 5;
/// Value of what moves in the masks of `dsslam synth`.
const MOVING: u8 = synth::LABEL_MOVING;
/// Pairs with at least this share of matches on what moves are counted apart.
const BUSY: f64 = 0.3;

type Failure = Box<dyn Error>;

/// A frame with its activation map and, on a rendered sequence, its mask.
struct View {
    frame: Frame,
    map: ActivationMap,
    mask: Option<GrayImage>,
}

/// Matches of two views that have depth in both.
struct Pair {
    pixels: [Vec<Vec2>; 2],
    points: [Vec<Vec3>; 2],
    camera: Pinhole,
    /// Product of the activations.
    weights: Vec<f64>,
    /// Whether the match shows something that moves.
    moves: Vec<bool>,
}

/// What runs of one estimator on all pairs gave.
#[derive(Default)]
struct Tally {
    pairs: usize,
    iterations: usize,
    inliers: usize,
    /// Inliers on what stands still.
    still: usize,
    /// Models whose inliers are mostly on what moves.
    astray: usize,
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let (sequence, model) = match &arguments[..] {
        [sequence] => (sequence, dsfeat::BUILT_IN.to_vec()),
        [sequence, model] => (sequence, std::fs::read(model)?),
        _ => return Err("usage: weighted_ransac SEQUENCE [MODEL.onnx]".into()),
    };
    let sequence = io::open_sequence(sequence, Some(io::Sensor::Stereo))?;
    let pairs = pairs(&sequence, &model)?;
    let busy: Vec<&Pair> = pairs.iter().filter(|p| p.share_moving() >= BUSY).collect();
    println!("{}: {} pairs of frames {STEP} apart", sequence.name, pairs.len());
    print_table("all", &pairs.iter().collect::<Vec<_>>());
    if !busy.is_empty() {
        print_table("at least 30 % of the matches on what moves", &busy);
    }
    Ok(())
}

fn pairs(sequence: &Sequence, model: &[u8]) -> Result<Vec<Pair>, Failure> {
    let calibration = sequence.calibration.clone().ok_or("the sequence has no calibration")?;
    let first = io::load_gray(&sequence.frames[0].left)?;
    let (width, height) = (first.width, first.height);
    let rig = Arc::new(Rig { stereo: calibration.rig, distortion: calibration.distortion, width, height });
    let stereo = StereoConfig::default();
    let mut builder = FrameBuilder::new(rig, ExtractorConfig::default(), stereo, DepthConfig::default());
    let network = dsfeat::Network::load(model, None, 1)?;
    let mut view = |i: usize| -> Result<View, Failure> {
        let images = io::load_frame(&sequence.frames[i])?;
        let right = images.right.ok_or("the right image is missing")?;
        let (frame, _) = builder.stereo(i as u32, i as f64, &images.left, &right)?;
        let map = network.answers(&images.left)?.map;
        let mask = mask_of(&sequence.frames[i].left);
        Ok(View {
            frame,
            map,
            mask: mask.filter(|path| path.is_file()).map(|p| io::load_gray(&p)).transpose()?,
        })
    };
    let starts = (0..sequence.frames.len().saturating_sub(STEP)).step_by(EVERY);
    starts.map(|i| Ok(Pair::new(&view(i)?, &view(i + STEP)?))).collect()
}

/// Where `dsslam synth --masks` puts the mask of an image.
fn mask_of(image: &Path) -> Option<PathBuf> {
    Some(image.parent()?.parent()?.join("masks").join(image.file_name()?))
}

impl View {
    fn activation(&self, i: usize) -> f64 {
        let keypoint = &self.frame.keypoints[i];
        f64::from(self.map.at(keypoint.x, keypoint.y))
    }

    fn moves(&self, i: usize) -> bool {
        let keypoint = &self.frame.keypoints[i];
        let (x, y) = (keypoint.x.round() as usize, keypoint.y.round() as usize);
        self.mask.as_ref().is_some_and(|mask| mask.get(x, y) == Some(MOVING))
    }
}

impl Pair {
    fn new(a: &View, b: &View) -> Self {
        let mut pair = Pair {
            pixels: Default::default(),
            points: Default::default(),
            camera: a.frame.rig.stereo.camera,
            weights: Vec::new(),
            moves: Vec::new(),
        };
        for (i, j) in match_brute_force(&a.frame.descriptors, &b.frame.descriptors, 50, 0.8) {
            let (i, j) = (i as usize, j as usize);
            let (Some(point_a), Some(point_b)) = (a.frame.unproject(i), b.frame.unproject(j)) else {
                continue;
            };
            pair.pixels[0].push(a.frame.pixel(i));
            pair.pixels[1].push(b.frame.pixel(j));
            pair.points[0].push(point_a);
            pair.points[1].push(point_b);
            pair.weights.push(a.activation(i) * b.activation(j));
            pair.moves.push(a.moves(i) || b.moves(j));
        }
        pair
    }

    fn share_moving(&self) -> f64 {
        self.moves.iter().filter(|m| **m).count() as f64 / self.moves.len().max(1) as f64
    }
}

fn print_table(title: &str, pairs: &[&Pair]) {
    let moving = pairs.iter().map(|p| p.share_moving()).sum::<f64>() / pairs.len().max(1) as f64;
    println!("\n{title}: {} pairs, {:.1} % of the matches on what moves", pairs.len(), 100.0 * moving);
    println!(
        "{:<14} {:<11} {:>10} {:>8} {:>10} {:>7}",
        "model", "weights", "iterations", "inliers", "still", "astray"
    );
    for (name, of) in [("fundamental", 0), ("PnP", 1), ("Sim3", 2)] {
        for weighted in [false, true] {
            let mut tally = Tally::default();
            for (n, pair) in pairs.iter().enumerate() {
                tally.add(pair, of, weighted, mix_seed(1, n as u64, of));
            }
            let mean = |sum: usize| sum as f64 / tally.pairs.max(1) as f64;
            let weights = if weighted { "activation" } else { "none" };
            println!(
                "{name:<14} {weights:<11} {:>10.1} {:>8.1} {:>10.1} {:>7}",
                mean(tally.iterations),
                mean(tally.inliers),
                mean(tally.still),
                tally.astray
            );
        }
    }
}

impl Tally {
    /// Estimates model number `of` for a pair.
    fn add(&mut self, pair: &Pair, of: u64, weighted: bool, seed: u64) {
        let weights = weighted.then_some(&pair.weights[..]);
        let thresholds = vec![5.991; pair.weights.len()];
        let options = RansacOptions { max_iterations: 2000, confidence: 0.99, seed, sample_size: 3 };
        match of {
            0 => {
                let estimator = FundamentalEstimator::new(&pair.pixels[0], &pair.pixels[1], 3.841);
                let options = RansacOptions { sample_size: FundamentalEstimator::SAMPLE_SIZE, ..options };
                self.count(pair, ransac(&estimator, weights, &options));
            }
            1 => {
                let estimator = PnpEstimator::new(pair.camera, &pair.pixels[1], &pair.points[0], &thresholds);
                self.count(pair, ransac(&estimator, weights, &options));
            }
            _ => {
                let sights = |i: usize| SightedPoints {
                    camera: pair.camera,
                    points_cam: &pair.points[i],
                    pixels: &pair.pixels[i],
                    thresholds_sq: &thresholds,
                };
                let estimator = SimilarityEstimator::new(sights(1), sights(0), true);
                self.count(pair, ransac(&estimator, weights, &options));
            }
        }
    }

    fn count<M>(&mut self, pair: &Pair, found: Option<Consensus<M>>) {
        let Some(found) = found else { return };
        let still = found.inliers.iter().filter(|&&i| !pair.moves[i]).count();
        self.pairs += 1;
        self.iterations += found.iterations;
        self.inliers += found.inliers.len();
        self.still += still;
        self.astray += usize::from(2 * still < found.inliers.len());
    }
}
