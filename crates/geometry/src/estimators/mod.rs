//! Ready estimators for [`crate::ransac`].

mod fundamental;
mod homography;
mod pnp;
mod similarity;

pub use fundamental::FundamentalEstimator;
pub use homography::HomographyEstimator;
pub use pnp::PnpEstimator;
pub use similarity::{SightedPoints, SimilarityEstimator};

/// The chosen elements, in the order of the indices.
fn pick<T: Copy>(all: &[T], indices: &[usize]) -> Vec<T> {
    indices.iter().map(|&i| all[i]).collect()
}
