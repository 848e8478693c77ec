//! Every vector kernel against its scalar twin, bit for bit, on random images of odd sizes.

use simd::Simd;

use super::{blur, brief, fast, moments, normal, resize::Resizer, sad};
use crate::detect::rows_around;
use crate::plane::Plane;
use geometry::GrayImage;
use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Noise of `contrast` gray levels on smooth ramps, so that corners, edges and flat parts occur.
fn textured(width: usize, height: usize, contrast: u8, seed: u64) -> Plane {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let image = GrayImage::from_fn(width, height, |x, y| {
        let block = if (x / 9 + y / 7) % 3 == 0 { 90 } else { 0 };
        let noise = if contrast == 0 { 0 } else { rng.random_range(0..=contrast) };
        (block + (x + 2 * y) % 140).min(255) as u8 / 2 + noise / 2
    });
    let mut plane = Plane::default();
    plane.copy_from(&image);
    plane
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn blur_is_equal(width in 1usize..150, height in 1usize..40, contrast: u8, seed: u64) {
        let source = textured(width, height, contrast, seed);
        let [mut scalar, mut vector] = [Plane::default(), Plane::default()];
        blur::gaussian(Simd::scalar(), &source, &mut Vec::new(), &mut scalar);
        blur::gaussian(Simd::detect(), &source, &mut Vec::new(), &mut vector);
        prop_assert_eq!(scalar.to_image(), vector.to_image());
    }

    #[test]
    fn resize_is_equal(width in 1usize..200, height in 1usize..40, factor in 1.0f64..3.0, seed: u64) {
        let source = textured(width, height, 255, seed);
        let size = [width, height].map(|n| ((n as f64 / factor).round() as usize).max(1));
        let [mut scalar, mut vector] = [Plane::default(), Plane::default()];
        Resizer::default().run(Simd::scalar(), &source, size.into(), &mut scalar);
        Resizer::default().run(Simd::detect(), &source, size.into(), &mut vector);
        prop_assert_eq!(scalar.to_image(), vector.to_image());
    }

    #[test]
    fn corner_scores_and_maxima_are_equal(width in 7usize..150, contrast: u8, threshold in 1u8..60, seed: u64) {
        let source = textured(width, 9, contrast, seed);
        let find = |simd| {
            let score = |y: usize| {
                let mut scores = vec![255; width + 40];
                scores[..3].fill(0);
                fast::score_row(simd, &rows_around(&source, y), 3, width - 3, threshold, &mut scores);
                scores.truncate(width + 29);
                scores
            };
            let rows = [3, 4, 5].map(score);
            let mut maxima = Vec::new();
            let [a, b, c] = rows.each_ref().map(Vec::as_slice);
            fast::local_maxima(simd, [a, b, c], 3, width - 3, &mut maxima);
            (rows, maxima)
        };
        prop_assert_eq!(find(Simd::scalar()), find(Simd::detect()));
    }

    #[test]
    fn scores_of_a_square_are_equal(contrast: u8, seed: u64, x in 4usize..40) {
        let source = textured(45, 9, contrast, seed);
        let square = |simd| fast::score_square(simd, &std::array::from_fn(|i| source.row(i)), x);
        prop_assert_eq!(square(Simd::scalar()), square(Simd::detect()));
        prop_assert_eq!(square(Simd::detect())[1][1], fast::score_at(&rows_around(&source, 4), x));
    }

    #[test]
    fn costs_are_equal(width in 18usize..160, contrast: u8, brighter in 0u8..60, seed: u64) {
        let image = textured(30, 11, contrast, seed);
        let mut other = textured(width, 11, contrast, seed ^ 1);
        for value in other.row_mut(5) {
            *value = value.saturating_add(brighter);
        }
        let costs = |simd| {
            let mut costs = Vec::new();
            let strip = (&other, 8, width - 15);
            let mut scratch = sad::Scratch::default();
            sad::costs_along_row(simd, (&image, 11, 5), strip, &mut scratch, &mut costs);
            let biases: Vec<i16> = (0..costs.len()).map(|place| scratch.bias(place)).collect();
            (costs, biases)
        };
        prop_assert_eq!(costs(Simd::scalar()).0.len(), width - 15);
        prop_assert_eq!(costs(Simd::scalar()), costs(Simd::detect()));
    }

    #[test]
    fn normal_equations_are_equal(contrast: u8, fraction in 0i16..128, offset: i16, robust: bool, seed: u64) {
        let (left, right) = (textured(24, 20, contrast, seed), textured(40, 20, contrast, seed));
        let patch = normal::Patch::new(Simd::detect(), &left, 11, 9);
        let rows: [normal::Row<'_>; normal::SIDE] = std::array::from_fn(|j| normal::Row {
            pixels: &right.row(j + 2)[3 + j / 3..],
            fraction: (fraction + j as i16) % 128,
        });
        prop_assert_eq!(&patch, &normal::Patch::new(Simd::scalar(), &left, 11, 9));
        let sums = |simd| normal::sums(simd, &patch, &rows, offset, robust);
        prop_assert_eq!(sums(Simd::scalar()), sums(Simd::detect()));
    }

    #[test]
    fn moments_are_equal(contrast: u8, x in 15usize..45, y in 15usize..35, seed: u64) {
        let source = textured(61, 51, contrast, seed);
        let sum = |simd| moments::moments(simd, source.data(), source.stride(), y * source.stride() + x);
        prop_assert_eq!(sum(Simd::scalar()), sum(Simd::detect()));
    }

    #[test]
    fn descriptors_are_equal(contrast in 1u8.., angle in 0.0f32..7.0, seed: u64) {
        let source = textured(45, 43, contrast, seed);
        let offset = 20 * source.stride() + 21;
        let describe = |simd| brief::describe(simd, source.data(), source.stride(), offset, angle.cos(), angle.sin());
        prop_assert_eq!(describe(Simd::scalar()), describe(Simd::detect()));
    }
}

