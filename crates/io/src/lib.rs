//! Datasets, images, configuration and trajectories.
