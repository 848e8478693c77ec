//! `dsslam activation`: an image, its activation as a heat map, and the features that a selection keeps and drops.

use std::fmt::Write as _;

use anyhow::anyhow;
use dsfeat::{Network, heat_map};
use features::{ActivationMap, ActivationSource, Extractor, Keypoint, SelectionConfig};
use geometry::{GrayImage, Raster};
use io::{Config, FeatureSelection};

use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::network;
use crate::network_args::ActivationArgs;
use crate::setup;

/// Colours of kept and dropped features.
const KEPT: [u8; 3] = [40, 230, 60];
const DROPPED: [u8; 3] = [235, 50, 40];
/// Rows or columns of white between the pictures.
const GAP: usize = 6;

/// Computes the map, draws the picture and prints the counts.
///
/// # Errors
/// An image, a configuration or a network that cannot be used; a picture that cannot be written.
pub(crate) fn run(args: &ActivationArgs) -> Result<Exit, Failure> {
    let image = io::load_gray(&args.image).or_input()?;
    let mut config = Config::load(args.config.as_deref(), &args.overrides).or_input()?;
    config.features.keep = args.keep as usize;
    if config.features.selection == FeatureSelection::Response {
        config.features.selection = FeatureSelection::Activation;
    }
    let (mut net, selection) = network::open(&config.features, &args.network).or_input()?;
    let map = net.activation(&image).or_input()?;
    let mut extractor = Extractor::new(setup::extractor(&config.features));
    let candidates = extractor.extract(&image).keypoints;
    let chosen = extractor.extract_selected(&image, &selection, &mut Known(map.clone()));
    let (kept, _) = chosen.map_err(|reason| anyhow!(reason)).or_input()?;
    let dropped = without(&candidates, &kept.keypoints);
    let picture = beside(&[
        grey(&image),
        heat_map(&image, &map),
        features_drawn(&image, &[(&dropped, DROPPED), (&kept.keypoints, KEPT)]),
    ]);
    io::save_png_rgb(&args.out, &picture).or_output()?;
    console::say(report(&net, &selection, &map, &kept.keypoints, &dropped).trim_end());
    console::say(format!("written    {}", args.out.display()));
    Ok(Exit::Done)
}

/// A map that has been made already.
#[derive(Debug)]
pub(crate) struct Known(pub(crate) ActivationMap);

impl ActivationSource for Known {
    fn activation(&mut self, _: &GrayImage) -> Result<ActivationMap, String> {
        Ok(self.0.clone())
    }
}

fn report(
    net: &Network,
    selection: &SelectionConfig,
    map: &ActivationMap,
    kept: &[Keypoint],
    dropped: &[Keypoint],
) -> String {
    let mean = |features: &[Keypoint]| {
        let sum: f64 = features.iter().map(|k| f64::from(map.at(k.x, k.y))).sum();
        sum / (features.len().max(1)) as f64
    };
    let values = &map.values().data;
    let trusted = values.iter().filter(|&&v| v >= 0.5).count() as f64 / values.len() as f64;
    let (width, height) = net.input_size();
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "network    {width} x {height} pixels, map {} x {}",
        map.values().width,
        map.values().height
    );
    let _ = writeln!(
        text,
        "rule       {:?}, spread {:?}, at most {}",
        selection.rule, selection.spread, selection.keep
    );
    let _ = writeln!(text, "trusted    {:.1} % of the image", 100.0 * trusted);
    let _ = writeln!(text, "kept       {} features, mean activation {:.3}", kept.len(), mean(kept));
    let _ = writeln!(text, "dropped    {} features, mean activation {:.3}", dropped.len(), mean(dropped));
    text
}

/// Those of `all` that are not in `some`; both in the same order.
fn without(all: &[Keypoint], some: &[Keypoint]) -> Vec<Keypoint> {
    let mut some = some.iter().peekable();
    all.iter().filter(|k| some.next_if(|s| s == k).is_none()).copied().collect()
}

fn grey(image: &GrayImage) -> io::Rgb {
    Raster { width: image.width, height: image.height, data: image.data.iter().map(|&v| [v; 3]).collect() }
}

/// The image with a square around each feature.
fn features_drawn(image: &GrayImage, groups: &[(&[Keypoint], [u8; 3])]) -> io::Rgb {
    let mut picture = grey(image);
    for &(features, colour) in groups {
        for feature in features {
            square(&mut picture, (feature.x.round() as i64, feature.y.round() as i64), colour);
        }
    }
    picture
}

/// A square of 5 x 5 pixels, its outline only.
fn square(picture: &mut io::Rgb, (x, y): (i64, i64), colour: [u8; 3]) {
    const REACH: i64 = 2;
    for dy in -REACH..=REACH {
        for dx in (-REACH..=REACH).filter(|dx| dx.abs().max(dy.abs()) == REACH) {
            let (column, row) = (usize::try_from(x + dx), usize::try_from(y + dy));
            let (Ok(column), Ok(row)) = (column, row) else { continue };
            if column < picture.width && row < picture.height {
                picture.row_mut(row)[column] = colour;
            }
        }
    }
}

/// Pictures of equal size side by side, wide ones one below the other.
fn beside(pictures: &[io::Rgb]) -> io::Rgb {
    let Some(first) = pictures.first() else { return Raster::default() };
    let (width, height, n) = (first.width, first.height, pictures.len());
    let is_wide = width > 2 * height;
    let total = |side: usize| n * side + (n - 1) * GAP;
    let (all_width, all_height) = if is_wide { (width, total(height)) } else { (total(width), height) };
    let mut sheet = Raster::new(all_width, all_height, [255; 3]);
    for (i, picture) in pictures.iter().enumerate() {
        let (left, top) = if is_wide { (0, i * (height + GAP)) } else { (i * (width + GAP), 0) };
        for y in 0..height {
            sheet.row_mut(top + y)[left..left + width].copy_from_slice(picture.row(y));
        }
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f32) -> Keypoint {
        Keypoint { x, y: 1.0, ..Keypoint::default() }
    }

    #[test]
    fn what_is_not_kept_is_dropped() {
        let all = [at(1.0), at(2.0), at(3.0), at(4.0)];
        assert_eq!(without(&all, &[at(2.0), at(4.0)]), [at(1.0), at(3.0)]);
        assert_eq!(without(&all, &[]), all);
        assert!(without(&all, &all).is_empty());
    }

    #[test]
    fn wide_pictures_stand_below_each_other_and_others_side_by_side() {
        let wide = beside(&[Raster::new(90, 20, [1; 3]), Raster::new(90, 20, [2; 3])]);
        assert_eq!((wide.width, wide.height, wide.at(0, 0), wide.at(0, 45)), (90, 46, [1; 3], [2; 3]));
        let tall = beside(&[Raster::new(30, 20, [1; 3]), Raster::new(30, 20, [2; 3])]);
        assert_eq!((tall.width, tall.height, tall.at(65, 0)), (66, 20, [2; 3]));
        assert_eq!(tall.at(32, 5), [255; 3], "the gap");
    }

    #[test]
    fn squares_at_the_edge_stay_inside() {
        let image = GrayImage::new(8, 8, 0);
        let picture = features_drawn(&image, &[(&[at(0.0), at(7.0)], KEPT)]);
        assert_eq!((picture.at(2, 1), picture.at(5, 1), picture.at(0, 1)), (KEPT, KEPT, [0; 3]));
    }
}
