//! Lays the true path onto the map: the map stays where it is, so that nothing but the true path has to be sent again.

use geometry::{SO3, Sim3, Vec3, align_umeyama};

/// From the coordinates of the truth to those of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    map_from_truth: Sim3,
}

impl Alignment {
    /// The best one for pairs (true position, position in the map), meters; scale only where the map's is free. With fewer
    /// than three pairs the first ones are laid on each other. `None` without a pair.
    pub fn of(pairs: &[(Vec3, Vec3)], with_scale: bool) -> Option<Self> {
        let (truth, found): (Vec<Vec3>, Vec<Vec3>) = pairs.iter().copied().unzip();
        let best = align_umeyama(&truth, &found, None, with_scale).filter(Sim3::is_valid);
        let first = pairs.first().map(|(truth, found)| Sim3::new(SO3::identity(), found - truth, 1.0));
        best.or(first).map(|map_from_truth| Alignment { map_from_truth })
    }

    /// Where a true position lies in the map, in the map's unit of length.
    pub fn apply(&self, truth: &Vec3) -> Vec3 {
        self.map_from_truth * *truth
    }

    /// The map's unit of length, meters; 1 where it is not free.
    pub fn meters_per_unit(&self) -> f64 {
        1.0 / self.map_from_truth.scale
    }
}
