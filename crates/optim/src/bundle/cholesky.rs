//! Sparse Cholesky factorization in dense blocks, one block row per free camera.

use simd::{Simd, Task};

/// A symmetric positive definite matrix of CxC blocks: lower triangle by columns, factored in place.
pub(crate) struct BlockCholesky<const C: usize> {
    /// Start of each column in `rows` and `blocks`.
    start: Vec<usize>,
    /// Block row of each block, ascending, the diagonal first.
    rows: Vec<u32>,
    /// Row-major blocks; of the diagonal ones only the lower triangle counts.
    pub(crate) blocks: Vec<[[f64; C]; C]>,
    /// Inverse of the factor's diagonal.
    inv_diagonal: Vec<[f64; C]>,
}

impl<const C: usize> BlockCholesky<C> {
    /// Zero matrix with the given rows per column (closed under fill).
    pub(crate) fn new(columns: &[Vec<u32>]) -> Self {
        let mut start = Vec::with_capacity(columns.len() + 1);
        start.push(0);
        for column in columns {
            start.push(start[start.len() - 1] + column.len());
        }
        let rows = columns.concat();
        let blocks = vec![[[0.0; C]; C]; rows.len()];
        Self { start, rows, blocks, inv_diagonal: vec![[0.0; C]; columns.len()] }
    }

    /// Number of block rows.
    pub(crate) fn n(&self) -> usize {
        self.inv_diagonal.len()
    }

    /// Index of the diagonal block of a column.
    #[inline(always)]
    pub(crate) fn diagonal(&self, column: usize) -> usize {
        self.start[column]
    }

    /// Indices of the blocks of a column, and their rows.
    pub(crate) fn column(&self, column: usize) -> (std::ops::Range<usize>, &[u32]) {
        let range = self.start[column]..self.start[column + 1];
        (range.clone(), &self.rows[range])
    }

    /// Replaces the matrix by its factor; `false` when it is not positive definite.
    pub(crate) fn factor(&mut self, simd: Simd) -> bool {
        simd.run(Factor(self))
    }

    /// Replaces the right-hand side by the solution.
    pub(crate) fn solve(&self, x: &mut [[f64; C]]) {
        for k in 0..self.n() {
            let xk = self.solve_lower(k, &x[k]);
            x[k] = xk;
            for b in self.start[k] + 1..self.start[k + 1] {
                let (block, target) = (&self.blocks[b], &mut x[self.rows[b] as usize]);
                for r in 0..C {
                    for c in 0..C {
                        target[r] -= block[r][c] * xk[c];
                    }
                }
            }
        }
        for k in (0..self.n()).rev() {
            let mut xk = x[k];
            for b in self.start[k] + 1..self.start[k + 1] {
                let (block, other) = (&self.blocks[b], &x[self.rows[b] as usize]);
                for r in 0..C {
                    for c in 0..C {
                        xk[c] -= block[r][c] * other[r];
                    }
                }
            }
            x[k] = self.solve_upper(k, &xk);
        }
    }

    #[inline(always)]
    fn solve_lower(&self, column: usize, b: &[f64; C]) -> [f64; C] {
        let (l, inv) = (&self.blocks[self.start[column]], &self.inv_diagonal[column]);
        let mut x = *b;
        for c in 0..C {
            x[c] *= inv[c];
            for r in c + 1..C {
                x[r] -= l[r][c] * x[c];
            }
        }
        x
    }

    #[inline(always)]
    fn solve_upper(&self, column: usize, b: &[f64; C]) -> [f64; C] {
        let (l, inv) = (&self.blocks[self.start[column]], &self.inv_diagonal[column]);
        let mut x = *b;
        for r in (0..C).rev() {
            x[r] *= inv[r];
            for c in 0..r {
                x[c] -= l[r][c] * x[r];
            }
        }
        x
    }
}

struct Factor<'a, const C: usize>(&'a mut BlockCholesky<C>);

impl<const C: usize> Task for Factor<'_, C> {
    type Output = bool;

    /// Right-looking: factor a column, subtract its outer product from the columns to the right.
    #[inline(always)]
    fn run(self) -> bool {
        let matrix = self.0;
        for k in 0..matrix.n() {
            let (first, end) = (matrix.start[k], matrix.start[k + 1]);
            let Some(inv) = factor_diagonal(&mut matrix.blocks[first]) else { return false };
            matrix.inv_diagonal[k] = inv;
            let l = matrix.blocks[first];
            for block in &mut matrix.blocks[first + 1..end] {
                divide_by_transpose(block, &l, &inv);
            }
            for j in first + 1..end {
                let l_j = transposed(&matrix.blocks[j]);
                let mut target = matrix.start[matrix.rows[j] as usize];
                for i in j..end {
                    while matrix.rows[target] != matrix.rows[i] {
                        target += 1;
                    }
                    let l_i = matrix.blocks[i];
                    subtract_product(&mut matrix.blocks[target], &l_i, &l_j);
                }
            }
        }
        true
    }
}

