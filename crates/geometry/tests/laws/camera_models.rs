//! Cameras with their lens: projection and its inverse, derivatives, limits.

use crate::assert_close;
use crate::support::numeric_jacobian;
use dsslam_geometry::{CameraModel, Distortion, KannalaBrandt, Pinhole, Rational, Vec2, Vec3};
use proptest::prelude::*;
use std::f64::consts::PI;

/// EuRoC's left camera.
pub(crate) const EUROC_LEFT: CameraModel = CameraModel::Pinhole {
    camera: Pinhole { fx: 458.654, fy: 457.296, cx: 367.215, cy: 248.375 },
    distortion: Distortion {
        k1: -0.283_408_11,
        k2: 0.073_959_07,
        p1: 0.000_193_59,
        p2: 1.761_871_14e-5,
        k3: 0.0,
    },
};

/// TUM-VI's left camera, which sees 195 degrees.
pub(crate) const TUM_VI_LEFT: KannalaBrandt = KannalaBrandt {
    camera: Pinhole { fx: 190.978_477_15, fy: 190.973_307_0, cx: 254.931_706_05, cy: 256.897_442_98 },
    k1: 0.003_482_389_402_25,
    k2: 0.000_715_034_848_16,
    k3: -0.002_053_236_141_87,
    k4: 0.000_202_936_735_91,
};

/// A lens with eight coefficients, as depth cameras report it.
const KINECT: Rational = Rational {
    camera: Pinhole { fx: 613.0, fy: 612.8, cx: 640.3, cy: 366.7 },
    upper: Distortion { k1: 0.515_2, k2: -2.754_3, p1: 0.000_4, p2: -0.000_2, k3: 1.601_2 },
    lower: [0.393_9, -2.569_1, 1.524_3],
};

/// No lens at all in the model: the equidistant projection.
const EQUIDISTANT: KannalaBrandt = KannalaBrandt { k1: 0.0, k2: 0.0, k3: 0.0, k4: 0.0, ..TUM_VI_LEFT };

/// A direction with its angle from the axis up to `max_angle`, times a distance.
fn any_point(max_angle: f64) -> impl Strategy<Value = Vec3> {
    (0.0..max_angle, 0.0..2.0 * PI, 0.5..20.0).prop_map(|(angle, around, distance): (f64, f64, f64)| {
        Vec3::new(angle.sin() * around.cos(), angle.sin() * around.sin(), angle.cos()) * distance
    })
}

proptest! {
    #[test]
    fn unprojection_inverts_projection(narrow in any_point(0.75), wide in any_point(1.7)) {
        for (model, point) in [
            (EUROC_LEFT, narrow),
            (CameraModel::KannalaBrandt(TUM_VI_LEFT), wide),
            (CameraModel::Rational(KINECT), narrow),
        ] {
            assert_close!(model.unproject(&model.project(&point)), point.normalize(), 1e-12);
            let pixel = model.project(&point);
            assert_close!(model.project(&(model.unproject(&pixel) * 3.0)), pixel, 1e-9);
        }
    }

    #[test]
    fn the_jacobian_of_the_rational_lens_is_its_derivative(point in any_point(0.75)) {
        let ideal = point.xy() / point.z;
        assert_close!(KINECT.distort_jacobian(&ideal), numeric_jacobian(&ideal, |x| KINECT.distort(x)), 1e-8);
    }

    #[test]
    fn the_equidistant_fisheye_counts_angles(point in any_point(2.5)) {
        let Pinhole { fx, fy, cx, cy } = EQUIDISTANT.camera;
        let pixel = EQUIDISTANT.project(&point);
        let radius = Vec2::new((pixel.x - cx) / fx, (pixel.y - cy) / fy).norm();
        prop_assert!((radius - point.xy().norm().atan2(point.z)).abs() < 1e-12);
    }
}

