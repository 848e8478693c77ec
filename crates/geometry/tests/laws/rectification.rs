//! Stereo rectification: equal rows, disparity and depth, no pixel without a source, faults of the rig.

use crate::camera_models::{EUROC_LEFT, TUM_VI_LEFT};
use crate::support::{generator, random_vec3};
use dsslam_geometry::{
    CameraModel, Distortion, Pinhole, Rational, RectificationError, SE3, SO3, StereoRectification, Vec2,
    Vec3, rectify_single, rectify_stereo,
};

const SIZE: (usize, usize) = (752, 480);
const EUROC_RIGHT: CameraModel = CameraModel::Pinhole {
    camera: Pinhole { fx: 457.587, fy: 456.134, cx: 379.999, cy: 255.238 },
    distortion: Distortion {
        k1: -0.283_683_65,
        k2: 0.074_512_84,
        p1: -0.000_104_73,
        p2: -3.555_907e-5,
        k3: 0.0,
    },
};

/// A right camera 11 cm to the right, turned and shifted a little.
fn right_from_left(seed: u64) -> SE3 {
    let mut rng = generator(seed);
    let center = Vec3::new(0.11, 0.0, 0.0) + random_vec3(&mut rng, 0.005);
    SE3::new(SO3::exp(&random_vec3(&mut rng, 0.05)), Vec3::zeros()) * SE3::new(SO3::identity(), -center)
}

fn rectified(motion: &SE3) -> StereoRectification {
    rectify_stereo(&EUROC_LEFT, &EUROC_RIGHT, SIZE, motion).expect("a rig side by side")
}

/// The source of a rectified pixel.
fn source(model: &CameraModel, turn: &SO3, camera: &Pinhole, pixel: &Vec2) -> Vec2 {
    model.project(&(turn.inverse() * camera.unproject(pixel)))
}

#[test]
fn a_point_lies_on_one_row_and_its_disparity_tells_its_depth() {
    for seed in 0..20 {
        let motion = right_from_left(seed);
        let StereoRectification { rectified_from_left, rectified_from_right, rig } = rectified(&motion);
        let mut rng = generator(seed + 100);
        for _ in 0..50 {
            let point_left = random_vec3(&mut rng, 2.0) + Vec3::new(0.0, 0.0, 5.0);
            let in_left = rectified_from_left * point_left;
            let in_right = rectified_from_right * (motion * point_left);
            let (u, v) = (rig.camera.project(&in_left), rig.camera.project(&in_right));
            assert!((u.y - v.y).abs() < 1e-9, "seed {seed}: {u} {v}");
            let expected = rig.project(&in_left);
            assert!((expected.z - v.x).abs() < 1e-9, "seed {seed}: {u} {v}");
        }
        assert!((rig.baseline_m - motion.translation.norm()).abs() < 1e-14);
    }
}

#[test]
fn raw_pixels_of_a_point_are_sources_of_one_row() {
    let motion = right_from_left(3);
    let StereoRectification { rectified_from_left, rectified_from_right, rig } = rectified(&motion);
    let (pixel, depth) = (Vec2::new(300.0, 200.0), 4.0);
    let point_left = rectified_from_left.inverse() * (rig.camera.unproject(&pixel) * depth);
    let raw = source(&EUROC_LEFT, &rectified_from_left, &rig.camera, &pixel);
    assert!((EUROC_LEFT.project(&point_left) - raw).norm() < 1e-9);
    let other = pixel - Vec2::new(rig.bf() / depth, 0.0);
    let raw = source(&EUROC_RIGHT, &rectified_from_right, &rig.camera, &other);
    assert!((EUROC_RIGHT.project(&(motion * point_left)) - raw).norm() < 1e-9);
}

/// Alpha 0: the rectified image is filled, and as wide as that allows.
#[test]
fn every_pixel_has_a_source_and_a_wider_view_would_not_do() {
    for seed in 0..10 {
        let StereoRectification { rectified_from_left, rectified_from_right, rig } =
            rectified(&right_from_left(seed));
        let (width, height) = (SIZE.0 as f64, SIZE.1 as f64);
        // OpenCV counts a pixel's breadth behind the last center as inside, in source and target.
        let worst = |camera: &Pinhole| {
            let mut outside = f64::NEG_INFINITY;
            for (model, turn) in [(EUROC_LEFT, rectified_from_left), (EUROC_RIGHT, rectified_from_right)] {
                for i in 0..=64 {
                    let along = f64::from(i) / 64.0;
                    for (x, y) in [(0.0, along), (1.0, along), (along, 0.0), (along, 1.0)] {
                        let p = source(&model, &turn, camera, &Vec2::new(x * width, y * height));
                        outside = [outside, -p.x, -p.y, p.x - width, p.y - height]
                            .into_iter()
                            .fold(outside, f64::max);
                    }
                }
            }
            outside
        };
        // The outline is sampled nine times a side: between samples it may bend outward by less than a pixel.
        assert!(worst(&rig.camera) < 1.0, "seed {seed}: {}", worst(&rig.camera));
        let wider = Pinhole { fx: rig.camera.fx * 0.97, fy: rig.camera.fy * 0.97, ..rig.camera };
        assert!(worst(&wider) > 1.0, "seed {seed}: {}", worst(&wider));
    }
}

