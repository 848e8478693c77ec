//! Everything the vocabulary and the place index promise, one file per promise.

mod binary_format;
mod files;
mod matching;
mod place_index;
mod real_data;
mod support;
mod text_format;
mod training;
mod transform;
