//! Four drives of KITTI with what a place recognizer said of them, offered one after the other as a loop closer would meet it.
//!
//! A place counts when it looked alike from two candidates before, as the loop closer asks it of keyframes in a row; then come the
//! position prior and the test of the cycle. The candidates say only "the same place": their motion is the identity, the true ones are one to six meters
//! apart. The drift of this odometry (a percent of what it turns) was read off these drives; with half and twice of it the answers are
//! the same.

#![allow(dead_code, reason = "each test takes what it needs")]

use std::collections::{BTreeMap, BTreeSet};

use dsslam_optim::loop_test::{Doubts, Witness, culprit};
use dsslam_optim::{
    CycleEdge, CycleEdgeKind, DriftModel, LoopVerdict, PoseGraphEdge, PoseGraphOptions, PoseGraphProblem,
    refine_pose_graph, test_loop,
};
use geometry::{Mat6, SE3, SO3, Vec3};

use super::g2o;

/// What stereo odometry of the year 2012 shows.
pub(crate) const DRIFT: DriftModel = DriftModel {
    sigma_m: 0.01,
    m_per_m: 0.02,
    sigma_rad: 5e-4,
    rad_per_m: 2e-5,
    rad_per_rad: 0.01,
    max_m_per_m: 0.03,
    margin_m: 5.0,
};
/// How far two views of one place are apart: standard deviations.
const PLACE_M: f64 = 2.5;
const PLACE_RAD: f64 = 0.06;
/// Candidates before, within this many nodes, from which the place must have looked alike.
const CONSISTENCY: usize = 2;
const ROW: u32 = 60;
/// Nodes within which a loop stands for another one.
pub(crate) const NEIGHBORS: u32 = 20;

/// A drive.
pub(crate) struct Drive {
    /// node_from_world along the odometry.
    pub(crate) nodes: Vec<SE3>,
    motions: Vec<SE3>,
    /// Length of the path up to each node.
    path_m: Vec<f64>,
    truth: Vec<Vec3>,
    pub(crate) candidates: Vec<(u32, u32)>,
    pub(crate) are_true: Vec<(u32, u32)>,
}

/// What became of the candidates.
pub(crate) struct Answer {
    pub(crate) accepted: Vec<(u32, u32)>,
    pub(crate) taken_back: Vec<(u32, u32)>,
    /// The path with the accepted ones.
    pub(crate) nodes: Vec<SE3>,
    /// The path without each of them, as far as it was asked for.
    without: BTreeMap<(u32, u32), Vec<SE3>>,
}

impl Drive {
    pub(crate) fn load(name: &str) -> Option<Drive> {
        let read = |end: &str| g2o::find(&format!("kitti_loops/kitti_{name}_{end}"));
        let (path, candidates) = g2o::parse_plane(&read("alpha_0.15.g2o")?);
        let (truth, _) = g2o::parse_plane(&read("GT.g2o")?);
        let listed = read("alpha_0.15_GT_LC.txt")?;
        let are_true = listed.lines().map(|line| {
            let mut ids = line.split_whitespace().map(|word| word.parse().expect("a node"));
            (ids.next().expect("a node"), ids.next().expect("another node"))
        });
        let mut path_m = vec![0.0];
        path_m.extend(path.iter().scan(0.0, |sum, motion| {
            *sum += motion.translation.norm();
            Some(*sum)
        }));
        let centers = |motions: &[SE3]| chain(motions).iter().map(SE3::center).collect();
        Some(Drive {
            nodes: chain(&path),
            truth: centers(&truth),
            path_m,
            motions: path,
            candidates,
            are_true: are_true.collect(),
        })
    }

    fn odometry(&self, growth: f64, drift: &DriftModel) -> Vec<CycleEdge> {
        let motions = self.motions.iter().zip(0u32..);
        motions.map(|(&motion, a)| drift.edge(a, a + 1, motion, growth)).collect()
    }

