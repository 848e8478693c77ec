//! Schedules, image prefetching and timings: the only crate with threads.
