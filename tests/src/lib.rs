//! End-to-end, replay, golden and architecture tests; benchmarks.
