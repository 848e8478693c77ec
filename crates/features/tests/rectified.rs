//! Rectification on real images: matched corners of the two cameras lie on one row. Needs `DSSLAM_DATA`.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test stops at the first problem")]

mod common;

use common::median;
use dsslam_features::{Extractor, ExtractorConfig, Features, RemapTable, match_brute_force, remap};
use geometry::{GrayImage, Pinhole};
use io::{RectifiedView, Sequence, load_frame, open_sequence};
use std::path::Path;

/// Frames that are looked at.
const STEP: usize = 20;

fn sequence() -> Option<Sequence> {
    let folder = std::env::var_os("DSSLAM_DATA").map(|data| Path::new(&data).join("euroc_MH01_200"));
    let folder = folder.filter(|folder| folder.is_dir());
    if folder.is_none() {
        println!("skipped: DSSLAM_DATA has no euroc_MH01_200");
    }
    folder.map(|folder| open_sequence(&folder, None).unwrap())
}

fn table(view: &RectifiedView, camera: &Pinhole) -> RemapTable {
    let size = (view.size.width, view.size.height);
    RemapTable::rectifying(&view.model, &view.rectified_from_cam, camera, size, size)
}

/// Distances between the rows of corners that match best both ways.
fn row_differences(left: &Features, right: &Features) -> Vec<f64> {
    let pairs = match_brute_force(&left.descriptors, &right.descriptors, 50, 0.7);
    let row = |features: &Features, i: u32| f64::from(features.keypoints[i as usize].y);
    pairs.iter().map(|&(i, j)| (row(left, i) - row(right, j)).abs()).collect()
}

#[test]
fn matched_corners_lie_on_one_row_after_rectification() {
    let Some(sequence) = sequence() else { return };
    let camera = sequence.calibration.as_ref().unwrap().rig.camera;
    let tables: Vec<RemapTable> = sequence.rectification.iter().map(|view| table(view, &camera)).collect();
    let empty = tables.iter().map(|table| table.mask(0).data.iter().filter(|&&v| v == 0).count());
    let empty: Vec<usize> = empty.collect();
    // OpenCV's rule of alpha 0 leaves at most the outermost row or column without a source.
    assert!(empty.iter().all(|&n| n <= 752 + 480), "{empty:?}");
    let mut extractor = Extractor::new(ExtractorConfig { keep: 1200, ..ExtractorConfig::default() });
    let (mut raw, mut rectified) = (Vec::new(), Vec::new());
    for frame in sequence.frames.iter().step_by(STEP) {
        let images = load_frame(frame).unwrap();
        let pair = [images.left, images.right.unwrap()];
        let mut differences = |images: [&GrayImage; 2]| {
            let [left, right] = images.map(|image| extractor.extract(image));
            row_differences(&left, &right)
        };
        raw.extend(differences(pair.each_ref()));
        let [left, right] = [0, 1].map(|i| remap(&pair[i], &tables[i]).unwrap());
        rectified.extend(differences([&left, &right]));
    }
    let (n, before, after) = (rectified.len(), median(raw), median(rectified));
    println!("{n} matches: rows differ by {after:.3} px in the median, {before:.3} px before rectification");
    println!("pixels without a source: {empty:?}");
    assert!(n > 500 && after < 0.5 && before > 3.0 * after, "{n} matches, {before} px, {after} px");
}
