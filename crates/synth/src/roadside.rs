//! What stands between road and houses: trees, lamps, signs, boxes, hedges, walls, fences, bushes.

use crate::furniture;
use crate::layout::{ROAD_HALF_M, SIDE_HALF_M};
use crate::library::Common;
use crate::mesh::Placement;
use crate::rows::footprint_along;
use crate::street::WALK_M;
use crate::town::{Scene, Town};
use rand::Rng;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Length of a piece of hedge, wall or fence, meters.
const PIECE_M: f64 = 3.0;

/// Meshes to choose from.
pub(crate) struct Stock {
    trees: Vec<u32>,
    bushes: Vec<u32>,
    lamp: u32,
    signs: Vec<u32>,
    boxes: Vec<u32>,
    /// Hedges, walls and fences.
    barriers: Vec<u32>,
}

impl Stock {
    pub(crate) fn new(scene: &mut Scene, common: &Common) -> Self {
        let mut barriers = vec![scene.mesh(furniture::fence(common, PIECE_M))];
        for surface in [common.hedge, common.walls[0], common.walls[1], common.walls[2]] {
            for height in [0.7, 1.25] {
                barriers.push(scene.mesh(furniture::barrier(PIECE_M, height, surface, surface)));
            }
        }
        Self {
            trees: (0..10).map(|k| scene.mesh(furniture::tree(common, 100 + k))).collect(),
            bushes: (0..4).map(|k| scene.mesh(furniture::bush(common, 40 + k))).collect(),
            lamp: scene.mesh(furniture::lamp(common, 6.5)),
            signs: (0..8).map(|k| scene.mesh(furniture::sign(common, k))).collect(),
            boxes: (0..6).map(|k| scene.mesh(furniture::cabinet(common, k))).collect(),
            barriers,
        }
    }
}

impl Town<'_, '_> {
    fn pick(&mut self, meshes: &[u32]) -> u32 {
        meshes[self.rng.random_range(0..meshes.len())]
    }

    /// Lamps, trees, signs and boxes on the walk.
    pub(crate) fn curb_side(&mut self, side: f64, stock: &Stock) {
        let regular = self.settings.regular;
        let course = self.layout.course;
        let mut s = if side > 0.0 { 6.0 } else { 14.0 };
        let mut slot = 0_usize;
        while s < course.length - 4.0 {
            let to_street = self.layout.to_side_street(s, side);
            if to_street > SIDE_HALF_M + 1.5 {
                let kind = if regular { slot % 4 } else { self.rng.random_range(0..10) };
                self.curb_thing(side, s, kind, to_street > 8.0, stock);
                if slot.is_multiple_of(3) {
                    let mut placement = course.at(s + 2.5).beside(side * (ROAD_HALF_M + 0.45));
                    placement.yaw += side * FRAC_PI_2;
                    self.scene.place(stock.lamp, placement, 1.0);
                }
            }
            slot += 1;
            s += if regular { 9.0 } else { self.rng.random_range(6.5..11.0) };
        }
    }

    /// A tree (kinds 0 to 3), a box (4, 5), a sign (6, 7) or nothing.
    fn curb_thing(&mut self, side: f64, s: f64, kind: usize, may_be_tree: bool, stock: &Stock) {
        let regular = self.settings.regular;
        let course = self.layout.course;
        let at = |lateral: f64, turn: f64| {
            let mut placement = course.at(s).beside(side * (ROAD_HALF_M + lateral));
            placement.yaw += turn;
            placement
        };
        match kind {
            0..=3 if may_be_tree && regular => self.scene.place(stock.trees[0], at(1.0, 0.0), 1.0),
            0..=3 if may_be_tree => {
                let (tree, spin) = (self.pick(&stock.trees), self.rng.random_range(0.0..TAU));
                let gain = self.rng.random_range(0.75..1.2);
                self.scene.place(tree, at(1.0, spin), gain);
            }
            4 | 5 => {
                let cabinet = self.pick(&stock.boxes);
                self.scene.place(cabinet, at(2.55, side * FRAC_PI_2), 1.0);
            }
            6 | 7 => {
                let sign = self.pick(&stock.signs);
                self.scene.place(sign, at(0.5, if side > 0.0 { 0.0 } else { PI }), 1.0);
            }
            _ => {}
        }
    }

    /// Hedges, walls and fences wherever no house stands at the walk's outer edge, with bushes and trees behind.
    pub(crate) fn gardens(&mut self, side: f64, stock: &Stock) {
        let course = self.layout.course;
        let edge = ROAD_HALF_M + WALK_M + 0.15;
        let (mut s, mut barrier) = (0.0, stock.barriers[0]);
        while s < course.length - PIECE_M {
            let middle = s + 0.5 * PIECE_M;
            if self.rng.random_bool(0.15) {
                barrier = self.pick(&stock.barriers);
            }
            let clear = self.layout.is_free(&course.at(middle).beside(side * edge).position, 0.3, edge - 0.5)
                && self.layout.to_side_street(middle, side) > SIDE_HALF_M + 2.0;
            if clear {
                let line = |s: f64| course.at(s);
                if let Some(ground) = footprint_along(&line, s, s + 2.0 * PIECE_M, side, edge, [PIECE_M, 0.5])
                {
                    self.scene.place(barrier, ground.placement, 1.0);
                }
                self.plant(side, s + 1.0, edge, 1.4..2.4, (0.5, 0.6), &stock.bushes);
                self.plant(side, s, edge + 2.5, 1.0..9.5, (0.3, 1.2), &stock.trees);
            }
            s += PIECE_M;
        }
    }

    /// Perhaps a plant between `edge` and `edge + beyond` meters beside the course; `(chance, radius)`.
    fn plant(
        &mut self,
        side: f64,
        s: f64,
        edge: f64,
        beyond: std::ops::Range<f64>,
        (chance, radius): (f64, f64),
        meshes: &[u32],
    ) {
        let place = self.layout.course.at(s).beside(side * (edge + self.rng.random_range(beyond)));
        let (mesh, yaw) = (self.pick(meshes), self.rng.random_range(0.0..TAU));
        let gain = self.rng.random_range(0.7..1.1);
        if self.rng.random_bool(chance) && self.layout.is_free(&place.position, radius, edge) {
            self.scene.place(mesh, Placement { yaw, ..place }, gain);
        }
    }
}
