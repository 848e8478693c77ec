//! The second-order cone program of [`super::fit_translations`], for the interior-point solver Clarabel.
//!
//! Unknown are corrections x of the starting positions and per edge s and v with |error| / sigma <= s + v, v >= 0; the sum
//! of s^2 / 2 + huber v becomes least.

use clarabel::algebra::CscMatrix;
use clarabel::solver::SupportedConeT::{NonnegativeConeT, SecondOrderConeT};
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use geometry::Vec3;

use super::{ConvexError, TranslationProblem};

/// Relative and absolute duality gap, and feasibility, in whitened units.
const TOLERANCE: f64 = 1e-8;
/// The same where the solver comes to a standstill before.
const REDUCED_TOLERANCE: f64 = 1e-6;

/// The positions that minimize the loss, from the given ones; the problem has been checked.
pub(super) fn solve(problem: &TranslationProblem, start: &[Vec3]) -> Result<Vec<Vec3>, ConvexError> {
    if problem.edges.is_empty() {
        return Ok(start.to_vec());
    }
    let Program { objective, linear, constraints, bounds, cones } = program(problem, start);
    let settings = DefaultSettings {
        verbose: false,
        max_iter: 200,
        max_threads: 1,
        tol_gap_abs: TOLERANCE,
        tol_gap_rel: TOLERANCE,
        tol_feas: TOLERANCE,
        reduced_tol_gap_abs: REDUCED_TOLERANCE,
        reduced_tol_gap_rel: REDUCED_TOLERANCE,
        reduced_tol_feas: REDUCED_TOLERANCE,
        ..Default::default()
    };
    let failed = |status: String, iterations: u32| ConvexError::Solver { status, iterations };
    let mut solver = DefaultSolver::new(&objective, &linear, &constraints, &bounds, &cones, settings)
        .map_err(|e| failed(e.to_string(), 0))?;
    solver.solve();
    let solution = &solver.solution;
    if !matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved) {
        return Err(failed(format!("{:?}", solution.status), solution.iterations));
    }
    let moved = start.iter().enumerate().map(|(node, position)| match column(problem, node as u32) {
        Some(first) => position + Vec3::from_column_slice(&solution.x[first..first + 3]),
        None => *position,
    });
    Ok(moved.collect())
}

/// Clarabel's form: least x' objective x / 2 + linear x with bounds - constraints x in the cones.
struct Program {
    objective: CscMatrix<f64>,
    linear: Vec<f64>,
    constraints: CscMatrix<f64>,
    bounds: Vec<f64>,
    cones: Vec<SupportedConeT<f64>>,
}

/// Index of the first unknown of a node, `None` for the fixed one.
fn column(problem: &TranslationProblem, node: u32) -> Option<usize> {
    (node != problem.fixed).then(|| 3 * (node as usize - usize::from(node > problem.fixed)))
}

fn program(problem: &TranslationProblem, start: &[Vec3]) -> Program {
    let m = problem.edges.len();
    let first_s = 3 * (problem.n_nodes - 1);
    let n = first_s + 2 * m;
    let mut linear = vec![0.0; n];
    let mut bounds = vec![0.0; 5 * m];
    let mut entries = Entries::default();
    let mut squares = Entries::default();
    let mut cones = vec![NonnegativeConeT(m)];
    for (k, e) in problem.edges.iter().enumerate() {
        let (s, v, row) = (first_s + k, first_s + m + k, m + 4 * k);
        squares.add(s, s, 1.0);
        linear[v] = problem.huber;
        entries.add(k, v, -1.0);
        entries.add(row, s, -1.0);
        entries.add(row, v, -1.0);
        let error = e.translation - (start[e.b as usize] - start[e.a as usize]);
        for i in 0..3 {
            for (node, sign) in [(e.a, -1.0), (e.b, 1.0)] {
                if let Some(first) = column(problem, node) {
                    entries.add(row + 1 + i, first + i, sign / e.sigma_m);
                }
            }
            bounds[row + 1 + i] = error[i] / e.sigma_m;
        }
        cones.push(SecondOrderConeT(4));
    }
    Program { objective: squares.matrix(n, n), linear, constraints: entries.matrix(5 * m, n), bounds, cones }
}

/// Entries of a sparse matrix.
#[derive(Default)]
struct Entries {
    rows: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
}

impl Entries {
    fn add(&mut self, row: usize, column: usize, value: f64) {
        self.rows.push(row);
        self.columns.push(column);
        self.values.push(value);
    }

    fn matrix(self, n_rows: usize, n_columns: usize) -> CscMatrix<f64> {
        CscMatrix::new_from_triplets(n_rows, n_columns, self.rows, self.columns, self.values)
    }
}