#[test]
fn without_a_denominator_the_rational_lens_is_the_usual_one() {
    let CameraModel::Pinhole { camera, distortion } = EUROC_LEFT else { panic!("a pinhole") };
    let rational = CameraModel::Rational(Rational { camera, upper: distortion, lower: [0.0; 3] });
    for point in [Vec3::new(0.3, -0.4, 1.0), Vec3::new(-0.7, 0.2, 2.0)] {
        assert_close!(rational.project(&point), EUROC_LEFT.project(&point), 1e-12);
    }
    assert!((rational.max_angle() - EUROC_LEFT.max_angle()).abs() < 1e-9);
    // x (1 + s) / (1 + 2 s) at x = 1: two thirds.
    let upper = Distortion { k1: 1.0, ..Distortion::default() };
    let lens = Rational { camera, upper, lower: [2.0, 0.0, 0.0] };
    assert_close!(lens.distort(&Vec2::new(1.0, 0.0)), Vec2::new(2.0 / 3.0, 0.0), 1e-15);
    assert!(
        Rational { lower: [-0.25, 0.0, 0.0], ..lens }.max_radius() <= 2.0,
        "the denominator vanishes there"
    );
}

#[test]
fn the_axis_is_seen_at_the_principal_point() {
    for model in [EUROC_LEFT, CameraModel::KannalaBrandt(TUM_VI_LEFT)] {
        let (center, axis) = (Vec2::new(model.pinhole().cx, model.pinhole().cy), Vec3::new(0.0, 0.0, 4.0));
        assert_eq!(model.project(&axis), center);
        assert_close!(model.unproject(&center), Vec3::z(), 1e-15);
    }
}

#[test]
fn the_fisheye_has_the_values_of_the_formula() {
    let camera = Pinhole { fx: 100.0, fy: 200.0, cx: 10.0, cy: 20.0 };
    let lens = KannalaBrandt { camera, k1: 0.1, k2: 0.01, k3: 0.001, k4: 0.0001 };
    // A ray 90 degrees off the axis, along (3, 4): a + 0.1 a^3 + 0.01 a^5 + 0.001 a^7 + 0.0001 a^9 with a = pi / 2.
    let a = PI / 2.0;
    let radius = a + 0.1 * a.powi(3) + 0.01 * a.powi(5) + 0.001 * a.powi(7) + 0.0001 * a.powi(9);
    let expected = Vec2::new(10.0 + 100.0 * radius * 0.6, 20.0 + 200.0 * radius * 0.8);
    assert_close!(lens.project(&Vec3::new(3.0, 4.0, 0.0)), expected, 1e-10);
}

#[test]
fn projection_is_one_to_one_up_to_the_limit_and_not_beyond() {
    let folding = Distortion { k1: -0.5, ..Distortion::default() };
    let bent = CameraModel::Pinhole { camera: *EUROC_LEFT.pinhole(), distortion: folding };
    // r (1 - 0.5 r^2) grows up to r^2 = 2 / 3.
    assert!((bent.max_angle() - (2.0_f64 / 3.0).sqrt().atan()).abs() < 1e-12);
    let curled = CameraModel::KannalaBrandt(KannalaBrandt { k1: -0.1, ..EQUIDISTANT });
    assert!((curled.max_angle() - (10.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    for model in [bent, curled] {
        let column = |angle: f64| model.project(&Vec3::new(angle.sin(), 0.0, angle.cos())).x;
        let limit = model.max_angle();
        assert!(column(limit - 1e-3) < column(limit) && column(limit + 1e-3) < column(limit));
        // A pixel that no ray reaches gives a finite ray of length one.
        let ray = model.unproject(&Vec2::new(5000.0, 0.0));
        assert!((ray.norm() - 1.0).abs() < 1e-12);
    }
    assert_eq!(CameraModel::KannalaBrandt(EQUIDISTANT).max_angle(), PI);
    assert!(CameraModel::KannalaBrandt(TUM_VI_LEFT).max_angle().to_degrees() > 97.5);
    assert!(EUROC_LEFT.max_angle().to_degrees() > 50.0);
}

#[test]
fn a_model_is_shown_with_its_numbers() {
    let camera = Pinhole { fx: 100.0, fy: 200.0, cx: 10.0, cy: 20.0 };
    let pinhole =
        CameraModel::Pinhole { camera, distortion: Distortion { k1: 0.5, ..Distortion::default() } };
    assert_eq!(pinhole.to_string(), "pinhole 100 200 10 20, radial-tangential 0.5 0 0 0 0");
    let fisheye = KannalaBrandt { camera, k1: 0.1, k2: 0.2, k3: 0.3, k4: 0.4 };
    let shown = CameraModel::KannalaBrandt(fisheye).to_string();
    assert_eq!(shown, "fisheye 100 200 10 20, Kannala-Brandt 0.1 0.2 0.3 0.4");
}
