//! `dsslam features`: the key-points of an image.

use std::path::PathBuf;

use clap::Args;
use draw::{Canvas, PALETTE, Strip, Stroke, Swatch};
use features::{Extractor, ExtractorConfig, Features, Keypoint};
use geometry::{GrayImage, Vec2};

use super::input::{self, SettingsArgs};
use super::{row, save, zoom_for};
use crate::exit::{Exit, Failure, OrExit};

/// Radius of a ring in pixels of its key-point's level: a quarter of the patch that is described, so that rings stay apart.
const RING_PX: f64 = 4.0;

/// Arguments of `dsslam features`.
#[derive(Debug, Args)]
pub(crate) struct FeaturesArgs {
    /// An image, or the folder of a sequence.
    #[arg(value_name = "IMAGE|SEQUENCE")]
    input: PathBuf,
    /// Number of the sequence's frame; by default its first.
    #[arg(long, value_name = "N")]
    frame: Option<u32>,
    /// The picture to write (PNG).
    #[arg(short, long, value_name = "PNG")]
    out: PathBuf,
    /// The configuration.
    #[command(flatten)]
    settings: SettingsArgs,
}

impl FeaturesArgs {
    /// Extracts, counts and draws.
    ///
    /// # Errors
    /// An image or a configuration that cannot be used, a picture that cannot be written.
    pub(crate) fn run(&self) -> Result<Exit, Failure> {
        let config = self.settings.load().or_input()?;
        let extraction = input::extractor(&config);
        let picture = input::picture(&self.input, self.frame, config).or_input()?;
        let features = Extractor::new(extraction.clone()).extract(&picture.image);
        let counts = count(&features, extraction.levels);
        row("image", &format!("{} ({}x{})", picture.name, picture.image.width, picture.image.height));
        row("features", &format!("{} of at most {}", features.keypoints.len(), extraction.keep));
        row("by octave", &counts.iter().map(usize::to_string).collect::<Vec<_>>().join(" "));
        row("response", &responses(&features));
        save(&self.out, &drawn(&picture.image, &picture.name, &features, &extraction))
    }
}

/// Key-points per octave.
fn count(features: &Features, levels: usize) -> Vec<usize> {
    let mut counts = vec![0; levels];
    for keypoint in &features.keypoints {
        counts[usize::from(keypoint.octave)] += 1;
    }
    counts
}

fn responses(features: &Features) -> String {
    let mut responses: Vec<f32> = features.keypoints.iter().map(|k| k.response).collect();
    responses.sort_by(f32::total_cmp);
    match (responses.first(), responses.get(responses.len() / 2), responses.last()) {
        (Some(least), Some(median), Some(most)) => format!("{least} to {most}, median {median}"),
        _ => "none".to_owned(),
    }
}

/// Large rings first, so that small ones stay visible.
fn drawn(image: &GrayImage, name: &str, features: &Features, extraction: &ExtractorConfig) -> Canvas {
    let zoom = zoom_for(image.width);
    let mut canvas = Canvas::of_gray(image, zoom);
    canvas.wash([0, 0, 0], 0.25);
    for keypoint in features.keypoints.iter().rev() {
        mark(&mut canvas, keypoint, zoom, extraction.scale_factor);
    }
    let counts = count(features, extraction.levels);
    let octave = |(octave, n): (usize, &usize)| Swatch::kind(color(octave), format!("octave {octave}: {n}"));
    let strip = Strip {
        title: format!("{name}: {} ORB features; ring: scale, line: orientation", features.keypoints.len()),
        swatches: counts.iter().enumerate().map(octave).collect(),
    };
    let strip = strip.drawn(canvas.image.width);
    Canvas::stacked(&[canvas, strip])
}

fn color(octave: usize) -> draw::Color {
    PALETTE[octave % PALETTE.len()]
}

fn mark(canvas: &mut Canvas, keypoint: &Keypoint, zoom: usize, scale_factor: f32) {
    let at = Canvas::magnified(&Vec2::new(f64::from(keypoint.x), f64::from(keypoint.y)), zoom);
    let scale = f64::from(scale_factor).powi(i32::from(keypoint.octave));
    let radius_px = RING_PX * scale * zoom as f64;
    let (sin, cos) = f64::from(keypoint.angle_deg).to_radians().sin_cos();
    let stroke = Stroke { color: color(usize::from(keypoint.octave)), width_px: 1.2 };
    canvas.ring(&at, radius_px, stroke);
    canvas.line(&at, &(at + Vec2::new(cos, sin) * radius_px), stroke);
}
