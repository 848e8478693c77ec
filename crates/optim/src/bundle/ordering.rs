//! Elimination order of the free cameras and the fill of their Cholesky factor.
//!
//! Exact minimum degree on the graph of cameras that share a point, by bit sets: the reduced camera system of a street is
//! nearly banded, and a loop adds few rows. Ties go to the lower index.

/// Order and fill of a symmetric block matrix.
pub(crate) struct Ordering {
    /// Elimination position per camera.
    pub(crate) position: Vec<u32>,
    /// Per position the rows (positions, ascending, first the diagonal) of its column of the factor.
    pub(crate) columns: Vec<Vec<u32>>,
}

/// Symmetric adjacency as one bit set per node; each is its own neighbor.
pub(crate) struct Adjacency {
    n: usize,
    words: usize,
    bits: Vec<u64>,
}

impl Adjacency {
    /// No edges among `n` nodes.
    pub(crate) fn new(n: usize) -> Self {
        let words = n.div_ceil(64);
        let mut bits = vec![0; n * words];
        for node in 0..n {
            bits[node * words + node / 64] = 1 << (node % 64);
        }
        Self { n, words, bits }
    }

    /// Connects every pair of `clique`.
    pub(crate) fn connect(&mut self, clique: &[u32]) {
        for &a in clique {
            let row = &mut self.bits[a as usize * self.words..][..self.words];
            for &b in clique {
                row[b as usize / 64] |= 1 << (b % 64);
            }
        }
    }

    /// Joins the neighbors of `node` into a clique, takes it out of the graph and returns them.
    fn eliminate(&mut self, node: usize) -> Vec<u32> {
        let mut pivot = self.bits[node * self.words..][..self.words].to_vec();
        pivot[node / 64] &= !(1 << (node % 64));
        let neighbours = ones(&pivot);
        for &m in &neighbours {
            let row = &mut self.bits[m as usize * self.words..][..self.words];
            row.iter_mut().zip(&pivot).for_each(|(r, p)| *r |= p);
            row[node / 64] &= !(1 << (node % 64));
        }
        neighbours
    }

    fn degree(&self, node: usize) -> u32 {
        self.bits[node * self.words..][..self.words].iter().map(|w| w.count_ones()).sum()
    }

    /// Eliminates all nodes, fewest neighbors first.
    pub(crate) fn minimum_degree(mut self) -> Ordering {
        let n = self.n;
        let mut degree: Vec<u32> = (0..n).map(|i| self.degree(i)).collect();
        let mut position = vec![u32::MAX; n];
        let mut fill = Vec::with_capacity(n);
        for step in 0..n {
            let open = (0..n).filter(|&i| position[i] == u32::MAX);
            let Some(node) = open.min_by_key(|&i| degree[i]) else { break };
            position[node] = step as u32;
            let neighbours = self.eliminate(node);
            for &m in &neighbours {
                degree[m as usize] = self.degree(m as usize);
            }
            fill.push(neighbours);
        }
        let columns = fill
            .into_iter()
            .enumerate()
            .map(|(step, neighbours)| {
                let mut rows: Vec<u32> = neighbours.iter().map(|&m| position[m as usize]).collect();
                rows.push(step as u32);
                rows.sort_unstable();
                rows
            })
            .collect();
        Ordering { position, columns }
    }
}

/// Indices of the set bits, ascending.
fn ones(words: &[u64]) -> Vec<u32> {
    let mut out = Vec::new();
    for (w, &word) in words.iter().enumerate() {
        let mut rest = word;
        while rest != 0 {
            out.push((w * 64) as u32 + rest.trailing_zeros());
            rest &= rest - 1;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(n: usize, cliques: &[&[u32]]) -> Ordering {
        let mut adjacency = Adjacency::new(n);
        cliques.iter().for_each(|clique| adjacency.connect(clique));
        adjacency.minimum_degree()
    }

    fn n_blocks(ordering: &Ordering) -> usize {
        ordering.columns.iter().map(Vec::len).sum()
    }

    #[test]
    fn a_star_and_a_chain_have_no_fill() {
        let star: Vec<[u32; 2]> = (1..100).map(|i| [0, i]).collect();
        let chain: Vec<[u32; 2]> = (1..100).map(|i| [i - 1, i]).collect();
        for edges in [star, chain] {
            let edges: Vec<&[u32]> = edges.iter().map(|e| &e[..]).collect();
            let ordering = order(100, &edges);
            assert_eq!(n_blocks(&ordering), 100 + 99);
            let mut positions = ordering.position.clone();
            positions.sort_unstable();
            assert!(positions.into_iter().eq(0..100));
        }
    }

    #[test]
    fn a_ring_fills_one_block_per_step_and_its_columns_are_closed() {
        let ring: Vec<[u32; 2]> = (0..70).map(|i| [i, (i + 1) % 70]).collect();
        let ring: Vec<&[u32]> = ring.iter().map(|e| &e[..]).collect();
        let ordering = order(70, &ring);
        assert_eq!(n_blocks(&ordering), 70 + 70 + 67);
        for column in &ordering.columns {
            for (k, &a) in column.iter().enumerate().skip(1) {
                assert!(column[k..].iter().all(|b| ordering.columns[a as usize].contains(b)));
            }
        }
    }

    #[test]
    fn lonely_nodes_have_a_diagonal_only() {
        let ordering = order(3, &[&[1]]);
        assert_eq!((ordering.position, ordering.columns), (vec![0, 1, 2], vec![vec![0], vec![1], vec![2]]));
    }
}
