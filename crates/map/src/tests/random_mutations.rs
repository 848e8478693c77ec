//! Long random histories: `check` after each step, refusals change nothing, snapshots stay what they were.

use std::collections::BTreeMap;

use proptest::prelude::*;
use rand::Rng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use super::world::*;
use crate::{
    Batch, Correction, KeyframeCorrection, KeyframeId, Map, MapError, NewKeyframe, NewPoint, Observation,
    Parent, PointCount, PointId,
};

/// The kinds of steps; `Batch` without and with a keyframe are two.
const KINDS: [&str; 10] = [
    "keyframe",
    "points",
    "link",
    "unlink",
    "merge",
    "remove point",
    "remove keyframe",
    "estimates",
    "correction",
    "count",
];

/// Chooses arguments: mostly sensible ones, now and then any.
struct Chooser<'a> {
    map: &'a Map,
    random: ChaCha8Rng,
}

impl Chooser<'_> {
    fn keyframe(&mut self) -> KeyframeId {
        let alive: Vec<KeyframeId> = self.map.keyframes().map(|k| k.id).collect();
        match alive.choose(&mut self.random) {
            Some(&id) if self.random.random_bool(0.97) => id,
            _ if self.random.random_bool(0.5) => self.map.next_keyframe_id(),
            _ => KeyframeId(self.random.random_range(0..=self.map.next_keyframe_id().0)),
        }
    }

    fn point(&mut self) -> PointId {
        let alive: Vec<PointId> = self.map.points().map(|p| p.id).collect();
        match alive.choose(&mut self.random) {
            Some(&id) if self.random.random_bool(0.97) => id,
            _ if self.random.random_bool(0.5) => self.map.next_point_id(),
            _ => PointId(self.random.random_range(0..=self.map.next_point_id().0)),
        }
    }

    fn feature(&mut self) -> u32 {
        let beyond = u32::from(self.random.random_bool(0.02));
        self.random.random_range(0..N_FEATURES + beyond)
    }

    fn observation(&mut self) -> Observation {
        Observation { keyframe: self.keyframe(), feature: self.feature() }
    }

    /// Points with observations in the batch's keyframe and others.
    fn new_points(&mut self, most: usize, own: Option<KeyframeId>) -> Vec<NewPoint> {
        let n = self.random.random_range(0..=most);
        let mut feature = self.random.random_range(0..10);
        let mut new_point = || {
            feature += 1;
            let mut observations: Vec<Observation> =
                (0..self.random.random_range(0..3)).map(|_| self.observation()).collect();
            observations.extend(own.map(|keyframe| Observation { keyframe, feature }));
            NewPoint { position: random_position(&mut self.random), observations }
        };
        (0..n).map(|_| new_point()).collect()
    }

    fn batch(&mut self, with_keyframe: bool) -> Batch {
        if !with_keyframe {
            return Batch { keyframe: None, points: self.new_points(2, None) };
        }
        let n = self.random.random_range(0..20);
        let mut matches: BTreeMap<u32, PointId> =
            (0..n).map(|i| (N_FEATURES - 1 - i, self.point())).collect();
        if self.random.random_bool(0.9) {
            let mut known = std::collections::BTreeSet::new();
            matches.retain(|_, p| known.insert(*p));
        }
        let parent = match self.random.random_range(0..10) {
            0 => Parent::Under(self.keyframe()),
            1 => Parent::NewSubmap,
            _ => Parent::Closest,
        };
        if parent == Parent::NewSubmap && self.random.random_bool(0.9) {
            matches.clear();
        }
        let matches = matches.into_iter().collect();
        let keyframe = NewKeyframe { matches, parent, ..new_keyframe(self.map, &[]) };
        let mut points = self.new_points(4, Some(self.map.next_keyframe_id()));
        if parent == Parent::NewSubmap && self.random.random_bool(0.9) {
            let own = self.map.next_keyframe_id();
            points.iter_mut().for_each(|p| p.observations.retain(|o| o.keyframe == own));
        }
        Batch { keyframe: Some(keyframe), points }
    }

    fn poses(&mut self) -> Vec<(KeyframeId, geometry::SE3)> {
        let n = self.random.random_range(0..4);
        (0..n).map(|_| (self.keyframe(), random_pose(&mut self.random))).collect()
    }

    fn positions(&mut self) -> Vec<(PointId, geometry::Vec3)> {
        let n = self.random.random_range(0..6);
        let position = |r: &mut ChaCha8Rng| {
            let bad = r.random_bool(0.02);
            random_position(r) * if bad { f64::NAN } else { 1.0 }
        };
        (0..n).map(|_| (self.point(), position(&mut self.random))).collect()
    }

    fn correction(&mut self) -> Correction {
        let now = self.map.revision();
        let seen_revision = self.random.random_range(now.saturating_sub(30)..=now);
        let mut poses = self.poses();
        if self.random.random_bool(0.8) {
            poses.retain(|(id, _)| self.map.keyframe(*id).is_some_and(|k| k.inserted_at <= seen_revision));
        }
        let keyframes = poses
            .into_iter()
            .map(|(keyframe, cam_from_world)| {
                let scale = [1.0, self.random.random_range(0.5..2.0)][self.random.random_range(0..2)];
                KeyframeCorrection { keyframe, cam_from_world, scale }
            })
            .collect();
        let n_joined = [0, 0, 1, 2][self.random.random_range(0..4)];
        let n_merged = self.random.random_range(0..4);
        let n_edges = self.random.random_range(0..2);
        let named = |l: &std::sync::Arc<crate::ClosedLoop>| (l.matched, l.keyframe);
        let mut correction = Correction {
            keyframes,
            points: self.positions(),
            seen_revision,
            joined: (0..n_joined).map(|_| (self.keyframe(), self.keyframe())).collect(),
            merged: (0..n_merged).map(|_| (self.point(), self.point())).collect(),
            loop_edges: (0..n_edges).map(|_| (self.keyframe(), self.keyframe())).collect(),
            taken_back: Vec::new(),
        };
        let standing = self.map.loops().iter().map(named);
        correction.taken_back = standing.filter(|_| self.random.random_bool(0.2)).collect();
        correction
    }

    fn counts(&mut self) -> Vec<PointCount> {
        (0..5).map(|_| PointCount { point: self.point(), seen: 2, found: 1, evidence: -700 }).collect()
    }
}

