//! Which of the candidates become features: by activation, or by response among those on trusted places.

use crate::activation::ActivationMap;
use crate::quadtree::{Corner, Quadtree};

/// Activation below this belongs to what moves.
pub(crate) const TRUSTED: f32 = 0.5;
/// Steps of activation that count as different. The network is nearly sure of most places, and differences among those say
/// less about a feature than its response does.
const STEPS: f32 = 8.0;

/// By what candidates are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelectionRule {
    /// Places on what may move are given up (activation below one half), of the others the strongest responses are kept.
    Semantic,
    /// The highest activation, in steps of an eighth, and of equal steps the strongest response.
    Activation,
}

/// Whether the features kept are spread over the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spread {
    /// The image is divided into as many cells as features are wanted, the fuller the finer, and each keeps its best.
    #[default]
    Cells,
    /// The best of the image, wherever they are.
    Anywhere,
}

/// How features are chosen among the candidates of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectionConfig {
    /// By what.
    pub rule: SelectionRule,
    /// Most features that are kept.
    pub keep: usize,
    /// Whether they are spread over the image.
    pub spread: Spread,
}

/// What may become a feature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contender {
    /// Column on the full image, pixels.
    pub x: f32,
    /// Row on the full image, pixels.
    pub y: f32,
    /// How strong it is; of corners the FAST score.
    pub response: u8,
}

/// The contenders kept, as ascending indices, and the activation of each of them.
///
/// Trusted places come first and are spread over the image of `size` pixels. Where they are fewer than wanted, the others
/// fill up in falling order of activation, but never under [`SelectionRule::Semantic`]. Ties go to the lower index.
#[must_use]
pub fn select(
    contenders: &[Contender],
    map: &ActivationMap,
    config: &SelectionConfig,
    size: (usize, usize),
) -> (Vec<usize>, Vec<f32>) {
    let activation: Vec<f32> = contenders.iter().map(|c| map.at(c.x, c.y)).collect();
    let step = |i: usize| match config.rule {
        SelectionRule::Activation => (activation[i] * STEPS) as u8,
        SelectionRule::Semantic => 0,
    };
    let mut ranked: Vec<usize> = (0..contenders.len()).collect();
    ranked.sort_by_key(|&i| std::cmp::Reverse((step(i), contenders[i].response)));
    let (trusted, rest): (Vec<usize>, Vec<usize>) = ranked.iter().partition(|&&i| activation[i] >= TRUSTED);
    let mut kept = match config.spread {
        Spread::Anywhere => trusted.into_iter().take(config.keep).collect(),
        Spread::Cells => spread(contenders, &trusted, config.keep, size),
    };
    if config.rule == SelectionRule::Activation {
        let missing = config.keep - kept.len();
        kept.extend(rest.into_iter().take(missing));
    }
    kept.sort_unstable();
    let activation = kept.iter().map(|&i| activation[i]).collect();
    (kept, activation)
}

/// At most `keep` of `ranked`, best first, each the best of its cell.
fn spread(contenders: &[Contender], ranked: &[usize], keep: usize, size: (usize, usize)) -> Vec<usize> {
    let side = |length: usize| length.clamp(1, usize::from(u16::MAX)) as u16;
    let (width, height) = (side(size.0), side(size.1));
    // Equal scores: of a cell the first in rank is kept.
    let corner = |&i: &usize| {
        let place = |p: f32, len: u16| (p.round().max(0.0) as u16).min(len - 1);
        Corner { x: place(contenders[i].x, width), y: place(contenders[i].y, height), score: 0 }
    };
    let corners: Vec<Corner> = ranked.iter().map(corner).collect();
    let chosen = Quadtree::default().choose(&corners, [0, 0, width, height], keep);
    chosen.into_iter().map(|i| ranked[i]).collect()
}
