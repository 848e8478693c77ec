//! Poses, cameras, minimal solvers and weighted RANSAC: pure mathematics.
