//! What follows from a point's observations: representative descriptor, mean viewing direction, distance range.

use features::Descriptor;
use geometry::Vec3;

use crate::arena::Arena;
use crate::map::RemovedKeyframe;
use crate::{Keyframe, KeyframeId, Map, Observation, PointId};

type Keyframes = Arena<KeyframeId, Keyframe, RemovedKeyframe>;

/// From where and at which distances a point is expected to be found.
pub(crate) struct ViewingGeometry {
    pub(crate) normal: Vec3,
    pub(crate) min_distance_m: f64,
    pub(crate) max_distance_m: f64,
}

/// The descriptor with the least median Hamming distance to the others (lower median), ties by keyframe id.
///
/// `observations` must not be empty.
pub(crate) fn representative_descriptor(keyframes: &Keyframes, observations: &[Observation]) -> Descriptor {
    let descriptors: Vec<Descriptor> = observations
        .iter()
        .map(|o| keyframes.live(o.keyframe).frame.descriptors[o.feature as usize])
        .collect();
    let n = descriptors.len();
    if n <= 2 {
        return descriptors[0];
    }
    let mut distances = vec![0_u32; n * n];
    for i in 0..n {
        for j in i + 1..n {
            let d = descriptors[i].distance(&descriptors[j]);
            distances[i * n + j] = d;
            distances[j * n + i] = d;
        }
    }
    // The distance to itself, 0, sorts first: the lower median of the n - 1 others is at (n - 2) / 2 + 1 = n / 2.
    let median = |i: usize| *distances[i * n..(i + 1) * n].to_vec().select_nth_unstable(n / 2).1;
    let best = (0..n).min_by_key(|&i| (median(i), i)).unwrap_or(0);
    descriptors[best]
}

/// Mean viewing direction and distance range of a point at `position`, seen from the present poses.
///
/// The reference must be among the observations.
pub(crate) fn viewing_geometry(
    keyframes: &Keyframes,
    observations: &[Observation],
    reference: Observation,
    position: &Vec3,
) -> ViewingGeometry {
    let directions = observations
        .iter()
        .filter_map(|o| (position - keyframes.live(o.keyframe).center()).try_normalize(f64::MIN_POSITIVE));
    let sum = directions.fold(Vec3::zeros(), |sum, d| sum + d);
    let keyframe = keyframes.live(reference.keyframe);
    let offset = position - keyframe.center();
    let optical_axis = || keyframe.cam_from_world.rotation.inverse() * Vec3::z();
    let normal = sum
        .try_normalize(f64::EPSILON)
        .or_else(|| offset.try_normalize(f64::MIN_POSITIVE))
        .unwrap_or_else(optical_axis);

    let scales = &keyframe.frame.scales.scales;
    let octave = usize::from(keyframe.frame.keypoints[reference.feature as usize].octave);
    let max_distance_m = offset.norm() * f64::from(scales[octave]);
    let min_distance_m = max_distance_m / f64::from(scales[scales.len() - 1]);
    ViewingGeometry { normal, min_distance_m, max_distance_m }
}

impl Map {
    /// Renews everything that follows from the observations of a point.
    pub(crate) fn refresh_point(&mut self, id: PointId) {
        let point = self.points.live_mut(id);
        point.descriptor = representative_descriptor(&self.keyframes, &point.observations);
        self.refresh_geometry(id);
    }

    /// Renews what follows from the poses of the observers and the position of a point.
    pub(crate) fn refresh_geometry(&mut self, id: PointId) {
        let point = self.points.live_mut(id);
        let feature = point.feature_in(point.reference).expect("the reference keyframe observes the point");
        let reference = Observation { keyframe: point.reference, feature };
        let view = viewing_geometry(&self.keyframes, &point.observations, reference, &point.position);
        point.normal = view.normal;
        point.min_distance_m = view.min_distance_m;
        point.max_distance_m = view.max_distance_m;
    }
}
