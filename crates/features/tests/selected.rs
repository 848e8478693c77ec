//! Features selected by activation: trusted places come first, a selection changes nothing in the
//! features themselves, and the same input gives the same bits.

mod common;

use common::{config, render};
use dsslam_features::{
    ActivationError, ActivationMap, ActivationSource, Extractor, Features, SelectionConfig, SelectionRule,
    Spread,
};
use geometry::{GrayImage, Raster};

/// Gives the same values for every image.
#[derive(Debug)]
struct Fixed(Raster<f32>);

impl ActivationSource for Fixed {
    fn activation(&self, image: &GrayImage) -> Result<ActivationMap, ActivationError> {
        ActivationMap::new(self.0.clone(), image.width, image.height).ok_or(ActivationError::Unknown)
    }
}

const ACTIVATION: SelectionConfig =
    SelectionConfig { rule: SelectionRule::Activation, keep: 200, spread: Spread::Cells };

fn image() -> GrayImage {
    render(|x, y| (x, y))
}

fn selected(selection: SelectionConfig, map: Raster<f32>) -> (Features, Vec<f32>) {
    let mut extractor = Extractor::new(config());
    let selected = extractor.extract_selected(&image(), &selection, &Fixed(map)).expect("the map is one");
    (selected.features, selected.activation)
}

/// Activation `left` in the left half of the image and `right` in the right.
fn halves(left: f32, right: f32) -> Raster<f32> {
    Raster::from_fn(64, 8, |x, _| if x < 32 { left } else { right })
}

fn n_left(features: &Features) -> usize {
    let middle = image().width as f32 / 2.0;
    features.keypoints.iter().filter(|k| k.x < middle).count()
}

#[test]
fn a_selection_leaves_features_and_their_order_as_they_are() {
    let all = Extractor::new(config()).extract(&image());
    let (same, activation) =
        selected(SelectionConfig { keep: 100_000, ..ACTIVATION }, Raster::new(4, 4, 0.8));
    assert_eq!(same, all);
    assert!(activation.len() == all.keypoints.len() && activation.iter().all(|a| (a - 0.8).abs() < 1e-6));
    let (some, _) = selected(ACTIVATION, Raster::new(4, 4, 0.8));
    assert_eq!(some.keypoints.len(), 200);
    let mut rest = all.keypoints.iter().zip(&all.descriptors);
    for wanted in some.keypoints.iter().zip(&some.descriptors) {
        assert!(rest.any(|feature| feature == wanted), "in the same order");
    }
}

#[test]
fn other_places_get_what_their_activation_adds_up_to_where_trusted_ones_are_enough() {
    let everything = SelectionConfig { keep: 100_000, ..ACTIVATION };
    let (_, activation) = selected(everything, halves(0.1, 0.9));
    let distrusted: f32 = activation.iter().filter(|&&a| a < 0.5).sum();
    let reserve = (200.0 * distrusted / activation.iter().sum::<f32>()) as usize;
    assert!((15..35).contains(&reserve), "half of the image at a ninth of the activation: {reserve}");
    for spread in [Spread::Cells, Spread::Anywhere] {
        for rule in [SelectionRule::Activation, SelectionRule::Semantic] {
            let selection = SelectionConfig { rule, spread, ..ACTIVATION };
            let (features, activation) = selected(selection, halves(0.1, 0.9));
            let expected = if rule == SelectionRule::Semantic { 0..=0 } else { reserve - 1..=reserve + 1 };
            assert_eq!(features.keypoints.len(), 200, "{selection:?}");
            let n_others = activation.iter().filter(|&&a| a < 0.5).count();
            assert!(expected.contains(&n_others), "{selection:?}: {n_others}, not {expected:?}");
            assert!(n_left(&features) <= expected.end() + 10, "{selection:?}: {}", n_left(&features));
        }
    }
}

#[test]
fn what_is_missing_comes_from_other_places_by_activation_only() {
    let few = Raster::from_fn(100, 1, |x, _| if x < 5 { 0.9 } else { 0.3 * (x as f32 / 100.0) });
    let (features, activation) = selected(ACTIVATION, few.clone());
    assert_eq!(features.keypoints.len(), 200);
    assert!(activation.iter().any(|&a| a >= 0.5) && activation.iter().any(|&a| a < 0.5));
    let semantic = SelectionConfig { rule: SelectionRule::Semantic, ..ACTIVATION };
    let (features, activation) = selected(semantic, few);
    assert!(!features.keypoints.is_empty() && features.keypoints.len() < 200);
    assert!(activation.iter().all(|&a| a >= 0.5));
}

