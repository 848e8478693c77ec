//! Lays out a world: side streets, rows of houses, trees, lamps, signs, hedges; everything that stands still.

use crate::course::{Course, Station};
use crate::furniture;
use crate::houses::{self, Plot};
use crate::layout::{Footprint, Layout, ROAD_HALF_M, SIDE_HALF_M, SideStreet};
use crate::library::{Common, Recipes};
use crate::mesh::{Instance, Layer, Mesh, Placement, V3};
use crate::preset::Settings;
use crate::sky;
use crate::street::{self, WALK_M};
use geometry::mix_seed;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::FRAC_PI_2;

/// Value of static things in the label image.
pub const LABEL_STATIC: u8 = 0;
/// Value of vehicles in traffic.
pub const LABEL_MOVING: u8 = 1;
/// Value of parked vehicles.
pub const LABEL_PARKED: u8 = 2;
/// Value of the sky.
pub const LABEL_SKY: u8 = 3;

/// Meshes, textures asked for, and what is placed where.
#[derive(Debug, Default)]
pub(crate) struct Scene {
    pub(crate) meshes: Vec<Mesh>,
    pub(crate) recipes: Recipes,
    pub(crate) instances: Vec<Instance>,
}

impl Scene {
    /// Adds a mesh and returns its index.
    pub(crate) fn mesh(&mut self, mesh: Mesh) -> u32 {
        self.meshes.push(mesh);
        (self.meshes.len() - 1) as u32
    }

    /// Places a static object.
    fn place(&mut self, mesh: u32, placement: Placement, gain: f64) {
        self.instances.push(Instance { mesh, placement, layer: Layer::Object, label: LABEL_STATIC, gain });
    }

    fn spread(&mut self, mesh: Mesh, layer: Layer, label: u8) {
        let mesh = self.mesh(mesh);
        self.instances.push(Instance { mesh, placement: Placement::identity(), layer, label, gain: 1.0 });
    }
}

/// Chooses places for side streets: on straight parts, at least 50 m apart, clear of other parts of the course.
pub(crate) fn side_streets(course: &Course, settings: &Settings, seed: u64) -> Vec<SideStreet> {
    let mut rng = ChaCha8Rng::seed_from_u64(mix_seed(seed, 0, 1));
    let mut streets: Vec<SideStreet> = Vec::new();
    let mut s = 35.0;
    while s < course.length - 35.0 {
        let straight = (-18..=18).all(|k| course.at(s + f64::from(k)).curvature.abs() < 0.006);
        if !straight {
            s += 2.0;
            continue;
        }
        let station = course.at(s);
        let arm = |sign: f64| arm_length(course, &station, sign);
        let (mut left_m, mut right_m) = (arm(-1.0), arm(1.0));
        // Some are mere junctions, unless trucks need crossings.
        if !settings.truck_halts && left_m > 0.0 && right_m > 0.0 && rng.random_bool(0.3) {
            if rng.random_bool(0.5) { left_m = 0.0 } else { right_m = 0.0 }
        }
        if left_m + right_m > 0.0 {
            let heading = station.heading + FRAC_PI_2;
            streets.push(SideStreet {
                s,
                center: station.position,
                right: station.right(),
                heading,
                left_m,
                right_m,
            });
            s += rng.random_range(55.0..95.0);
        } else {
            s += 6.0;
        }
    }
    streets
}

/// How far a side street can run before it comes within 24 m of the course again; 0 when that is less than 38 m.
fn arm_length(course: &Course, station: &Station, sign: f64) -> f64 {
    let mut length: f64 = 26.0;
    while length < 75.0
        && course.distance(&(station.position + station.right() * sign * (length + 24.0))) > 24.0
    {
        length += 3.0;
    }
    if length < 38.0 { 0.0 } else { length }
}

