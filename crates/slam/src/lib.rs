//! The steps of SLAM: initialise, track, map.
