//! Rendered street worlds with exact ground truth.
