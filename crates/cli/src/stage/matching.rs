//! `dsslam inspect match`: the matches of two images and which of them one motion explains.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use draw::{Canvas, Color, Strip, Stroke, Swatch};
use features::{Features, match_brute_force};
use geometry::{FundamentalEstimator, Mat3, RansacOptions, Vec2, mix_seed, ransac};

use super::input::{Frames, Picture, picture};
use super::{row, save};
use crate::args::{NetworkArgs, SettingsArgs};
use crate::exit::{Exit, Failure, OrExit};

/// Arguments of `dsslam inspect match`.
#[derive(Debug, Args)]
pub(crate) struct MatchArgs {
    /// An image, or with --frames the folder of a sequence.
    #[arg(value_name = "A")]
    a: PathBuf,
    /// Another image.
    #[arg(value_name = "B", required_unless_present = "frames", conflicts_with = "frames")]
    b: Option<PathBuf>,
    /// Numbers of two frames of the sequence A.
    #[arg(long, value_names = ["I", "J"], num_args = 2)]
    frames: Option<Vec<u32>>,
    /// The picture to write (PNG).
    #[arg(short, long, value_name = "PNG")]
    out: PathBuf,
    /// Maximum number of differing bits, of 256.
    #[arg(long, value_name = "BITS", default_value_t = 50)]
    max_distance: u32,
    /// Ratio test: the best match must differ in less than this fraction of the second best's bits.
    #[arg(long, value_name = "SHARE", default_value_t = 0.9)]
    ratio: f32,
    /// Maximum distance from the epipolar line, pixels.
    #[arg(long, value_name = "PX", default_value_t = 1.5)]
    threshold: f64,
    /// Also matches the remaining features along their epipolar lines.
    #[arg(long)]
    guided: bool,
    /// The configuration.
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Two images with their features.
struct Pair {
    pictures: [Picture; 2],
    features: [Features; 2],
    /// Positions without the lens's distortion, where it is known.
    pixels: [Vec<Vec2>; 2],
}

/// Pairs of feature indices.
#[derive(Default)]
struct Matches {
    inliers: Vec<(u32, u32)>,
    outliers: Vec<(u32, u32)>,
    guided: Vec<(u32, u32)>,
    samples: usize,
}

const INLIER: Color = [0, 225, 150];
const OUTLIER: Color = [255, 95, 30];
const GUIDED: Color = [110, 190, 255];
/// Purpose of the random numbers, for the seed.
const PURPOSE: u64 = 0x6d61;

impl MatchArgs {
    /// Matches, sorts the matches, counts and draws them.
    ///
    /// # Errors
    /// Images or a configuration that cannot be used, a picture that cannot be written.
    pub(crate) fn run(&self) -> Result<Exit, Failure> {
        let pair = self.pair().or_input()?;
        let matches = self.matches(&pair);
        for (name, (picture, features)) in ["a", "b"].iter().zip(pair.pictures.iter().zip(&pair.features)) {
            let size = format!("{}x{}", picture.image.width, picture.image.height);
            row(name, &format!("{} ({size}), {} features", picture.name, features.keypoints.len()));
        }
        let n = matches.inliers.len() + matches.outliers.len();
        row("matches", &format!("{n} (mutual, at most {} bits, ratio {})", self.max_distance, self.ratio));
        let motion = match matches.samples {
            0 => "no fundamental matrix found".to_owned(),
            samples => {
                format!("within {} px of a fundamental matrix ({samples} samples)", self.threshold)
            }
        };
        row("inliers", &format!("{} {motion}", matches.inliers.len()));
        row("outliers", &matches.outliers.len().to_string());
        if self.guided {
            row("guided", &format!("{} more along epipolar lines", matches.guided.len()));
        }
        save(&self.out, &drawn(&pair, &matches, self.guided))
    }

    fn pair(&self) -> Result<Pair> {
        let config = self.settings.load_for(&self.a, &NetworkArgs::default())?.config;
        if let (Some(numbers), true) = (&self.frames, self.a.is_dir()) {
            let frames = Frames::open(&self.a, None, &config)?;
            let pictures = [frames.picture(Some(numbers[0]))?, frames.picture(Some(numbers[1]))?];
            // Without a camera the lens is unknown.
            let rig = frames.input.rig().ok();
            let ideal = |pixel: Vec2| rig.as_ref().map_or(pixel, |rig| rig.undistort(&pixel));
            return Ok(Pair::of(pictures, ideal));
        }
        let Some(b) = &self.b else {
            bail!("{}: found an image, but --frames needs a sequence", self.a.display());
        };
        if let Some(folder) = [&self.a, b].into_iter().find(|path| path.is_dir()) {
            bail!(
                "{}: found a folder, expected an image (or --frames I J with a sequence)",
                folder.display()
            );
        }
        let pictures = [picture(&self.a, None, &config)?, picture(b, None, &config)?];
        Ok(Pair::of(pictures, |pixel| pixel))
    }

