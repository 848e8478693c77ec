//! Metrics, tables and plots of trajectories.