/// Builds everything that stands still around the course.
pub(crate) fn build(
    course: &Course,
    side_streets: &[SideStreet],
    settings: &Settings,
    common: &Common,
    scene: &mut Scene,
    seed: u64,
) {
    let layout = Layout { course, side_streets: side_streets.to_vec(), houses: Vec::new() };
    let rng = ChaCha8Rng::seed_from_u64(mix_seed(seed, 0, 2));
    let mut town = Town { layout, common, settings, scene, rng, looks: 0, known: Vec::new() };
    for side in [-1.0, 1.0] {
        town.course_row(side);
    }
    for street in side_streets {
        town.side_rows(street);
    }
    if !settings.regular {
        town.second_row();
    }
    for side in [-1.0, 1.0] {
        town.kerb_side(side);
        town.gardens(side);
    }
    let (low, high) = course.bounds();
    let ground = street::build(&town.layout, common, seed as u32, settings.regular);
    for mesh in ground {
        scene.spread(mesh, Layer::Ground, LABEL_STATIC);
    }
    scene.spread(sky::build(common, (low + high) / 2.0), Layer::Sky, LABEL_SKY);
}

struct Town<'a, 'b> {
    layout: Layout<'a>,
    common: &'b Common,
    settings: &'b Settings,
    scene: &'b mut Scene,
    rng: ChaCha8Rng,
    /// Number of fronts designed so far.
    looks: u32,
    /// Houses of a regular street: width, storeys and mesh.
    known: Vec<(f64, u32, u32)>,
}

impl Town<'_, '_> {
    /// A row of houses along one side of the course.
    fn course_row(&mut self, side: f64) {
        let course = self.layout.course;
        let end = if course.closed { course.length } else { course.length + 60.0 };
        let start = if course.closed { 0.0 } else { -20.0 };
        self.row(&|s| course.at(s), start, end, side, ROAD_HALF_M + WALK_M, 7.4);
    }

    /// Rows along both sides of both arms of a side street, and a house across each end.
    fn side_rows(&mut self, street: &SideStreet) {
        for (sign, length) in [(-1.0, street.left_m), (1.0, street.right_m)] {
            if length <= 0.0 {
                continue;
            }
            let dir = street.right * sign;
            let heading = street.heading + if sign < 0.0 { std::f64::consts::PI } else { 0.0 };
            let line = |s: f64| Station { position: street.center + dir * s, heading, curvature: 0.0 };
            let width = 13.0;
            let front = line(length + 1.0).beside(-0.5 * width);
            let end = Footprint { placement: front, width, depth: 9.0 };
            if self
                .layout
                .has_room(&Footprint { placement: line(length + 5.4).beside(-0.5 * width), ..end }, 7.4)
            {
                self.house(Footprint { placement: line(length + 5.4).beside(-0.5 * width), ..end }, 3, false);
            }
            for side in [-1.0, 1.0] {
                self.row(&line, ROAD_HALF_M + WALK_M + 0.5, length, side, SIDE_HALF_M + 2.0, 7.4);
            }
        }
    }

    /// Houses side by side along a line from `from` to `to`, their fronts `lateral` metres (or a front garden more) from it.
    fn row(
        &mut self,
        line: &dyn Fn(f64) -> Station,
        from: f64,
        to: f64,
        side: f64,
        lateral: f64,
        clearance: f64,
    ) {
        let regular = self.settings.regular;
        let mut s = from;
        let (mut setback, mut left_in_group) = (0.0, 0);
        while s < to {
            if left_in_group == 0 {
                left_in_group = self.rng.random_range(2..6);
                setback =
                    if regular || self.rng.random_bool(0.5) { 0.1 } else { self.rng.random_range(2.0..5.0) };
            }
            let wish = if regular { 12.0 } else { self.rng.random_range(8.5..16.0) };
            let depth = if regular { 10.0 } else { self.rng.random_range(8.0..11.5) };
            let storeys = if regular { 3 } else { [1, 2, 2, 2, 3, 3, 4, 5][self.rng.random_range(0..8)] };
            let fits =
                [(wish, depth), (0.7 * wish, 0.8 * depth), (6.0, 6.0)].into_iter().find_map(|(w, d)| {
                    let footprint = footprint_along(line, s, to, side, lateral + setback, w, d)?;
                    self.layout.has_room(&footprint, clearance).then_some(footprint)
                });
            let Some(footprint) = fits else {
                s += 1.0;
                continue;
            };
            self.house(footprint, storeys, false);
            left_in_group -= 1;
            let gap = if regular || left_in_group > 0 { 0.02 } else { self.rng.random_range(1.0..7.0) };
            s = beyond(line, s, side * (lateral + setback), footprint.width).unwrap_or(s + footprint.width)
                + gap;
        }
    }