    fn matches(&self, pair: &Pair) -> Matches {
        let [a, b] = &pair.features;
        let all = match_brute_force(&a.descriptors, &b.descriptors, self.max_distance, self.ratio);
        let pixels_a: Vec<Vec2> = all.iter().map(|m| pair.pixels[0][m.0 as usize]).collect();
        let pixels_b: Vec<Vec2> = all.iter().map(|m| pair.pixels[1][m.1 as usize]).collect();
        let estimator = FundamentalEstimator::new(&pixels_a, &pixels_b, self.threshold * self.threshold);
        let options = RansacOptions {
            sample_size: FundamentalEstimator::SAMPLE_SIZE,
            max_iterations: 5000,
            confidence: 0.999,
            seed: mix_seed(0, 0, PURPOSE),
        };
        let Some(found) = ransac(&estimator, None, &options) else {
            return Matches { outliers: all, ..Matches::default() };
        };
        let is_inlier = |i: usize| found.inliers.binary_search(&i).is_ok();
        let (inliers, outliers): (Vec<_>, Vec<_>) = (0..all.len()).partition(|&i| is_inlier(i));
        let of = |indices: Vec<usize>| -> Vec<(u32, u32)> { indices.into_iter().map(|i| all[i]).collect() };
        let (inliers, outliers) = (of(inliers), of(outliers));
        let guided = if self.guided { self.guided_matches(pair, &found.model, &inliers) } else { Vec::new() };
        Matches { inliers, outliers, guided, samples: found.iterations }
    }

    /// Features that are left, each with the most similar one near its epipolar line and within one octave; of several that want the
    /// same the most similar gets it, ties by index.
    fn guided_matches(&self, pair: &Pair, fundamental: &Mat3, taken: &[(u32, u32)]) -> Vec<(u32, u32)> {
        let [a, b] = &pair.features;
        let mut free = [vec![true; a.keypoints.len()], vec![true; b.keypoints.len()]];
        for &(i, j) in taken {
            (free[0][i as usize], free[1][j as usize]) = (false, false);
        }
        let mut wishes: Vec<(u32, u32, u32)> = Vec::new();
        for i in (0..a.keypoints.len()).filter(|&i| free[0][i]) {
            let near = |j: &usize| {
                let octaves = a.keypoints[i].octave.abs_diff(b.keypoints[*j].octave);
                let (pixel_a, pixel_b) = (&pair.pixels[0][i], &pair.pixels[1][*j]);
                let error_sq = geometry::sampson_error_sq(fundamental, pixel_a, pixel_b);
                free[1][*j] && octaves <= 1 && error_sq <= self.threshold * self.threshold
            };
            let distance = |j: usize| (a.descriptors[i].distance(&b.descriptors[j]), i as u32, j as u32);
            let mut candidates: Vec<_> = (0..b.keypoints.len()).filter(near).map(distance).collect();
            candidates.sort_unstable();
            let Some(&best) = candidates.first() else { continue };
            let stands_out =
                candidates.get(1).is_none_or(|next| (best.0 as f32) < self.ratio * next.0 as f32);
            if best.0 <= self.max_distance && stands_out {
                wishes.push(best);
            }
        }
        wishes.sort_unstable();
        let mut matches = Vec::new();
        for (_, i, j) in wishes {
            if std::mem::replace(&mut free[1][j as usize], false) {
                matches.push((i, j));
            }
        }
        matches
    }
}

impl Pair {
    fn of(mut pictures: [Picture; 2], ideal: impl Fn(Vec2) -> Vec2) -> Self {
        let features = pictures.each_mut().map(|picture| picture.extractor.extract(&picture.image));
        let pixels = [0, 1]
            .map(|side| features[side].keypoints.iter().map(|keypoint| ideal(keypoint.pixel())).collect());
        Self { pictures, features, pixels }
    }
}

/// Wide images one below the other, others side by side; outliers first, so that inliers lie over them.
fn drawn(pair: &Pair, matches: &Matches, with_guided: bool) -> Canvas {
    let [a, b] = [0, 1].map(|side: usize| Canvas::of_gray(&pair.pictures[side].image, 1));
    let stack = a.image.width >= 2 * a.image.height;
    let offset =
        if stack { Vec2::new(0.0, a.image.height as f64) } else { Vec2::new(a.image.width as f64, 0.0) };
    let mut canvas = if stack { Canvas::stacked(&[a, b]) } else { side_by_side(&a, &b) };
    canvas.wash([0, 0, 0], 0.35);
    let kinds = [(&matches.outliers, OUTLIER), (&matches.guided, GUIDED), (&matches.inliers, INLIER)];
    for (pairs, color) in kinds {
        for &(i, j) in pairs {
            let from = pair.features[0].keypoints[i as usize].pixel();
            let to = pair.features[1].keypoints[j as usize].pixel() + offset;
            canvas.line(&from, &to, Stroke { color, width_px: 0.8 });
            canvas.disc(&from, 2.2, color);
            canvas.disc(&to, 2.2, color);
        }
    }
    let mut swatches = vec![
        Swatch::kind(INLIER, format!("inliers: {}", matches.inliers.len())),
        Swatch::kind(OUTLIER, format!("outliers: {}", matches.outliers.len())),
    ];
    if with_guided {
        swatches.push(Swatch::kind(GUIDED, format!("guided: {}", matches.guided.len())));
    }
    let title = format!("{} - {}", short(&pair.pictures[0].name), short(&pair.pictures[1].name));
    let strip = Strip { title, swatches }.drawn(canvas.image.width);
    Canvas::stacked(&[canvas, strip])
}

fn side_by_side(a: &Canvas, b: &Canvas) -> Canvas {
    let height = a.image.height.max(b.image.height);
    let mut whole = Canvas::new(a.image.width + b.image.width, height, draw::WHITE);
    whole.paste(a, 0, 0);
    whole.paste(b, a.image.width, 0);
    whole
}

/// The last part of a path; anything else as it is.
fn short(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}
