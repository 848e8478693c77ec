//! Time of whole pose graph optimizations from a file's values, of one linear system, and of the test of a loop.

#![allow(missing_docs)]

#[path = "../tests/g2o/mod.rs"]
mod g2o;

use criterion::{Criterion, criterion_group, criterion_main};
use dsslam_optim::{
    CycleEdge, CycleEdgeKind, PoseGraphOptions, TranslationEdge, TranslationProblem, fit_translations,
    refine_pose_graph, test_loop,
};
use geometry::{SE3, Vec3, Vec6};

fn pose_graph(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("refine_pose_graph");
    group.sample_size(10);
    for name in ["sphere2500.g2o", "parking-garage.g2o", "smallGrid3D.g2o"] {
        let Some(problem) = g2o::find(name).map(|text| g2o::parse(&text)) else { continue };
        let whole = PoseGraphOptions::default();
        group.bench_function(format!("{name}, to the default tolerance"), |b| {
            b.iter(|| refine_pose_graph(&problem, &whole));
        });
        let one = PoseGraphOptions { max_iterations: 1, ..whole };
        group.bench_function(format!("{name}, one iteration"), |b| {
            b.iter(|| refine_pose_graph(&problem, &one))
        });
    }
    group.finish();
}

/// A ring of `n` nodes whose odometry is off a little, with a loop every tenth node across the ring's end.
fn ring(n: u32) -> (Vec<SE3>, Vec<CycleEdge>) {
    let step = SE3::exp(&Vec6::new(0.0, 0.0, 1.0, 0.0, std::f64::consts::TAU / f64::from(n), 0.0));
    let mut nodes = vec![SE3::identity()];
    let mut edges = Vec::new();
    for b in 1..n {
        let k = f64::from(b);
        let noise = SE3::exp(&(Vec6::new(k.sin(), (2.0 * k).sin(), (3.0 * k).sin(), 0.0, 0.02, 0.01) * 0.02));
        let b_from_a = noise * step;
        nodes.push(b_from_a * nodes[b as usize - 1]);
        let kind = CycleEdgeKind::Odometry;
        edges.push(CycleEdge { a: b - 1, b, b_from_a, sigma_m: 0.05, sigma_rad: 0.002, kind });
    }
    for k in 0..n / 20 {
        let kind = if k == 0 { CycleEdgeKind::Candidate } else { CycleEdgeKind::EarlierLoop };
        let (a, b) = (n - 1 - k, k);
        let b_from_a = (0..2 * k + 1).fold(SE3::identity(), |motion, _| step * motion);
        edges.push(CycleEdge { a, b, b_from_a, sigma_m: 0.1, sigma_rad: 0.002, kind });
    }
    (nodes, edges)
}

fn loops(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("loops");
    group.sample_size(10);
    for n in [100, 300, 1000] {
        let (nodes, edges) = ring(n);
        group.bench_function(format!("test_loop, {n} nodes"), |b| b.iter(|| test_loop(&nodes, &edges)));
        let between = |e: &CycleEdge| nodes[e.b as usize].center() - nodes[e.a as usize].center();
        let edges = edges.iter().map(|e| {
            let translation = between(e) + Vec3::repeat(0.01 * f64::from(e.a).sin());
            TranslationEdge { a: e.a, b: e.b, translation, sigma_m: e.sigma_m }
        });
        let problem =
            TranslationProblem { n_nodes: nodes.len(), fixed: 0, edges: edges.collect(), huber: 1.5 };
        group.bench_function(format!("fit_translations, {n} nodes"), |b| {
            b.iter(|| fit_translations(&problem))
        });
    }
    group.finish();
}

criterion_group!(benches, pose_graph, loops);
criterion_main!(benches);
