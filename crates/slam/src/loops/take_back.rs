//! A verified place that contradicts the map may say that an earlier loop was wrong: when enough speaks against that one
//! ([`Doubts`]), the new loop is closed in the map without it.

use geometry::SE3;
use map::{ClosedLoop, Correction, KeyframeId, Map};
use optim::loop_test::{Doubts, Witness, culprit};

use super::LoopCorrection;
use super::correct::{correct, relax, test};
use super::essential_graph::EssentialGraph;
use super::position_prior::PositionPrior;
use super::verify::{Verified, verify};
use crate::params::Params;
use crate::world::World;

/// Loops that are left out in turn, to see what a refused candidate contradicts: each costs a pose graph and a test.
const MAX_SUSPECTS: usize = 4;

/// A loop by its keyframes: of the earlier visit, of the later one.
pub(super) type Name = (KeyframeId, KeyframeId);

/// A world without one of its loops.
struct Without {
    name: Name,
    world: World,
    /// Factor of lengths around each keyframe by which it was adjusted after the loop was gone; empty: by none.
    scales: Vec<(KeyframeId, f64)>,
}

/// Hears what a refused candidate says; the correction that closes it and takes an earlier loop back, if that is due.
pub(super) fn hear(
    doubts: &mut Doubts<Name, SE3>,
    keyframe: KeyframeId,
    refused: &Verified,
    world: &World,
    params: &Params,
) -> Option<LoopCorrection> {
    let map = &world.map;
    doubts.keep(|name| map.loops().iter().any(|closed| name == (closed.matched, closed.keyframe)));
    let strain = |verified: &Verified, map: &Map| {
        let verdict = test(keyframe, verified, map, params, None)?;
        let reach = PositionPrior::new(map, keyframe, &params.camera).strain(verified.matched);
        Some(verdict.strain().max(reach))
    };
    let (mut tried, mut left) = (Vec::new(), Vec::new());
    for closed in suspects(keyframe, refused, map) {
        if let Some(without) = Without::new(world, closed, params)
            && let Ok(verified) = verify(refused.matched, keyframe, &without.world, params)
            && let Some(strain) = strain(&verified, &without.world.map)
        {
            tried.push((without, verified));
            left.push(strain);
        }
    }
    let (without, verified) = tried.swap_remove(culprit(strain(refused, map)?, &left)?);
    let map_without = &without.world.map;
    let there = map_without.keyframe(verified.matched)?.cam_from_world;
    let witness = Witness {
        now: keyframe.0,
        then: verified.matched.0,
        now_from_then: verified.cam_from_world * there.inverse(),
    };
    let agrees = |first: &Witness<SE3>| {
        let verdict = test(keyframe, &verified, map_without, params, Some(first));
        verdict.is_some_and(|verdict| verdict.is_consistent())
    };
    let first = doubts.hear(without.name, witness, agrees)?;
    let found = correct(keyframe, &verified, map_without, params, Some(&first)).ok()?;
    Some(without.in_terms_of(map, found))
}

/// The loops that may be at fault, likeliest first: those without which the keyframe comes nearest to where it was verified.
fn suspects<'m>(keyframe: KeyframeId, refused: &Verified, map: &'m Map) -> Vec<&'m ClosedLoop> {
    let Some(there) = map.keyframe(refused.matched) else { return Vec::new() };
    let here_from_there = refused.cam_from_world * there.cam_from_world.inverse();
    let off = |closed: &ClosedLoop| {
        let expected = here_from_there * map.pose_without(closed, refused.matched)?;
        Some((expected.center() - map.pose_without(closed, keyframe)?.center()).norm())
    };
    let loops = map.loops().iter().filter_map(|closed| Some((off(closed)?, &**closed)));
    let mut loops: Vec<(f64, &ClosedLoop)> = loops.collect();
    loops.sort_by(|a, b| a.0.total_cmp(&b.0));
    loops.into_iter().map(|l| l.1).take(MAX_SUSPECTS).collect()
}

impl Without {
    /// `None` if the map does not let go of the loop.
    fn new(world: &World, closed: &ClosedLoop, params: &Params) -> Option<Self> {
        let (now, name) = (&world.map, (closed.matched, closed.keyframe));
        let taken_back = vec![name];
        let mut map = now.clone();
        let seen_revision = map.revision();
        map.apply_correction(&Correction { taken_back, seen_revision, ..Correction::default() }).ok()?;
        let mut scales = Vec::new();
        let later = now.loops().iter().skip_while(|l| ***l != *closed).skip(1);
        let later: Vec<Name> = later.map(|l| (l.matched, l.keyframe)).collect();
        if !later.is_empty() {
            let graph = graph_without(now, &map, closed, &later, params);
            let keyframes = relax(&graph, &map, params, None);
            scales = keyframes.iter().map(|k| (k.keyframe, k.scale)).collect();
            let seen_revision = map.revision();
            map.apply_correction(&Correction { keyframes, seen_revision, ..Correction::default() }).ok()?;
        }
        Some(Without { name, world: World { map, ..world.clone() }, scales })
    }

    /// A correction of this world as one of the map that still has the loop.
    fn in_terms_of(&self, map: &Map, mut found: LoopCorrection) -> LoopCorrection {
        let correction = &mut found.correction;
        correction.taken_back = vec![self.name];
        correction.seen_revision = map.revision();
        for k in &mut correction.keyframes {
            if let Ok(at) = self.scales.binary_search_by_key(&k.keyframe, |s| s.0) {
                k.scale *= self.scales[at].1;
            }
        }
        // Points that came to be when the loop's were split will have other names in the map.
        let has_name = |id: &map::PointId| *id < map.next_point_id();
        correction.merged.retain(|(keep, drop)| has_name(keep) && has_name(drop));
        found.earlier_points.retain(has_name);
        found
    }
}

/// The essential graph of the map `without` a loop. Motions between keyframes that the loop closed over are as they were before
/// it; those to later keyframes, and later loops, as they are `now`.
fn graph_without(
    now: &Map,
    without: &Map,
    closed: &ClosedLoop,
    later: &[Name],
    params: &Params,
) -> EssentialGraph {
    let mut graph = EssentialGraph::new(without, closed.keyframe, params.loops.essential_weight);
    let motion = |a: KeyframeId, b: KeyframeId| {
        let [a_from_world, b_from_world] = [now.keyframe(a)?, now.keyframe(b)?].map(|k| k.cam_from_world);
        let mut b_from_a = b_from_world * a_from_world.inverse();
        b_from_a.translation *= without.scale_of(b) / now.scale_of(b);
        Some(b_from_a)
    };
    for edge in &mut graph.edges {
        let (a, b) = (graph.nodes[edge.a], graph.nodes[edge.b]);
        if !closed.closed_over(a, b) {
            edge.measured = motion(a, b);
        }
    }
    for &(a, b) in later {
        if let (Some((a, _)), Some((b, _))) = (now.resolve_keyframe(a), now.resolve_keyframe(b))
            && let Some(b_from_a) = motion(a, b)
        {
            let ends = [graph.index(a), graph.index(b)];
            graph.edges.retain(|e| !(e.is_loop && [Some(e.a), Some(e.b)].iter().all(|n| ends.contains(n))));
            graph.add_loop(without, [a, b], b_from_a);
        }
    }
    graph
}

#[cfg(test)]
#[path = "../../tests/steps/take_back.rs"]
mod tests;
