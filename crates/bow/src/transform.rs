//! Descriptors of an image to its bag-of-words vector and its direct index.

use crate::direct::DirectIndex;
use crate::kernels::nearest;
use crate::vector::BowVector;
use crate::vocabulary::{Tree, Vocabulary};
use features::Descriptor;
use simd::{Task, run_counting};

/// Level of the nodes of direct indices, from the root: 10 nodes for a branching of 10. ORB-SLAM2 has 100, which takes less time, but
/// in other light more features of one place end under different nodes (`eval/README.md` has the figures).
pub const DIRECT_LEVEL: u32 = 1;

/// What the vocabulary says about an image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transformed {
    /// Its TF-IDF vector.
    pub bow: BowVector,
    /// Its features by node.
    pub direct: DirectIndex,
}

impl Vocabulary {
    /// Vector and direct index at [`DIRECT_LEVEL`] of an image's descriptors.
    ///
    /// `activation`, one weight per descriptor, multiplies what a feature adds to the vector; features whose weight is not
    /// positive and finite add nothing. Missing weights count as one. All features are in the direct index.
    pub fn transform(&self, descriptors: &[Descriptor], activation: Option<&[f32]>) -> Transformed {
        self.transform_at(descriptors, activation, DIRECT_LEVEL)
    }

    /// As [`Vocabulary::transform`] with the nodes of the direct index at another level, 0 being the root; where a word
    /// stands above that level, it is the node.
    pub fn transform_at(
        &self,
        descriptors: &[Descriptor],
        activation: Option<&[f32]>,
        level: u32,
    ) -> Transformed {
        let tree = self.tree();
        let Paths { words, nodes } = run_counting(Descend { tree, descriptors, level });
        let weights = words.iter().enumerate().map(|(i, &word)| {
            let trust = activation.and_then(|weights| weights.get(i)).copied().unwrap_or(1.0);
            (word, tree.weights[word as usize] * trust)
        });
        Transformed {
            bow: BowVector::from_weights(weights.collect()),
            direct: DirectIndex::from_nodes(&nodes),
        }
    }

    /// The word of each descriptor.
    pub fn words_of(&self, descriptors: &[Descriptor]) -> Vec<u32> {
        run_counting(Descend { tree: self.tree(), descriptors, level: 0 }).words
    }
}

/// Where descriptors end in the tree and where they come through.
struct Paths {
    words: Vec<u32>,
    nodes: Vec<u32>,
}

/// From the root to the nearest child, again and again; of equally near children the first.
struct Descend<'a> {
    tree: Tree<'a>,
    descriptors: &'a [Descriptor],
    level: u32,
}

impl Task for Descend<'_> {
    type Output = Paths;

    #[inline(always)]
    fn run(self) -> Paths {
        let n = self.descriptors.len();
        let mut paths = Paths { words: Vec::with_capacity(n), nodes: Vec::with_capacity(n) };
        for descriptor in self.descriptors {
            let (mut node, mut at_level, mut depth) = (0, 0, 0);
            loop {
                let children = self.tree.children(node);
                if children.is_empty() {
                    break;
                }
                node = children.start + nearest(&self.tree.medians[children], &descriptor.0);
                depth += 1;
                if depth <= self.level {
                    at_level = node;
                }
            }
            paths.words.push(node as u32);
            paths.nodes.push(at_level as u32);
        }
        paths
    }
}