#[test]
fn what_surely_moves_never_fills_in() {
    let moves = Raster::from_fn(100, 1, |x, _| if x < 5 { 0.9 } else { 0.0 });
    let (features, activation) = selected(ACTIVATION, moves);
    assert!(!features.keypoints.is_empty() && features.keypoints.len() < 200, "{}", features.keypoints.len());
    // A few may share the part of what is between, where the map rises; filling in would take them all.
    let sure = activation.iter().filter(|&&a| a < 0.1).count();
    assert!(2 * sure < activation.len(), "{activation:?}");
}

#[test]
fn spread_features_cover_the_image_more_evenly() {
    // The best of the image are in a narrow band; of each cell the best are everywhere.
    let band = || Raster::from_fn(16, 1, |x, _| if (6..10).contains(&x) { 1.0 } else { 0.7 });
    let in_band = |features: &Features| {
        let width = image().width as f32;
        let inside = |x: f32| (0.37..0.63).contains(&(x / width));
        features.keypoints.iter().filter(|k| inside(k.x)).count()
    };
    let cells = in_band(&selected(ACTIVATION, band()).0);
    let anywhere = in_band(&selected(SelectionConfig { spread: Spread::Anywhere, ..ACTIVATION }, band()).0);
    assert!(anywhere > 2 * cells, "{anywhere} anywhere, {cells} with cells");
}

#[test]
fn of_equally_trusted_places_the_strongest_responses_are_kept() {
    let anywhere = SelectionConfig { spread: Spread::Anywhere, ..ACTIVATION };
    let (features, _) = selected(anywhere, Raster::new(1, 1, 0.9));
    let all = Extractor::new(config()).extract(&image());
    let weakest =
        features.keypoints.iter().map(|k| k.response).min_by(f32::total_cmp).expect("there are some");
    let stronger = all.keypoints.iter().filter(|k| k.response > weakest).count();
    assert!(stronger <= 200 && features.keypoints.len() == 200);
}

#[test]
fn full_activation_is_no_step_of_its_own() {
    // A network that fades to "no opinion" answers 1 here and nearly 1 there, which says nothing about the features.
    let anywhere = SelectionConfig { spread: Spread::Anywhere, ..ACTIVATION };
    let of = |left: f32| selected(anywhere, halves(left, 1.0)).0;
    assert_eq!(of(0.999), of(1.0));
    assert_eq!(of(0.76), of(1.0));
    assert_ne!(of(0.7), of(1.0));
}

#[test]
fn places_need_both_answers_and_take_others_only_where_those_are_too_few() {
    #[derive(Debug)]
    struct Both(Raster<f32>, Raster<f32>);
    impl ActivationSource for Both {
        fn activation(&self, image: &GrayImage) -> Result<ActivationMap, ActivationError> {
            let map = ActivationMap::new(self.0.clone(), image.width, image.height);
            map.and_then(|map| map.with_lasting(self.1.clone())).ok_or(ActivationError::Unknown)
        }
    }
    let places = SelectionConfig { rule: SelectionRule::Places, spread: Spread::Anywhere, keep: 200 };
    let of = |now: Raster<f32>, later: Raster<f32>, keep: usize| {
        let mut extractor = Extractor::new(config());
        let config = SelectionConfig { keep, ..places };
        extractor.extract_selected(&image(), &config, &Both(now, later)).expect("maps of one size").features
    };
    let (all, parked) = (Raster::new(64, 8, 0.9), halves(0.1, 0.9));
    let width = image().width as f32;
    let within = |features: &Features| features.keypoints.iter().all(|k| k.x > 0.49 * width);
    for (now, later) in [(all.clone(), parked.clone()), (parked.clone(), all.clone())] {
        let kept = of(now, later, 200);
        assert!(kept.keypoints.len() == 200 && within(&kept));
    }
    let n = Extractor::new(config()).extract(&image()).keypoints.len();
    assert_eq!(of(all.clone(), parked, n).keypoints.len(), n, "others fill what is missing");
    assert_eq!(
        of(all.clone(), all, 200),
        selected(SelectionConfig { rule: SelectionRule::Activation, ..places }, Raster::new(4, 4, 0.81)).0
    );
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let reference = selected(ACTIVATION, halves(0.3, 0.7));
    for n in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads");
        let again = pool.install(|| selected(ACTIVATION, halves(0.3, 0.7)));
        assert_eq!(again, reference, "{n} threads");
    }
}

#[test]
fn a_source_without_a_map_gives_its_reason() {
    let mut extractor = Extractor::new(config());
    let nothing = &Fixed(Raster::new(0, 0, 0.0));
    let refused = extractor.extract_selected(&image(), &ACTIVATION, nothing);
    assert_eq!(refused, Err(ActivationError::Unknown));
    let selected = extractor
        .extract_selected(&GrayImage::new(20, 20, 9), &ACTIVATION, &Fixed(Raster::new(1, 1, 1.0)))
        .expect("too small an image has no features");
    assert!(selected.features.keypoints.is_empty() && selected.activation.is_empty());
}
