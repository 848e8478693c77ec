//! Pose graphs: recovery, cost, gauge, scale drift, and input that determines little or nothing.

mod common;

use common::{normal, random};
use dsslam_optim::{
    PoseGraphEdge, PoseGraphOptions, PoseGraphProblem, PoseGraphSolution, PoseGroup, StopReason,
    refine_pose_graph,
};
use geometry::{Mat3, Mat6, Mat7, SE3, SO3, Sim3, Vec3, Vec6, Vec7};
use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

fn noise<const D: usize>(random: &mut ChaCha8Rng, sigma: f64) -> SVector<f64, D> {
    SVector::from_fn(|_, _| sigma * normal(random))
}

/// A chain of nodes with loops, its measurements disturbed by `sigma`; the poses are the true ones, the first one fixed.
fn graph<G, const D: usize>(seed: u64, n: u32, n_loops: u32, sigma: f64) -> PoseGraphProblem<G>
where
    G: PoseGroup<Tangent = SVector<f64, D>, Matrix = SMatrix<f64, D, D>>,
{
    let mut random = random(seed);
    let mut poses = vec![G::exp(&noise(&mut random, 1.0))];
    for i in 1..n as usize {
        poses.push(G::exp(&noise(&mut random, 0.4)) * poses[i - 1]);
    }
    let chain = (1..n).map(|i| (i - 1, i));
    let mut pairs: Vec<(u32, u32)> = chain.collect();
    pairs.extend((0..n_loops).map(|_| {
        let a = random.random_range(0..n - 1);
        (a, random.random_range(a + 1..n))
    }));
    let edges = pairs.iter().map(|&(a, b)| {
        let b_from_a = poses[b as usize] * poses[a as usize].inverse() * G::exp(&noise(&mut random, sigma));
        let root =
            SMatrix::<f64, D, D>::from_fn(|r, c| 0.3 * normal(&mut random) + if r == c { 3.0 } else { 0.0 });
        PoseGraphEdge { a, b, b_from_a, information: root.tr_mul(&root) }
    });
    let edges = edges.collect();
    let mut fixed = vec![false; n as usize];
    fixed[0] = true;
    PoseGraphProblem { poses, fixed, edges }
}

/// The same graph with its free poses displaced.
fn displaced<G, const D: usize>(problem: &PoseGraphProblem<G>, seed: u64, sigma: f64) -> PoseGraphProblem<G>
where
    G: PoseGroup<Tangent = SVector<f64, D>>,
{
    let mut random = random(seed);
    let mut problem = problem.clone();
    for (pose, fixed) in problem.poses.iter_mut().zip(&problem.fixed) {
        if !fixed {
            *pose = G::exp(&noise(&mut random, sigma)) * *pose;
        }
    }
    problem
}

/// Solves, and checks what holds for any graph.
fn solve<G, const D: usize>(problem: &PoseGraphProblem<G>, options: &PoseGraphOptions) -> PoseGraphSolution<G>
where
    G: PoseGroup<Tangent = SVector<f64, D>, Matrix = SMatrix<f64, D, D>>,
{
    let solution = refine_pose_graph(problem, options);
    let report = solution.report;
    assert!(report.final_cost <= report.initial_cost * (1.0 + 1e-12), "{report:?}");
    assert_eq!(solution.chi_sq.len(), problem.edges.len());
    for ((pose, initial), fixed) in solution.poses.iter().zip(&problem.poses).zip(&problem.fixed) {
        assert!(pose.is_valid() || !initial.is_valid());
        assert!(!fixed || pose == initial);
    }
    assert_eq!(refine_pose_graph(problem, options).poses, solution.poses, "equal input, equal bits");
    solution
}

fn largest_difference<G, const D: usize>(a: &[G], b: &[G]) -> f64
where
    G: PoseGroup<Tangent = SVector<f64, D>>,
{
    a.iter().zip(b).map(|(a, b)| (*a * b.inverse()).log().norm()).fold(0.0, f64::max)
}

/// Exact measurements must bring every displaced pose back.
fn check_recovery<G, const D: usize>()
where
    G: PoseGroup<Tangent = SVector<f64, D>, Matrix = SMatrix<f64, D, D>>,
{
    for seed in 0..6 {
        let truth = graph::<G, D>(seed, 60, 25, 0.0);
        let problem = displaced(&truth, 100 + seed, 0.15);
        assert!(largest_difference(&problem.poses, &truth.poses) > 0.2, "displaced");
        let solution = solve(&problem, &PoseGraphOptions::default());
        let error = largest_difference(&solution.poses, &truth.poses);
        assert_eq!(solution.report.stop, StopReason::Converged);
        assert!(error < 1e-6 && solution.report.final_cost < 1e-12, "{error} {:?}", solution.report);
        assert_eq!(solution.report.n_inliers, problem.edges.len());
    }
}

