//! Loops true and false on a course of 500 m with drift of one percent.

mod common;

use common::{random, small_motion};
use dsslam_optim::{
    CHI2_CLOSURE, ConvexError, CycleEdge, CycleEdgeKind, Inconsistency, LoopNumbers, LoopVerdict, test_loop,
};
use geometry::{SE3, SO3, Vec3, Vec6};
use proptest::prelude::*;

/// Nodes per round, 5 m apart along a square of 125 m that begins in the middle of a side.
const ROUND: u32 = 100;
const STEP_M: f64 = 5.0;
/// One percent of a round, spread over its edges.
const ODOMETRY_M: f64 = 0.5;
const ODOMETRY_RAD: f64 = 0.001;
const LOOP_M: f64 = 0.1;
const LOOP_RAD: f64 = 0.002;

/// True pose, node_from_world, of a place along the course; z forward, the third round where the first was.
fn place(node: u32) -> SE3 {
    let mut world_from_node = SE3::identity();
    for k in 0..node {
        let turn = if k % 25 == 12 { std::f64::consts::FRAC_PI_2 } else { 0.0 };
        world_from_node =
            world_from_node * SE3::new(SO3::exp(&Vec3::new(0.0, turn, 0.0)), Vec3::new(0.0, 0.0, STEP_M));
    }
    world_from_node.inverse()
}

struct Course {
    nodes: Vec<SE3>,
    edges: Vec<CycleEdge>,
}

/// Odometry over `n` nodes with noise of `scale` times its sigma; the nodes stand where it led.
fn course(seed: u64, n: u32, scale: f64, sigma_m: f64, sigma_rad: f64) -> Course {
    let mut random = random(seed);
    let mut course = Course { nodes: vec![place(0)], edges: Vec::new() };
    for b in 1..n {
        let noise = small_motion(&mut random, scale * sigma_m, scale * sigma_rad);
        let b_from_a = noise * place(b) * place(b - 1).inverse();
        course.nodes.push(b_from_a * course.nodes[b as usize - 1]);
        course.edges.push(CycleEdge {
            a: b - 1,
            b,
            b_from_a,
            sigma_m,
            sigma_rad,
            kind: CycleEdgeKind::Odometry,
        });
    }
    course
}

fn drifted(seed: u64, n: u32) -> Course {
    course(seed, n, 1.0, ODOMETRY_M, ODOMETRY_RAD)
}

impl Course {
    /// Joins `a` and `b` by the true motion from `a` to `b_really`.
    fn join(&mut self, kind: CycleEdgeKind, a: u32, b: u32, b_really: u32) {
        let b_from_a = place(b_really) * place(a).inverse();
        self.edges.push(CycleEdge { a, b, b_from_a, sigma_m: LOOP_M, sigma_rad: LOOP_RAD, kind });
    }

    fn candidate(&mut self, a: u32, b: u32, b_really: u32) -> LoopVerdict {
        self.join(CycleEdgeKind::Candidate, a, b, b_really);
        self.verdict()
    }

    fn verdict(&self) -> LoopVerdict {
        let verdict = test_loop(&self.nodes, &self.edges);
        assert_eq!(test_loop(&self.nodes, &self.edges), verdict);
        verdict
    }
}

fn numbers(verdict: &LoopVerdict) -> LoopNumbers {
    match verdict {
        LoopVerdict::Consistent(numbers) | LoopVerdict::Inconsistent { numbers, .. } => *numbers,
    }
}

fn reason(verdict: &LoopVerdict) -> &Inconsistency {
    match verdict {
        LoopVerdict::Inconsistent { reason, .. } => reason,
        LoopVerdict::Consistent(numbers) => panic!("accepted: {numbers:?}"),
    }
}

fn is_accepted(verdict: &LoopVerdict) -> bool {
    matches!(verdict, LoopVerdict::Consistent(_))
}

#[test]
fn the_course_closes() {
    let difference = common::pose_difference(&place(ROUND), &place(0));
    assert!(difference.0 < 1e-9 && difference.1 < 1e-9, "{difference:?}");
}

