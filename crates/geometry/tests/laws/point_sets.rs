//! Alignment of point sets.

use crate::assert_close;
use crate::support::{generator, noise, random_motion, random_vec3};
use dsslam_geometry::{SO3, Sim3, Vec3, align_umeyama};
use rand::Rng;

fn points(seed: u64, n: usize) -> Vec<Vec3> {
    let mut rng = generator(seed);
    (0..n).map(|_| random_vec3(&mut rng, 10.0)).collect()
}

fn similarity(seed: u64) -> Sim3 {
    let mut rng = generator(seed + 500);
    let motion = random_motion(&mut rng, 30.0, 3.1);
    Sim3::new(motion.rotation, motion.translation, rng.random_range(0.2..5.0))
}

fn moved(s: &Sim3, points: &[Vec3]) -> Vec<Vec3> {
    points.iter().map(|p| s * p).collect()
}

#[test]
fn exact_sets_give_the_similarity() {
    for seed in 0..200 {
        let src = points(seed, 3 + seed as usize % 20);
        let truth = similarity(seed);
        let found = align_umeyama(&src, &moved(&truth, &src), None, true).unwrap();
        assert_close!(found.matrix(), truth.matrix(), 1e-9);
    }
}

#[test]
fn exact_sets_without_scale_give_the_rigid_motion() {
    for seed in 0..200 {
        let src = points(seed, 5);
        let truth = Sim3 { scale: 1.0, ..similarity(seed) };
        let found = align_umeyama(&src, &moved(&truth, &src), None, false).unwrap();
        assert_eq!(found.scale, 1.0);
        assert_close!(found.matrix(), truth.matrix(), 1e-9);
    }
}

#[test]
fn points_on_a_plane_and_mirrored_points_give_a_rotation() {
    let flat: Vec<_> = points(3, 10).iter().map(|p| Vec3::new(p.x, p.y, 0.0)).collect();
    let truth = similarity(3);
    assert_close!(
        align_umeyama(&flat, &moved(&truth, &flat), None, true).unwrap().matrix(),
        truth.matrix(),
        1e-9
    );
    let src = points(4, 10);
    let mirrored: Vec<_> = src.iter().map(|p| Vec3::new(p.x, p.y, -p.z)).collect();
    let found = align_umeyama(&src, &mirrored, None, true).unwrap();
    assert!((found.rotation.matrix().determinant() - 1.0).abs() < 1e-12);
}

#[test]
fn the_answer_is_the_minimum_of_the_weighted_cost() {
    let mut rng = generator(9);
    let src = points(9, 30);
    let dst: Vec<_> = moved(&similarity(9), &src).iter().map(|p| p + random_vec3(&mut rng, 2.0)).collect();
    let weights: Vec<f64> = (0..30).map(|_| rng.random_range(0.1..3.0)).collect();
    let found = align_umeyama(&src, &dst, Some(&weights), true).unwrap();
    let cost = |s: &Sim3| -> f64 { (0..30).map(|i| weights[i] * (s * src[i] - dst[i]).norm_squared()).sum() };
    for k in 0..14 {
        let mut v = dsslam_geometry::Vec7::zeros();
        v[k / 2] = if k % 2 == 0 { 1e-4 } else { -1e-4 };
        assert!(cost(&(Sim3::exp(&v) * found)) > cost(&found), "direction {k}");
    }
}

#[test]
fn a_double_weight_equals_a_repeated_point_and_a_zero_weight_a_missing_one() {
    let mut rng = generator(10);
    let src = points(10, 6);
    let dst: Vec<_> =
        moved(&similarity(10), &src).iter().map(|p| p + Vec3::from_fn(|_, _| noise(&mut rng, 0.5))).collect();
    let weighted = align_umeyama(&src, &dst, Some(&[2.0, 1.0, 1.0, 1.0, 1.0, 0.0]), true).unwrap();
    let list = |p: &[Vec3]| [p[0], p[0], p[1], p[2], p[3], p[4]];
    let repeated = align_umeyama(&list(&src), &list(&dst), None, true).unwrap();
    assert_close!(weighted.matrix(), repeated.matrix(), 1e-10);
}

#[test]
fn moving_either_set_moves_the_answer() {
    let mut rng = generator(11);
    let src = points(11, 12);
    let dst: Vec<_> = moved(&similarity(11), &src).iter().map(|p| p + random_vec3(&mut rng, 0.5)).collect();
    let found = align_umeyama(&src, &dst, None, true).unwrap();
    let (a, b) = (similarity(12), similarity(13));
    let after = align_umeyama(&moved(&a, &src), &moved(&b, &dst), None, true).unwrap();
    assert_close!(after.matrix(), (b * found * a.inverse()).matrix(), 1e-8);
}

#[test]
fn sets_that_determine_nothing_are_refused() {
    let line: Vec<_> = (0..5).map(|i| Vec3::new(1.0, 2.0, 3.0) * f64::from(i)).collect();
    let some = points(1, 5);
    assert!(align_umeyama(&line, &moved(&similarity(1), &line), None, true).is_none(), "on a line");
    assert!(align_umeyama(&[Vec3::x(); 5], &some, None, true).is_none(), "one place");
    assert!(align_umeyama(&some[..2], &some[..2], None, true).is_none(), "two points");
    assert!(align_umeyama(&some, &some[..4], None, true).is_none(), "lengths");
    assert!(align_umeyama(&some, &some, Some(&[1.0, 1.0, 0.0, 0.0, 0.0]), true).is_none(), "two weights");
    assert!(
        align_umeyama(&some, &some, Some(&[1.0, 1.0, 1.0, 1.0, -1.0]), true).is_none(),
        "negative weight"
    );
    let mut broken = some.clone();
    broken[0].x = f64::NAN;
    assert!(align_umeyama(&broken, &some, None, true).is_none(), "not a number");
    assert_close!(
        align_umeyama(&some, &some, None, true).unwrap().rotation.matrix(),
        SO3::identity().matrix(),
        1e-12
    );
}
