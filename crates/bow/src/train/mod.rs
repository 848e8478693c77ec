//! Training: hierarchical k-medians on the descriptors of many images, then inverse document frequencies
//! (Galvez-Lopez and Tardos, T-RO 2012, section III).

mod cluster;
mod idf;
mod majority;
mod seeding;

use crate::error::FormatError;
use crate::kernels::Bits;
use crate::vocabulary::{MAX_BRANCHING, MAX_LEVELS, Origin, Tables, Vocabulary};
use cluster::Split;
use features::Descriptor;
use geometry::mix_seed;
use rayon::prelude::*;

/// How a vocabulary is trained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrainOptions {
    /// Children of a node, 2 to [`MAX_BRANCHING`].
    pub branching: u32,
    /// Steps from the root to a word, 1 to [`MAX_LEVELS`].
    pub levels: u32,
    /// Seed of all random choices.
    pub seed: u64,
    /// Most rounds of k-medians per node.
    pub max_iterations: usize,
    /// A node with fewer descriptors is not divided.
    pub min_descriptors: usize,
}

impl Default for TrainOptions {
    fn default() -> Self {
        Self { branching: 10, levels: 5, seed: 0, max_iterations: 12, min_descriptors: 20 }
    }
}

/// Why no vocabulary can be trained.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TrainError {
    /// A setting is out of range.
    #[error("{name} is {found}, expected {low} to {high}")]
    Option {
        /// Name of the setting.
        name: &'static str,
        /// Its value.
        found: u32,
        /// Least value.
        low: u32,
        /// Greatest value.
        high: u32,
    },
    /// Too little to learn from.
    #[error("{found} descriptors in {n_images} images, expected at least {needed}, not all equal")]
    TooFewDescriptors {
        /// Descriptors given.
        found: usize,
        /// Images given.
        n_images: usize,
        /// Least number for a first division.
        needed: usize,
    },
    /// The tree came out too large for the format.
    #[error(transparent)]
    Format(#[from] FormatError),
}

/// A vocabulary for the descriptors of these images, one vector per image.
///
/// Runs on the current rayon pool; the bytes of the result depend on the input and the options, not on the number of
/// threads.
///
/// # Errors
/// [`TrainError`] for options out of range or fewer descriptors than a first division needs.
pub fn train(images: &[Vec<Descriptor>], options: &TrainOptions) -> Result<Vocabulary, TrainError> {
    check_options(options)?;
    let mut descriptors: Vec<Bits> = images.iter().flatten().map(|descriptor| descriptor.0).collect();
    let n_descriptors = descriptors.len();
    let root = grow(&mut descriptors, 0, options.seed, options);
    if root.is_empty() {
        let needed = options.min_descriptors.max(2);
        return Err(TrainError::TooFewDescriptors { found: n_descriptors, n_images: images.len(), needed });
    }
    drop(descriptors);
    let mut tables = flatten(root);
    tables.branching = options.branching;
    tables.levels = options.levels;
    tables.origin =
        Origin { n_images: images.len() as u64, n_descriptors: n_descriptors as u64, seed: options.seed };
    let unweighted = Vocabulary::from_tables(&tables)?;
    tables.weights = idf::weights(&unweighted, images);
    Ok(Vocabulary::from_tables(&tables)?)
}

fn check_options(options: &TrainOptions) -> Result<(), TrainError> {
    let ranges =
        [("branching", options.branching, 2, MAX_BRANCHING), ("levels", options.levels, 1, MAX_LEVELS)];
    for (name, found, low, high) in ranges {
        if !(low..=high).contains(&found) {
            return Err(TrainError::Option { name, found, low, high });
        }
    }
    Ok(())
}

/// A node of the growing tree.
struct Node {
    median: Bits,
    children: Vec<Node>,
}

/// The children of the node that holds these descriptors; none when it is a word. Reorders the descriptors.
fn grow(descriptors: &mut [Bits], depth: u32, seed: u64, options: &TrainOptions) -> Vec<Node> {
    if depth == options.levels || descriptors.len() < options.min_descriptors.max(2) {
        return Vec::new();
    }
    let Split { medians, sizes } = cluster::split(descriptors, seed, options);
    if medians.len() < 2 {
        return Vec::new();
    }
    let mut rest = descriptors;
    let mut parts = Vec::with_capacity(medians.len());
    for (i, (median, size)) in medians.into_iter().zip(sizes).enumerate() {
        let (part, behind) = rest.split_at_mut(size);
        parts.push((median, part, mix_seed(seed, i as u64, u64::from(depth))));
        rest = behind;
    }
    let grow_part = |(median, part, seed)| Node { median, children: grow(part, depth + 1, seed, options) };
    parts.into_par_iter().with_max_len(1).map(grow_part).collect()
}

/// The tables of a tree, breadth first, weights zero.
fn flatten(root: Vec<Node>) -> Tables {
    let mut tables = Tables { medians: vec![[0; 4]], ..Tables::default() };
    let mut level = vec![root];
    while !level.is_empty() {
        let mut next = Vec::new();
        for children in level {
            tables.first_child.push(tables.medians.len() as u32);
            for child in children {
                tables.medians.push(child.median);
                next.push(child.children);
            }
        }
        level = next;
    }
    tables.first_child.push(tables.medians.len() as u32);
    tables.weights = vec![0.0; tables.medians.len()];
    tables
}