#[test]
fn true_loops_after_drift_of_one_sigma_are_accepted() {
    let mut squares = 0.0;
    for seed in 0..40 {
        let verdict = drifted(seed, ROUND + 4).candidate(ROUND + 2, 1, 1);
        assert!(is_accepted(&verdict), "seed {seed}: {verdict:?}");
        let n = numbers(&verdict);
        assert_eq!(n.cycle_edges, 102);
        assert!((n.cycle_length_m - 510.0).abs() < 30.0, "{n:?}");
        squares += (n.translation_closure_m / n.translation_sigma_m).powi(2) / 40.0;
    }
    // Chi-square with 3 degrees of freedom has the mean 3; its mean over 40 draws deviates by 0.4.
    assert!((1.8..4.2).contains(&squares), "{squares}");
}

/// Where only rotations drift, the closure comes from their lever arms alone.
#[test]
fn drift_of_rotation_counts_by_its_lever_arm() {
    let mut squares = 0.0;
    for seed in 0..60 {
        let verdict = course(seed, ROUND + 1, 1.0, 0.01, 0.003).candidate(ROUND, 0, 0);
        assert!(is_accepted(&verdict), "seed {seed}: {verdict:?}");
        let n = numbers(&verdict);
        assert!(n.translation_sigma_m > 1.0, "{n:?}");
        squares += (n.translation_closure_m / n.translation_sigma_m).powi(2) / 60.0;
    }
    // The sigma is that across the arm; along it rotations move nothing, so 2 instead of 3.
    assert!((1.0..3.0).contains(&squares), "{squares}");
}

#[test]
fn a_false_loop_of_30_m_is_refused() {
    let mut n_refused = 0;
    for seed in 0..40 {
        // Node 106 lies 30 m farther along the straight than node 0 and looks the same way.
        let verdict = drifted(seed, ROUND + 8).candidate(ROUND + 6, 0, ROUND + 6);
        if let LoopVerdict::Inconsistent { reason, numbers } = &verdict {
            assert!(matches!(reason, Inconsistency::Translation { sigmas } if *sigmas > 4.0), "{reason:?}");
            assert!(numbers.rotation_closure_deg < 4.0 * numbers.rotation_sigma_deg);
            n_refused += 1;
        }
    }
    // Six sigma on average: one in fifty drifts by two of them towards the false place.
    assert!(n_refused >= 37, "{n_refused} of 40");
    let exact = course(0, ROUND + 8, 0.0, ODOMETRY_M, ODOMETRY_RAD).candidate(ROUND + 6, 0, ROUND + 6);
    assert!(matches!(reason(&exact), Inconsistency::Translation { .. }));
    assert!((numbers(&exact).translation_closure_m - 30.0).abs() < 1e-6, "{exact:?}");
}

#[test]
fn a_false_loop_within_the_drift_is_refused_by_two_earlier_loops() {
    for seed in 0..10 {
        // Node 105 taken for node 2, 15 m back: three sigma of odometry.
        let mut alone = course(seed, 2 * ROUND, 0.3, ODOMETRY_M, ODOMETRY_RAD);
        let verdict = alone.candidate(ROUND + 5, 2, ROUND + 5);
        assert!(is_accepted(&verdict), "odometry alone cannot tell, seed {seed}: {verdict:?}");

        let mut joined = course(seed, 2 * ROUND, 0.3, ODOMETRY_M, ODOMETRY_RAD);
        joined.join(CycleEdgeKind::EarlierLoop, ROUND, 0, 0);
        joined.join(CycleEdgeKind::EarlierLoop, ROUND + 9, 9, 9);
        let verdict = joined.candidate(ROUND + 5, 2, ROUND + 5);
        assert!(matches!(reason(&verdict), Inconsistency::Translation { .. }), "seed {seed}: {verdict:?}");
        let n = numbers(&verdict);
        // Odometry is the weakest and tears first.
        assert!(n.odometry_residual > 4.0 && n.odometry_residual > n.candidate_residual, "{n:?}");

        joined.edges.pop();
        let verdict = joined.candidate(ROUND + 5, 5, 5);
        assert!(is_accepted(&verdict), "the true place, seed {seed}: {verdict:?}");
        assert!(numbers(&verdict).cycle_edges < 15);
    }
}

