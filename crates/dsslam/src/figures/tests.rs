//! Each rule doubts what it is for, and nothing else does; good figures of real cameras are left alone.

use features::Rig;
use geometry::{CameraModel, Distortion, ImageSize, KannalaBrandt, Pinhole, Sensor, StereoRig};

use super::Figures;
use super::facts::{Facts, Times, camera_of};
use super::sight::{Look, Pairing, Sight};

const SIZE: ImageSize = ImageSize { width: 1226, height: 370 };
const PINHOLE: Pinhole = Pinhole { fx: 707.1, fy: 707.1, cx: 601.9, cy: 183.1 };

fn rig(camera: Pinhole, baseline_m: f64, size: ImageSize) -> Rig {
    let stereo = StereoRig { camera, baseline_m };
    Rig { stereo, distortion: Distortion::default(), width: size.width, height: size.height }
}

/// Stereo matches with these disparities and this offset of the rows.
fn pairing(n: usize, disparity: f32, rows: f32) -> Pairing {
    Pairing::of_shifts(&vec![(disparity, rows); n]).0
}

fn sight() -> Sight {
    let look = Look { brightness: 95.0, corners: 1000 };
    let pairing = Some(pairing(400, 30.0, 0.3));
    let depths_m = [8.0, 20.0, 70.0].repeat(9);
    Sight { left: look, right: Some(look), pairing, halves: None, depths_m, with_depth: None }
}

/// What a good stereo sequence says.
fn good() -> Facts {
    let rig = rig(PINHOLE, 0.537, SIZE);
    let times: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.1037).collect();
    Facts {
        sensor: Sensor::Stereo,
        layout: "KITTI odometry",
        source: "calib.txt".to_owned(),
        cameras: vec![camera_of(&rig)],
        rig,
        is_rectified: false,
        units_per_meter: 5000.0,
        times: Some(Times::of(&times, false)),
        with_truth: Some(50),
        map_rig: None,
        sights: vec![sight(); 5],
    }
}

/// A good RGB-D sequence.
fn desk() -> Facts {
    let size = ImageSize { width: 640, height: 480 };
    let rig = rig(Pinhole { fx: 517.3, fy: 516.5, cx: 318.6, cy: 255.3 }, 0.077, size);
    let sight = Sight { right: None, pairing: None, depths_m: vec![0.8, 1.1, 1.7], ..sight() };
    let sights = vec![sight; 5];
    Facts { sensor: Sensor::Rgbd, cameras: vec![camera_of(&rig)], rig, sights, ..good() }
}

/// The doubts about a sequence with another camera.
fn of_camera(pinhole: Pinhole, size: ImageSize) -> Vec<&'static str> {
    rules_of(&Facts { cameras: vec![camera_of(&rig(pinhole, 0.537, size))], ..good() })
}

fn rules_of(facts: &Facts) -> Vec<&'static str> {
    Figures::of(facts).doubts.iter().map(|doubt| doubt.rule).collect()
}

/// The one doubt, by this rule.
#[track_caller]
fn only(facts: &Facts, rule: &str) -> String {
    let doubts = Figures::of(facts).doubts;
    assert_eq!(doubts.iter().map(|doubt| doubt.rule).collect::<Vec<_>>(), [rule], "{doubts:?}");
    doubts[0].text.clone()
}

#[test]
fn good_sequences_are_shown_and_not_doubted() {
    let figures = Figures::of(&good());
    assert_eq!(figures.doubts, []);
    let lines: Vec<String> = figures.lines.iter().map(|f| format!("{}: {}", f.name, f.text)).collect();
    let expected = [
        "camera: 1226x370 pixels, focal length 707.1 x 707.1 px, field of view 82 x 29 deg, principal point (601.9, 183.1)",
        "distortion: none",
        "baseline: 0.537 m; median depth seen 20.0 m (5 to 95 %: 8.00 to 70.0 m)",
        "images: 5 frames looked at, left image of brightness 95 with 1000 corners, right image of brightness 95 with 1000 corners, \
         100 % of their matches on the same row",
        "times: 50 frames in 5.08 s, 9.64 frames/s, longest gap 0.104 s",
        "layout: KITTI odometry, sensor stereo; calibration from calib.txt",
        "ground truth: poses for 50 of 50 frames",
    ];
    assert_eq!(lines, expected);
    let figures = Figures::of(&desk());
    assert_eq!(figures.doubts, []);
    let depth = figures.lines.iter().find(|figure| figure.name == "depth").unwrap();
    assert!(depth.text.starts_with("5000 units per meter; median depth seen 1.10 m"), "{}", depth.text);
    // A stream tells nothing of its times and images before it begins; its camera is shown all the same.
    let stream = Facts { times: None, with_truth: None, sights: Vec::new(), ..good() };
    assert_eq!(rules_of(&stream), [""; 0]);
    assert_eq!(Figures::of(&stream).lines.len(), 5);
}

