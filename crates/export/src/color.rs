//! Colors of the points.

use draw::{Color, gradient};

use crate::scene::Scene;

/// What the color of a point tells where there are no images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tint {
    /// When it was made: dark at the beginning of the map, bright at its end.
    Age,
    /// How many keyframes see it: dark for two, bright for the most, by the logarithm.
    Observations,
}

impl Tint {
    /// A color per point of the scene.
    pub fn colors(self, scene: &Scene) -> Vec<Color> {
        let amounts: Vec<f64> = match self {
            Self::Age => scene.points.iter().map(|point| f64::from(point.created_by)).collect(),
            Self::Observations => scene.points.iter().map(|point| (point.track.len() as f64).ln()).collect(),
        };
        let least = amounts.iter().copied().fold(f64::INFINITY, f64::min);
        let span = amounts.iter().copied().fold(f64::NEG_INFINITY, f64::max) - least;
        amounts.iter().map(|amount| gradient((amount - least) / span.max(f64::MIN_POSITIVE))).collect()
    }
}
