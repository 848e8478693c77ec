//! Which of the candidates become features: by activation, or by response among those on trusted places.

use serde::{Deserialize, Serialize};

use crate::activation::ActivationMap;
use crate::quadtree::{Corner, Quadtree};

/// Activation below this belongs to what moves.
const TRUSTED: f32 = 0.5;
/// Activation below which a place surely moves: it never fills in for trusted places that are missing.
const SURELY_MOVES: f32 = 0.1;
/// Features per cell. Of a larger cell stronger corners are kept, which are found again more often.
const PER_CELL: usize = 4;
/// Steps of activation that count as different. The network is nearly sure of most places, and differences among those say
/// less about a feature than its response does.
const STEPS: f32 = 4.0;

/// By what candidates are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SelectionRule {
    /// The highest activation, in steps of a quarter, and of equal steps the strongest response.
    Activation,
    /// Places on anything that may move, now or another day, are excluded (second answer below one half); of the rest the strongest
    /// responses are kept.
    Semantic,
    /// For recognizing places: as `Activation`, but by both answers multiplied, and nothing below one half while there is enough
    /// else. The evaluation of places uses it; a run selects for tracking as well.
    #[serde(skip)]
    Places,
    /// No network: the strongest response, spread over the image as the extractor does it.
    Response,
}

impl SelectionRule {
    /// Their words in the configuration.
    pub const WORDS: &[&str] = &["activation", "semantic", "response"];
}

/// Whether the features kept are spread over the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Spread {
    /// The image is divided into a quarter as many cells as features are wanted, the fuller the finer, and each keeps its
    /// best four.
    #[default]
    Cells,
    /// The best of the image, wherever they are.
    Anywhere,
}

impl Spread {
    /// Their words in the configuration.
    pub const WORDS: &[&str] = &["cells", "anywhere"];
}

/// How features are chosen among the candidates of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectionConfig {
    /// By what.
    pub rule: SelectionRule,
    /// Maximum number of features kept.
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

/// The contenders kept, as ascending indices.
///
/// Under [`SelectionRule::Activation`] places below `TRUSTED` get a part of what is kept as large as their part of the sum of all
/// activations, and more only where there are too few trusted ones: near hedges and parked cars say much about the motion of the
/// camera, and a network errs; what it is sure of to move gets next to nothing. Under [`SelectionRule::Semantic`] they get
/// nothing, under [`SelectionRule::Places`] what is left over; under [`SelectionRule::Response`] activations do not count. Both
/// groups are spread over the image of `size` pixels. Ties go to the lower index.
pub fn select(
    contenders: &[Contender],
    map: &ActivationMap,
    config: &SelectionConfig,
    size: (usize, usize),
) -> Vec<usize> {
    let trust = |c: &Contender| match config.rule {
        SelectionRule::Semantic => map.lasting_at(c.x, c.y),
        SelectionRule::Places => map.at(c.x, c.y) * map.lasting_at(c.x, c.y),
        SelectionRule::Activation | SelectionRule::Response => map.at(c.x, c.y),
    };
    let activation: Vec<f32> = contenders.iter().map(trust).collect();
    let step = |i: usize| {
        let step = (activation[i] * STEPS).min(STEPS - 1.0) as u8;
        match config.rule {
            SelectionRule::Activation if activation[i] >= SURELY_MOVES => 1 + step,
            SelectionRule::Places => step,
            SelectionRule::Activation | SelectionRule::Semantic | SelectionRule::Response => 0,
        }
    };
    // One word each: from the top step, response and lower index.
    let rank =
        |i: usize| u64::from(step(i)) << 40 | u64::from(contenders[i].response) << 32 | !(i as u32) as u64;
    let mut ranks: Vec<u64> = (0..contenders.len()).map(rank).collect();
    ranks.sort_unstable_by(|a, b| b.cmp(a));
    let ranked = ranks.into_iter().map(|rank| !(rank as u32) as usize);
    let is_trusted = |i: usize| config.rule == SelectionRule::Response || activation[i] >= TRUSTED;
    let (trusted, others): (Vec<usize>, Vec<usize>) = ranked.partition(|&i| is_trusted(i));
    let best = |of: &[usize], n: usize| match config.spread {
        Spread::Anywhere => of.iter().copied().take(n).collect(),
        Spread::Cells => spread(contenders, of, n, size),
    };
    let n_others = match config.rule {
        SelectionRule::Semantic | SelectionRule::Response => 0,
        SelectionRule::Places => others.len().min(config.keep.saturating_sub(trusted.len())),
        SelectionRule::Activation => {
            let sum = |of: &[usize]| of.iter().map(|&i| activation[i]).sum::<f32>();
            let (theirs, rest) = (sum(&others), sum(&trusted));
            let reserve = (config.keep as f32 * theirs / (theirs + rest).max(f32::MIN_POSITIVE)) as usize;
            let doubtful = others.partition_point(|&i| activation[i] >= SURELY_MOVES);
            let missing = config.keep.saturating_sub(trusted.len());
            others.len().min(reserve.max(missing.min(doubtful)))
        }
    };
    let mut kept: Vec<usize> = best(&trusted, config.keep - n_others);
    kept.extend(best(&others, n_others));
    kept.sort_unstable();
    kept
}

/// At most `keep` of `ranked`, best first: the best of each cell, then the second of each, and so on.
fn spread(contenders: &[Contender], ranked: &[usize], keep: usize, size: (usize, usize)) -> Vec<usize> {
    let side = |length: usize| length.clamp(1, usize::from(u16::MAX)) as u16;
    let (width, height) = (side(size.0), side(size.1));
    let place = |p: f32, len: u16| (p.round().max(0.0) as u16).min(len - 1);
    let corner =
        |&i: &usize| Corner { x: place(contenders[i].x, width), y: place(contenders[i].y, height), score: 0 };
    let corners: Vec<Corner> = ranked.iter().map(corner).collect();
    let cells = Quadtree::default().cells(&corners, [0, 0, width, height], keep.div_ceil(PER_CELL));
    // Rank within the cell, then rank in the image: all firsts come before all seconds.
    let mut turns: Vec<(usize, usize)> = Vec::with_capacity(ranked.len());
    for mut members in cells {
        members.sort_unstable();
        turns.extend(members.into_iter().enumerate());
    }
    turns.sort_unstable();
    turns.into_iter().take(keep).map(|(_, i)| ranked[i]).collect()
}
