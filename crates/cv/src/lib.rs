//! OpenCV in one place: the reference that benchmarks compare with.