#[test]
fn exact_graphs_return_to_the_truth() {
    check_recovery::<SO3, 3>();
    check_recovery::<SE3, 6>();
    check_recovery::<Sim3, 7>();
}

/// At the minimum any small motion of any free node raises the cost.
fn check_minimum<G, const D: usize>(huber: Option<f64>)
where
    G: PoseGroup<Tangent = SVector<f64, D>, Matrix = SMatrix<f64, D, D>>,
{
    let mut problem = graph::<G, D>(7, 20, 8, 0.05);
    problem.edges[22].b_from_a = G::exp(&noise(&mut random(8), 0.5)) * problem.edges[22].b_from_a;
    let options = PoseGraphOptions { huber, relative_tolerance: 1e-14, ..Default::default() };
    let solution = solve(&problem, &options);
    let cost_at = |poses: Vec<G>| {
        let moved = PoseGraphProblem { poses, ..problem.clone() };
        refine_pose_graph(&moved, &PoseGraphOptions { max_iterations: 0, ..options }).report.initial_cost
    };
    let least = cost_at(solution.poses.clone());
    assert!((least - solution.report.final_cost).abs() <= 1e-12 * least);
    for node in 1..20 {
        for k in 0..D {
            for step in [-1e-3, 1e-3] {
                let mut poses = solution.poses.clone();
                poses[node] = G::exp(&SVector::from_fn(|i, _| if i == k { step } else { 0.0 })) * poses[node];
                assert!(cost_at(poses) > least, "node {node}, direction {k}");
            }
        }
    }
}

#[test]
fn the_solution_is_a_minimum() {
    for huber in [None, Some(1.5)] {
        check_minimum::<SE3, 6>(huber);
        check_minimum::<Sim3, 7>(huber);
    }
}

#[test]
fn hubers_loss_keeps_a_false_loop_from_bending_the_graph() {
    let mut problem = graph::<SE3, 6>(9, 60, 25, 0.0);
    let truth = problem.poses.clone();
    problem.edges[70].b_from_a = SE3::exp(&Vec6::new(5.0, -3.0, 2.0, 0.3, 0.5, -0.4));
    let plain = solve(&problem, &PoseGraphOptions::default());
    let robust =
        solve(&problem, &PoseGraphOptions { huber: Some(0.1), max_iterations: 200, ..Default::default() });
    assert_eq!(robust.report.stop, StopReason::Converged);
    let middle = |poses: &[SE3]| {
        let mut differences: Vec<f64> =
            poses.iter().zip(&truth).map(|(p, t)| (*p * t.inverse()).log().norm()).collect();
        differences.sort_by(f64::total_cmp);
        differences[30]
    };
    let (bent, kept) = (middle(&plain.poses), middle(&robust.poses));
    assert!(kept < 0.2 * bent, "{kept} {bent}");
    let worst = robust.chi_sq.iter().copied().fold(0.0, f64::max);
    assert_eq!(robust.chi_sq[70], worst);
    assert_eq!(robust.report.n_inliers, problem.edges.len() - 1);
}

/// Moving the world moves the answer along, and the gauge that is kept does not matter.
#[test]
fn the_answer_does_not_depend_on_the_gauge() {
    let problem = displaced(&graph::<Sim3, 7>(11, 30, 12, 0.05), 12, 0.1);
    let options = PoseGraphOptions { relative_tolerance: 1e-14, ..Default::default() };
    let solution = solve(&problem, &options);
    let motion = Sim3::exp(&Vec7::from_column_slice(&[3.0, -5.0, 8.0, 1.0, -0.5, 0.7, 0.4]));
    let elsewhere =
        PoseGraphProblem { poses: problem.poses.iter().map(|p| *p * motion).collect(), ..problem.clone() };
    let moved = solve(&elsewhere, &options);
    let expected: Vec<Sim3> = solution.poses.iter().map(|p| *p * motion).collect();
    assert!(largest_difference(&moved.poses, &expected) < 1e-6);
    assert!((moved.report.final_cost / solution.report.final_cost - 1.0).abs() < 1e-9);

    for hold in [None, Some(17)] {
        let mut free = problem.clone();
        free.fixed[0] = false;
        if let Some(node) = hold {
            free.fixed[node] = true;
        }
        let other = solve(&free, &options);
        assert_eq!(other.poses[hold.unwrap_or(0)], problem.poses[hold.unwrap_or(0)]);
        assert!((other.report.final_cost / solution.report.final_cost - 1.0).abs() < 1e-9);
        let shift = other.poses[0].inverse() * solution.poses[0];
        let back: Vec<Sim3> = other.poses.iter().map(|p| *p * shift).collect();
        assert!(largest_difference(&back, &solution.poses) < 1e-5);
    }
}

