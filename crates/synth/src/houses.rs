//! Meshes of houses: body, roof, balconies, ledges, steps, chimneys. Local frame: origin at the front's left ground corner as seen
//! from the street, x along the front, z into the house.

use crate::facade::FacadePlan;
use crate::library::{Common, Recipe, Recipes};
use crate::mesh::{Mesh, Surface, V3};
use crate::noise::unit;

/// Outer dimensions of a house, meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plot {
    pub(crate) width: f64,
    pub(crate) depth: f64,
    pub(crate) stories: u32,
    /// Only seen from afar: drawn with coarser textures.
    pub(crate) distant: bool,
}

impl Plot {
    /// Height of the walls.
    pub(crate) fn height(&self) -> f64 {
        0.5 + 3.0 * f64::from(self.stories)
    }
}

/// Builds a house; `look` decides everything about its appearance (equal looks give equal houses).
pub(crate) fn build(plot: &Plot, recipes: &mut Recipes, common: &Common, look: u32) -> Mesh {
    let r = |k: i32| f64::from(unit(k, 17, look));
    let (w, d, h) = (plot.width, plot.depth, plot.height());
    let mut front = FacadePlan::from_seed([w as f32, h as f32], plot.stories, look);
    front.distant = plot.distant;
    let texels = front.texels();
    let front_surface = common.fitted(recipes.add(Recipe::Facade(front.clone())), texels, [w, h]);
    let side_surface = common.gables[(r(3) * common.gables.len() as f64) as usize];
    // The wall's v counts from the ground; a quad's from its upper edge.
    let side_surface = Surface { offset: [0.0, -h * side_surface.density[1]], ..side_surface };
    let mut mesh = Mesh::default();
    let (x, y, z) = (V3::x() * w, V3::y() * h, V3::z() * d);
    let top = -V3::y() * h;
    mesh.quad(top, x, y, front_surface);
    mesh.quad(top + x, z, y, side_surface);
    mesh.quad(top + z, -z, y, side_surface);
    mesh.quad(top + x + z, -x, y, Surface { offset: [90.0, side_surface.offset[1]], ..side_surface });
    let roof = common.roofs[(r(0) * common.roofs.len() as f64) as usize];
    if r(1) < 0.72 {
        gable(&mut mesh, plot, roof, side_surface, 0.5 + 0.35 * r(2));
    } else {
        parapet(&mut mesh, plot, common);
    }
    relief(&mut mesh, plot, &front, common, look);
    mesh.finish()
}

/// A saddle roof with its ridge along the front.
fn gable(mesh: &mut Mesh, plot: &Plot, roof: Surface, wall: Surface, pitch: f64) {
    let (w, d, h) = (plot.width, plot.depth, plot.height());
    let rise = (0.5 * d * pitch).min(4.5);
    let eave = 0.45;
    let drop = eave * rise / (0.5 * d);
    let p = |x: f64, up: f64, z: f64| V3::new(x, -h - up, z);
    let slope = |mesh: &mut Mesh, corners: [V3; 4]| {
        let (right, down) = (corners[1] - corners[0], corners[3] - corners[0]);
        mesh.add(&corners, right.normalize(), down.normalize(), roof);
    };
    slope(mesh, [p(0.0, rise, 0.5 * d), p(w, rise, 0.5 * d), p(w, -drop, -eave), p(0.0, -drop, -eave)]);
    slope(mesh, [p(w, rise, 0.5 * d), p(0.0, rise, 0.5 * d), p(0.0, -drop, d + eave), p(w, -drop, d + eave)]);
    // Underside of the eaves towards the street, and its gutter.
    let gutter = Surface { gain: 0.55, ..wall };
    mesh.quad(p(0.0, -drop, -eave), V3::x() * w, V3::y() * 0.14, gutter);
    let under = [
        p(0.0, -drop - 0.14, -eave),
        p(w, -drop - 0.14, -eave),
        p(w, -drop - 0.14, 0.0),
        p(0.0, -drop - 0.14, 0.0),
    ];
    mesh.add(&under, V3::x(), V3::z(), gutter);
    for (at, dir) in [(0.0, -1.0), (w, 1.0)] {
        let (a, b) = (p(at, 0.0, 0.0), p(at, 0.0, d));
        let ridge = p(at, rise, 0.5 * d);
        let corners = if dir > 0.0 { [ridge, b, a] } else { [ridge, a, b] };
        mesh.add(&corners, V3::z() * dir, V3::y(), Surface { offset: [40.0, 300.0], ..wall });
    }
}

