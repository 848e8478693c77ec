//! Which keyframes may show the same place: those that look alike, the one that has been familiar for some keyframes, and those
//! that should be near (ORB-SLAM, Mur-Artal et al. 2015, section VII-A).

use std::collections::{BTreeMap, BTreeSet};

use bow::{BowVector, Familiarity, PlaceMatch};
use geometry::Vec3;
use map::{ClosedLoop, KeyframeId, Map};

use super::outcome::NoLoop;
use super::position_prior::PositionPrior;
use crate::keyframe_database::Alike;
use crate::params::Params;
use crate::world::World;

/// A keyframe must share more than this part of the words that the best one shares.
const MIN_SHARED_WORDS: f64 = 0.8;
/// Groups with less than this part of the best group's score are dropped.
const MIN_GROUP_SCORE: f64 = 0.75;
/// Covisible keyframes whose scores count for a keyframe's group.
const GROUP_SIZE: usize = 10;
/// Keyframes that are near by position need this part of the score that appearance alone would need.
const NEARBY_SCORE: f64 = 0.5;
/// Keyframes near by position that are looked at.
const MAX_NEARBY: usize = 2;
/// The most familiar keyframe must be this much more familiar than any that shares no points with it. In rendered towns driven a
/// second time in other light, most of the right ones are; one in twenty of the others is.
const MIN_CONTRAST: f64 = 1.1;

/// Keyframes that may show the place of `keyframe`, best first; `familiarity` takes what it looks like.
///
/// # Errors
/// Why there is none.
pub(super) fn find(
    keyframe: KeyframeId,
    world: &World,
    params: &Params,
    familiarity: &mut Familiarity,
) -> Result<Vec<KeyframeId>, NoLoop> {
    let map = &world.map;
    let (Some(current), Some((bow, _))) = (map.keyframe(keyframe), world.places.of(keyframe)) else {
        return Err(NoLoop::NoPlaces);
    };
    let near: BTreeSet<KeyframeId> =
        current.covisible().iter().map(|&(id, _)| id).chain(std::iter::once(keyframe)).collect();
    let min_score = lowest_covisible_score(current, bow, world, params.loops.min_covisible_weight);
    let prior = PositionPrior::new(map, keyframe, &params.camera);
    let alike = world.places.alike(bow, |id| !near.contains(&id) && prior.allows(id));
    let best_score = alike.first().map_or(0.0, |m| m.score);
    let mut found = strongest_groups(map, &alike, min_score);
    let similar = alike.iter().filter(|a| a.score >= NEARBY_SCORE * min_score);
    let similar: BTreeSet<KeyframeId> = similar.map(|a| a.keyframe).collect();
    found.extend(most_familiar(map, &alike, familiarity));
    found.extend(prior.nearby(MAX_NEARBY, |id| similar.contains(&id)));
    let mut once = BTreeSet::new();
    found.retain(|id| once.insert(*id));
    if found.is_empty() { Err(NoLoop::Alone { best_score, min_score }) } else { Ok(found) }
}

/// Keyframes that look alike and are out of reach, but would not be if one of the loops had not been closed.
pub(super) fn find_far(keyframe: KeyframeId, world: &World, params: &Params) -> Vec<KeyframeId> {
    let map = &world.map;
    let (Some(current), Some((bow, _))) = (map.keyframe(keyframe), world.places.of(keyframe)) else {
        return Vec::new();
    };
    if map.loops().is_empty() {
        return Vec::new();
    }
    let prior = PositionPrior::new(map, keyframe, &params.camera);
    let mut far = world.places.alike(bow, |id| !prior.allows(id));
    let min_score = lowest_covisible_score(current, bow, world, params.loops.min_covisible_weight);
    far.retain(|alike| alike.score >= min_score);
    if !far.is_empty() {
        // Later loops are left as they are.
        let center = |closed: &ClosedLoop, id| Some(map.pose_without(closed, id)?.center());
        let loops = map.loops().iter().filter_map(|closed| Some((&**closed, center(closed, keyframe)?)));
        let loops: Vec<(&ClosedLoop, Vec3)> = loops.collect();
        let would_be = |id, &(closed, here): &(&ClosedLoop, Vec3)| {
            center(closed, id).is_some_and(|there| prior.would_allow(id, (here - there).norm()))
        };
        far.retain(|alike| loops.iter().any(|closed| would_be(alike.keyframe, closed)));
    }
    strongest_groups(map, &far, min_score)
}

/// The keyframe that has been most familiar, if it stands out.
fn most_familiar(map: &Map, alike: &[Alike], familiarity: &mut Familiarity) -> Option<KeyframeId> {
    let found: Vec<PlaceMatch> = alike.iter().map(Alike::as_match).collect();
    let neighbors = |id: u32| {
        let covisible = map.keyframe(KeyframeId(id)).map_or(&[][..], |k| k.best_covisible(GROUP_SIZE));
        covisible.iter().map(|&(neighbor, _)| neighbor.0)
    };
    let familiar = familiarity.advance(&found, neighbors);
    let best = familiar.first()?;
    let around: BTreeSet<u32> =
        map.keyframe(KeyframeId(best.keyframe))?.covisible().iter().map(|&(id, _)| id.0).collect();
    let elsewhere = familiar[1..].iter().find(|place| !around.contains(&place.keyframe))?;
    (best.familiarity >= MIN_CONTRAST * elsewhere.familiarity).then_some(KeyframeId(best.keyframe))
}

/// The lowest score with a keyframe that certainly shows the same place.
fn lowest_covisible_score(current: &map::Keyframe, bow: &BowVector, world: &World, min_weight: u32) -> f64 {
    current
        .covisible_at_least(min_weight)
        .iter()
        .filter_map(|&(id, _)| world.places.of(id))
        .map(|(other, _)| bow.score(other))
        .fold(1.0, f64::min)
}

/// The best member of every group whose summed score comes near that of the best group, best first.
pub(crate) fn strongest_groups(map: &Map, alike: &[Alike], min_score: f64) -> Vec<KeyframeId> {
    let most_words = alike.iter().map(|m| m.shared_words).max().unwrap_or(0);
    let scores: BTreeMap<KeyframeId, f64> = alike
        .iter()
        .filter(|m| f64::from(m.shared_words) > MIN_SHARED_WORDS * f64::from(most_words))
        .filter(|m| map.keyframe(m.keyframe).is_some())
        .map(|m| (m.keyframe, m.score))
        .collect();
    let mut groups: Vec<(f64, KeyframeId)> = scores
        .iter()
        .filter(|&(_, &score)| score >= min_score)
        .filter_map(|(&id, &score)| {
            let covisible = map.keyframe(id)?.best_covisible(GROUP_SIZE);
            let members = covisible.iter().filter_map(|&(member, _)| Some((member, *scores.get(&member)?)));
            let mut best = (score, id);
            let mut sum = score;
            for (member, score) in members {
                sum += score;
                if score > best.0 {
                    best = (score, member);
                }
            }
            Some((sum, best.1))
        })
        .collect();
    groups.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let bar = groups.first().map_or(0.0, |best| MIN_GROUP_SCORE * best.0);
    let mut once = BTreeSet::new();
    groups.into_iter().filter(|g| g.0 > bar).map(|g| g.1).filter(|id| once.insert(*id)).collect()
}

#[cfg(test)]
#[path = "../../tests/steps/candidates.rs"]
mod tests;