/// The order of edges and nodes' numbers may change rounding only.
#[test]
fn the_order_of_the_edges_does_not_matter() {
    let problem = displaced(&graph::<SE3, 6>(13, 40, 20, 0.05), 14, 0.05);
    let mut turned = problem.clone();
    turned.edges.reverse();
    let options = PoseGraphOptions { relative_tolerance: 1e-14, ..Default::default() };
    let (one, other) = (solve(&problem, &options), solve(&turned, &options));
    assert!(largest_difference(&one.poses, &other.poses) < 1e-7);
    for (a, b) in one.chi_sq.iter().zip(other.chi_sq.iter().rev()) {
        assert!((a - b).abs() < 1e-7 * (1.0 + a));
    }
}

/// A monocular round whose scale has drifted: odometry says 1 where the true ratio is `q`, and so does the loop. Then the
/// errors of pure scale `ln q` on every edge are in balance (all rows of the Jacobians for scale are plus or minus one).
#[test]
fn scale_drift_of_a_loop_spreads_evenly() {
    let (n, drift) = (40u32, 0.8f64);
    let q = drift.powf(1.0 / f64::from(n));
    let scaled = |scale: f64| Sim3::new(SO3::identity(), Vec3::zeros(), scale);
    let turn = SO3::exp(&Vec3::new(0.0, std::f64::consts::TAU / f64::from(n), 0.0));
    let step = Sim3::new(turn, Vec3::z(), 1.0);
    let mut rigid = vec![Sim3::identity()];
    for i in 1..n as usize {
        rigid.push(step * rigid[i - 1]);
    }
    let expected: Vec<Sim3> = rigid.iter().zip(0..).map(|(pose, i)| scaled(q.powi(i)) * *pose).collect();
    let edges = (0..n).map(|a| {
        let b = (a + 1) % n;
        let b_from_a = expected[b as usize] * expected[a as usize].inverse() * scaled(1.0 / q);
        PoseGraphEdge { a, b, b_from_a, information: Mat7::identity() }
    });
    let edges: Vec<PoseGraphEdge<Sim3>> = edges.collect();
    let mut poses = vec![Sim3::identity()];
    for i in 1..n as usize {
        poses.push(edges[i - 1].b_from_a * poses[i - 1]);
    }
    assert!((poses[n as usize - 1].scale - 1.0).abs() < 1e-12, "odometry knows nothing of its drift");
    let fixed = (0..n).map(|i| i == 0).collect();
    let problem = PoseGraphProblem { poses, fixed, edges };
    let solution = solve(&problem, &PoseGraphOptions { relative_tolerance: 1e-14, ..Default::default() });
    assert!(largest_difference(&solution.poses, &expected) < 1e-6, "{:?}", solution.report);
    for chi_sq in solution.chi_sq {
        assert!((chi_sq.sqrt() / q.ln().abs() - 1.0).abs() < 1e-6, "{chi_sq}");
    }
}

/// Parts of a graph that nothing joins are each solved as if alone.
#[test]
fn parts_are_solved_as_if_alone() {
    let first = displaced(&graph::<SE3, 6>(15, 20, 8, 0.05), 16, 0.1);
    let mut second = displaced(&graph::<SE3, 6>(17, 25, 8, 0.05), 18, 0.1);
    second.fixed[0] = false;
    let mut both = first.clone();
    both.poses.extend(&second.poses);
    both.poses.push(SE3::exp(&Vec6::repeat(0.5)));
    both.fixed.extend(&second.fixed);
    both.fixed.push(false);
    both.edges.extend(second.edges.iter().map(|e| PoseGraphEdge { a: e.a + 20, b: e.b + 20, ..*e }));
    let options = PoseGraphOptions { relative_tolerance: 1e-14, ..Default::default() };
    let solution = solve(&both, &options);
    assert!(largest_difference(&solution.poses[..20], &solve(&first, &options).poses) < 1e-7);
    assert!(largest_difference(&solution.poses[20..45], &solve(&second, &options).poses) < 1e-7);
    assert_eq!(solution.poses[45], both.poses[45], "a node without an edge stays");
}

/// A direction without information moves nothing: here translations are not measured at all.
#[test]
fn directions_without_information_stay() {
    let truth = graph::<SE3, 6>(19, 15, 5, 0.0);
    let mut problem = displaced(&truth, 20, 0.1);
    for e in &mut problem.edges {
        e.information = Mat6::from_diagonal(&Vec6::new(0.0, 0.0, 0.0, 1.0, 1.0, 1.0));
    }
    let solution = solve(&problem, &PoseGraphOptions::default());
    assert!(solution.report.final_cost < 1e-12, "{:?}", solution.report);
    for ((solved, before), truth) in solution.poses.iter().zip(&problem.poses).zip(&truth.poses) {
        assert!((solved.rotation * truth.rotation.inverse()).angle() < 1e-5);
        let motion = (*solved * before.inverse()).log();
        assert!(motion.fixed_rows::<3>(0).norm() < 1e-9, "{motion}");
    }
}

