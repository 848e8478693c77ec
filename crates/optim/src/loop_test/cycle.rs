//! The lightest cycle that a candidate closes.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A way from the first to the second end of a candidate over other edges.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Way {
    /// Edge and whether it is walked from its `a` to its `b`, in order.
    pub(super) steps: Vec<(usize, bool)>,
    /// Sum of the weights.
    pub(super) weight: f64,
}

/// The lightest way between the ends of edge `candidate` without that edge (Dijkstra); `None` where there is none.
///
/// `ends` are the nodes of each edge, `weights` must not be negative. Ties go to the node that is reached first and the
/// edge that comes first.
pub(super) fn lightest_way(
    n_nodes: usize,
    ends: &[(u32, u32)],
    weights: &[f64],
    candidate: usize,
) -> Option<Way> {
    let mut incident = vec![Vec::new(); n_nodes];
    for (edge, &(a, b)) in ends.iter().enumerate().filter(|&(edge, _)| edge != candidate) {
        incident[a as usize].push((edge, b, true));
        incident[b as usize].push((edge, a, false));
    }
    let (from, to) = ends[candidate];
    let mut best = vec![f64::INFINITY; n_nodes];
    let mut arrived_by: Vec<Option<(usize, bool, u32)>> = vec![None; n_nodes];
    best[from as usize] = 0.0;
    // Numbers that are not negative are ordered as their bits are.
    let mut open = BinaryHeap::from([Reverse((0u64, from))]);
    while let Some(Reverse((bits, node))) = open.pop() {
        let weight = f64::from_bits(bits);
        if node == to {
            break;
        }
        if weight > best[node as usize] {
            continue;
        }
        for &(edge, next, is_forward) in &incident[node as usize] {
            let total = weight + weights[edge];
            if total < best[next as usize] {
                best[next as usize] = total;
                arrived_by[next as usize] = Some((edge, is_forward, node));
                open.push(Reverse((total.to_bits(), next)));
            }
        }
    }
    let mut steps = Vec::new();
    let mut node = to;
    while node != from {
        let (edge, is_forward, previous) = arrived_by[node as usize]?;
        steps.push((edge, is_forward));
        node = previous;
    }
    steps.reverse();
    Some(Way { steps, weight: best[to as usize] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lightest_way_is_found_in_order_and_direction() {
        // 0-1-2-3 in a row, a detour 1-4-3, and the candidate 3 -> 0.
        let ends = [(0, 1), (2, 1), (2, 3), (3, 0), (1, 4), (3, 4)];
        let by_row = lightest_way(5, &ends, &[1.0, 1.0, 1.0, 0.1, 1.5, 1.0], 3).unwrap();
        assert_eq!(by_row, Way { steps: vec![(2, false), (1, true), (0, false)], weight: 3.0 });
        let by_detour = lightest_way(5, &ends, &[1.0, 1.0, 1.0, 0.1, 0.5, 1.0], 3).unwrap();
        assert_eq!(by_detour, Way { steps: vec![(5, true), (4, false), (0, false)], weight: 2.5 });
    }

    #[test]
    fn a_bridge_closes_no_cycle() {
        assert_eq!(lightest_way(4, &[(0, 1), (1, 2), (2, 3)], &[1.0; 3], 1), None);
    }
}