    /// Offers all candidates; `forced` ones are accepted as if there was no gate.
    pub(crate) fn offer_all(&self, drift: &DriftModel, forced: &[(u32, u32)]) -> Answer {
        let along = |a: u32, b: u32| self.along(a, b);
        let mut answer = Answer {
            accepted: Vec::new(),
            taken_back: Vec::new(),
            nodes: self.nodes.clone(),
            without: BTreeMap::new(),
        };
        let mut doubts = Doubts::new(NEIGHBORS);
        let mut heard = BTreeSet::new();
        // Candidates within reach, and those that would be without one of the loops.
        let (mut alike, mut far) = (Vec::new(), Vec::new());
        for &(now, then) in &self.candidates {
            if forced.contains(&(now, then)) {
                self.accept(&mut answer, &[(now, then)], drift);
                continue;
            }
            let meets = |nodes: &[SE3]| drift.can_meet(gap(nodes, (now, then)), along(now, then));
            let is_near = meets(&answer.nodes);
            if !is_near && !self.without_each(&mut answer, drift).any(|(_, nodes)| meets(nodes)) {
                continue;
            }
            // Both visits went on by the same length, give or take how far views of one place are apart.
            let in_row = |&&(a, b): &&(u32, u32)| {
                let gone_on = (along(now, a) - along(then, b)).abs();
                now - a <= ROW && gone_on <= 2.0 * PLACE_M * std::f64::consts::SQRT_2
            };
            let in_reach = far.iter().filter(|_| !is_near);
            let row: Vec<(u32, u32)> = alike.iter().chain(in_reach).filter(in_row).copied().collect();
            if is_near { &mut alike } else { &mut far }.push((now, then));
            if row.len() < CONSISTENCY {
                continue;
            }
            if self.refused(&answer, (now, then), drift).is_none() {
                self.accept(&mut answer, &[(now, then)], drift);
                continue;
            }
            // What the row began with is heard in hindsight.
            let first = row.iter().copied().min().filter(|first| !heard.contains(first));
            for ends in first.into_iter().chain([(now, then)]) {
                heard.insert(ends);
                if let Some(strain) = self.refused(&answer, ends, drift) {
                    self.doubt(&mut doubts, &mut answer, ends, strain, drift);
                }
            }
        }
        answer
    }

    /// How far a candidate goes in what is allowed, if it is out of reach or contradicts the path and the loops accepted.
    fn refused(&self, answer: &Answer, ends: (u32, u32), drift: &DriftModel) -> Option<f64> {
        let reach = drift.strain(gap(&answer.nodes, ends), self.along(ends.0, ends.1));
        let verdict = self.test(&answer.nodes, &answer.accepted, ends, drift);
        (reach > 1.0 || !verdict.is_consistent()).then(|| reach.max(verdict.strain()))
    }

    /// Path between two nodes, meters.
    fn along(&self, a: u32, b: u32) -> f64 {
        self.path_m[a as usize] - self.path_m[b as usize]
    }

    /// How a candidate agrees with the path up to it and these loops.
    fn test(
        &self,
        nodes: &[SE3],
        loops: &[(u32, u32)],
        (now, then): (u32, u32),
        drift: &DriftModel,
    ) -> LoopVerdict {
        // A drive knows nothing of what comes later.
        let upto = now as usize + 1;
        let mut edges = self.odometry(f64::from(now - then).sqrt(), drift);
        edges.truncate(upto - 1);
        let known = loops.iter().filter(|ends| ends.0 <= now);
        edges.extend(known.map(|&ends| same_place(ends, CycleEdgeKind::EarlierLoop)));
        edges.push(same_place((now, then), CycleEdgeKind::Candidate));
        test_loop(&nodes[..upto], &edges)
    }

    fn accept(&self, answer: &mut Answer, loops: &[(u32, u32)], drift: &DriftModel) {
        answer.accepted.extend(loops);
        answer.nodes = self.solve(&answer.nodes, &answer.accepted, drift);
        answer.without.clear();
    }