#[test]
fn nothing_at_all() {
    let empty = PoseGraphProblem::<SE3> { poses: vec![], fixed: vec![], edges: vec![] };
    let solution = solve(&empty, &PoseGraphOptions::default());
    assert_eq!((solution.report.stop, solution.report.iterations), (StopReason::NoData, 0));
    let mut held = graph::<SE3, 6>(21, 10, 3, 0.1);
    held.fixed.fill(true);
    let solution = solve(&held, &PoseGraphOptions::default());
    assert_eq!((solution.report.stop, solution.poses), (StopReason::NoData, held.poses));
}

/// Useless edges are skipped and marked; the rest is solved as if they were not there.
#[test]
fn edges_that_say_nothing_are_left_out() {
    let good = displaced(&graph::<SE3, 6>(22, 20, 8, 0.05), 23, 0.1);
    let expected = solve(&good, &PoseGraphOptions::default());
    let mut problem = good.clone();
    problem.poses.push(SE3::new(SO3::identity(), Vec3::repeat(f64::NAN)));
    problem.fixed.truncate(5);
    let n_good = good.edges.len();
    let any = good.edges[3];
    let mut negative = Mat6::identity();
    negative[(1, 1)] = -1.0;
    problem.edges.extend([
        PoseGraphEdge { a: 999, ..any },
        PoseGraphEdge { b: u32::MAX, ..any },
        PoseGraphEdge { b: any.a, ..any },
        PoseGraphEdge { b: 20, ..any },
        PoseGraphEdge { b_from_a: SE3::new(SO3::identity(), Vec3::repeat(f64::INFINITY)), ..any },
        PoseGraphEdge { information: Mat6::repeat(f64::NAN), ..any },
        PoseGraphEdge { information: Mat6::zeros(), ..any },
        PoseGraphEdge { information: negative, ..any },
    ]);
    let solution = refine_pose_graph(&problem, &PoseGraphOptions::default());
    assert_eq!(solution.poses[..20], expected.poses[..]);
    assert_eq!(solution.report, expected.report);
    assert_eq!(solution.chi_sq[..n_good], expected.chi_sq[..]);
    assert!(solution.chi_sq[n_good..].iter().all(|c| c.is_nan()), "{:?}", &solution.chi_sq[n_good..]);
}

fn any_graph() -> impl Strategy<Value = PoseGraphProblem<SE3>> {
    let number = prop_oneof![
        8 => -3.0..3.0f64,
        1 => Just(0.0),
        1 => Just(f64::NAN),
        1 => prop_oneof![Just(1e8), Just(-1e200), Just(1e-300)],
    ];
    let pose = prop::array::uniform6(number.clone()).prop_map(|v| SE3::exp(&Vec6::from(v)));
    let information = prop_oneof![
        4 => (0.0..1e6f64).prop_map(Mat6::from_diagonal_element),
        1 => prop::collection::vec(number, 36).prop_map(|v| Mat6::from_column_slice(&v)),
    ];
    let edge = (0..9u32, 0..9u32, pose.clone(), information)
        .prop_map(|(a, b, b_from_a, information)| PoseGraphEdge { a, b, b_from_a, information });
    let nodes = prop::collection::vec((pose, any::<bool>()), 0..8);
    (nodes, prop::collection::vec(edge, 0..25)).prop_map(|(nodes, edges)| {
        let (poses, fixed) = nodes.into_iter().unzip();
        PoseGraphProblem { poses, fixed, edges }
    })
}

proptest! {
    #[test]
    fn any_garbage_is_survived_and_costs_no_more(problem in any_graph(), huber in prop::option::of(0.1..5.0f64)) {
        let solution = refine_pose_graph(&problem, &PoseGraphOptions { huber, ..Default::default() });
        let report = solution.report;
        let (initial_cost, final_cost) = (report.initial_cost, report.final_cost);
        prop_assert!(final_cost <= initial_cost * (1.0 + 1e-9) || initial_cost.is_nan(), "{:?}", report);
        for (pose, initial) in solution.poses.iter().zip(&problem.poses) {
            prop_assert!(pose.is_valid() || !initial.is_valid());
        }
    }

    #[test]
    fn rotations_of_a_noisy_ring_close(seed in 0..1000u64) {
        let problem = displaced(&graph::<SO3, 3>(seed, 12, 4, 0.02), seed + 1, 0.1);
        let solution = solve(&problem, &PoseGraphOptions::default());
        prop_assert_eq!(solution.report.stop, StopReason::Converged);
        prop_assert!(solution.poses.iter().all(|r| (r.matrix() * r.matrix().transpose() - Mat3::identity()).amax() < 1e-12));
    }
}
