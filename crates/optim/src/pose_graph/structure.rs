//! Which nodes of a pose graph may move, and the matrix of their normal equations.

use super::edge::Factor;
use crate::sparse::{BlockMatrix, Slot};

/// Marks a node that stays.
pub(super) const STAYS: u32 = u32::MAX;

/// Where an edge's blocks go; `None` for nodes that stay.
#[derive(Clone, Copy)]
pub(super) struct EdgeSlots {
    pub(super) a: Option<(usize, Slot)>,
    pub(super) b: Option<(usize, Slot)>,
    pub(super) ab: Option<Slot>,
}

/// The free nodes, and the places of all edges in the matrix.
pub(super) struct Structure<const D: usize> {
    /// Per node its elimination position, or [`STAYS`].
    pub(super) position: Vec<u32>,
    /// Per factor.
    pub(super) slots: Vec<EdgeSlots>,
    pub(super) matrix: BlockMatrix<D>,
    pub(super) n_free: usize,
}

impl<const D: usize> Structure<D> {
    /// `None` when the matrix would not fit into memory.
    pub(super) fn new<G>(n_nodes: usize, fixed: &[bool], factors: &[Factor<G, D>]) -> Option<Self> {
        let ends: Vec<(u32, u32)> = factors.iter().map(|f| (f.a, f.b)).collect();
        let stays = staying(n_nodes, fixed, &ends);
        let mut free_index = vec![STAYS; n_nodes];
        let mut n_free = 0;
        for (index, _) in free_index.iter_mut().zip(&stays).filter(|(_, stays)| !**stays) {
            *index = n_free;
            n_free += 1;
        }
        let free = |node: u32| Some(free_index[node as usize]).filter(|&i| i != STAYS);
        let pairs: Vec<(u32, u32)> = ends.iter().filter_map(|&(a, b)| Some((free(a)?, free(b)?))).collect();
        let matrix = BlockMatrix::new(n_free as usize, &pairs)?;
        let place = |index: u32| {
            let position = matrix.position(index);
            (position, matrix.diagonal(position))
        };
        let slots = ends.iter().map(|&(a, b)| {
            let (a, b) = (free(a), free(b));
            let ab = a.zip(b).and_then(|(a, b)| matrix.slot(a, b));
            EdgeSlots { a: a.map(place), b: b.map(place), ab }
        });
        let slots = slots.collect();
        let position =
            free_index.iter().map(|&i| if i == STAYS { STAYS } else { matrix.position(i) as u32 }).collect();
        Some(Self { position, slots, matrix, n_free: n_free as usize })
    }
}

/// Nodes that stay: fixed ones, those without an edge, and the lowest of each connected part that has no fixed one.
fn staying(n_nodes: usize, fixed: &[bool], ends: &[(u32, u32)]) -> Vec<bool> {
    let mut parts = Parts::new(n_nodes);
    let mut stays = vec![true; n_nodes];
    for &(a, b) in ends {
        parts.join(a, b);
        for node in [a, b] {
            stays[node as usize] = fixed.get(node as usize).copied().unwrap_or(false);
        }
    }
    let mut is_held = vec![false; n_nodes];
    for node in 0..n_nodes {
        is_held[parts.root(node as u32) as usize] |= stays[node];
    }
    for node in 0..n_nodes {
        let root = parts.root(node as u32) as usize;
        // The root of a part is its lowest node.
        stays[node] |= root == node && !is_held[root];
    }
    stays
}

/// Disjoint sets whose root is their lowest member.
struct Parts(Vec<u32>);

impl Parts {
    fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    fn root(&mut self, node: u32) -> u32 {
        let mut node = node as usize;
        while self.0[node] as usize != node {
            self.0[node] = self.0[self.0[node] as usize];
            node = self.0[node] as usize;
        }
        node as u32
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_without_a_fixed_node_keeps_its_lowest() {
        // Parts: 0-2-5 with fixed 5; 1-3-4; 6 alone; 8-7 without a flag.
        let fixed = [false, false, false, false, false, true, false];
        let ends = [(5, 2), (2, 0), (4, 3), (3, 1), (8, 7)];
        let stays = staying(9, &fixed, &ends);
        assert_eq!(stays, [false, true, false, false, false, true, true, true, false]);
    }

    #[test]
    fn nothing_stays_that_a_fixed_node_holds() {
        let ends = [(0, 1), (1, 2), (2, 3)];
        assert_eq!(staying(4, &[false, false, true, false], &ends), [false, false, true, false]);
    }
}
