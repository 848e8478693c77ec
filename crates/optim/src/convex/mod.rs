//! Positions from measured translations whose rotations are known: a convex problem, and so without false minima.

mod cone;

use geometry::Vec3;

/// A measured difference of positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TranslationEdge {
    /// Node from which is measured.
    pub a: u32,
    /// Node to which is measured.
    pub b: u32,
    /// Position of `b` minus position of `a` along the world's axes, meters.
    pub translation: Vec3,
    /// Standard deviation of each coordinate, meters.
    pub sigma_m: f64,
}

/// A graph of measured translations.
#[derive(Clone, Debug, PartialEq)]
pub struct TranslationProblem {
    /// Number of nodes.
    pub n_nodes: usize,
    /// The node at the origin.
    pub fixed: u32,
    /// Measurements in any order.
    pub edges: Vec<TranslationEdge>,
    /// Where the loss turns from quadratic to linear, in sigma of the norm of the error.
    pub huber: f64,
}

/// Positions that fit a [`TranslationProblem`] best.
#[derive(Clone, Debug, PartialEq)]
pub struct TranslationFit {
    /// Per node, meters; the fixed one at the origin.
    pub positions: Vec<Vec3>,
    /// Per edge the norm of its error over its sigma.
    pub residuals: Vec<f64>,
    /// Sum of Huber's losses, each half the squared residual where it is quadratic.
    pub cost: f64,
}

/// Why [`fit_translations`] has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConvexError {
    /// The fixed node is not among the nodes.
    #[error("node {fixed} is to be fixed, but there are {n_nodes} nodes")]
    NoSuchNode {
        /// The fixed node.
        fixed: u32,
        /// Number of nodes.
        n_nodes: usize,
    },
    /// An edge joins a node to itself or names one that does not exist, or its numbers are unusable.
    #[error("edge {edge} is unusable: it joins nodes {a} and {b} of {n_nodes}, with sigma {sigma_m} m")]
    BadEdge {
        /// Index of the edge.
        edge: usize,
        /// Its first node.
        a: u32,
        /// Its second node.
        b: u32,
        /// Number of nodes.
        n_nodes: usize,
        /// Its standard deviation.
        sigma_m: f64,
    },
    /// Huber's limit is not a positive number.
    #[error("the limit of Huber's loss is {0}, not a positive number")]
    BadHuber(f64),
    /// A node without a chain of edges to the fixed one.
    #[error("node {node} is not connected to the fixed node")]
    Disconnected {
        /// The lowest such node.
        node: u32,
    },
    /// The cone solver gave up.
    #[error("the cone solver stopped with {status} after {iterations} iterations")]
    Solver {
        /// What it says.
        status: String,
        /// Steps it took.
        iterations: u32,
    },
}

/// The positions that minimize the sum of Huber's losses of the norms of all errors, as a second-order cone program.
///
/// The loss is rotation invariant: `rho(r) = min over v >= 0 of (|r| - v)^2 / 2 + huber v`. On one thread; equal input gives
/// equal bits.
///
/// # Errors
/// See [`ConvexError`]; nothing is guessed. An answer is good to 1e-6 of its cost at least, nearly always to 1e-8.
pub fn fit_translations(problem: &TranslationProblem) -> Result<TranslationFit, ConvexError> {
    check(problem)?;
    let start = positions_along_a_tree(problem)?;
    let positions = cone::solve(problem, &start)?;
    let residuals: Vec<f64> = problem
        .edges
        .iter()
        .map(|e| (positions[e.b as usize] - positions[e.a as usize] - e.translation).norm() / e.sigma_m)
        .collect();
    let cost = residuals.iter().map(|&r| huber_loss(r, problem.huber)).sum();
    Ok(TranslationFit { positions, residuals, cost })
}

fn huber_loss(residual: f64, huber: f64) -> f64 {
    if residual <= huber { 0.5 * residual * residual } else { huber * (residual - 0.5 * huber) }
}

fn check(problem: &TranslationProblem) -> Result<(), ConvexError> {
    let &TranslationProblem { n_nodes, fixed, huber, .. } = problem;
    if fixed as usize >= n_nodes {
        return Err(ConvexError::NoSuchNode { fixed, n_nodes });
    }
    if !(huber > 0.0 && huber.is_finite()) {
        return Err(ConvexError::BadHuber(huber));
    }
    for (edge, &TranslationEdge { a, b, translation, sigma_m }) in problem.edges.iter().enumerate() {
        let usable = a != b
            && (a.max(b) as usize) < n_nodes
            && translation.iter().all(|v| v.is_finite())
            && sigma_m > 0.0
            && sigma_m.is_finite();
        if !usable {
            return Err(ConvexError::BadEdge { edge, a, b, n_nodes, sigma_m });
        }
    }
    Ok(())
}

/// Positions that follow the edges breadth first from the fixed node; they keep the solver's numbers small.
fn positions_along_a_tree(problem: &TranslationProblem) -> Result<Vec<Vec3>, ConvexError> {
    let mut incident = vec![Vec::new(); problem.n_nodes];
    for e in &problem.edges {
        incident[e.a as usize].push((e.b, e.translation));
        incident[e.b as usize].push((e.a, -e.translation));
    }
    let mut positions = vec![None; problem.n_nodes];
    positions[problem.fixed as usize] = Some(Vec3::zeros());
    let mut open = vec![(problem.fixed, Vec3::zeros())];
    let mut next = 0;
    while let Some(&(node, position)) = open.get(next) {
        next += 1;
        for &(other, translation) in &incident[node as usize] {
            let reached = &mut positions[other as usize];
            if reached.is_none() {
                *reached = Some(position + translation);
                open.push((other, position + translation));
            }
        }
    }
    let found = positions.into_iter().enumerate();
    found.map(|(node, p)| p.ok_or(ConvexError::Disconnected { node: node as u32 })).collect()
}