/// One random step of a kind.
fn step(map: &mut Map, kind: usize, seed: u64) -> Result<(), MapError> {
    let before = map.clone();
    let mut c = Chooser { map: &before, random: generator(seed) };
    match KINDS[kind] {
        "keyframe" => map.insert(c.batch(true)).map(|_| ()),
        "points" => map.insert(c.batch(false)).map(|_| ()),
        "link" => map.link(c.point(), c.observation()),
        "unlink" => {
            let point = c.point();
            let seen_in = before.point(point).and_then(|p| p.observations().choose(&mut c.random));
            let keyframe = seen_in.map_or_else(|| c.keyframe(), |o| o.keyframe);
            map.unlink(point, keyframe).map(|_| ())
        }
        "merge" => map.merge_points(c.point(), c.point()),
        "remove point" => map.remove_point(c.point()),
        "remove keyframe" => map.remove_keyframe(c.keyframe()).map(|_| ()),
        "estimates" => map.set_estimates(&c.poses(), &c.positions()),
        "correction" => map.apply_correction(&c.correction()),
        "count" => map.count(&c.counts()),
        other => unreachable!("{other}"),
    }
}

/// Takes a step and asserts everything that holds for every step.
fn checked_step(map: &mut Map, kind: usize, seed: u64) -> bool {
    let before = map.clone();
    let digest = before.digest();
    let result = step(map, kind, seed);
    assert_eq!(map.check(), Ok(()), "after {} with seed {seed}: {result:?}", KINDS[kind]);
    assert_eq!(before.digest(), digest, "a snapshot does not change");
    match result {
        Ok(()) => assert_eq!(map.revision(), before.revision() + 1),
        Err(_) => assert_eq!((map.revision(), map.digest()), (before.revision(), digest)),
    }
    result.is_ok()
}

/// A kind by weight: enough keyframes and points come in to make up for what goes.
fn kind_of(number: u64) -> usize {
    const WEIGHTS: [u64; 10] = [8, 5, 6, 4, 2, 2, 3, 3, 2, 2];
    let mut rest = number % WEIGHTS.iter().sum::<u64>();
    let mut kind = 0;
    while rest >= WEIGHTS[kind] {
        rest -= WEIGHTS[kind];
        kind += 1;
    }
    kind
}

