//! Map files of a synthetic street: `measure` prints sizes and times, `save FILE` saves two versions in turn until it is
//! killed (see the test `map_file`).
#![allow(clippy::print_stdout, reason = "a program for people and tests")]

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use features::{Descriptor, Features, Frame, Keypoint, Rig, ScaleLevels};
use geometry::{Distortion, Pinhole, SE3, SO3, StereoRig, Vec3};
use map::file::{decode, encode};
use map::{Batch, Map, MapFileInfo, NewKeyframe, NewPoint, Observation, PointId};

/// Size of a synthetic map.
struct Street {
    n_keyframes: u32,
    n_features: u32,
    /// Points that each keyframe makes.
    n_new: u32,
}

/// What a drive over several hundred meters leaves.
const MEASURED: Street = Street { n_keyframes: 300, n_features: 1_500, n_new: 134 };
/// Enough that saving takes a while.
const SAVED: Street = Street { n_keyframes: 40, n_features: 1_000, n_new: 100 };

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["measure"] => measure(&MEASURED),
        ["save", path] => save_for_ever(&SAVED, Path::new(path)),
        _ => Err("usage: map_file measure | map_file save FILE".into()),
    }
}

/// Prints the digests of both versions, then `saved` after the first save.
fn save_for_ever(street: &Street, path: &Path) -> Result<(), Box<dyn Error>> {
    let first = street.map()?;
    let mut second = first.clone();
    second.remove_point(first.points().next().ok_or("a map without points")?.id)?;
    println!("{} {}", first.digest(), second.digest());
    let versions = [first, second].map(|map| encode(&map, &MapFileInfo::default()));
    io::write_durable(path, &versions[0])?;
    println!("saved");
    loop {
        for version in &versions {
            io::write_durable(path, version)?;
        }
    }
}

#[allow(clippy::disallowed_methods, reason = "the clock is what this is about")]
fn measure(street: &Street) -> Result<(), Box<dyn Error>> {
    let map = street.map()?;
    let n_observations: usize = map.points().map(|p| p.n_observations()).sum();
    println!(
        "{} keyframes of {} features, {} points, {n_observations} observations",
        map.n_keyframes(),
        street.n_features,
        map.n_points()
    );
    let info = MapFileInfo::default();
    let bytes = encode(&map, &info);
    println!("file: {:.2} MB", bytes.len() as f64 / 1e6);
    let timed = |what: &str, work: &dyn Fn() -> Result<(), Box<dyn Error>>| {
        let mut times = Vec::new();
        for _ in 0..5 {
            let start = std::time::Instant::now();
            work()?;
            times.push(start.elapsed().as_secs_f64());
        }
        times.sort_by(f64::total_cmp);
        println!("{what}: best {:.3} s, median {:.3} s", times[0], times[2]);
        Ok::<(), Box<dyn Error>>(())
    };
    timed("encode", &|| if encode(&map, &info) == bytes { Ok(()) } else { Err("other bytes".into()) })?;
    timed("decode", &|| match decode(&bytes)?.0.digest() == map.digest() {
        true => Ok(()),
        false => Err("another map".into()),
    })?;
    timed("check alone", &|| map.check().map_err(|found| format!("{found:?}").into()))?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("street.dsmap");
    timed("write_durable", &|| Ok(io::write_durable(&path, &bytes)?))?;
    timed("write_atomic", &|| Ok(io::write_atomic(&path, &bytes)?))
}

impl Street {
    /// Keyframes in a row, one meter apart; the points of each are seen in the next ones too.
    fn map(&self) -> Result<Map, Box<dyn Error>> {
        let stereo =
            StereoRig { camera: Pinhole { fx: 718.0, fy: 718.0, cx: 607.0, cy: 185.0 }, baseline_m: 0.54 };
        let rig = Arc::new(Rig { stereo, distortion: Distortion::default(), width: 1241, height: 376 });
        let scales = Arc::new(ScaleLevels::new(8, 1.2));
        let mut map = Map::new();
        for k in 0..self.n_keyframes {
            let keyframe = map.next_keyframe_id();
            let frame = Arc::new(self.frame(k, rig.clone(), scales.clone()));
            let cam_from_world = SE3::new(SO3::identity(), Vec3::new(0.0, 0.0, -f64::from(k)));
            let oldest = map.next_point_id().0.saturating_sub(7 * self.n_new);
            // Each point for as many keyframes as its number says: 0 to 7 after its own.
            let seen = (oldest..map.next_point_id().0)
                .filter(|p| k - p / self.n_new <= p % 8 && map.point(PointId(*p)).is_some());
            let matches: Vec<(u32, PointId)> = (0..).zip(seen.map(PointId)).collect();
            let first_new = matches.len() as u32;
            let point = |feature: u32| NewPoint {
                position: Vec3::new(
                    20.0 * uniform(k, feature, 20) - 10.0,
                    4.0 * uniform(k, feature, 21) - 2.0,
                    f64::from(k) + 5.0 + 40.0 * uniform(k, feature, 22),
                ),
                observations: vec![Observation { keyframe, feature }],
            };
            let points = (first_new..first_new + self.n_new).map(point).collect();
            let new = NewKeyframe { frame, cam_from_world, matches, parent: map::Parent::Closest };
            map.insert(Batch { keyframe: Some(new), points })?;
        }
        Ok(map)
    }

    /// Features all over the image, two thirds of them with depth.
    fn frame(&self, index: u32, rig: Arc<Rig>, scales: Arc<ScaleLevels>) -> Frame {
        let keypoint = |i: u32| Keypoint {
            x: (1241.0 * uniform(index, i, 1)) as f32,
            y: (376.0 * uniform(index, i, 2)) as f32,
            octave: (8.0 * uniform(index, i, 3).powi(2)) as u8,
            angle_deg: (360.0 * uniform(index, i, 4)) as f32,
            response: (7.0 + 60.0 * uniform(index, i, 5)).floor() as f32,
        };
        let keypoints: Vec<Keypoint> = (0..self.n_features).map(keypoint).collect();
        let descriptor = |i: u32| Descriptor(std::array::from_fn(|word| random(index, i, 10 + word as u64)));
        let descriptors = (0..self.n_features).map(descriptor).collect();
        let right_u = (0..).zip(&keypoints).map(|(i, k)| match uniform(index, i, 6) {
            known if known < 0.67 => k.x - 1.0 - 100.0 * known as f32,
            _ => f32::NAN,
        });
        let right_u = right_u.collect();
        Frame::new(index, 0.1 * f64::from(index), rig, scales, Features { keypoints, descriptors }, right_u)
    }
}

fn random(keyframe: u32, feature: u32, purpose: u64) -> u64 {
    geometry::mix_seed(u64::from(keyframe), u64::from(feature), purpose)
}

/// From 0 to 1.
fn uniform(keyframe: u32, feature: u32, purpose: u64) -> f64 {
    (random(keyframe, feature, purpose) >> 11) as f64 / (1_u64 << 53) as f64
}
