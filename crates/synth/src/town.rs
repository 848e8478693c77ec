//! Lays out everything that stands still: side streets first, then houses (`rows`), then what stands beside the road (`roadside`).

use crate::course::{Course, Station};
use crate::layout::{Layout, SideStreet};
use crate::library::{Common, Recipes};
use crate::mesh::{Instance, Layer, Mesh, Placement};
use crate::preset::{Halts, Settings};
use crate::roadside::Stock;
use crate::sky;
use crate::street;
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
    pub(crate) fn place(&mut self, mesh: u32, placement: Placement, gain: f64) {
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
        // Some are mere junctions, unless we halt at crossings.
        if settings.halts == Halts::None && left_m > 0.0 && right_m > 0.0 && rng.random_bool(0.3) {
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
    let stock = Stock::new(town.scene, common);
    for side in [-1.0, 1.0] {
        town.curb_side(side, &stock);
        town.gardens(side, &stock);
    }
    let (low, high) = course.bounds();
    let ground = street::build(&town.layout, common, seed as u32, settings.regular);
    for mesh in ground {
        scene.spread(mesh, Layer::Ground, LABEL_STATIC);
    }
    scene.spread(sky::build(common, (low + high) / 2.0), Layer::Sky, LABEL_SKY);
}

/// A town while it is laid out.
pub(crate) struct Town<'a, 'b> {
    pub(crate) layout: Layout<'a>,
    pub(crate) common: &'b Common,
    pub(crate) settings: &'b Settings,
    pub(crate) scene: &'b mut Scene,
    pub(crate) rng: ChaCha8Rng,
    /// Number of fronts designed so far.
    pub(crate) looks: u32,
    /// Houses of a regular street: width, stories and mesh.
    pub(crate) known: Vec<(f64, u32, u32)>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::V3;
    use crate::preset::Preset;

    fn scene(preset: Preset, seed: u64) -> (Course, Scene) {
        let course = if preset.is_open() { Course::street(seed, 900.0) } else { Course::town(seed) };
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
