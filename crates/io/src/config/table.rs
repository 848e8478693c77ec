//! All keys of the configuration. A new key is a line here and a field in `settings.rs`; nothing else.

use geometry::Sensor;

use super::schema::{
    ANY, Entry, above, between, choice, flag, integer, optional_choice, optional_file, optional_integer,
    optional_real, real,
};

/// All keys, in the order in which they are written.
#[rustfmt::skip]
pub const SCHEMA: &[Entry] = &[
    optional_real("camera.fx", "px", above(0.0), "focal length, horizontal; a calibration file of the dataset wins"),
    optional_real("camera.fy", "px", above(0.0), "focal length, vertical"),
    optional_real("camera.cx", "px", ANY, "principal point, horizontal"),
    optional_real("camera.cy", "px", ANY, "principal point, vertical"),
    real("camera.k1", 0.0, "", ANY, "radial distortion, r^2"),
    real("camera.k2", 0.0, "", ANY, "radial distortion, r^4"),
    real("camera.p1", 0.0, "", ANY, "tangential distortion"),
    real("camera.p2", 0.0, "", ANY, "tangential distortion"),
    real("camera.k3", 0.0, "", ANY, "radial distortion, r^6"),
    optional_integer("camera.width", "px", [16, 16_384], "image width; absent: that of the first image"),
    optional_integer("camera.height", "px", [16, 16_384], "image height; absent: that of the first image"),
    optional_real("camera.baseline_m", "m", above(0.0), "distance of the two cameras; for RGB-D the virtual one (bf / fx)"),
    real("camera.fps", 10.0, "Hz", above(0.0), "frame rate; the longest gap between keyframes is one second of frames"),
    real("camera.depth_units_per_metre", 5000.0, "1/m", above(0.0), "value of a depth image at one metre"),

    optional_choice("input.sensor", Sensor::WORDS, "what to use; absent: the richest that the dataset offers"),
    real("input.scale", 1.0, "", between(0.1, 1.0), "images are reduced by this factor before anything else; the camera is scaled with them"),
    optional_file("input.mask", "grey PNG of the size of the left raw image: no features where it is 0"),
    real("input.association_tolerance_s", 0.02, "s", above(0.0), "largest time between a colour image and its depth image"),

    integer("features.keep", 2000, "", [50, 100_000], "keypoints kept per image"),
    optional_integer("features.keep_mono", "", [50, 100_000], "keypoints kept of a single camera, whose maps need more of them; absent: keep"),
    choice("features.selection", "response", &["activation", "semantic", "response"], "by what they are chosen; the first two need ONNX Runtime"),
    integer("features.candidates", 2000, "", [50, 100_000], "keypoints among which activation or semantic choose"),
    choice("features.spread", "cells", &["cells", "anywhere"], "those chosen by activation or semantic: the best of each cell, or of the image"),
    integer("features.network_threads", 1, "", [1, 64], "threads of the network; no result depends on them"),
    integer("features.levels", 8, "", [1, 16], "levels of the image pyramid"),
    real("features.scale_factor", 1.2, "", between(1.01, 2.0), "ratio of the sizes of two neighbouring levels"),
    integer("features.fast_initial", 20, "grey levels", [1, 255], "FAST threshold tried first in a cell"),
    integer("features.fast_minimum", 7, "grey levels", [1, 255], "FAST threshold of a cell where the first finds nothing"),
    flag("features.subpixel", true, "refine the position of keypoints below one pixel"),

    flag("weights.ransac", true, "samples and scores of RANSAC are weighted by the activation of features"),
    flag("weights.optimisation", false, "observations count in optimisation as far as their features are trusted"),
    flag("weights.words", true, "words of a frame count as far as their features are trusted"),

    optional_real("stereo.min_depth_m", "m", above(0.0), "nearest depth searched for; absent: five baselines"),
    real("stereo.close_depth_baselines", 40.0, "baselines", above(0.0), "a point nearer than this makes a map point at once"),
    real("stereo.disparity_offset_px", 0.0, "px", between(-5.0, 5.0), "added to every disparity: a known error of the stereo calibration"),
    integer("stereo.calibration_frames", 0, "frames", [0, 100_000], "first frames run once before to refine the disparity offset from the images; 0: not at all"),

    integer("tracking.init_min_features", 100, "", [10, 100_000], "features with depth needed to start a map"),
    integer("tracking.min_inliers", 30, "", [4, 10_000], "matched map points below which a frame counts as lost"),
    optional_real("tracking.keyframe_ratio", "", between(0.0, 1.0), "a keyframe is due when fewer of the reference's points are tracked; absent: 0.75, monocular 0.9"),
    integer("tracking.close_tracked_min", 100, "", [0, 100_000], "close points tracked, below which a keyframe is due ..."),
    integer("tracking.close_untracked_max", 70, "", [0, 100_000], "... if more close features than this have no point"),

    optional_integer("mapping.neighbours", "keyframes", [1, 100], "covisible keyframes with which a new one is triangulated and fused; absent: 10, monocular 20"),
    integer("mapping.local_ba_first_iterations", 5, "", [1, 1000], "local bundle adjustment: iterations with the robust kernel"),
    integer("mapping.local_ba_second_iterations", 10, "", [0, 1000], "local bundle adjustment: iterations after outliers are gone"),
    real("mapping.keyframe_cull_ratio", 0.9, "", between(0.1, 1.0), "a keyframe goes when more of its points are seen by three others"),
    real("mapping.point_found_ratio", 0.25, "", between(0.0, 1.0), "a young point goes when it is found in fewer of the frames that should see it"),

    flag("loops.enabled", true, "look for places seen before and correct the map; needs a vocabulary"),

    integer("runtime.lag", 2, "frames", [1, 100], "tracking sees the finished mapping of a keyframe so many frames later; 1: with the next frame"),
    integer("runtime.loop_lag", 10, "frames", [1, 1000], "a loop may be closed so many frames after the keyframe that found it"),

    integer("seed", 1, "", [0, i64::MAX], "seed of all random numbers"),
];
