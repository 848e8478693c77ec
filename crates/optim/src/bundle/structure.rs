//! Index structure of a problem, made once: observations sorted by point, the camera-point blocks ("slots") they fill, and
//! for each pair of slots of a point the block of the reduced camera system it adds to.

use super::cholesky::BlockCholesky;
use super::ordering::Adjacency;
use super::solver::Edge;

/// Marks what has no slot or position: fixed cameras.
pub(crate) const NONE: u32 = u32::MAX;

/// An observation in solver order.
#[derive(Clone, Copy)]
pub(crate) struct SortedEdge<O> {
    pub(crate) camera: u32,
    /// Slot of (camera, point), or [`NONE`] for a fixed camera.
    pub(crate) slot: u32,
    pub(crate) observation: O,
}

/// See the module.
pub(crate) struct Structure<O> {
    /// Observations by point, then elimination position of their camera (fixed last), then input order.
    pub(crate) edges: Vec<SortedEdge<O>>,
    /// Range of edges per point.
    pub(crate) point_edges: Vec<u32>,
    /// Range of slots per point.
    pub(crate) point_slots: Vec<u32>,
    /// Elimination position of the camera of each slot; ascending within a point.
    pub(crate) slot_position: Vec<u32>,
    /// Start in `pair_block` per slot.
    pub(crate) slot_pairs: Vec<u32>,
    /// For slot a and each slot b >= a of the same point: index of block (b, a) of the reduced system.
    pub(crate) pair_block: Vec<u32>,
    /// Elimination position per camera, [`NONE`] for fixed ones.
    pub(crate) position: Vec<u32>,
}

impl<O: Copy> Structure<O> {
    /// Sorts the problem and lays out its reduced camera system.
    pub(crate) fn new<const C: usize>(
        fixed: &[bool],
        n_points: usize,
        edges: &[Edge<O>],
    ) -> (Self, BlockCholesky<C>) {
        let (by_point, point_edges) = bucket(n_points, edges.iter().map(|e| e.point));
        let (position, matrix) = order_cameras(fixed, edges, &by_point, &point_edges);
        let mut structure = Self {
            edges: Vec::with_capacity(edges.len()),
            point_edges,
            point_slots: Vec::with_capacity(n_points + 1),
            slot_position: Vec::new(),
            slot_pairs: Vec::new(),
            pair_block: Vec::new(),
            position,
        };
        structure.fill_slots(edges, by_point);
        structure.fill_pairs(&matrix);
        (structure, matrix)
    }

    fn fill_slots(&mut self, edges: &[Edge<O>], mut by_point: Vec<u32>) {
        self.point_slots.push(0);
        for range in self.point_edges.windows(2) {
            let of_point = &mut by_point[range[0] as usize..range[1] as usize];
            of_point.sort_unstable_by_key(|&e| {
                let camera = edges[e as usize].camera;
                (self.position[camera as usize], camera, e)
            });
            let mut last = NONE;
            for &e in of_point.iter() {
                let Edge { camera, observation, .. } = edges[e as usize];
                let position = self.position[camera as usize];
                if position != NONE && position != last {
                    self.slot_position.push(position);
                    last = position;
                }
                let slot = if position == NONE { NONE } else { self.slot_position.len() as u32 - 1 };
                self.edges.push(SortedEdge { camera, slot, observation });
            }
            self.point_slots.push(self.slot_position.len() as u32);
        }
    }

    /// Column by column, so that looking up a block is one array access.
    fn fill_pairs<const C: usize>(&mut self, matrix: &BlockCholesky<C>) {
        let mut slot_end = vec![0; self.slot_position.len()];
        for range in self.point_slots.windows(2) {
            slot_end[range[0] as usize..range[1] as usize].fill(range[1]);
        }
        let mut n_pairs = 0;
        for (slot, &end) in slot_end.iter().enumerate() {
            self.slot_pairs.push(n_pairs);
            n_pairs += end - slot as u32;
        }
        self.pair_block = vec![0; n_pairs as usize];
        let (by_position, start) = bucket(matrix.n(), self.slot_position.iter().copied());
        let mut block_of_row = vec![NONE; matrix.n()];
        for column in 0..matrix.n() {
            let (blocks, rows) = matrix.column(column);
            for (block, &row) in blocks.zip(rows) {
                block_of_row[row as usize] = block as u32;
            }
            for &slot in &by_position[start[column] as usize..start[column + 1] as usize] {
                let first = self.slot_pairs[slot as usize] as usize;
                let rows = &self.slot_position[slot as usize..slot_end[slot as usize] as usize];
                for (pair, &row) in self.pair_block[first..].iter_mut().zip(rows) {
                    *pair = block_of_row[row as usize];
                }
            }
        }
    }
}

/// Counting sort: item indices by bucket (stable), and the range of each bucket.
fn bucket(n_buckets: usize, bucket_of: impl ExactSizeIterator<Item = u32> + Clone) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; n_buckets + 1];
    for b in bucket_of.clone() {
        start[b as usize + 1] += 1;
    }
    for i in 0..n_buckets {
        start[i + 1] += start[i];
    }
    let mut next = start.clone();
    let mut items = vec![0; bucket_of.len()];
    for (item, b) in bucket_of.enumerate() {
        items[next[b as usize] as usize] = item as u32;
        next[b as usize] += 1;
    }
    (items, start)
}

/// Elimination position per camera and the empty reduced camera system.
fn order_cameras<O, const C: usize>(
    fixed: &[bool],
    edges: &[Edge<O>],
    by_point: &[u32],
    point_edges: &[u32],
) -> (Vec<u32>, BlockCholesky<C>) {
    let mut free_index = vec![NONE; fixed.len()];
    let mut n_free = 0;
    for (index, _) in free_index.iter_mut().zip(fixed).filter(|(_, fixed)| !**fixed) {
        *index = n_free;
        n_free += 1;
    }
    let mut adjacency = Adjacency::new(n_free as usize);
    let mut clique = Vec::new();
    for range in point_edges.windows(2) {
        clique.clear();
        let of_point = &by_point[range[0] as usize..range[1] as usize];
        let cameras = of_point.iter().map(|&e| free_index[edges[e as usize].camera as usize]);
        clique.extend(cameras.filter(|&c| c != NONE));
        adjacency.connect(&clique);
    }
    let ordering = adjacency.minimum_degree();
    let position = free_index.iter().map(|&i| if i == NONE { NONE } else { ordering.position[i as usize] });
    (position.collect(), BlockCholesky::new(&ordering.columns))
}
