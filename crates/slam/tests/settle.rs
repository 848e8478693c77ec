//! The last look at the whole map at the end of a run.

#[allow(dead_code, reason = "shared with other tests")]
mod common;

use common::{Pair, World, slalom};
use dsslam_slam::{CameraParams, NoProbe, Params};

const FRAMES: u32 = 60;

fn params(final_bundle: bool) -> Params {
    let mut params = Params::of(CameraParams::stereo(21.0, 10.0));
    params.mapping.refine_calibration = false;
    params.mapping.final_bundle = final_bundle;
    // Windows so small that local adjustments hold most of the corridor.
    params.mapping.max_local_keyframes = 3;
    params.mapping.keyframe_cull_ratio = 1.0;
    params.tracking.keyframe_ratio = Some(0.95);
    params
}

/// A drive whose noise depends on `seed`.
fn drive(world: &World, seed: u32, params: &Params) -> Pair {
    let mut pair = Pair::new(params);
    for i in 0..FRAMES {
        pair.step(&world.frame(1000 * seed + i, &slalom(i)));
    }
    pair
}

/// Root mean square of the keyframes' position errors, meters, and how many there are.
fn error_m(pair: &Pair) -> (f64, usize) {
    let map = &pair.mapper.world().map;
    let squares = map.keyframes().map(|keyframe| {
        let truth = slalom(keyframe.frame.index % 1000);
        (keyframe.cam_from_world.inverse().translation - truth.translation).norm_squared()
    });
    let squares: Vec<f64> = squares.collect();
    ((squares.iter().sum::<f64>() / squares.len() as f64).sqrt(), squares.len())
}

#[test]
fn all_keyframes_together_are_more_exact_than_one_after_the_other() {
    let world = World::with_density(80.0, 0.5, 12.0);
    let mut ratios = Vec::new();
    for seed in 1..=6 {
        let mut pair = drive(&world, seed, &params(true));
        let (before, n) = error_m(&pair);
        assert!(n > 15, "{n} keyframes");
        pair.mapper.settle(&mut NoProbe);
        assert_eq!(pair.mapper.world().map.check(), Ok(()));
        ratios.push(error_m(&pair).0 / before);
    }
    let mean = ratios.iter().map(|ratio: &f64| ratio.ln()).sum::<f64>() / ratios.len() as f64;
    assert!(mean.exp() < 0.95, "{ratios:.2?}");
}

#[test]
fn nothing_moves_where_it_is_switched_off() {
    let world = World::with_density(80.0, 0.5, 12.0);
    let mut pair = drive(&world, 1, &params(false));
    let before = pair.mapper.world().map.revision();
    pair.mapper.settle(&mut NoProbe);
    assert_eq!(pair.mapper.world().map.revision(), before);
}
