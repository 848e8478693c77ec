//! `dsslam inspect stereo`: the disparities of a stereo frame.

use std::path::PathBuf;

use clap::Args;
use draw::{Canvas, Strip, Swatch, spread};
use features::Frame;
use geometry::GrayImage;
use io::Sensor;

use super::input::{FrameArgs, Frames};
use super::{row, save, zoom_for};
use crate::args::{NetworkArgs, SettingsArgs};
use crate::exit::{Exit, Failure, OrExit};

/// Arguments of `dsslam inspect stereo`.
#[derive(Debug, Args)]
pub(crate) struct StereoArgs {
    /// Folder of a stereo sequence.
    #[arg(value_name = "SEQUENCE")]
    sequence: PathBuf,
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

impl StereoArgs {
    /// Finds the disparities, counts and draws them.
    ///
    /// # Errors
    /// A sequence or a configuration that cannot be used, a picture that cannot be written.
    pub(crate) fn run(&self) -> Result<Exit, Failure> {
        let config = self.settings.load_for(&self.sequence, &self.network).or_input()?.config;
        let frames = Frames::open(&self.sequence, Some(Sensor::Stereo), &config).or_input()?;
        let (info, images) = frames.load(self.picture.frame).or_input()?;
        let name = frames.name_of(info);
        let setup = frames.input.setup(&self.network.options()).or_input()?;
        let right = images.right.unwrap_or_default();
        let mut builder = setup.frame_builder(setup.stereo.disparity_offset_px);
        let (frame, _) = builder.stereo(info.index, info.timestamp_s, &images.left, &right).or_input()?;
        let found = Disparities::of(&frame);
        let (n, of) = (found.marks.len(), frame.len());
        row("frame", &format!("{name} ({}x{})", images.left.width, images.left.height));
        row("features", &of.to_string());
        row("disparities", &format!("{n} ({:.1} %)", 100.0 * n as f64 / of.max(1) as f64));
        let [least, median, most] = found.range_px;
        row("range", &format!("{least:.2} to {most:.2} px, median {median:.2} px"));
        let depth = |px: f64| setup.rig.stereo.depth_from_disparity(px);
        let depths = [most, least, median].map(depth);
        row("depth", &format!("{:.2} to {:.2} m, median {:.2} m", depths[0], depths[1], depths[2]));
        save(&self.picture.out, &found.drawn(&images.left, &name, of))
    }
}

/// What has been found.
struct Disparities {
    /// Index of the feature with its disparity, far ones first.
    marks: Vec<(usize, f64)>,
    /// Least, median and largest, 0 without any.
    range_px: [f64; 3],
    /// Features without one.
    without: Vec<usize>,
    pixels: Vec<geometry::Vec2>,
}

impl Disparities {
    fn of(frame: &Frame) -> Self {
        let disparity = |i: usize| f64::from(frame.keypoints[i].x - frame.right_u[i]);
        let (with, without): (Vec<usize>, Vec<usize>) = (0..frame.len()).partition(|&i| frame.has_depth(i));
        let mut marks: Vec<(usize, f64)> = with.into_iter().map(|i| (i, disparity(i))).collect();
        marks.sort_by(|a, b| a.1.total_cmp(&b.1));
        let at = |i: usize| marks.get(i).map_or(0.0, |mark| mark.1);
        let range_px = [at(0), at(marks.len() / 2), at(marks.len().saturating_sub(1))];
        let pixels = (0..frame.len()).map(|i| frame.pixel(i)).collect();
        Self { marks, range_px, without, pixels }
    }

    /// Red for the nearest, blue for the farthest, by the logarithm.
    fn drawn(&self, image: &GrayImage, name: &str, n_features: usize) -> Canvas {
        let zoom = zoom_for(image.width);
        let mut canvas = Canvas::of_gray(image, zoom);
        canvas.wash([0, 0, 0], 0.25);
        for &i in &self.without {
            canvas.disc(&Canvas::magnified(&self.pixels[i], zoom), 1.6, [200, 200, 200]);
        }
        let [least, _, most] = self.range_px;
        let span = (most / least).ln().max(f64::MIN_POSITIVE);
        for &(i, disparity) in &self.marks {
            let color = spread((most / disparity).ln() / span);
            canvas.disc(&Canvas::magnified(&self.pixels[i], zoom), 3.2, color);
        }
        let label = format!("{most:.1} px (near) to {least:.1} px (far), logarithmic");
        let strip = Strip {
            title: format!("{name}: {} of {n_features} features have a disparity", self.marks.len()),
            swatches: vec![
                Swatch::scale(spread, label),
                Swatch::kind([200, 200, 200], format!("none: {}", self.without.len())),
            ],
        };
        let strip = strip.drawn(canvas.image.width);
        Canvas::stacked(&[canvas, strip])
    }
}
