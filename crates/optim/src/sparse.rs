//! Sparse symmetric systems in dense blocks, solved by faer's Cholesky factorization.
//!
//! The elimination order comes from approximate minimum degree on the graph of blocks, once; so does the symbolic
//! factorization. All runs on the calling thread. faer chooses instructions by processor, so between processors of different
//! kind the last bits may differ.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side, Spec};
use nalgebra::{SMatrix, SVector};

/// A symmetric matrix of D x D blocks: upper triangle by scalar columns, in elimination order.
pub(crate) struct BlockMatrix<const D: usize> {
    /// Elimination position per node.
    position: Vec<u32>,
    /// Per block column (by position) the rows above its diagonal, ascending.
    above: Vec<Vec<u32>>,
    /// Index of the first value of each block column.
    start: Vec<usize>,
    values: Vec<f64>,
    pattern: SymbolicSparseColMat<usize>,
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
    memory: MemBuffer,
}

/// Where a block lies among the values; its orientation follows the elimination order.
#[derive(Clone, Copy)]
pub(crate) struct Slot {
    first: usize,
    /// Rows above the diagonal block in its column.
    height: usize,
    /// Whether the block is stored for (second node, first node).
    is_transposed: bool,
}

impl Slot {
    #[inline(always)]
    fn index(&self, row: usize, column: usize) -> usize {
        self.first + column * self.height + column * (column + 1) / 2 + row
    }
}

impl<const D: usize> BlockMatrix<D> {
    /// The zero matrix over `n` nodes with blocks on the diagonal and for each pair of different nodes; pairs may repeat.
    ///
    /// `None` when the factor would not fit into memory.
    pub(crate) fn new(n: usize, pairs: &[(u32, u32)]) -> Option<Self> {
        let position = minimum_degree(n, pairs)?;
        let above = rows_above(n, pairs.iter().map(|&(a, b)| (position[a as usize], position[b as usize])));
        let (start, pattern) = scalar_pattern::<D>(&above);
        // The blocks are supernodes by themselves.
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let order = SymmetricOrdering::Identity;
        let symbolic = factorize_symbolic_cholesky(pattern.as_ref(), Side::Upper, order, params).ok()?;
        let request =
            symbolic
                .factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default())
                .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let memory = MemBuffer::try_new(request).ok()?;
        let values = vec![0.0; pattern.compute_nnz()];
        let factor = vec![0.0; symbolic.len_val()];
        Some(Self { position, above, start, values, pattern, symbolic, factor, memory })
    }

    /// Elimination position of a node: the index of its part of a right-hand side.
    pub(crate) fn position(&self, node: u32) -> usize {
        self.position[node as usize] as usize
    }

    /// The slot of the diagonal block at a position.
    pub(crate) fn diagonal(&self, position: usize) -> Slot {
        let height = D * self.above[position].len();
        Slot { first: self.start[position] + height, height, is_transposed: false }
    }

    /// The slot of the block (a, b) for two different nodes that were given as a pair; `None` for others.
    pub(crate) fn slot(&self, a: u32, b: u32) -> Option<Slot> {
        let (a, b) = (self.position[a as usize], self.position[b as usize]);
        let column = a.max(b) as usize;
        let k = self.above[column].binary_search(&a.min(b)).ok()?;
        let height = D * self.above[column].len();
        Some(Slot { first: self.start[column] + k * D, height, is_transposed: a > b })
    }

    /// Sets all values to zero.
    pub(crate) fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Adds the upper triangle of a matrix to a diagonal block.
    pub(crate) fn add_diagonal(&mut self, slot: Slot, block: &SMatrix<f64, D, D>) {
        for c in 0..D {
            for r in 0..=c {
                self.values[slot.index(r, c)] += block[(r, c)];
            }
        }
    }

    /// Adds a matrix to the block (a, b) of a slot.
    pub(crate) fn add(&mut self, slot: Slot, block: &SMatrix<f64, D, D>) {
        for c in 0..D {
            let first = slot.index(0, c);
            for (r, value) in self.values[first..first + D].iter_mut().enumerate() {
                *value += if slot.is_transposed { block[(c, r)] } else { block[(r, c)] };
            }
        }
    }

    /// The diagonal of the matrix by position.
    pub(crate) fn diagonal_values(&self) -> Vec<SVector<f64, D>> {
        (0..self.above.len())
            .map(|p| SVector::from_fn(|i, _| self.values[self.diagonal(p).index(i, i)]))
            .collect()
    }

    /// Replaces the diagonal of the matrix.
    pub(crate) fn set_diagonal_values(&mut self, diagonal: impl Iterator<Item = SVector<f64, D>>) {
        for (p, values) in diagonal.enumerate() {
            let slot = self.diagonal(p);
            for i in 0..D {
                self.values[slot.index(i, i)] = values[i];
            }
        }
    }

    /// Factors the matrix as it stands and replaces the right-hand side (by position) by the solution.
    ///
    /// `false` when the matrix is not finite and positive definite, or the solution not finite.
    pub(crate) fn solve(&mut self, rhs: &mut [SVector<f64, D>]) -> bool {
        // An infinite pivot would pass as a row without unknowns.
        if !self.values.iter().all(|v| v.is_finite()) {
            return false;
        }
        let n = D * rhs.len();
        let matrix = SparseColMatRef::new(self.pattern.as_ref(), &self.values);
        let stack = MemStack::new(&mut self.memory);
        let factored = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            matrix,
            Side::Upper,
            LltRegularization::default(),
            Par::Seq,
            stack,
            Spec::default(),
        );
        if factored.is_err() {
            return false;
        }
        let mut x: Vec<f64> = rhs.iter().flat_map(|v| v.iter().copied()).collect();
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(&mut x, n, 1),
            Par::Seq,
            stack,
        );
        for (v, x) in rhs.iter_mut().zip(x.chunks_exact(D)) {
            *v = SVector::from_column_slice(x);
        }
        x.iter().all(|v| v.is_finite())
    }
}