#[test]
fn a_turned_loop_is_refused_for_its_rotation() {
    let mut course = drifted(1, ROUND + 1);
    course.join(CycleEdgeKind::Candidate, ROUND, 0, 0);
    let turn = SE3::exp(&Vec6::new(0.0, 0.0, 0.0, 0.0, 0.2, 0.0));
    let candidate = course.edges.last_mut().unwrap();
    candidate.b_from_a = turn * candidate.b_from_a;
    let verdict = course.verdict();
    assert!(matches!(reason(&verdict), Inconsistency::Rotation { sigmas } if *sigmas > 10.0), "{verdict:?}");
    let n = numbers(&verdict);
    assert!((n.rotation_closure_deg - 0.2f64.to_degrees()).abs() < 4.0 * n.rotation_sigma_deg, "{n:?}");
    let expected = (100.0 * ODOMETRY_RAD * ODOMETRY_RAD + LOOP_RAD * LOOP_RAD).sqrt().to_degrees();
    assert!((n.rotation_sigma_deg - expected).abs() < 1e-12);
}

/// Carried off unnoticed, a true loop contradicts odometry; where odometry says that it was lost, the loop tells.
#[test]
fn kidnapped() {
    let jump = SE3::exp(&Vec6::new(40.0, 0.0, 10.0, 0.0, 0.0, 0.0));
    for (sigma_m, is_fine) in [(ODOMETRY_M, false), (100.0, true)] {
        let mut course = course(2, ROUND + 1, 0.5, ODOMETRY_M, ODOMETRY_RAD);
        course.edges[60].b_from_a = jump * course.edges[60].b_from_a;
        course.edges[60].sigma_m = sigma_m;
        for b in 61..=ROUND as usize {
            course.nodes[b] = course.edges[b - 1].b_from_a * course.nodes[b - 1];
        }
        let verdict = course.candidate(ROUND, 0, 0);
        assert_eq!(is_accepted(&verdict), is_fine, "{verdict:?}");
        let n = numbers(&verdict);
        assert!((n.translation_closure_m - 41.2).abs() < 15.0, "{n:?}");
    }
}

/// The candidate is good, but elsewhere an earlier loop is torn by another one: moving the map would be wrong.
#[test]
fn a_torn_earlier_loop_is_named() {
    let mut course = course(3, 2 * ROUND, 0.3, 0.1, ODOMETRY_RAD);
    for k in (40..62).step_by(2) {
        course.join(CycleEdgeKind::EarlierLoop, ROUND + k, k, k);
    }
    course.join(CycleEdgeKind::EarlierLoop, ROUND + 52, 46, ROUND + 52);
    let torn = course.edges.len() - 1;
    let verdict = course.candidate(ROUND, 0, 0);
    let LoopVerdict::Inconsistent { reason: Inconsistency::Residual { edge, kind, sigmas }, numbers } =
        verdict
    else {
        panic!("{verdict:?}")
    };
    assert_eq!((edge, kind), (torn, CycleEdgeKind::EarlierLoop), "{numbers:?}");
    assert!(sigmas > 50.0 && numbers.earlier_loop_residual == sigmas && numbers.candidate_residual < 4.0);
}

