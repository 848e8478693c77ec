//! The vocabulary tree: medians, first children and weights in one block of memory, as in the file.

use crate::block::Block;
use crate::error::FormatError;
use crate::format::binary::{self, Header};
use crate::format::layout::{HEADER_BYTES, Layout};
use crate::kernels::Bits;
use features::Descriptor;
use std::ops::Range;
use std::sync::Arc;

/// Largest branching.
pub const MAX_BRANCHING: u32 = 1000;
/// Most levels below the root.
pub const MAX_LEVELS: u32 = 16;

/// A tree whose nodes hold the bitwise median of descriptors; its leaves are the words.
///
/// Nodes are numbered breadth first, the root is 0, the children of a node are neighbors. A word is the number of its
/// leaf, so words are not dense. Cheap to load, as the file's bytes are used in place, and to clone.
#[derive(Clone, Debug)]
pub struct Vocabulary {
    header: Header,
    layout: Layout,
    block: Block,
}

/// Where a vocabulary comes from, as far as its file tells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// Images it was trained on; 0 when unknown.
    pub n_images: u64,
    /// Descriptors it was trained on; 0 when unknown.
    pub n_descriptors: u64,
    /// Seed of the training.
    pub seed: u64,
}

/// A tree as plain tables, breadth first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tables {
    pub(crate) branching: u32,
    pub(crate) levels: u32,
    pub(crate) origin: Origin,
    pub(crate) medians: Vec<Bits>,
    /// One more than there are nodes.
    pub(crate) first_child: Vec<u32>,
    pub(crate) weights: Vec<f32>,
}

/// The tables of a vocabulary, borrowed.
#[derive(Clone, Copy)]
pub(crate) struct Tree<'a> {
    pub(crate) medians: &'a [Bits],
    pub(crate) first_child: &'a [u32],
    pub(crate) weights: &'a [f32],
}

impl<'a> Tree<'a> {
    /// The tables in bytes of this layout, aligned to 8.
    pub(crate) fn of(bytes: &'a [u8], layout: Layout) -> Self {
        Self {
            medians: bytemuck::cast_slice(&bytes[HEADER_BYTES..layout.children]),
            first_child: bytemuck::cast_slice(&bytes[layout.children..layout.weights]),
            weights: bytemuck::cast_slice(&bytes[layout.weights..layout.end]),
        }
    }

    /// The children of a node; empty for a leaf.
    #[inline(always)]
    pub(crate) fn children(&self, node: usize) -> Range<usize> {
        self.first_child[node] as usize..self.first_child[node + 1] as usize
    }
}

impl Vocabulary {
    /// The vocabulary in the bytes of a file of our own format.
    ///
    /// # Errors
    /// [`FormatError`] for anything that this program did not write: every byte is checked.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, FormatError> {
        Self::from_block(Block::Bytes(Arc::new(bytes)))
    }

    /// The vocabulary in bytes compiled into the program; nothing is copied when they are aligned to 8.
    ///
    /// # Errors
    /// As [`Vocabulary::from_bytes`].
    pub fn from_static(bytes: &'static [u8]) -> Result<Self, FormatError> {
        Self::from_block(Block::Static(bytes))
    }

    /// The vocabulary in a block of bytes, which is used in place if it is aligned.
    pub(crate) fn from_block(block: Block) -> Result<Self, FormatError> {
        let length = block.bytes().len();
        let block = block.aligned();
        let (header, layout) = binary::check(&block.bytes()[..length])?;
        Ok(Self { header, layout, block })
    }

    /// The vocabulary of a valid tree.
    ///
    /// # Errors
    /// [`FormatError::Invalid`] with the rule that the tables break.
    pub(crate) fn from_tables(tables: &Tables) -> Result<Self, FormatError> {
        Self::from_bytes(binary::assemble(tables)?)
    }

    /// The bytes of its file.
    pub fn as_bytes(&self) -> &[u8] {
        &self.block.bytes()[..self.layout.total]
    }

    pub(crate) fn tree(&self) -> Tree<'_> {
        Tree::of(self.block.bytes(), self.layout)
    }

    /// Most children of a node.
    pub fn branching(&self) -> u32 {
        self.header.branching
    }

    /// Most steps from the root to a leaf.
    pub fn levels(&self) -> u32 {
        self.header.levels
    }

    /// Number of nodes, the root included; words are below this number.
    pub fn n_nodes(&self) -> u32 {
        self.header.n_nodes
    }

    /// Number of words (leaves).
    pub fn n_words(&self) -> u32 {
        self.header.n_words
    }

    /// What it was trained on.
    pub fn origin(&self) -> Origin {
        self.header.origin
    }

    /// The children of a node, empty for a word; `None` when there is no such node.
    pub fn children(&self, node: u32) -> Option<Range<u32>> {
        let children = self.tree().children((node < self.n_nodes()).then_some(node as usize)?);
        Some(children.start as u32..children.end as u32)
    }

    /// The median of a node (zero for the root); `None` when there is no such node.
    pub fn median(&self, node: u32) -> Option<Descriptor> {
        self.tree().medians.get(node as usize).copied().map(Descriptor)
    }

    /// The inverse document frequency of a word; `None` when there is no such node.
    pub fn weight(&self, node: u32) -> Option<f32> {
        self.tree().weights.get(node as usize).copied()
    }
}

impl PartialEq for Vocabulary {
    fn eq(&self, other: &Self) -> bool {
        self.as_bytes() == other.as_bytes()
    }
}