#[test]
fn cameras_that_no_lens_makes_are_doubted() {
    let half = ImageSize { width: 613, height: 185 };
    assert_eq!(of_camera(PINHOLE, half), ["other_size"], "calibrated at twice the size");
    let double = ImageSize { width: 2452, height: 740 };
    assert_eq!(of_camera(PINHOLE, double), ["other_size"], "calibrated at half the size");
    for (pinhole, rules) in [
        (Pinhole { fx: 7.071, fy: 7.071, ..PINHOLE }, &["field_of_view"][..]),
        (Pinhole { fx: 7071.0, fy: 7071.0, ..PINHOLE }, &["field_of_view"]),
        (Pinhole { fy: 500.0, ..PINHOLE }, &["pixel_shape"]),
        (Pinhole { cy: 601.9, cx: 183.1, ..PINHOLE }, &["principal_point"]),
        (Pinhole { cx: 200.0, ..PINHOLE }, &["principal_point"]),
        // KITTI-360 as it is published.
        (Pinhole { cy: 0.635 * 370.0, ..PINHOLE }, &[]),
    ] {
        assert_eq!(of_camera(pinhole, SIZE), rules, "{pinhole:?}");
    }
}

/// Of a rational model with eight numbers the second one was once taken for k2.
#[test]
fn distortions_that_fold_the_image_are_doubted() {
    let of = |k1, k2| {
        let distortion = Distortion { k1, k2, ..Distortion::default() };
        let camera = camera_of(&Rig { distortion, ..good().rig });
        rules_of(&Facts { cameras: vec![camera], ..good() })
    };
    assert_eq!(of(-0.28, 0.07), [""; 0]);
    assert_eq!(of(-24.4, -628.0), ["lens"]);
    assert_eq!(of(0.0, 900.0), ["lens"]);
    let model =
        CameraModel::KannalaBrandt(KannalaBrandt { camera: PINHOLE, k1: 0.0, k2: 0.0, k3: 0.0, k4: 0.0 });
    let fisheye = io::RawCamera { model, ..good().cameras[0].clone() };
    assert_eq!(rules_of(&Facts { cameras: vec![fisheye], ..good() }), [""; 0]);
}

#[test]
fn baselines_in_other_units_are_doubted() {
    let with = |baseline_m| Facts { rig: rig(PINHOLE, baseline_m, SIZE), ..good() };
    let text = only(&with(110.0), "baseline");
    assert_eq!(text, "the baseline is 110 m, usual are 0.001 to 3: is it in millimeters or pixels?");
    only(&with(0.000_11), "baseline");
    assert_eq!(rules_of(&Facts { sensor: Sensor::Mono, ..with(0.0) }), [""; 0]);
}

#[test]
fn depths_that_no_depth_camera_sees_are_doubted() {
    let with = |factor: f64| {
        let mut facts = Facts { units_per_meter: 5000.0 / factor, ..desk() };
        facts.sights.iter_mut().flat_map(|s| &mut s.depths_m).for_each(|depth| *depth *= factor);
        facts
    };
    let text = only(&with(13.0), "depth");
    assert!(
        text.starts_with("the median depth seen is 14.3 m with 384.6")
            && text.contains("between 10.4 and 22.1 m"),
        "{text}"
    );
    for wrong in [5.0, 5000.0, 1.0 / 13.1] {
        only(&with(wrong), "depth");
    }
    let mut empty = desk();
    empty.sights.iter_mut().for_each(|sight| sight.depths_m.clear());
    assert!(only(&empty, "depth").starts_with("the depth images hold no depth (0, or beyond the 32 m"));
}

