//! The damped 3x3 block of one point and its Cholesky factor.

/// Range of the damping's scale, so that directions without any observation stay solvable.
const MIN_SCALE: f64 = 1e-6;
const MAX_SCALE: f64 = 1e32;
/// A pivot this small against its diagonal holds no information: the point stays where it is.
const MIN_PIVOT_RATIO: f64 = 1e-13;

/// What the damping of a parameter is multiplied by, given its entry on the diagonal of the normal equations.
#[inline(always)]
pub(super) fn damping_scale(diagonal: f64) -> f64 {
    diagonal.clamp(MIN_SCALE, MAX_SCALE)
}

/// Factor L of the damped block V = L L^T; all zero, which yields no step, where V is singular.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PointFactor {
    /// L below the diagonal: 10, 20, 21.
    lower: [f64; 3],
    /// Inverse of its diagonal.
    inv_diagonal: [f64; 3],
    /// -L^-1 times the gradient.
    pub(super) y: [f64; 3],
    /// Gradient of the cost in the point.
    pub(super) gradient: [f64; 3],
    /// Damping added to the diagonal.
    pub(super) damping: [f64; 3],
}

impl PointFactor {
    /// Damps and factors a block given by its lower triangle (00, 10, 11, 20, 21, 22).
    #[inline(always)]
    pub(super) fn new(block: &[f64; 6], gradient: &[f64; 3], lambda: f64) -> Self {
        let [b00, b10, b11, b20, b21, b22] = *block;
        let damping = [b00, b11, b22].map(|d| lambda * damping_scale(d));
        let (d0, d1, d2) = (b00 + damping[0], b11 + damping[1], b22 + damping[2]);
        let i0 = 1.0 / d0.sqrt();
        let (l10, l20) = (b10 * i0, b20 * i0);
        let p1 = d1 - l10 * l10;
        let i1 = 1.0 / p1.sqrt();
        let l21 = (b21 - l20 * l10) * i1;
        let p2 = d2 - l20 * l20 - l21 * l21;
        let i2 = 1.0 / p2.sqrt();
        if !(p1 > MIN_PIVOT_RATIO * d1 && p2 > MIN_PIVOT_RATIO * d2) {
            return Self::default();
        }
        let y0 = -gradient[0] * i0;
        let y1 = (-gradient[1] - l10 * y0) * i1;
        let y2 = (-gradient[2] - l20 * y0 - l21 * y1) * i2;
        Self {
            lower: [l10, l20, l21],
            inv_diagonal: [i0, i1, i2],
            y: [y0, y1, y2],
            gradient: *gradient,
            damping,
        }
    }

    /// L^-1 times three rows.
    #[inline(always)]
    pub(super) fn solve_lower<const C: usize>(&self, rows: &[[f64; C]; 3]) -> [[f64; C]; 3] {
        let ([l10, l20, l21], [i0, i1, i2]) = (self.lower, self.inv_diagonal);
        let mut z = *rows;
        for c in 0..C {
            z[0][c] *= i0;
            z[1][c] = (z[1][c] - l10 * z[0][c]) * i1;
            z[2][c] = (z[2][c] - l20 * z[0][c] - l21 * z[1][c]) * i2;
        }
        z
    }

    /// L^-T times a vector.
    #[inline(always)]
    pub(super) fn solve_upper(&self, b: &[f64; 3]) -> [f64; 3] {
        let ([l10, l20, l21], [i0, i1, i2]) = (self.lower, self.inv_diagonal);
        let x2 = b[2] * i2;
        let x1 = (b[1] - l21 * x2) * i1;
        [(b[0] - l10 * x1 - l20 * x2) * i0, x1, x2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factored_block_solves_its_system() {
        let (block, gradient) = ([4.0, 1.0, 3.0, -0.5, 0.7, 2.0], [1.0, -2.0, 0.5]);
        let lambda = 0.1;
        let factor = PointFactor::new(&block, &gradient, lambda);
        let x = factor.solve_upper(&factor.y);
        let [b00, b10, b11, b20, b21, b22] = block;
        let grown = 1.0 + lambda;
        let rows = [[b00 * grown, b10, b20], [b10, b11 * grown, b21], [b20, b21, b22 * grown]];
        for (row, g) in rows.iter().zip(gradient) {
            let product: f64 = row.iter().zip(x).map(|(a, b)| a * b).sum();
            assert!((product + g).abs() < 1e-14, "{product} {g}");
        }
    }

    #[test]
    fn a_singular_block_gives_no_step() {
        for block in [[1.0, 1.0, 1.0, 1.0, 1.0, 1.0], [f64::NAN; 6]] {
            let factor = PointFactor::new(&block, &[1.0; 3], 0.0);
            assert_eq!(factor.solve_upper(&factor.y), [0.0; 3]);
        }
    }
}