    fn house(&mut self, footprint: Footprint, storeys: u32, distant: bool) {
        let plot = Plot { width: footprint.width, depth: footprint.depth, storeys, distant };
        self.layout.houses.push(footprint);
        let mesh = if self.settings.regular { self.repeated(&plot) } else { self.designed(&plot) };
        self.scene.place(mesh, footprint.placement, 1.0);
    }

    fn designed(&mut self, plot: &Plot) -> u32 {
        self.looks += 1;
        let look = self.rng.random::<u32>();
        let mesh = houses::build(plot, &mut self.scene.recipes, self.common, look);
        self.scene.mesh(mesh)
    }

    /// Two designs in turn for each size.
    fn repeated(&mut self, plot: &Plot) -> u32 {
        self.looks += 1;
        let variant = self.looks % 2;
        let same = |w: f64| (w - plot.width).abs() < 0.05;
        if let Some((_, _, mesh)) = self.known.iter().find(|(w, v, _)| same(*w) && *v == variant) {
            return *mesh;
        }
        let mesh = houses::build(plot, &mut self.scene.recipes, self.common, 7 + variant);
        let mesh = self.scene.mesh(mesh);
        self.known.push((plot.width, variant, mesh));
        mesh
    }

    /// Houses at random behind the first row, to close the view through gaps.
    fn second_row(&mut self) {
        let (low, high) = self.layout.course.bounds();
        let margin = 70.0;
        for _ in 0..900 {
            let x = self.rng.random_range(low.x - margin..high.x + margin);
            let z = self.rng.random_range(low.z - margin..high.z + margin);
            let placement = Placement { position: V3::new(x, 0.0, z), yaw: self.rng.random_range(0.0..6.28) };
            let (width, depth) = (self.rng.random_range(9.0..17.0), self.rng.random_range(9.0..13.0));
            let storeys = self.rng.random_range(3..7);
            let footprint = Footprint { placement, width, depth };
            if self.layout.has_room(&footprint, 21.0) {
                self.house(footprint, storeys, true);
            }
        }
    }

