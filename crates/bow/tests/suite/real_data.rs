//! Real sequences, where `DSSLAM_DATA` names a folder with them; elsewhere each test says that it was skipped. None of the
//! frames was used for the training of the built-in vocabulary.

use dsslam_bow::{BowVector, DirectIndex, MatchOptions, MatchSide, PlaceIndex, Vocabulary, match_by_node};
use features::{Extractor, ExtractorConfig, Features};
use std::path::PathBuf;
use std::sync::Arc;

/// A frame of a sequence.
struct View {
    features: Features,
    bow: Arc<BowVector>,
    direct: DirectIndex,
}

/// Frames of a folder of images, every `step`-th of the first `end`, if the folder is there.
fn views(folder: &str, end: usize, step: usize) -> Option<Vec<View>> {
    let Some(data) = std::env::var_os("DSSLAM_DATA") else {
        println!("skipped: DSSLAM_DATA is not set, so {folder} is not available");
        return None;
    };
    let folder = PathBuf::from(data).join(folder);
    let mut paths: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort_by_key(|path| number(path));
    let vocabulary = Vocabulary::built_in().unwrap();
    let mut extractor = Extractor::new(ExtractorConfig { keep: 1000, ..ExtractorConfig::default() });
    let mut view = |path: &PathBuf| {
        let features = extractor.extract(&io::load_gray(path).unwrap());
        let transformed = vocabulary.transform(&features.descriptors, None);
        View { features, bow: Arc::new(transformed.bow), direct: transformed.direct }
    };
    Some(paths.iter().take(end).step_by(step).map(&mut view).collect())
}

/// The number in a file's name: these are not padded with zeros.
fn number(path: &std::path::Path) -> u32 {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    name.chars().filter(char::is_ascii_digit).collect::<String>().parse().unwrap()
}

fn index(views: &[View]) -> PlaceIndex {
    let mut index = PlaceIndex::default();
    for (id, view) in (0..).zip(views) {
        index.add(id, Arc::clone(&view.bow)).unwrap();
    }
    index
}

#[test]
fn the_frame_that_looks_most_alike_is_a_neighbor() {
    let Some(views) = views("kitti06_first51/image_0", 51, 1) else { return };
    let index = index(&views);
    for (id, view) in (0u32..).zip(&views) {
        let best = index.query(&view.bow, |other| other == id)[0];
        assert_eq!(best.keyframe.abs_diff(id), 1, "frame {id} retrieves {}", best.keyframe);
    }
}

#[test]
fn the_right_image_retrieves_its_left_one() {
    let Some(left) = views("kitti06_first51/image_0", 51, 5) else { return };
    let Some(right) = views("kitti06_first51/image_1", 51, 5) else { return };
    let index = index(&left);
    for (id, view) in (0..).zip(&right) {
        assert_eq!(index.query(&view.bow, |_| false)[0].keyframe, id);
    }
}

#[test]
fn a_sequence_that_returns_to_its_start_retrieves_it() {
    // The last frames see the place of the first ones; in between the camera is elsewhere.
    let Some(views) = views("boofcv_library/left", 400, 5) else { return };
    let last = views.len() as u32 - 1;
    let found = index(&views).query(&views[last as usize].bow, |id| id + 20 > last);
    assert!(found[0].keyframe <= 2, "the last frame retrieves {}", 5 * found[0].keyframe);
}

#[test]
fn guided_matching_agrees_with_the_motion() {
    let Some(views) = views("kitti06_first51/image_0", 2, 1) else { return };
    let matched = |with_rotation: bool| {
        let [a, b] = [0, 1].map(|i: usize| MatchSide {
            descriptors: &views[i].features.descriptors,
            direct: &views[i].direct,
            keypoints: with_rotation.then_some(&views[i].features.keypoints[..]),
            eligible: None,
        });
        match_by_node(&a, &b, &MatchOptions::default())
    };
    let matches = matched(true);
    assert!(matches.len() > 100 && matches.len() <= matched(false).len(), "{}", matches.len());
    // Driving straight on: hardly anything moves more than a tenth of the image's width.
    let shift = |m: &dsslam_bow::NodeMatch| {
        let [p, q] = [views[0].features.keypoints[m.a as usize], views[1].features.keypoints[m.b as usize]];
        (p.x - q.x).hypot(p.y - q.y)
    };
    let n_near = matches.iter().filter(|m| shift(m) < 120.0).count();
    assert!(n_near * 100 >= matches.len() * 95, "{n_near} of {}", matches.len());
}
