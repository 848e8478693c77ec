//! The essential graph: what holds the map together between keyframes (ORB-SLAM, Mur-Artal et al. 2015,
//! section III-D).

use std::collections::BTreeSet;

use geometry::SE3;
use map::{KeyframeId, Map};

/// An edge of the essential graph between two nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct EssentialEdge {
    pub(super) a: usize,
    pub(super) b: usize,
    pub(super) is_loop: bool,
    /// The motion from `a` to `b`, where it is not that of the map.
    pub(super) measured: Option<SE3>,
}

/// The keyframes of one sub-map and the edges between them.
pub(super) struct EssentialGraph {
    /// Sorted by id.
    pub(super) nodes: Vec<KeyframeId>,
    pub(super) cam_from_world: Vec<SE3>,
    pub(super) edges: Vec<EssentialEdge>,
}

impl EssentialGraph {
    /// Spanning tree, loop edges, and covisibility from `min_weight` shared points on.
    pub(super) fn new(map: &Map, member: KeyframeId, min_weight: u32) -> Self {
        let nodes = map.submap_members(member);
        let mut pairs = BTreeSet::new();
        let mut loops = BTreeSet::new();
        let mut cam_from_world = Vec::with_capacity(nodes.len());
        for keyframe in nodes.iter().filter_map(|&id| map.keyframe(id)) {
            let id = keyframe.id;
            cam_from_world.push(keyframe.cam_from_world);
            pairs.extend(keyframe.parent().map(|parent| (parent.min(id), parent.max(id))));
            let covisible = keyframe.covisible_at_least(min_weight).iter().map(|&(other, _)| other);
            pairs.extend(covisible.map(|other| (other.min(id), other.max(id))));
            loops.extend(keyframe.loop_edges().iter().map(|&other| (other.min(id), other.max(id))));
        }
        let mut graph = EssentialGraph { nodes, cam_from_world, edges: Vec::new() };
        let edges = pairs.difference(&loops).map(|&pair| (pair, false));
        let edges: Vec<_> = edges.chain(loops.iter().map(|&pair| (pair, true))).collect();
        for ((a, b), is_loop) in edges {
            if let (Some(a), Some(b)) = (graph.index(a), graph.index(b)) {
                graph.edges.push(EssentialEdge { a, b, is_loop, measured: None });
            }
        }
        graph
    }

    /// The node of a keyframe.
    pub(super) fn index(&self, id: KeyframeId) -> Option<usize> {
        self.nodes.binary_search(&id).ok()
    }

    /// The motion of an edge: as measured, else as the map has it now.
    pub(super) fn b_from_a(&self, edge: &EssentialEdge) -> SE3 {
        edge.measured.unwrap_or_else(|| self.cam_from_world[edge.b] * self.cam_from_world[edge.a].inverse())
    }

    /// Adds a loop by its measured motion `b_from_a`; ends that were removed from `map` stand for the keyframes that carry them.
    pub(super) fn add_loop(&mut self, map: &Map, [a, b]: [KeyframeId; 2], b_from_a: SE3) {
        let carrier = |id| {
            let (alive, id_from_alive) = map.resolve_keyframe(id)?;
            Some((self.index(alive)?, id_from_alive))
        };
        if let (Some((a, a_from_alive)), Some((b, b_from_alive))) = (carrier(a), carrier(b))
            && a != b
        {
            let measured = Some(b_from_alive.inverse() * b_from_a * a_from_alive);
            self.edges.push(EssentialEdge { a, b, is_loop: true, measured });
        }
    }

    /// Nodes on the way from a node up to the root of the spanning tree, both included.
    pub(super) fn ancestors(&self, map: &Map, node: usize) -> Vec<usize> {
        let mut path = vec![node];
        let parent_of = |at: usize| self.index(map.keyframe(self.nodes[at])?.parent()?);
        while let Some(parent) = parent_of(path[path.len() - 1]) {
            path.push(parent);
        }
        path
    }
}

#[cfg(test)]
#[path = "../../tests/steps/essential_graph.rs"]
mod tests;
