//! The extractor as a whole: conformance with the specification, repeatability, invariances, bad input.

mod common;

use common::{HEIGHT, WIDTH, config, median, render, with_threads};
use dsslam_features::{Extractor, ExtractorConfig, Features, level_quotas, match_brute_force};
use geometry::GrayImage;

fn extract(image: &GrayImage) -> Features {
    Extractor::new(config()).extract(image)
}

fn plain() -> GrayImage {
    render(|x, y| (x, y))
}

/// Size of the level of a keypoint, and its place there.
fn on_level(keypoint: &dsslam_features::Keypoint) -> ([f64; 2], [f64; 2]) {
    let scale = 1.2f64.powi(i32::from(keypoint.octave));
    let size = [WIDTH as f64, HEIGHT as f64].map(|n| (n / scale).round());
    let place = |full: f32, side: f64, all: usize| (f64::from(full) + 0.5) * side / all as f64 - 0.5;
    (size, [place(keypoint.x, size[0], WIDTH), place(keypoint.y, size[1], HEIGHT)])
}

#[test]
fn quotas_are_filled_and_not_exceeded() {
    let features = extract(&plain());
    let quotas = level_quotas(1000, 8, 1.2);
    for (octave, &quota) in quotas.iter().enumerate() {
        let n = features.keypoints.iter().filter(|k| usize::from(k.octave) == octave).count();
        assert!(n <= quota, "octave {octave}: {n} of {quota}");
        // The coarsest levels of an image this small have fewer corners than places.
        assert!(octave > 4 || n == quota, "octave {octave}: {n} of {quota}");
    }
    assert_eq!(features.keypoints.len(), features.descriptors.len());
}

#[test]
fn corners_keep_sixteen_pixels_from_the_edge_of_their_level() {
    for subpixel in [false, true] {
        let features = Extractor::new(ExtractorConfig { subpixel, ..config() }).extract(&plain());
        // The refinement moves a corner by less than a pixel.
        let edge = if subpixel { 15.0 } else { 16.0 };
        for keypoint in &features.keypoints {
            for (side, place) in std::iter::zip(on_level(keypoint).0, on_level(keypoint).1) {
                assert!(place > edge - 0.01 && place < side - edge, "{keypoint:?}");
                assert!(
                    subpixel || (place - place.round()).abs() < 0.01,
                    "{keypoint:?} lies on a whole pixel"
                );
            }
        }
    }
}

#[test]
fn order_is_by_octave_row_column() {
    let features = Extractor::new(ExtractorConfig { subpixel: false, ..config() }).extract(&plain());
    let key = |k: &dsslam_features::Keypoint| (k.octave, (k.y * 16.0) as i32, (k.x * 16.0) as i32);
    assert!(features.keypoints.windows(2).all(|w| key(&w[0]) < key(&w[1])));
    assert!(features.keypoints.iter().all(|k| (0.0..360.0).contains(&k.angle_deg) && k.response >= 7.0));
}

#[test]
fn same_bytes_for_any_number_of_threads_and_any_history() {
    let image = plain();
    let reference = with_threads(1, || extract(&image));
    for n in [2, 3, 8] {
        assert_eq!(with_threads(n, || extract(&image)), reference);
    }
    // Buffers used before, for another size too, leave no trace.
    let mut used = Extractor::new(config());
    used.extract(&GrayImage::from_fn(333, 211, |x, y| (x * y % 251) as u8));
    used.extract(&render(|x, y| (x + 1000.0, y)));
    assert_eq!(used.extract(&image), reference);
}

#[test]
fn a_shift_of_the_image_shifts_the_corners() {
    // One threshold and no quota: what is found then depends on the surroundings of a corner only.
    let all = ExtractorConfig { keep: 100_000, levels: 1, fast_initial: 15, fast_minimum: 15, ..config() };
    let find = |dx: f64, dy: f64| Extractor::new(all.clone()).extract(&render(|x, y| (x + dx, y + dy)));
    let (reference, shifted) = (find(0.0, 0.0), find(-11.0, 5.0));
    let mut n_inside = 0;
    for (keypoint, descriptor) in reference.keypoints.iter().zip(&reference.descriptors) {
        let (x, y) = (keypoint.x + 11.0, keypoint.y - 5.0);
        let inside = x > 40.0 && y > 40.0 && x < WIDTH as f32 - 40.0 && y < HEIGHT as f32 - 40.0;
        if inside {
            n_inside += 1;
            let twin =
                shifted.keypoints.iter().position(|k| (k.x - x).abs() < 1e-3 && (k.y - y).abs() < 1e-3);
            let twin = twin.unwrap_or_else(|| panic!("{keypoint:?} is not found again"));
            assert_eq!(shifted.descriptors[twin], *descriptor);
            assert_eq!(shifted.keypoints[twin].angle_deg, keypoint.angle_deg);
        }
    }
    assert!(n_inside > 300, "{n_inside}");
}

#[test]
fn sub_pixel_positions_follow_a_fractional_shift() {
    let error = |subpixel: bool| {
        let settings = ExtractorConfig { levels: 1, subpixel, ..config() };
        let mut extractor = Extractor::new(settings);
        let reference = extractor.extract(&plain());
        let mut errors = Vec::new();
        for shift in [0.25, 0.5, 0.75] {
            let shifted = extractor.extract(&render(|x, y| (x + shift, y + shift)));
            for (i, j) in match_brute_force(&reference.descriptors, &shifted.descriptors, 50, 0.8) {
                let (a, b) = (reference.keypoints[i as usize], shifted.keypoints[j as usize]);
                errors.push(f64::from((a.x - b.x) - shift as f32).abs());
                errors.push(f64::from((a.y - b.y) - shift as f32).abs());
            }
        }
        assert!(errors.len() > 500);
        median(errors)
    };
    let (whole, refined) = (error(false), error(true));
    assert!(refined < 0.6 * whole, "{refined} px refined, {whole} px whole");
}

