//! `dsslam inspect activation`: an image, its activation as a heat map, and the features that a selection keeps and drops.

use std::fmt::Write as _;

use dsfeat::heat_map;
use features::{Keypoint, SelectionRule};
use geometry::{GrayImage, Raster};

use crate::args::ActivationArgs;
use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::selected::Selected;
use crate::stage;

/// Colors of kept and dropped features.
const KEPT: [u8; 3] = [40, 230, 60];
const DROPPED: [u8; 3] = [235, 50, 40];
/// Rows or columns of white between the pictures.
const GAP: usize = 6;

/// Computes the map, draws the picture and prints the counts.
///
/// # Errors
/// An image, a configuration or a network that cannot be used; a picture that cannot be written.
pub(crate) fn run(args: &ActivationArgs) -> Result<Exit, Failure> {
    let mut config = args.settings.load().or_input()?;
    config.features.keep = args.keep as usize;
    if config.features.selection == SelectionRule::Response {
        config.features.selection = SelectionRule::Activation;
    }
    let mut picture = stage::picture(&args.image, None, &config).or_input()?;
    let selected = Selected::of(&mut picture, &args.network).or_input()?;
    let image = picture.image;
    let picture = beside(&[
        gray(&image),
        heat_map(&image, &selected.map),
        features_drawn(&image, &[(&selected.dropped, DROPPED), (&selected.kept.keypoints, KEPT)]),
    ]);
    io::save_png_rgb(&args.out, &picture).or_output()?;
    console::say(report(&selected).trim_end());
    console::say(format!("written    {}", args.out.display()));
    Ok(Exit::Done)
}

fn report(selected: &Selected) -> String {
    let (map, rule) = (selected.map.values(), &selected.rule);
    let trusted = map.data.iter().filter(|&&v| v >= 0.5).count() as f64 / map.data.len() as f64;
    let (width, height) = selected.network.input_size();
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "network    {width} x {height} pixels, map {} x {}", map.width, map.height);
    let _ = writeln!(text, "rule       {:?}, spread {:?}, at most {}", rule.rule, rule.spread, rule.keep);
    let _ = writeln!(text, "trusted    {:.1} % of the image", 100.0 * trusted);
    for (name, features) in [("kept", &selected.kept.keypoints), ("dropped", &selected.dropped)] {
        let mean = selected.mean_activation(features);
        let _ = writeln!(text, "{name:<10} {} features, mean activation {mean:.3}", features.len());
    }
    text
}

fn gray(image: &GrayImage) -> io::Rgb {
    Raster { width: image.width, height: image.height, data: image.data.iter().map(|&v| [v; 3]).collect() }
}

/// The image with a square around each feature.
fn features_drawn(image: &GrayImage, groups: &[(&[Keypoint], [u8; 3])]) -> io::Rgb {
    let mut picture = gray(image);
    for &(features, color) in groups {
        for feature in features {
            square(&mut picture, (feature.x.round() as i64, feature.y.round() as i64), color);
        }
    }
    picture
}

/// A square of 5 x 5 pixels, its outline only.
fn square(picture: &mut io::Rgb, (x, y): (i64, i64), color: [u8; 3]) {
    const REACH: i64 = 2;
    for dy in -REACH..=REACH {
        for dx in (-REACH..=REACH).filter(|dx| dx.abs().max(dy.abs()) == REACH) {
            let (column, row) = (usize::try_from(x + dx), usize::try_from(y + dy));
            let (Ok(column), Ok(row)) = (column, row) else { continue };
            if column < picture.width && row < picture.height {
                picture.row_mut(row)[column] = color;
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