#[test]
fn stamps_in_other_units_and_invented_ones_are_doubted() {
    let with = |unit: f64, are_invented| {
        let times: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.05 * unit).collect();
        Facts { times: Some(Times::of(&times, are_invented)), ..good() }
    };
    for (unit, words) in [(1e9, "nanoseconds"), (1e6, "microseconds"), (1e3, "milliseconds")] {
        assert!(only(&with(unit, false), "times").ends_with(&format!("they look like {words}")));
    }
    only(&with(1e-3, false), "times");
    only(&with(1.0, true), "invented_times");
    assert!(only(&Facts { with_truth: Some(3), ..good() }, "ground_truth").contains("3 of 50 frames"));
}

#[test]
fn a_dark_right_camera_is_named() {
    let mut facts = good();
    for sight in &mut facts.sights[..3] {
        sight.right = Some(Look { brightness: 4.0, corners: 0 });
        sight.pairing = Some(Pairing::default());
    }
    assert_eq!(
        only(&facts, "dark_or_blank"),
        "the right image is dark: it has 0 corners and a brightness of 4 of 255, 3 of 5 frames looked at are like that"
    );
    // Two dark frames are a tunnel.
    facts.sights[0] = sight();
    assert_eq!(rules_of(&facts), [""; 0]);
}

#[test]
fn pairs_that_are_not_rectified_exchanged_or_late_are_doubted() {
    let with = |pairing: Pairing| {
        let mut facts = good();
        facts.sights.iter_mut().for_each(|sight| sight.pairing = Some(pairing.clone()));
        facts
    };
    assert!(only(&with(pairing(400, 30.0, 7.0)), "rows").contains("the right one is +7.0 px off"));
    let spread: Vec<(f32, f32)> = (0..200).map(|i| (30.0, i as f32 - 100.0)).collect();
    assert!(only(&with(Pairing::of_shifts(&spread).0), "rows").contains("not rectified"));
    assert!(only(&with(pairing(400, -30.0, 0.0)), "swapped").contains("exchanged"));
    assert!(
        only(&with(pairing(5, 30.0, 0.0)), "rows").starts_with("left and right images have little in common")
    );
    let late = Pairing { neighbors: Some([40, 380]), ..Pairing::of_shifts(&spread).0 };
    let text = only(&with(late), "right_late");
    assert!(text.ends_with("the right camera is late"), "{text}");
}

/// Frames of a ZED with the calibration of one camera.
#[test]
fn two_views_in_the_images_of_one_camera_are_told() {
    let with = |halves: Pairing| {
        let sight =
            Sight { right: None, pairing: None, halves: Some(halves), depths_m: Vec::new(), ..sight() };
        Facts { sensor: Sensor::Mono, sights: vec![sight; 5], ..good() }
    };
    let text = only(&with(pairing(200, 20.0, 0.5)), "side_by_side");
    assert!(text.contains("1000 of 1000 corners of the left half"), "{text}");
    // A wide street: few matches, and those anywhere.
    assert_eq!(rules_of(&with(pairing(10, 20.0, 0.5))), [""; 0]);
    let spread: Vec<(f32, f32)> = (0..200).map(|i| (30.0, i as f32 - 100.0)).collect();
    assert_eq!(rules_of(&with(Pairing::of_shifts(&spread).0)), [""; 0]);
}

/// Resuming from the map of another car was accepted in silence.
#[test]
fn a_map_of_another_camera_is_doubted() {
    let with = |map: Rig| Facts { map_rig: Some(map), ..good() };
    assert_eq!(rules_of(&with(good().rig)), [""; 0]);
    let rounded = Pinhole { fx: 707.0, cx: 602.0, ..PINHOLE };
    assert_eq!(rules_of(&with(rig(rounded, 0.537, SIZE))), [""; 0], "fewer digits");
    for other in [
        rig(Pinhole { fx: 777.8, fy: 777.8, ..PINHOLE }, 0.537, SIZE),
        rig(PINHOLE, 0.6, SIZE),
        rig(PINHOLE, 0.537, ImageSize { width: 1242, height: 375 }),
    ] {
        let text = only(&with(other), "other_camera");
        assert!(text.starts_with("the start map was made with another camera (1"), "{text}");
    }
}