#[test]
fn descriptors_are_found_again_after_a_rotation() {
    let (cx, cy) = (WIDTH as f64 / 2.0, HEIGHT as f64 / 2.0);
    let reference = extract(&plain());
    for degrees in [17.0f64, 45.0, 90.0, 133.0, 180.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        // The pixel at `p` of the rotated image shows what the first one has at `center + R (p - center)`.
        let turn =
            |x: f64, y: f64| (cx + cos * (x - cx) - sin * (y - cy), cy + sin * (x - cx) + cos * (y - cy));
        let rotated = extract(&render(turn));
        let pairs = match_brute_force(&reference.descriptors, &rotated.descriptors, 50, 0.8);
        let right = pairs.iter().filter(|&&(i, j)| {
            let (a, b) = (&reference.keypoints[i as usize], &rotated.keypoints[j as usize]);
            let (x, y) = turn(f64::from(b.x), f64::from(b.y));
            let turned = (f64::from(a.angle_deg - b.angle_deg) - degrees).rem_euclid(360.0);
            let near =
                (x - f64::from(a.x)).hypot(y - f64::from(a.y)) < 3.0 * 1.2f64.powi(i32::from(a.octave));
            near && !(30.0..330.0).contains(&turned)
        });
        let n_right = right.count();
        assert!(n_right >= 100, "{degrees} degrees: {n_right} of {}", pairs.len());
        assert!(n_right * 100 >= pairs.len() * 85, "{degrees} degrees: {n_right} of {}", pairs.len());
    }
}

#[test]
fn images_without_corners_and_images_too_small_give_nothing() {
    let sizes = [(0, 0), (1, 1), (5, 300), (300, 5), (32, 32), (33, 33), (40, 60)];
    for (width, height) in sizes {
        for value in [0, 128, 255] {
            assert!(extract(&GrayImage::new(width, height, value)).keypoints.is_empty());
        }
        // Whatever is found in noise, it must not panic.
        extract(&GrayImage::from_fn(width, height, |x, y| (x * 7919 + y * 104_729) as u8));
    }
    let nothing = ExtractorConfig { keep: 0, ..config() };
    assert!(Extractor::new(nothing).extract(&plain()).keypoints.is_empty());
    let no_levels = ExtractorConfig { levels: 0, ..config() };
    assert!(Extractor::new(no_levels).extract(&plain()).keypoints.is_empty());
    let extreme = ExtractorConfig { fast_initial: 255, fast_minimum: 0, ..config() };
    assert!(!Extractor::new(extreme).extract(&plain()).keypoints.is_empty());
}

#[test]
fn dim_cells_use_the_lower_threshold() {
    // The right half has a tenth of the contrast.
    let image = GrayImage::from_fn(WIDTH, HEIGHT, |x, y| {
        let value = common::texture(x as f64, y as f64);
        if x < WIDTH / 2 { value as u8 } else { (100.0 + 0.25 * value) as u8 }
    });
    let count = |minimum: u8| {
        let features = Extractor::new(ExtractorConfig { fast_minimum: minimum, ..config() }).extract(&image);
        features.keypoints.iter().filter(|k| k.x > WIDTH as f32 / 2.0 + 32.0).count()
    };
    let (strict, both) = (count(20), count(7));
    assert!(both > strict + 50, "{strict} at 20 only, {both} at 20 and 7");
}

#[test]
fn octaves_agree_on_where_things_are() {
    // Blobs far apart are found on several levels; all must place them alike, at the far edge too.
    let image = GrayImage::from_fn(WIDTH, HEIGHT, |x, y| {
        let from_center = |v: usize| (v % 80) as f64 - 40.0;
        let distance_sq = from_center(x).powi(2) + from_center(y).powi(2);
        (40.0 + 180.0 * (-distance_sq / 40.0).exp()) as u8
    });
    let features = Extractor::new(ExtractorConfig { keep: 4000, ..config() }).extract(&image);
    let mut offsets = vec![Vec::new(); 8];
    for keypoint in &features.keypoints {
        let from_center = |v: f32| f64::from(v).rem_euclid(80.0) - 40.0;
        let (dx, dy) = (from_center(keypoint.x), from_center(keypoint.y));
        if dx.hypot(dy) < 4.0 * 1.2f64.powi(i32::from(keypoint.octave)) {
            offsets[usize::from(keypoint.octave)].push((dx, dy));
        }
    }
    let mut n_octaves = 0;
    for (octave, found) in offsets.iter().enumerate().filter(|(_, found)| found.len() >= 10) {
        n_octaves += 1;
        let mean = |of: fn(&(f64, f64)) -> f64| found.iter().map(of).sum::<f64>() / found.len() as f64;
        let (x, y) = (mean(|o| o.0), mean(|o| o.1));
        assert!(x.hypot(y) < 0.35, "octave {octave}: blobs are found ({x}, {y}) px from where they are");
    }
    assert!(n_octaves >= 4, "{n_octaves}");
}