#[test]
fn a_rectified_rig_keeps_its_directions() {
    let camera = Pinhole { fx: 700.0, fy: 700.0, cx: 375.5, cy: 239.5 };
    let model = CameraModel::Pinhole { camera, distortion: Distortion::default() };
    let motion = SE3::new(SO3::identity(), Vec3::new(-0.5, 0.0, 0.0));
    let StereoRectification { rectified_from_left, rectified_from_right, rig } =
        rectify_stereo(&model, &model, SIZE, &motion).unwrap();
    assert_eq!((rectified_from_left, rectified_from_right), (SO3::identity(), SO3::identity()));
    assert!((rig.camera.cx - 375.5).abs() < 1e-9 && (rig.camera.cy - 239.5).abs() < 1e-9);
    assert!((rig.camera.fx - 700.0).abs() < 2.0 && rig.baseline_m == 0.5);
}

#[test]
fn a_fisheye_pair_gets_a_bounded_field_of_view() {
    let model = CameraModel::KannalaBrandt(TUM_VI_LEFT);
    let motion = right_from_left(5);
    let rig = rectify_stereo(&model, &model, (512, 512), &motion).unwrap().rig;
    let half_angle = (256.0 / rig.camera.fx).atan().to_degrees();
    assert!((45.0..=60.5).contains(&half_angle), "{half_angle} degrees");
    let single = rectify_single(&model, (512, 512)).expect("an axis in the image");
    assert!((256.0 / single.fx).atan().to_degrees() >= half_angle, "one camera alone shows no less");
}

#[test]
fn faults_of_the_rig_are_told() {
    let fault = |turn: Vec3, x: f64, y: f64, z: f64| {
        let motion = SE3::new(SO3::exp(&turn), Vec3::new(x, y, z));
        rectify_stereo(&EUROC_LEFT, &EUROC_RIGHT, SIZE, &motion).unwrap_err()
    };
    let straight = Vec3::zeros();
    assert_eq!(fault(straight, 0.0, 0.0, 0.0), RectificationError::NoBaseline);
    assert_eq!(fault(straight, f64::NAN, 0.0, 0.0), RectificationError::NoBaseline);
    assert_eq!(fault(straight, 0.25, 0.0, 0.0), RectificationError::Swapped { left_by_m: 0.25 });
    assert_eq!(fault(straight, -0.1, -0.2, 0.0), RectificationError::Vertical { x_m: 0.1, y_m: 0.2 });
    let apart = fault(Vec3::new(0.0, 2.9, 0.0), -0.3, 0.0, 0.0);
    assert_eq!(apart, RectificationError::NoCommonView);
    for (error, text) in [
        (fault(straight, 0.0, 0.0, 0.0), "found no baseline between the two cameras, expected one above 0 m"),
        (
            fault(straight, 0.25, 0.0, 0.0),
            "found the second camera 0.2500 m to the left of the first, expected it to the right",
        ),
        (
            fault(straight, -0.1, -0.2, 0.0),
            "found the second camera 0.2000 m along y and 0.1000 m along x of the first, expected it to the right",
        ),
        (apart, "found cameras that look in different directions, expected a common field of view"),
    ] {
        assert_eq!(error.to_string(), text);
    }
}

/// Eight coefficients of another image: the message named cameras that look in different directions.
#[test]
fn a_lens_that_folds_its_image_back_is_told_with_the_place() {
    let camera = Pinhole { fx: 707.0912, fy: 707.0912, cx: 601.8873, cy: 183.1104 };
    let upper = Distortion { k1: 0.1, k2: -0.2, p1: 0.0, p2: 0.0, k3: 0.01 };
    let model = CameraModel::Rational(Rational { camera, upper, lower: [0.2, 0.1, 0.02] });
    let error = rectify_single(&model, (1226, 370)).unwrap_err();
    let RectificationError::Folded { camera: 0, radius_px, corner_px } = error else { panic!("{error}") };
    // Along a row, the image is farthest out where the lens folds.
    let along = (1..2000).map(|i| model.project(&Vec3::new(f64::from(i) * 1e-3, 0.0, 1.0)).x - camera.cx);
    assert!((along.fold(0.0, f64::max) - radius_px).abs() < 0.01, "{radius_px}");
    assert!((corner_px - (1226.0_f64 - 601.8873).hypot(370.0 - 183.1104)).abs() < 1e-9);
    assert!(error.to_string().starts_with("found coefficients that fold the image back 49"), "{error}");
}