    /// The path without each of the accepted loops.
    fn without_each<'a>(
        &self,
        answer: &'a mut Answer,
        drift: &DriftModel,
    ) -> impl Iterator<Item = (&'a (u32, u32), &'a Vec<SE3>)> {
        for &one in &answer.accepted {
            let others: Vec<_> = answer.accepted.iter().copied().filter(|&l| l != one).collect();
            answer.without.entry(one).or_insert_with(|| self.solve(&self.nodes, &others, drift));
        }
        answer.without.iter()
    }

    /// A refused candidate may speak against an earlier loop.
    fn doubt(
        &self,
        doubts: &mut Doubts<(u32, u32), ()>,
        answer: &mut Answer,
        ends: (u32, u32),
        refused: f64,
        drift: &DriftModel,
    ) {
        let accepted = answer.accepted.clone();
        let others = |one: (u32, u32)| accepted.iter().copied().filter(move |&l| l != one);
        let without: Vec<_> = self.without_each(answer, drift).collect();
        let reach = |nodes: &[SE3]| drift.strain(gap(nodes, ends), self.along(ends.0, ends.1));
        let left = |&(one, nodes): &(&(u32, u32), &Vec<SE3>)| {
            self.test(nodes, &others(*one).collect::<Vec<_>>(), ends, drift).strain().max(reach(nodes))
        };
        let Some(at) = culprit(refused, &without.iter().map(left).collect::<Vec<_>>()) else { return };
        let (one, nodes) = (*without[at].0, without[at].1.clone());
        let agrees = |w: &Witness<()>| {
            let loops: Vec<_> = others(one).chain([(w.now, w.then)]).collect();
            self.test(&nodes, &loops, ends, drift).is_consistent()
        };
        let witness = Witness { now: ends.0, then: ends.1, now_from_then: () };
        if let Some(first) = doubts.hear(one, witness, agrees) {
            answer.accepted.retain(|&l| l != one);
            answer.taken_back.push(one);
            self.accept(answer, &[(first.now, first.then), ends], drift);
        }
    }

    /// The whole path with the loops accepted so far.
    fn solve(&self, nodes: &[SE3], accepted: &[(u32, u32)], drift: &DriftModel) -> Vec<SE3> {
        let loops = accepted.iter().map(|&ends| same_place(ends, CycleEdgeKind::EarlierLoop));
        let edges = self.odometry(1.0, drift).into_iter().chain(loops).map(|edge| {
            let [m, rad] = [edge.sigma_m, edge.sigma_rad].map(|sigma| 1.0 / (sigma * sigma));
            let information = Mat6::from_diagonal(&[m, m, m, rad, rad, rad].into());
            PoseGraphEdge { a: edge.a, b: edge.b, b_from_a: edge.b_from_a, information }
        });
        let mut fixed = vec![false; nodes.len()];
        fixed[0] = true;
        let problem = PoseGraphProblem { poses: nodes.to_vec(), fixed, edges: edges.collect() };
        refine_pose_graph(&problem, &PoseGraphOptions::default()).poses
    }

    /// Root mean square distance to the true path after the best rigid motion in the plane, meters.
    pub(crate) fn ate(&self, nodes: &[SE3]) -> f64 {
        let centers: Vec<Vec3> = nodes.iter().map(SE3::center).collect();
        let mean = |points: &[Vec3]| points.iter().sum::<Vec3>() / points.len() as f64;
        let (here, there) = (mean(&centers), mean(&self.truth));
        let (mut cos, mut sin) = (0.0, 0.0);
        let pairs = || centers.iter().zip(&self.truth).map(|(p, q)| (p - here, q - there));
        for (p, q) in pairs() {
            cos += p.x * q.x + p.y * q.y;
            sin += p.x * q.y - p.y * q.x;
        }
        let rotation = SO3::exp(&Vec3::new(0.0, 0.0, sin.atan2(cos)));
        (pairs().map(|(p, q)| (rotation * p - q).norm_squared()).sum::<f64>() / centers.len() as f64).sqrt()
    }
}

/// node_from_world of a path that starts at the origin.
fn chain(motions: &[SE3]) -> Vec<SE3> {
    let mut nodes = vec![SE3::identity()];
    nodes.extend(motions.iter().scan(SE3::identity(), |node, &motion| {
        *node = motion * *node;
        Some(*node)
    }));
    nodes
}

/// How far apart the ends of a loop are, meters.
fn gap(nodes: &[SE3], (a, b): (u32, u32)) -> f64 {
    (nodes[a as usize].center() - nodes[b as usize].center()).norm()
}

fn same_place((a, b): (u32, u32), kind: CycleEdgeKind) -> CycleEdge {
    CycleEdge { a, b, b_from_a: SE3::identity(), sigma_m: PLACE_M, sigma_rad: PLACE_RAD, kind }
}
