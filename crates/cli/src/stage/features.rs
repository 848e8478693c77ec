//! `dsslam inspect features`: the keypoints of an image, and of a selection by activation also those that it drops.

use std::path::PathBuf;

use clap::Args;
use draw::{Canvas, Color, PALETTE, Strip, Stroke, Swatch};
use features::{ExtractorConfig, Keypoint, SelectionRule};
use geometry::{GrayImage, Vec2};

use super::input::{self, FrameArgs, Picture};
use super::{row, save, zoom_for};
use crate::args::{NetworkArgs, SettingsArgs};
use crate::exit::{Exit, Failure, OrExit};
use crate::selected::Selected;

/// Radius of a ring in pixels of its keypoint's level: a quarter of the patch that is described, so that rings stay apart.
const RING_PX: f64 = 4.0;
/// Colors of what a selection keeps and drops.
const KEPT: Color = [0, 225, 150];
const DROPPED: Color = [255, 95, 30];

/// Arguments of `dsslam inspect features`.
#[derive(Debug, Args)]
pub(crate) struct FeaturesArgs {
    /// An image, or the folder of a sequence.
    #[arg(value_name = "IMAGE|SEQUENCE")]
    input: PathBuf,
    /// Which frame, and the picture.
    #[command(flatten)]
    picture: FrameArgs,
    /// The configuration.
    #[command(flatten)]
    settings: SettingsArgs,
    /// The network that selects features.
    #[command(flatten)]
    network: NetworkArgs,
}

/// What is drawn.
struct Found {
    features: Vec<Keypoint>,
    /// What the selection drops; `None` where all that is extracted is kept.
    selected: Option<Selected>,
}

impl FeaturesArgs {
    /// Extracts, selects, counts and draws.
    ///
    /// # Errors
    /// An image, a configuration or a network that cannot be used, a picture that cannot be written.
    pub(crate) fn run(&self) -> Result<Exit, Failure> {
        let config = self.settings.load_for(&self.input, &self.network).or_input()?.config;
        let mut picture = input::picture(&self.input, self.picture.frame, &config).or_input()?;
        let found = self.find(&mut picture)?;
        let settings = &picture.settings;
        let size = format!("{}x{}", picture.image.width, picture.image.height);
        row("image", &format!("{} ({size})", picture.name));
        row("features", &format!("{} of at most {}", found.features.len(), settings.keep));
        found.tell_selection();
        let counts = count(&found.features, settings.levels);
        row("by octave", &counts.iter().map(usize::to_string).collect::<Vec<_>>().join(" "));
        row("response", &responses(&found.features));
        save(&self.picture.out, &found.drawn(&picture.image, &picture.name, settings))
    }

    fn find(&self, picture: &mut Picture) -> Result<Found, Failure> {
        if picture.settings.selection == SelectionRule::Response {
            let features = picture.extractor.extract(&picture.image).keypoints;
            return Ok(Found { features, selected: None });
        }
        let selected = Selected::of(picture, &self.network).or_input()?;
        Ok(Found { features: selected.kept.keypoints.clone(), selected: Some(selected) })
    }
}

impl Found {
    /// Counts of what the selection keeps and drops.
    fn tell_selection(&self) {
        let Some(selected) = &self.selected else {
            row("selection", "response: all that are extracted are kept");
            return;
        };
        let rule = format!("{:?}", selected.rule.rule).to_lowercase();
        row(
            "selection",
            &format!("{rule}, among {} candidates", self.features.len() + selected.dropped.len()),
        );
        for (name, of) in [("kept", &self.features), ("dropped", &selected.dropped)] {
            row(name, &format!("{}, mean activation {:.3}", of.len(), selected.mean_activation(of)));
        }
    }

    /// What is dropped first, then large rings, so that small ones stay visible.
    fn drawn(&self, image: &GrayImage, name: &str, settings: &ExtractorConfig) -> Canvas {
        let zoom = zoom_for(image.width);
        let mut canvas = Canvas::of_gray(image, zoom);
        canvas.wash([0, 0, 0], 0.25);
        let dropped = self.selected.iter().flat_map(|selected| &selected.dropped);
        dropped.for_each(|keypoint| canvas.disc(&Canvas::magnified(&keypoint.pixel(), zoom), 2.2, DROPPED));
        for keypoint in self.features.iter().rev() {
            let color = if self.selected.is_some() { KEPT } else { color(keypoint.octave.into()) };
            mark(&mut canvas, keypoint, zoom, settings.scale_factor, color);
        }
        let n = self.features.len();
        let strip = match &self.selected {
            None => Strip {
                title: format!("{name}: {n} ORB features; ring: scale, line: orientation"),
                swatches: octaves(&count(&self.features, settings.levels)),
            },
            Some(selected) => Strip {
                title: format!("{name}: {n} ORB features selected; ring: scale, line: orientation"),
                swatches: vec![
                    Swatch::kind(KEPT, format!("kept: {n}")),
                    Swatch::kind(DROPPED, format!("dropped: {}", selected.dropped.len())),
                ],
            },
        };
        let strip = strip.drawn(canvas.image.width);
        Canvas::stacked(&[canvas, strip])
    }
}

/// Keypoints per octave.
fn count(features: &[Keypoint], levels: usize) -> Vec<usize> {
    let mut counts = vec![0; levels];
    for keypoint in features {
        counts[usize::from(keypoint.octave)] += 1;
    }
    counts
}

fn responses(features: &[Keypoint]) -> String {
    let mut responses: Vec<f32> = features.iter().map(|k| k.response).collect();
    responses.sort_by(f32::total_cmp);
    match (responses.first(), responses.get(responses.len() / 2), responses.last()) {
        (Some(least), Some(median), Some(most)) => format!("{least} to {most}, median {median}"),
        _ => "none".to_owned(),
    }
}

fn octaves(counts: &[usize]) -> Vec<Swatch> {
    let octave = |(octave, n): (usize, &usize)| Swatch::kind(color(octave), format!("octave {octave}: {n}"));
    counts.iter().enumerate().map(octave).collect()
}

fn color(octave: usize) -> Color {
    PALETTE[octave % PALETTE.len()]
}

fn mark(canvas: &mut Canvas, keypoint: &Keypoint, zoom: usize, scale_factor: f64, color: Color) {
    let at = Canvas::magnified(&keypoint.pixel(), zoom);
    let scale = scale_factor.powi(i32::from(keypoint.octave));
    let radius_px = RING_PX * scale * zoom as f64;
    let (sin, cos) = f64::from(keypoint.angle_deg).to_radians().sin_cos();
    let stroke = Stroke { color, width_px: 1.2 };
    canvas.ring(&at, radius_px, stroke);
    canvas.line(&at, &(at + Vec2::new(cos, sin) * radius_px), stroke);
}