#[inline(always)]
fn transposed<const C: usize>(a: &[[f64; C]; C]) -> [[f64; C]; C] {
    std::array::from_fn(|r| std::array::from_fn(|c| a[c][r]))
}

/// `target -= a * b`.
#[inline(always)]
fn subtract_product<const C: usize>(target: &mut [[f64; C]; C], a: &[[f64; C]; C], b: &[[f64; C]; C]) {
    for r in 0..C {
        let mut row = target[r];
        for k in 0..C {
            for c in 0..C {
                row[c] -= a[r][k] * b[k][c];
            }
        }
        target[r] = row;
    }
}

/// Lower Cholesky factor of a diagonal block in place; returns the inverse diagonal.
#[inline(always)]
fn factor_diagonal<const C: usize>(a: &mut [[f64; C]; C]) -> Option<[f64; C]> {
    let mut inv = [0.0; C];
    for c in 0..C {
        let mut pivot = a[c][c];
        for k in 0..c {
            pivot -= a[c][k] * a[c][k];
        }
        if !(pivot > 0.0 && pivot < f64::INFINITY) {
            return None;
        }
        let root = pivot.sqrt();
        a[c][c] = root;
        inv[c] = 1.0 / root;
        for r in c + 1..C {
            let mut sum = a[r][c];
            for k in 0..c {
                sum -= a[r][k] * a[c][k];
            }
            a[r][c] = sum * inv[c];
        }
    }
    Some(inv)
}

/// `block <- block * l^-T`.
#[inline(always)]
fn divide_by_transpose<const C: usize>(block: &mut [[f64; C]; C], l: &[[f64; C]; C], inv: &[f64; C]) {
    let mut columns = transposed(block);
    for c in 0..C {
        for k in 0..c {
            for r in 0..C {
                columns[c][r] -= l[c][k] * columns[k][r];
            }
        }
        for r in 0..C {
            columns[c][r] *= inv[c];
        }
    }
    *block = transposed(&columns);
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use rand::Rng;

    use super::super::ordering::Adjacency;
    use super::*;

    /// A banded positive definite matrix with a few far blocks, and the same dense, in elimination order.
    fn example() -> (BlockCholesky<3>, DMatrix<f64>) {
        let n = 12;
        let mut adjacency = Adjacency::new(n);
        let pairs: Vec<[u32; 2]> = (0..11).map(|i| [i, i + 1]).chain([[0, 7], [2, 11]]).collect();
        for pair in &pairs {
            adjacency.connect(pair);
        }
        let ordering = adjacency.minimum_degree();
        let mut matrix = BlockCholesky::<3>::new(&ordering.columns);
        let mut dense = DMatrix::zeros(3 * n, 3 * n);
        let mut random = crate::common::random(1);
        let positions = pairs.iter().map(|pair| pair.map(|i| ordering.position[i as usize] as usize));
        for [a, b] in positions.chain((0..n).map(|i| [i, i])) {
            let (column, row) = (a.min(b), a.max(b));
            let (blocks, rows) = matrix.column(column);
            let block = blocks.zip(rows).find(|&(_, &r)| r as usize == row).map(|(block, _)| block);
            let block = &mut matrix.blocks[block.expect("in the pattern")];
            for r in 0..3 {
                for c in 0..3 {
                    let value = random.random_range(-1.0..1.0) + if a == b && r == c { 15.0 } else { 0.0 };
                    if a != b || r >= c {
                        block[r][c] = value;
                        dense[(3 * row + r, 3 * column + c)] = value;
                        dense[(3 * column + c, 3 * row + r)] = value;
                    }
                }
            }
        }
        (matrix, dense)
    }

    #[test]
    fn the_solution_equals_that_of_a_dense_solver() {
        let (mut matrix, dense) = example();
        let b = DVector::from_fn(dense.nrows(), |i, _| (i as f64).sin());
        let mut x: Vec<[f64; 3]> = (0..12).map(|k| std::array::from_fn(|i| b[3 * k + i])).collect();
        assert!(matrix.factor(Simd::detect()));
        matrix.solve(&mut x);
        let residual = dense * DVector::from_iterator(36, x.concat()) - b;
        assert!(residual.norm() < 1e-13, "{}", residual.norm());
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        for bad in [-50.0, f64::NAN, f64::INFINITY] {
            let (mut matrix, _) = example();
            let diagonal = matrix.diagonal(5);
            matrix.blocks[diagonal][1][1] = bad;
            assert!(!matrix.factor(Simd::detect()), "{bad}");
        }
    }
}