#[test]
fn score_is_the_largest_threshold_that_keeps_the_corner() {
    let is_corner = |rows: &[&[u8]; 7], x: usize, threshold: i32| {
        let center = i32::from(rows[3][x]);
        let ring = fast::RING.map(|(dx, dy)| i32::from(rows[dy][x + dx - 3]));
        (0..16).any(|start| {
            let arc = |test: &dyn Fn(i32) -> bool| (0..9).all(|i| test(ring[(start + i) % 16]));
            arc(&|p| p > center + threshold) || arc(&|p| p < center - threshold)
        })
    };
    let source = textured(200, 40, 80, 3);
    let mut n_corners = 0;
    for y in 3..37 {
        let rows = rows_around(&source, y);
        for x in 3..197 {
            let score = fast::score_at(&rows, x);
            let largest = (0..256).rev().find(|&t| is_corner(&rows, x, t)).unwrap_or(0);
            assert_eq!(i32::from(score), largest);
            n_corners += usize::from(score > 7);
        }
    }
    assert!(n_corners > 100, "the image has corners");
}

#[test]
fn constant_images_stay_constant() {
    for value in [0, 1, 127, 254, 255] {
        let mut source = Plane::default();
        source.copy_from(&GrayImage::new(50, 20, value));
        let mut result = Plane::default();
        blur::gaussian(Simd::detect(), &source, &mut Vec::new(), &mut result);
        assert!(result.to_image().data.iter().all(|&v| v == value));
        Resizer::default().run(Simd::detect(), &source, (42, 17), &mut result);
        assert!(result.to_image().data.iter().all(|&v| v == value));
    }
}

#[test]
fn reduction_keeps_a_ramp_in_place() {
    // Pixel centers correspond: x of the result lies at (x + 0.5) * 1.2 - 0.5 of the source.
    let mut source = Plane::default();
    source.copy_from(&GrayImage::from_fn(120, 30, |x, _| (2 * x) as u8));
    let mut result = Plane::default();
    Resizer::default().run(Simd::detect(), &source, (100, 25), &mut result);
    for x in 0..99 {
        let expected = 2.0 * ((x as f64 + 0.5) * 1.2 - 0.5);
        assert!((f64::from(result.at(x, 10)) - expected).abs() <= 0.51, "{x}");
    }
}

#[test]
fn the_largest_sums_do_not_overflow() {
    // Stripes of black and white, two pixels wide: the steepest derivatives everywhere.
    let mut stripes = Plane::default();
    stripes.copy_from(&GrayImage::from_fn(64, 20, |x, _| if x / 2 % 2 == 0 { 0 } else { 255 }));
    let patch = normal::Patch::new(Simd::detect(), &stripes, 16, 9);
    for shift in 0..4 {
        let rows: [normal::Row<'_>; normal::SIDE] =
            std::array::from_fn(|j| normal::Row { pixels: &stripes.row(j + 2)[9 + shift..], fraction: 64 });
        for (offset, robust) in [(0, false), (0, true), (i16::MAX, false), (i16::MIN, false), (4000, true)] {
            let [scalar, vector] = [Simd::scalar(), Simd::detect()];
            let sums = |simd| normal::sums(simd, &patch, &rows, offset, robust);
            assert_eq!(sums(scalar), sums(vector));
        }
    }
}