/// Moving the world changes no number; neither does turning the candidate round.
#[test]
fn the_verdict_does_not_depend_on_the_frame() {
    let mut course = drifted(4, ROUND + 3);
    course.join(CycleEdgeKind::EarlierLoop, ROUND + 2, 2, 2);
    let verdict = course.candidate(ROUND, 0, 0);
    let expected = numbers(&verdict);
    let motion = SE3::exp(&Vec6::new(100.0, -20.0, 7.0, 0.5, 1.0, -0.3));
    course.nodes.iter_mut().for_each(|n| *n = *n * motion);
    let candidate = course.edges.last_mut().unwrap();
    *candidate =
        CycleEdge { a: candidate.b, b: candidate.a, b_from_a: candidate.b_from_a.inverse(), ..*candidate };
    let moved = course.verdict();
    assert_eq!(is_accepted(&moved), is_accepted(&verdict));
    let (n, m) = (expected, numbers(&moved));
    assert_eq!(n.cycle_edges, m.cycle_edges);
    for (a, b) in [
        (n.cycle_length_m, m.cycle_length_m),
        (n.rotation_closure_deg, m.rotation_closure_deg),
        (n.rotation_sigma_deg, m.rotation_sigma_deg),
        (n.translation_closure_m, m.translation_closure_m),
        (n.translation_sigma_m, m.translation_sigma_m),
        (n.candidate_residual, m.candidate_residual),
        (n.earlier_loop_residual, m.earlier_loop_residual),
        (n.odometry_residual, m.odometry_residual),
    ] {
        assert!((a - b).abs() < 1e-4 * (1.0 + a), "{n:?} {m:?}");
    }
}

#[test]
fn input_without_an_answer_is_refused_with_a_reason() {
    let check = |change: &dyn Fn(&mut Course), expected: &Inconsistency| {
        let mut course = drifted(5, 20);
        course.join(CycleEdgeKind::Candidate, 15, 3, 3);
        change(&mut course);
        assert_eq!(reason(&course.verdict()), expected);
    };
    let bad = |edge| Inconsistency::BadInput { edge };
    check(&|c| c.edges.truncate(19), &bad(19));
    check(&|c| c.join(CycleEdgeKind::Candidate, 4, 10, 10), &bad(21));
    check(&|c| c.edges[4].b = 99, &bad(4));
    check(&|c| c.edges[4].b = c.edges[4].a, &bad(4));
    check(&|c| c.edges[7].sigma_m = 0.0, &bad(7));
    check(&|c| c.edges[7].sigma_rad = f64::NAN, &bad(7));
    check(&|c| c.edges[19].b_from_a.translation.x = f64::NAN, &bad(19));
    check(&|c| c.nodes[9].translation.z = f64::INFINITY, &bad(8));
    check(&|c| c.edges.clear(), &bad(0));
    // Without edge 8 the candidate is the only link between both halves.
    check(
        &|c| {
            c.edges.remove(8);
        },
        &Inconsistency::NoCycle,
    );
    // Nor may other nodes hang in the air.
    let mut apart = course(6, 20, 0.1, ODOMETRY_M, ODOMETRY_RAD);
    apart.nodes.push(SE3::identity());
    let verdict = apart.candidate(15, 3, 3);
    assert_eq!(reason(&verdict), &Inconsistency::Convex(ConvexError::Disconnected { node: 20 }));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever the numbers: a verdict, and accepted only what passes its gates.
    #[test]
    fn any_numbers_give_a_verdict(
        seed in 0..1000u64,
        powers in prop::collection::vec((-160..160i32, -160..160i32), 12),
        ends in prop::collection::vec((0..12u32, 0..12u32), 4),
        shift in -160..160i32,
    ) {
        let mut course = drifted(seed, 12);
        for &(a, b) in &ends {
            course.join(CycleEdgeKind::EarlierLoop, a, b, b);
        }
        course.join(CycleEdgeKind::Candidate, 1, 10, 10);
        for (e, &(m, rad)) in course.edges.iter_mut().zip(&powers) {
            (e.sigma_m, e.sigma_rad) = (10f64.powi(m), 10f64.powi(rad));
        }
        course.edges[3].b_from_a.translation.x += 10f64.powi(shift);
        if let LoopVerdict::Consistent(n) = test_loop(&course.nodes, &course.edges) {
            prop_assert!(n.rotation_closure_deg <= 4.1 * n.rotation_sigma_deg);
            prop_assert!(n.translation_closure_m <= 4.1 * n.translation_sigma_m);
            prop_assert!(n.candidate_residual <= CHI2_CLOSURE.sqrt());
        }
    }
}