    /// Lamps, trees, signs and boxes on the walk.
    fn kerb_side(&mut self, side: f64) {
        let common = self.common;
        let trees: Vec<u32> = (0..8).map(|k| self.scene.mesh(furniture::tree(common, 100 + k))).collect();
        let lamp = self.scene.mesh(furniture::lamp(common, 6.5));
        let signs: Vec<u32> = (0..8).map(|k| self.scene.mesh(furniture::sign(common, k))).collect();
        let boxes: Vec<u32> = (0..6).map(|k| self.scene.mesh(furniture::cabinet(common, k))).collect();
        let regular = self.settings.regular;
        let course = self.layout.course;
        let mut s = if side > 0.0 { 6.0 } else { 14.0 };
        let mut slot = 0_usize;
        while s < course.length - 2.0 {
            let to_street = self.layout.to_side_street(s, side);
            let at = |lateral: f64, turn: f64| {
                let mut placement = course.at(s).beside(side * lateral);
                placement.yaw += turn;
                placement
            };
            let inward = side * FRAC_PI_2;
            let kind = if regular { slot % 4 } else { self.rng.random_range(0..10) };
            match kind {
                _ if to_street < SIDE_HALF_M + 1.5 => {}
                0..=3 if to_street > 8.0 => {
                    let spin = if regular { 0.0 } else { self.rng.random_range(0.0..6.28) };
                    let tree = trees[if regular { 0 } else { self.rng.random_range(0..trees.len()) }];
                    let gain = if regular { 1.0 } else { self.rng.random_range(0.75..1.2) };
                    self.scene.place(tree, at(ROAD_HALF_M + 1.0, spin), gain);
                }
                4 | 5 => self.scene.place(
                    boxes[self.rng.random_range(0..boxes.len())],
                    at(ROAD_HALF_M + 2.55, inward),
                    1.0,
                ),
                6 | 7 => {
                    let sign = signs[self.rng.random_range(0..signs.len())];
                    let turn = if side > 0.0 { 0.0 } else { std::f64::consts::PI };
                    self.scene.place(sign, at(ROAD_HALF_M + 0.5, turn), 1.0);
                }
                _ => {}
            }
            if slot % 3 == 0 && to_street > SIDE_HALF_M + 1.5 {
                self.scene.place(
                    lamp,
                    {
                        let mut p = at(ROAD_HALF_M + 0.45, inward);
                        p.position += course.at(s).right().cross(&V3::y()) * 2.5;
                        p
                    },
                    1.0,
                );
            }
            slot += 1;
            s += if regular { 9.0 } else { self.rng.random_range(6.5..11.0) };
        }
    }

    /// Hedges, walls, fences, bushes and trees wherever no house stands at the walk's outer edge.
    fn gardens(&mut self, side: f64) {
        let course = self.layout.course;
        let common = self.common;
        let surfaces = [common.hedge, common.walls[0], common.walls[1], common.walls[2]];
        let (bush, trees): (Vec<u32>, Vec<u32>) = (
            (0..4).map(|k| self.scene.mesh(furniture::bush(common, 40 + k))).collect(),
            (0..4).map(|k| self.scene.mesh(furniture::tree(common, 60 + k))).collect(),
        );
        let edge = ROAD_HALF_M + WALK_M + 0.15;
        let length = 3.0;
        let fence = self.scene.mesh(furniture::fence(common, length));
        let mut walls = Vec::new();
        for surface in surfaces {
            for height in [0.7, 1.25] {
                walls.push(self.scene.mesh(furniture::barrier(length, height, surface, surface)));
            }
        }
        let (mut s, mut style) = (0.0, 0);
        while s < course.length - length {
            let place = self.layout.course.at(s + 0.5 * length).beside(side * edge);
            if self.rng.random_bool(0.15) {
                style = self.rng.random_range(0..walls.len() + 2);
            }
            let clear = self.layout.is_free(&place.position, 0.3, edge - 0.5)
                && self.layout.to_side_street(s + 0.5 * length, side) > SIDE_HALF_M + 2.0;
            if clear {
                if let Some(footprint) =
                    footprint_along(&|s| course.at(s), s, s + 2.0 * length, side, edge, length, 0.5)
                {
                    let mesh = walls.get(style).copied().unwrap_or(fence);
                    self.scene.place(mesh, footprint.placement, 1.0);
                }
                let behind = course.at(s + 1.0).beside(side * (edge + self.rng.random_range(1.4..2.4)));
                if self.rng.random_bool(0.5) && self.layout.is_free(&behind.position, 0.6, edge) {
                    let pick = bush[self.rng.random_range(0..bush.len())];
                    self.scene.place(
                        pick,
                        Placement { yaw: self.rng.random_range(0.0..6.28), ..behind },
                        1.0,
                    );
                }
                let deep = course.at(s).beside(side * (edge + self.rng.random_range(3.5..12.0)));
                if self.rng.random_bool(0.3) && self.layout.is_free(&deep.position, 1.2, edge + 2.5) {
                    let pick = trees[self.rng.random_range(0..trees.len())];
                    let gain = self.rng.random_range(0.7..1.1);
                    self.scene.place(pick, Placement { yaw: self.rng.random_range(0.0..6.28), ..deep }, gain);
                }
            }
            s += length;
        }
    }
}