/// Elimination position per node (Amestoy, Davis, Duff, "An approximate minimum degree ordering algorithm", 1996).
fn minimum_degree(n: usize, pairs: &[(u32, u32)]) -> Option<Vec<u32>> {
    let (_, pattern) = scalar_pattern::<1>(&rows_above(n, pairs.iter().copied()));
    let (mut order, mut position) = (vec![0; n], vec![0; n]);
    let mut memory = MemBuffer::try_new(amd::order_scratch::<usize>(n, pattern.compute_nnz())).ok()?;
    let stack = MemStack::new(&mut memory);
    amd::order(&mut order, &mut position, pattern.as_ref(), amd::Control::default(), stack).ok()?;
    Some(position.into_iter().map(|p| p as u32).collect())
}

/// Per block column the rows above its diagonal, ascending.
fn rows_above(n: usize, pairs: impl Iterator<Item = (u32, u32)>) -> Vec<Vec<u32>> {
    let mut above = vec![Vec::new(); n];
    for (a, b) in pairs {
        above[a.max(b) as usize].push(a.min(b));
    }
    for rows in &mut above {
        rows.sort_unstable();
        rows.dedup();
    }
    above
}

/// Start of each block column among the values, and the scalar columns of an upper triangle in D x D blocks.
fn scalar_pattern<const D: usize>(above: &[Vec<u32>]) -> (Vec<usize>, SymbolicSparseColMat<usize>) {
    let n = D * above.len();
    let (mut start, mut column_start, mut rows) = (Vec::new(), vec![0], Vec::new());
    for (p, blocks) in above.iter().enumerate() {
        start.push(rows.len());
        for c in 0..D {
            rows.extend(blocks.iter().flat_map(|&b| D * b as usize..D * (b as usize + 1)));
            rows.extend(D * p..=D * p + c);
            column_start.push(rows.len());
        }
    }
    (start, SymbolicSparseColMat::new_checked(n, n, column_start, None, rows))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use nalgebra::{DMatrix, DVector};
    use rand::Rng;

    use super::*;

    /// A banded positive definite matrix with far blocks, and the same dense by node.
    fn example(n: usize, seed: u64) -> (BlockMatrix<3>, DMatrix<f64>) {
        let far = |i: u32| (i % n as u32, (7 * i + 3) % n as u32);
        let pairs: Vec<(u32, u32)> =
            (1..n as u32).map(|i| (i, i - 1)).chain((0..6).map(far)).filter(|(a, b)| a != b).collect();
        let mut matrix = BlockMatrix::<3>::new(n, &pairs).unwrap();
        let mut dense = DMatrix::zeros(3 * n, 3 * n);
        let mut random = crate::common::random(seed);
        for &(a, b) in &pairs {
            let block = SMatrix::<f64, 3, 3>::from_fn(|_, _| random.random_range(-1.0..1.0));
            matrix.add(matrix.slot(a, b).unwrap(), &block);
            let (a, b) = (3 * a as usize, 3 * b as usize);
            let mut view = dense.fixed_view_mut::<3, 3>(a, b);
            view += block;
            let mut view = dense.fixed_view_mut::<3, 3>(b, a);
            view += block.transpose();
        }
        for node in 0..n {
            let root = SMatrix::<f64, 3, 3>::from_fn(|_, _| random.random_range(-1.0..1.0));
            let block = root * root.transpose() + SMatrix::identity() * 20.0;
            matrix.add_diagonal(matrix.diagonal(matrix.position(node as u32)), &block);
            let mut view = dense.fixed_view_mut::<3, 3>(3 * node, 3 * node);
            view += block;
        }
        (matrix, dense)
    }

    #[test]
    fn the_solution_equals_that_of_a_dense_solver() {
        for (n, seed) in [(1, 1), (2, 2), (12, 3), (150, 4)] {
            let (mut matrix, dense) = example(n, seed);
            let b = DVector::from_fn(3 * n, |i, _| (i as f64).sin());
            let mut x = vec![SVector::<f64, 3>::zeros(); n];
            for node in 0..n {
                x[matrix.position(node as u32)] = b.fixed_rows::<3>(3 * node).into_owned();
            }
            assert!(matrix.solve(&mut x));
            let by_node: Vec<f64> =
                (0..n).flat_map(|node| <[f64; 3]>::from(x[matrix.position(node as u32)])).collect();
            let residual = dense * DVector::from_vec(by_node) - b;
            assert!(residual.norm() < 1e-12, "{n}: {}", residual.norm());
        }
    }

    #[test]
    fn the_diagonal_is_read_and_replaced() {
        let (mut matrix, dense) = example(12, 5);
        let diagonal = matrix.diagonal_values();
        for node in 0..12 {
            let position = matrix.position(node as u32);
            for i in 0..3 {
                assert_eq!(diagonal[position][i], dense[(3 * node + i, 3 * node + i)]);
            }
        }
        matrix.set_diagonal_values(diagonal.iter().map(|d| d * 2.0));
        assert_eq!(matrix.diagonal_values()[7], diagonal[7] * 2.0);
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        for bad in [-50.0, f64::NAN, f64::INFINITY] {
            let (mut matrix, _) = example(12, 6);
            let mut diagonal = matrix.diagonal_values();
            diagonal[5][1] = bad;
            matrix.set_diagonal_values(diagonal.into_iter());
            assert!(!matrix.solve(&mut [SVector::from_element(1.0); 12]), "{bad}");
        }
    }

    /// Pairs that elimination in the given order adds.
    fn n_filled(position: &[u32], pairs: &[(u32, u32)]) -> usize {
        let mut above = vec![BTreeSet::new(); position.len()];
        for &(a, b) in pairs {
            let (a, b) = (position[a as usize], position[b as usize]);
            above[a.min(b) as usize].insert(a.max(b));
        }
        for p in 0..above.len() {
            let mut rest = above[p].clone();
            if let Some(next) = rest.pop_first() {
                above[next as usize].extend(rest);
            }
        }
        above.iter().map(BTreeSet::len).sum::<usize>() - pairs.len()
    }

    #[test]
    fn minimum_degree_fills_no_chain_and_no_star() {
        let star: Vec<_> = (1..200).map(|i| (0, i)).collect();
        let chain: Vec<_> = (1..200).map(|i| (i - 1, i)).collect();
        let ring: Vec<_> = (0..200).map(|i| (i, (i + 1) % 200)).collect();
        for (pairs, fill) in [(star, 0), (chain, 0), (ring, 197)] {
            let position = minimum_degree(200, &pairs).unwrap();
            assert_eq!(n_filled(&position, &pairs), fill);
            let mut sorted = position.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..200));
        }
    }
}