fn parapet(mesh: &mut Mesh, plot: &Plot, common: &Common) {
    let (w, d, h) = (plot.width, plot.depth, plot.height());
    let size = V3::new(w + 0.3, 0.5, d + 0.3);
    mesh.block(V3::new(-0.15, -h - 0.5, -0.15), size, common.concrete, common.concrete);
    let underside = [
        V3::new(-0.15, -h, -0.15),
        V3::new(w + 0.15, -h, -0.15),
        V3::new(w + 0.15, -h, 0.0),
        V3::new(-0.15, -h, 0.0),
    ];
    mesh.add(&underside, V3::x(), V3::z(), Surface { gain: 0.6, ..common.concrete });
}

/// What stands out from the front and the roof.
fn relief(mesh: &mut Mesh, plot: &Plot, front: &FacadePlan, common: &Common, look: u32) {
    let r = |k: i32| f64::from(unit(k, 31, look));
    let story_m = plot.height() / f64::from(plot.stories);
    let ledge = Surface { gain: f64::from(front.tone) / 120.0, ..common.concrete };
    if r(0) < 0.4 {
        for story in 1..plot.stories {
            let up = story_m * f64::from(story);
            shelf(mesh, V3::new(0.0, -up - 0.1, -0.14), V3::new(plot.width, 0.2, 0.14), ledge);
        }
    }
    if r(1) < 0.45 && plot.stories > 2 {
        let balcony_w = 1.8 + 1.5 * r(2);
        let column = (plot.width - balcony_w - 0.6) * r(3) + 0.3;
        for story in 1..plot.stories {
            let floor = story_m * f64::from(story) + 0.1;
            shelf(mesh, V3::new(column, -floor - 0.95, -1.15), V3::new(balcony_w, 1.05, 1.15), ledge);
        }
    }
    if front.shop && r(4) < 0.6 {
        // An awning over the shop windows.
        let (left, width) = (0.4, plot.width - 0.8);
        let up = story_m - 1.0;
        let fall = V3::new(0.0, 0.55, -1.3);
        let cloth = common.signs[(r(5) * common.signs.len() as f64) as usize];
        let cloth = Surface { density: [50.0, 50.0], ..cloth };
        let corner = V3::new(left + width, -up - 0.3, -0.02);
        mesh.quad(corner + fall, -V3::x() * width, -fall, cloth);
        mesh.quad(V3::new(left, -up - 0.3, -0.02), V3::x() * width, fall, cloth);
    } else if r(4) < 0.9 {
        let x = (plot.width - 1.6) * r(6);
        shelf(mesh, V3::new(x, -0.32, -0.9), V3::new(1.6, 0.32, 0.9), common.concrete);
    }
    if r(7) < 0.8 {
        let at = V3::new(plot.width * (0.15 + 0.6 * r(8)), -plot.height() - 4.0, 0.55 * plot.depth);
        let brick = common.walls[(r(9) * common.walls.len() as f64) as usize];
        mesh.block(at, V3::new(0.7, 4.0, 0.6), brick, common.concrete);
    }
}

/// A box in front of the wall (no back), with an underside.
fn shelf(mesh: &mut Mesh, near: V3, size: V3, surface: Surface) {
    let (x, y, z) = (V3::x() * size.x, V3::y() * size.y, V3::z() * size.z);
    mesh.quad(near, x, y, surface);
    mesh.quad(near + x, z, y, surface);
    mesh.quad(near + z, -z, y, surface);
    mesh.quad(near + z, x, -z, surface);
    let under = [near + y, near + y + x, near + y + x + z, near + y + z];
    mesh.add(&under, V3::x(), V3::z(), Surface { gain: 0.5 * surface.gain, ..surface });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn house_faces_look_outwards_and_are_planar() {
        for look in 0..30 {
            let mut recipes = Recipes::default();
            let common = Common::new(&mut recipes, 1);
            let plot = Plot { width: 11.0, depth: 10.0, stories: 2 + look % 3, distant: false };
            let mesh = build(&plot, &mut recipes, &common, look);
            let inside = V3::new(5.5, -0.6 * plot.height(), 5.0);
            for p in &mesh.polygons {
                let corners = &mesh.vertices[p.first as usize..(p.first + p.count) as usize];
                for c in corners {
                    assert!((c - corners[0]).dot(&p.normal).abs() < 1e-6);
                }
                let wall =
                    p.normal.y.abs() < 0.1 && corners.iter().all(|c| c.z >= -1e-9) && corners.len() == 4;
                let full = corners.iter().any(|c| c.y.abs() < 1e-9);
                if wall && full {
                    assert!(p.normal.dot(&(corners[0] - inside)) > 0.0, "{:?}", p.normal);
                }
            }
        }
    }
}
