//! The stage tools: counts that agree with what they look at, pictures of the right size, and refusals.

use super::support::{Call, dsslam_in, sandbox};

/// The value that a tool printed under a name.
fn value<'a>(text: &'a str, name: &str) -> &'a str {
    let line = text.lines().find(|line| line.starts_with(name));
    line.unwrap_or_else(|| panic!("no {name} in\n{text}"))[name.len()..].trim()
}

fn first_number(text: &str) -> usize {
    text.split(' ').next().unwrap().parse().unwrap()
}

#[test]
fn features_are_counted_and_drawn() {
    let dir = sandbox();
    let args = [
        "inspect",
        "features",
        "kitti/sequences/06",
        "--frame",
        "1",
        "--set",
        "features.keep=300",
        "-o",
        "new/f.png",
    ];
    let Call { code, stdout, stderr } = dsslam_in(dir.path(), &args);
    assert_eq!(code, Some(0), "{stderr}");
    let n = first_number(value(&stdout, "features"));
    let by_octave: Vec<usize> = value(&stdout, "by octave").split(' ').map(|n| n.parse().unwrap()).collect();
    assert!((250..=300).contains(&n) && by_octave.len() == 8, "{stdout}");
    assert_eq!(by_octave.iter().sum::<usize>(), n);
    let size = io::image_size(&dir.path().join("new/f.png")).unwrap();
    assert!(size.width == 1241 && size.height > 376, "{size}");
}

#[test]
fn features_kept_and_dropped_by_a_selection_are_counted_and_drawn() {
    let dir = sandbox();
    let args = ["inspect", "features", "kitti/sequences/06", "--set", "features.selection=activation"];
    let args = [&args[..], &["--set", "features.keep=300", "-o", "f.png"]].concat();
    let Call { code, stdout, stderr } = dsslam_in(dir.path(), &args);
    assert_eq!(code, Some(0), "{stderr}");
    let [kept, dropped] =
        ["kept", "dropped"].map(|name| first_number(&value(&stdout, name).replace(',', " ")));
    let candidates = value(&stdout, "selection").strip_prefix("activation, among ").map(first_number);
    assert!(
        kept == first_number(value(&stdout, "features")) && candidates == Some(kept + dropped),
        "{stdout}"
    );
    assert!(kept == 300 && dropped > 500, "{stdout}");
    let mean = |name: &str| value(&stdout, name).rsplit(' ').next().unwrap().parse::<f64>().unwrap();
    assert!(["kept", "dropped"].map(mean).iter().all(|mean| (0.0..=1.0).contains(mean)), "{stdout}");
    let picture = io::load_gray(&dir.path().join("f.png")).unwrap();
    assert_eq!(picture.width, 1241);
}

#[test]
fn most_matches_of_two_moments_are_explained_by_one_motion() {
    let dir = sandbox();
    let args = [
        "inspect",
        "match",
        "kitti/sequences/06",
        "--frames",
        "0",
        "2",
        "--guided",
        "--config",
        "default",
        "-o",
        "m.png",
    ];
    let Call { code, stdout, stderr } = dsslam_in(dir.path(), &args);
    assert_eq!(code, Some(0), "{stderr}");
    let [matches, inliers, outliers] =
        ["matches", "inliers", "outliers"].map(|n| first_number(value(&stdout, n)));
    assert_eq!(inliers + outliers, matches);
    assert!(inliers > 100 && inliers > 2 * outliers, "{stdout}");
    // The same two images as files.
    let files = ["image_0/000000.png", "image_0/000002.png"];
    let args = [&["inspect", "match"][..], &files, &["-o", "files.png"]].concat();
    let Call { stdout: of_files, .. } = dsslam_in(dir.path(), &args);
    assert_eq!(value(&of_files, "inliers"), value(&stdout, "inliers"));
}

#[test]
fn a_stage_reduces_images_as_a_run_does() {
    let dir = sandbox();
    for input in ["kitti/sequences/06", "image_0/000000.png"] {
        let args = ["inspect", "features", input, "--set", "input.scale=0.5", "-o", "half.png"];
        let Call { code, stdout, stderr } = dsslam_in(dir.path(), &args);
        assert_eq!(code, Some(0), "{stderr}");
        assert!(value(&stdout, "image").ends_with("(621x188)"), "{stdout}");
    }
}

#[test]
fn disparities_are_counted_and_drawn() {
    let dir = sandbox();
    let Call { code, stdout, stderr } =
        dsslam_in(dir.path(), &["inspect", "stereo", "kitti/sequences/06", "-o", "s.png"]);
    assert_eq!(code, Some(0), "{stderr}");
    let [features, disparities] = ["features", "disparities"].map(|name| first_number(value(&stdout, name)));
    assert!(disparities > features / 3 && disparities <= features, "{stdout}");
    assert!(io::image_size(&dir.path().join("s.png")).unwrap().height > 376);
}

#[test]
fn what_cannot_be_looked_at_is_named() {
    let dir = sandbox();
    let refusal = |args: &[&str]| {
        let Call { code, stderr, .. } = dsslam_in(dir.path(), &[args, &["-o", "x.png"]].concat());
        assert_eq!(code, Some(2), "{stderr}");
        assert!(!dir.path().join("x.png").exists());
        stderr.trim().to_owned()
    };
    for (args, expected) in [
        (
            &["inspect", "stereo", "morning", "--frame", "99"][..],
            "error: morning: frame 99 does not exist, expected 0 to 11",
        ),
        (
            &["inspect", "features", "image_0/000000.png", "--frame", "1"],
            "error: image_0/000000.png: found an image, but --frame 1 needs a sequence",
        ),
        (
            &["inspect", "match", "image_0/000000.png", "--frames", "0", "1"],
            "error: image_0/000000.png: found an image, but --frames needs a sequence",
        ),
        (
            &["inspect", "features", "image_0/000000.png", "--set", "input.mask=none.png"],
            "error: input.mask (--set input.mask=none.png): none.png: no such image",
        ),
        (
            &["inspect", "stereo", "morning", "--set", "input.mask=none.png"],
            "error: input.mask (--set input.mask=none.png): none.png: no such image",
        ),
        (
            &["inspect", "match", "morning", "image_0/000000.png"],
            "error: morning: found a folder, expected an image (or --frames I J with a sequence)",
        ),
    ] {
        assert_eq!(refusal(args), expected);
    }
    let args = ["inspect", "features", "image_0/000000.png", "-o", "image_0/000000.png/x.png"];
    assert_eq!(dsslam_in(dir.path(), &args).code, Some(3));
}