/// The place along the line where a chord of the given width, `lateral` beside the line, ends; `None` when 4 widths do not reach.
fn beyond(line: &dyn Fn(f64) -> Station, s: f64, lateral: f64, width: f64) -> Option<f64> {
    let start = line(s).beside(lateral).position;
    let steps = (16.0 * width) as i32;
    (1..steps)
        .map(|k| s + 0.25 * f64::from(k))
        .find(|end| (line(*end).beside(lateral).position - start).norm() >= width)
}

/// Ground of a house whose front is a chord of the line's offset curve and starts at `s`; `None` when it would end beyond `to`.
fn footprint_along(
    line: &dyn Fn(f64) -> Station,
    s: f64,
    to: f64,
    side: f64,
    lateral: f64,
    width: f64,
    depth: f64,
) -> Option<Footprint> {
    let end = beyond(line, s, side * lateral, width)?;
    if end > to {
        return None;
    }
    let (a, b) = (line(s).beside(side * lateral).position, line(end).beside(side * lateral).position);
    // Seen from the street, the front runs forwards on the left side and backwards on the right.
    let (from, dir) = if side < 0.0 { (a, (b - a).normalize()) } else { (b, (a - b).normalize()) };
    let position = if side < 0.0 { from } else { a - dir * width };
    Some(Footprint { placement: Placement { position, yaw: (-dir.z).atan2(dir.x) }, width, depth })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preset::Preset;

    fn scene(preset: Preset, seed: u64) -> (Course, Scene) {
        let course = if preset == Preset::Facades { Course::street(seed, 900.0) } else { Course::town(seed) };
        let settings = preset.settings();
        let mut scene = Scene::default();
        let common = Common::new(&mut scene.recipes, 1);
        let streets = side_streets(&course, &settings, seed);
        build(&course, &streets, &settings, &common, &mut scene, seed);
        (course, scene)
    }

    #[test]
    fn nothing_solid_stands_on_the_carriageway() {
        let (course, scene) = scene(Preset::Town, 4);
        assert!(scene.instances.len() > 400, "{}", scene.instances.len());
        for instance in scene.instances.iter().filter(|i| i.layer == Layer::Object) {
            let mesh = &scene.meshes[instance.mesh as usize];
            for v in mesh.vertices.iter().filter(|v| v.y > -1.2) {
                assert!(course.distance(&instance.placement.apply(v)) > 4.6);
            }
        }
    }

    #[test]
    fn both_sides_are_built_up() {
        for seed in [1, 2, 3] {
            let (course, scene) = scene(Preset::Town, seed);
            let high: Vec<V3> = scene
                .instances
                .iter()
                .filter(|i| i.layer == Layer::Object)
                .map(|i| (i, &scene.meshes[i.mesh as usize]))
                .filter(|(_, m)| m.radius > 5.0)
                .map(|(i, m)| i.placement.apply(&m.center))
                .collect();
            let mut open = 0;
            let places = (course.length / 5.0) as i32;
            for k in 0..places {
                for side in [-1.0, 1.0] {
                    let p = course.at(5.0 * f64::from(k)).beside(side * 14.0).position;
                    open += i32::from(!high.iter().any(|h| (h - p).xz().norm() < 12.0));
                }
            }
            assert!(open < places / 3, "{open} of {}", 2 * places);
        }
    }

    #[test]
    fn fronts_repeat_only_where_asked() {
        let (_, town) = scene(Preset::Town, 5);
        let (_, facades) = scene(Preset::Facades, 5);
        let fronts = |scene: &Scene| {
            scene
                .recipes
                .list
                .iter()
                .filter(|r| matches!(r, crate::library::Recipe::Facade(p) if !p.blank))
                .count()
        };
        assert!(fronts(&town) > 150, "{}", fronts(&town));
        assert!(fronts(&facades) < 20, "{}", fronts(&facades));
    }
}
