//! Vocabulary tree, bag-of-words vectors, guided matching and the place index.
//!
//! Start reading at [`Vocabulary`] (descriptors to a [`BowVector`] and a [`DirectIndex`]), then [`PlaceIndex`] (a vector
//! to the keyframes that look alike), [`Familiarity`] (which of them one has been driving past) and [`match_by_node`]
//! (two direct indices to feature matches). [`train`] makes a vocabulary, [`tool`] is what the command line calls.

mod block;
mod built_in;
mod direct;
mod error;
mod familiarity;
mod format;
mod index;
mod kernels;
mod matching;
pub mod tool;
mod train;
mod transform;
mod vector;
mod vocabulary;

pub use direct::DirectIndex;
pub use error::{FormatError, VocabularyError};
pub use familiarity::{Familiar, Familiarity};
pub use index::{DuplicateKeyframe, PlaceIndex, PlaceMatch};
pub use matching::{MatchOptions, MatchSide, NodeMatch, match_by_node};
pub use train::{TrainError, TrainOptions, train};
pub use transform::{DIRECT_LEVEL, Transformed};
pub use vector::BowVector;
pub use vocabulary::{MAX_BRANCHING, MAX_LEVELS, Origin, Vocabulary};
