//! Ids name what they should, observations exist on both sides, points have enough of them.

use super::Violation;
use crate::ids::Id;
use crate::{KeyframeId, Map, MapPoint, Observation, PROBATION_KEYFRAMES, PointId};

impl Map {
    /// Things carry the id that they are stored under, and what was replaced leads to its replacement.
    pub(super) fn check_ids(&self, found: &mut Vec<Violation>) {
        for (keyframe, item) in self.keyframes.iter().filter(|(id, item)| *id != item.id) {
            found.push(Violation::KeyframeId { keyframe, carries: item.id });
        }
        for (point, item) in self.points.iter().filter(|(id, item)| *id != item.id) {
            found.push(Violation::PointId { point, carries: item.id });
        }
        for point in (0..self.points.len()).map(PointId::from_index) {
            let step = |p: PointId| self.points.forward(p).copied();
            if !ends_inside(point, self.points.len(), step) {
                found.push(Violation::PointForward { point });
            }
        }
        for keyframe in (0..self.keyframes.len()).map(KeyframeId::from_index) {
            let step = |k: KeyframeId| self.keyframes.forward(k).map(|r| r.parent);
            let is_forwarded = step(keyframe).is_some() || self.keyframe(keyframe).is_some();
            if !is_forwarded || !ends_inside(keyframe, self.keyframes.len(), step) {
                found.push(Violation::KeyframeForward { keyframe });
            }
        }
    }

    pub(super) fn check_observations(&self, found: &mut Vec<Violation>) {
        for (id, keyframe) in self.keyframes.iter() {
            let (n_features, n_entries) = (keyframe.frame.len(), keyframe.points().len());
            if n_features != n_entries {
                found.push(Violation::TableLength { keyframe: id, n_features, n_entries });
            }
            for (feature, point) in (0_u32..).zip(keyframe.points()) {
                let observation = Observation { keyframe: id, feature };
                match point.map(|p| (p, self.point(p))) {
                    Some((missing, None)) => {
                        found.push(Violation::MissingPoint { keyframe: id, feature, missing });
                    }
                    Some((point, Some(p))) if !p.observations().contains(&observation) => {
                        found.push(Violation::UnlistedObservation { keyframe: id, feature, point });
                    }
                    _ => {}
                }
            }
        }
        for (id, point) in self.points.iter() {
            self.check_observers(id, point, found);
            self.check_count_and_reference(id, point, found);
        }
    }

    fn check_observers(&self, point: PointId, p: &MapPoint, found: &mut Vec<Violation>) {
        for &Observation { keyframe, feature } in p.observations() {
            match self.keyframe(keyframe) {
                None => found.push(Violation::MissingObserver { point, missing: keyframe }),
                Some(k) => {
                    let shows = k.point_at(feature);
                    if shows != Some(point) {
                        found.push(Violation::OneSidedObservation { point, keyframe, feature, shows });
                    }
                }
            }
        }
        for pair in p.observations().windows(2).filter(|w| w[0].keyframe >= w[1].keyframe) {
            found.push(Violation::ObservationOrder { point, keyframe: pair[1].keyframe });
        }
    }

    fn check_count_and_reference(&self, point: PointId, p: &MapPoint, found: &mut Vec<Violation>) {
        let (created_by, n_observations, n_keyframes) =
            (p.created_by, p.observations().len(), self.keyframes.len());
        if created_by.index() >= n_keyframes {
            found.push(Violation::Creator { point, created_by });
        }
        let newer = n_keyframes.saturating_sub(created_by.index() + 1);
        let needed = if newer < PROBATION_KEYFRAMES { 1 } else { 2 };
        if n_observations < needed {
            found.push(Violation::TooFewObservations { point, created_by, n_observations });
        }
        let reference = p.reference;
        if self.keyframe(reference).is_none() {
            found.push(Violation::MissingObserver { point, missing: reference });
        }
        if !p.observations().iter().any(|o| o.keyframe == reference) {
            found.push(Violation::Reference { point, reference });
        }
    }
}

/// Following the steps ends after at most `len` of them, at an id below `len`.
fn ends_inside<I: Id>(start: I, len: usize, step: impl Fn(I) -> Option<I>) -> bool {
    let mut id = start;
    for _ in 0..=len {
        match step(id) {
            Some(next) => id = next,
            None => return id.index() < len,
        }
    }
    false
}
