//! `dsslam inspect activation`: both answers of the network over an image, and the features that a selection keeps and drops.

use draw::{Canvas, Color, Strip, Swatch};
use dsfeat::{heat_color, heat_map};
use features::SelectionRule;
use geometry::GrayImage;

use crate::args::ActivationArgs;
use crate::exit::{Exit, Failure, OrExit};
use crate::selected::Selected;
use crate::stage::{self, row, save};

/// Colors of kept and dropped features.
const KEPT: Color = [40, 230, 60];
const DROPPED: Color = [235, 50, 40];
/// Radius of the dot of a feature, pixels.
const DOT_PX: f64 = 2.0;

/// Computes the maps, draws the picture and prints the counts.
///
/// # Errors
/// An image, a configuration or a network that cannot be used; a picture that cannot be written.
pub(crate) fn run(args: &ActivationArgs) -> Result<Exit, Failure> {
    let mut config = args.settings.load().or_input()?;
    (config.features.keep, config.features.keep_mono) = (args.keep as usize, None);
    if config.features.selection == SelectionRule::Response {
        config.features.selection = SelectionRule::Activation;
    }
    let mut picture = stage::picture(&args.image, None, &config).or_input()?;
    let selected = Selected::of(&mut picture, &args.network).or_input()?;
    report(&selected, &picture.image);
    save(&args.out, &drawn(&selected, &picture.image))
}

fn report(selected: &Selected, image: &GrayImage) {
    let (map, rule) = (&selected.answers.map, &selected.rule);
    let (width, height) = selected.network.input_size(image.width, image.height);
    let (columns, rows) = (map.values().width, map.values().height);
    row(
        "network",
        &format!("{width} x {height} pixels, map {columns} x {rows}, run by {}", selected.network.runner()),
    );
    if let Some(known) = selected.answers.known {
        row("street", &format!("{:.1} % sure that it is one; elsewhere there is no opinion", 100.0 * known));
    }
    row("rule", &format!("{:?}, spread {:?}, at most {}", rule.rule, rule.spread, rule.keep));
    let share = |trust: &dyn Fn(f32, f32) -> f32| {
        let pixels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x as f32, y as f32)));
        let trusted = pixels.filter(|&(x, y)| trust(x, y) >= 0.5).count();
        100.0 * trusted as f64 / image.data.len() as f64
    };
    row("stays now", &format!("{:.1} % of the image", share(&|x, y| map.at(x, y))));
    row("another day", &format!("{:.1} % of the image", share(&|x, y| map.lasting_at(x, y))));
    for (name, features) in [("kept", &selected.kept.keypoints), ("dropped", &selected.dropped)] {
        let mean = selected.mean_activation(features);
        row(name, &format!("{} features, mean activation {mean:.3}", features.len()));
    }
}

/// Both answers and the features, one below the other, each with what its colors mean.
fn drawn(selected: &Selected, image: &GrayImage) -> Canvas {
    let map = &selected.answers.map;
    let now = Canvas { image: heat_map(image, |x, y| map.at(x, y)) };
    let another_day = Canvas { image: heat_map(image, |x, y| map.lasting_at(x, y)) };
    let mut features = Canvas::of_gray(image, 1);
    for (of, color) in [(&selected.dropped, DROPPED), (&selected.kept.keypoints, KEPT)] {
        of.iter().for_each(|keypoint| features.disc(&keypoint.pixel(), DOT_PX, color));
    }
    let scale = |label: &str| vec![Swatch::scale(|share| heat_color(share as f32), label)];
    let kinds = vec![
        Swatch::kind(KEPT, format!("kept: {}", selected.kept.keypoints.len())),
        Swatch::kind(DROPPED, format!("dropped: {}", selected.dropped.len())),
    ];
    let parts = [
        (now, "activation: does it stay where it is now?", scale("0: moves, 1: stays")),
        (another_day, "lasting: will it be there another day?", scale("0: vehicle or person, 1: stays")),
        (features, "features", kinds),
    ];
    let with_legend = |(canvas, title, swatches): (Canvas, &str, Vec<Swatch>)| {
        let strip = Strip { title: title.to_owned(), swatches }.drawn(canvas.image.width);
        [canvas, strip]
    };
    Canvas::stacked(&parts.into_iter().flat_map(with_legend).collect::<Vec<_>>())
}