/// A map after that many random mutations.
pub(super) fn random_map(seed: u64, n_steps: u64) -> Map {
    let mut map = row_of_keyframes(4);
    for i in 0..n_steps {
        let _ = random_step(&mut map, seed, i);
    }
    map
}

/// The i-th random mutation of a history.
pub(super) fn random_step(map: &mut Map, seed: u64, i: u64) -> Result<(), MapError> {
    let number = geometry::mix_seed(seed, i, 0);
    step(map, kind_of(number), geometry::mix_seed(seed, i, 1))
}

#[test]
fn two_thousand_random_mutations_keep_every_invariant() {
    let mut map = Map::new();
    let mut accepted = [0; KINDS.len()];
    let mut refused = [0; KINDS.len()];
    let mut largest = (0, 0);
    let (mut n_roots, mut n_submaps, mut n_joins, mut n_taken_back) = (0, 0, 0, 0);
    for i in 0..2_000 {
        let kind = if map.n_keyframes() < 3 { 0 } else { kind_of(geometry::mix_seed(1, i, 0)) };
        let was_accepted = checked_step(&mut map, kind, geometry::mix_seed(2, i, kind as u64));
        let count = if was_accepted { &mut accepted } else { &mut refused };
        count[kind] += 1;
        largest = largest.max((map.n_points(), map.n_keyframes()));
        n_submaps = n_submaps.max(map.roots().len());
        n_joins += usize::from(map.roots().len() < n_roots);
        n_roots = map.roots().len();
        n_taken_back = map.taken_back.len();
    }
    assert!(n_taken_back >= 3, "{n_taken_back} loops taken back");
    assert!(n_submaps > 3 && n_joins > 10, "at most {n_submaps} sub-maps, {n_joins} joins");
    for (kind, name) in KINDS.iter().enumerate() {
        assert!(
            accepted[kind] >= 20 && refused[kind] >= 1,
            "{name}: {} and {}",
            accepted[kind],
            refused[kind]
        );
    }
    assert!(largest.0 > 50 && largest.1 > 10, "the map was not a toy: {largest:?} at most");
}

#[test]
fn equal_histories_make_equal_maps() {
    let run = || {
        let mut map = Map::new();
        for i in 0..300 {
            let _ = step(&mut map, kind_of(geometry::mix_seed(3, i, 0)), geometry::mix_seed(4, i, 0));
        }
        (map.digest(), map.revision())
    };
    assert_eq!(run(), run());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn any_history_keeps_every_invariant(
        steps in prop::collection::vec((any::<u64>(), any::<u64>()), 1..60),
        snapshot_at in 0_usize..60,
    ) {
        let mut map = row_of_keyframes(4);
        let mut snapshot = None;
        for (i, &(number, seed)) in steps.iter().enumerate() {
            if i == snapshot_at {
                snapshot = Some((map.clone(), map.digest()));
            }
            checked_step(&mut map, kind_of(number), seed);
        }
        if let Some((snapshot, digest)) = snapshot {
            prop_assert_eq!(snapshot.digest(), digest);
            prop_assert_eq!(snapshot.check(), Ok(()));
        }
    }

    #[test]
    fn every_id_ever_given_out_resolves_to_what_lives_or_to_nothing(
        steps in prop::collection::vec((any::<u64>(), any::<u64>()), 1..60),
    ) {
        let mut map = row_of_keyframes(4);
        for &(number, seed) in &steps {
            let before = map.clone();
            let _ = step(&mut map, kind_of(number), seed);
            for id in (0..map.next_point_id().0).map(PointId) {
                prop_assert!(map.resolve(id).is_none_or(|p| map.point(p).is_some()));
                // What was gone stays gone.
                prop_assert!(before.resolve(id).is_some() || map.resolve(id).is_none() || before.next_point_id() <= id);
            }
            for id in (0..map.next_keyframe_id().0).map(KeyframeId) {
                let alive = map.resolve_keyframe(id).map(|r| r.0);
                prop_assert!(alive.is_some_and(|k| map.keyframe(k).is_some()));
            }
        }
    }
}
