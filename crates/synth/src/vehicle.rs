//! Meshes of cars, vans, buses, trucks, lorries and trams: the origin on the ground in the middle, z forward, x right.

use crate::library::{Common, Recipe, Recipes};
use crate::mesh::{Mesh, Surface, V3};
use crate::texture::TextureId;
use crate::vehicle_paint::{Model, Part};

/// Length, width and height, meters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    pub(crate) length: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Model {
    /// Outer size.
    pub(crate) fn size(self) -> Size {
        let (length, width, height) = match self {
            Self::Hatchback => (4.0, 1.76, 1.5),
            Self::Saloon => (4.6, 1.82, 1.44),
            Self::Van => (5.3, 2.0, 2.2),
            Self::Bus => (11.5, 2.5, 3.1),
            Self::Truck => (15.0, 2.5, 3.8),
            Self::Lorry => (13.2, 2.55, 4.0),
            Self::Tram => (27.0, 2.6, 3.6),
        };
        Size { length, width, height }
    }
}

/// Where x points on the right of who sees a face from the front, and from behind or above.
const FROM_FRONT: f64 = -1.0;
const FROM_BEHIND: f64 = 1.0;

/// Builds faces of one vehicle with its own paint.
struct Body<'a> {
    mesh: Mesh,
    recipes: &'a mut Recipes,
    common: &'a Common,
    model: Model,
    seed: u32,
    /// Faces painted so far: equal parts share one drawing.
    painted: Vec<(Part, TextureId)>,
}

/// A vehicle of its own look.
pub(crate) fn build(model: Model, recipes: &mut Recipes, common: &Common, seed: u32) -> Mesh {
    let mut body = Body { mesh: Mesh::default(), recipes, common, model, seed, painted: Vec::new() };
    let size = model.size();
    let shadow = V3::new(-0.5 * size.width - 0.12, -0.012, 0.5 * size.length + 0.1);
    body.mesh.quad(shadow, V3::x() * (size.width + 0.24), -V3::z() * (size.length + 0.2), common.dark);
    match model {
        Model::Hatchback => {
            body.car(size, 0.88, &Profile { bonnet: 0.95, screen: 0.75, rear_screen: 0.35, boot: 0.05 })
        }
        Model::Saloon => {
            body.car(size, 0.88, &Profile { bonnet: 1.05, screen: 0.8, rear_screen: 0.7, boot: 0.62 })
        }
        Model::Van => {
            body.car(size, 1.1, &Profile { bonnet: 0.55, screen: 0.75, rear_screen: 0.1, boot: 0.02 })
        }
        Model::Bus => body.boxed(-0.5 * size.length, size.length, size, [Part::Box, Part::Rear]),
        Model::Tram => body.boxed(-0.5 * size.length, size.length, size, [Part::Cars, Part::Rear]),
        Model::Truck | Model::Lorry => {
            let cab = 2.3;
            let cab_size = Size { height: 3.0, ..size };
            let rear = if model == Model::Lorry { Part::Doors } else { Part::Rear };
            body.boxed(0.5 * size.length - cab, cab, cab_size, [Part::Flank, Part::Rear]);
            body.boxed(-0.5 * size.length, size.length - cab - 0.5, size, [Part::Box, rear]);
        }
    }
    body.wheels(size);
    body.mesh.finish()
}

/// Where the roof line bends: lengths along z, meters.
struct Profile {
    bonnet: f64,
    screen: f64,
    rear_screen: f64,
    boot: f64,
}

impl Body<'_> {
    /// A face's paint, stretched over `size_m`.
    fn paint(&mut self, part: Part, size_m: [f64; 2]) -> Surface {
        let known = self.painted.iter().find(|(p, _)| *p == part).map(|(_, id)| *id);
        let texture = known.unwrap_or_else(|| {
            let id = self.recipes.add(Recipe::Vehicle(part, self.model, self.seed));
            self.painted.push((part, id));
            id
        });
        Surface { detail: None, ..self.common.fitted(texture, part.texels(), size_m) }
    }

    /// A parallelogram or trapezoid; corners clockwise as seen, the texture fitted to its first sides.
    fn face(&mut self, part: Part, corners: [V3; 4]) {
        let right = corners[1] - corners[0];
        let bottom = corners[2] - corners[3];
        let wide = if right.norm() > bottom.norm() { right } else { bottom };
        let normal_free =
            (corners[3] - corners[0]) - wide * ((corners[3] - corners[0]).dot(&wide) / wide.norm_squared());
        let mut surface = self.paint(part, [wide.norm(), normal_free.norm()]);
        // The texture starts at the left end of the wider side.
        surface.offset[0] = surface.density[0] * (corners[0] - corners[3]).dot(&wide.normalize()).max(0.0);
        self.mesh.add(&corners, wide.normalize(), normal_free.normalize(), surface);
    }

    /// A face that reaches as far to the left as to the right, between its upper and its lower edge as seen; of each
    /// edge half its length, height and z. `right` is where x points on the viewer's right.
    fn across(&mut self, part: Part, right: f64, upper: [f64; 3], lower: [f64; 3]) {
        let corner = |side: f64, [half, up, z]: [f64; 3]| V3::new(side * half, -up, z);
        let corners =
            [corner(-right, upper), corner(right, upper), corner(right, lower), corner(-right, lower)];
        self.face(part, corners);
    }

    /// A car with bonnet, cabin and boot; `belt` is the height of the lower edge of the windows.
    fn car(&mut self, size: Size, belt: f64, profile: &Profile) {
        let (half_w, half_l, bottom) = (0.5 * size.width, 0.5 * size.length, 0.2);
        let (front, rear) = (half_l, -half_l);
        let nose = belt - 0.2;
        let base = front - profile.bonnet;
        let (roof_front, roof_rear) = (base - profile.screen, rear + profile.boot + profile.rear_screen);
        let tail = rear + profile.boot;
        let (half_roof, roof) = (half_w - 0.17, size.height);
        self.across(Part::Front, FROM_FRONT, [half_w, nose, front], [half_w, bottom, front]);
        self.across(Part::Rear, FROM_BEHIND, [half_w, belt, rear], [half_w, bottom, rear]);
        self.across(Part::Sheet, FROM_BEHIND, [half_w, nose, front], [half_w, belt, base]);
        self.across(Part::Sheet, FROM_BEHIND, [half_w, belt, tail], [half_w, belt, rear]);
        self.across(Part::Glass, FROM_FRONT, [half_roof, roof, roof_front], [half_w, belt, base]);
        self.across(Part::Glass, FROM_BEHIND, [half_roof, roof, roof_rear], [half_w, belt, tail]);
        self.across(Part::Sheet, FROM_BEHIND, [half_roof, roof, roof_front], [half_roof, roof, roof_rear]);
        self.flanks(size, belt, nose, base);
        for side in [-1.0, 1.0] {
            let upper = [roof_front, roof_rear].map(|z| V3::new(side * half_roof, -roof, z));
            let lower = [tail, base].map(|z| V3::new(side * half_w, -belt, z));
            self.cabin_side(side, upper, lower);
        }
    }

    /// Side windows between roof and belt; the texture's front is the vehicle's front.
    fn cabin_side(&mut self, side: f64, upper: [V3; 2], lower: [V3; 2]) {
        let mut surface =
            self.paint(Part::Windows, [(lower[1] - lower[0]).norm(), (upper[0] - lower[1]).norm() * 0.85]);
        let backwards = -V3::z();
        let down = (lower[0] - upper[1]) - V3::z() * (lower[0] - upper[1]).z;
        let from_front = (lower[1].z - upper[0].z).max(0.0);
        let corners = if side < 0.0 {
            // Seen from the left, the front is to the left.
            surface.offset[0] = surface.density[0] * from_front;
            [upper[0], upper[1], lower[0], lower[1]]
        } else {
            surface.offset[0] = surface.density[0] * (lower[1].z - upper[1].z);
            [upper[1], upper[0], lower[1], lower[0]]
        };
        self.mesh.add(&corners, backwards, down.normalize(), surface);
    }

    /// Lower flanks as pentagons that follow the bonnet.
    fn flanks(&mut self, size: Size, belt: f64, nose: f64, base: f64) {
        let (half_l, bottom) = (0.5 * size.length, 0.2);
        for side in [-1.0, 1.0] {
            let x = 0.5 * side * size.width;
            let mut surface = self.paint(Part::Flank, [size.length, belt - bottom]);
            let mut corners = vec![
                V3::new(x, -nose, half_l),
                V3::new(x, -belt, base),
                V3::new(x, -belt, -half_l),
                V3::new(x, -bottom, -half_l),
                V3::new(x, -bottom, half_l),
            ];
            if side > 0.0 {
                corners.reverse();
            }
            let (first, v) = (corners[0], surface.density);
            surface.offset = [v[0] * (half_l - first.z), v[1] * (belt + first.y)];
            self.mesh.add(&corners, -V3::z(), V3::y(), surface);
        }
    }

    /// An upright box from `rear` (z) with the given length.
    fn boxed(&mut self, rear: f64, length: f64, size: Size, [side_part, rear_part]: [Part; 2]) {
        let (w, bottom) = (0.5 * size.width, 0.35);
        let front = rear + length;
        let (h, middle) = (size.height, 0.5 * size.height);
        let p = |x: f64, up: f64, z: f64| V3::new(x, -up, z);
        self.face(side_part, [p(-w, h, front), p(-w, h, rear), p(-w, bottom, rear), p(-w, bottom, front)]);
        self.face(side_part, [p(w, h, rear), p(w, h, front), p(w, bottom, front), p(w, bottom, rear)]);
        // The upper half of the front is glass.
        self.across(Part::Glass, FROM_FRONT, [w, h, front], [w, middle, front]);
        self.across(Part::Front, FROM_FRONT, [w, middle, front], [w, bottom, front]);
        self.across(rear_part, FROM_BEHIND, [w, h, rear], [w, bottom, rear]);
        self.across(Part::Sheet, FROM_BEHIND, [w, h, front], [w, h, rear]);
    }

    /// Discs just outside the flanks, with a tread below the body.
    fn wheels(&mut self, size: Size) {
        let large = size.length > 8.0;
        let radius = if large { 0.48 } else { 0.32 };
        let axles: &[f64] =
            if size.length > 13.0 { &[-0.42, -0.34, -0.26, 0.25, 0.42] } else { &[-0.31, 0.32] };
        let rim =
            |x: f64, z: f64, angle: f64| V3::new(x, -radius - radius * angle.sin(), z + radius * angle.cos());
        let n = 12;
        for axle in axles {
            let z = axle * size.length;
            for side in [-1.0, 1.0] {
                let x = side * (0.5 * size.width + 0.015);
                let step = std::f64::consts::TAU / n as f64;
                // Angles grow from the front upwards: clockwise when seen from the right.
                let corners: Vec<V3> = (0..n).map(|i| rim(x, z, side * step * -f64::from(i))).collect();
                let mut surface = self.paint(Part::Wheel, [2.0 * radius; 2]);
                surface.offset = [surface.density[0] * 2.0 * radius, surface.density[1] * radius];
                self.mesh.add(&corners, V3::z(), V3::y(), surface);
            }
            for face in [-1.0, 1.0] {
                let corner = V3::new(-0.5 * size.width * face, -radius, z + face * -0.9 * radius);
                self.mesh.quad(corner, V3::x() * size.width * face, V3::y() * radius, self.common.tire);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_look_away_from_the_middle() {
        let mut recipes = Recipes::default();
        let common = Common::new(&mut recipes, 1);
        for model in
            [Model::Hatchback, Model::Saloon, Model::Van, Model::Bus, Model::Truck, Model::Lorry, Model::Tram]
        {
            let mesh = build(model, &mut recipes, &common, 5);
            let size = model.size();
            for p in &mesh.polygons {
                let corners = &mesh.vertices[p.first as usize..(p.first + p.count) as usize];
                let mean = corners.iter().sum::<V3>() / corners.len() as f64;
                // Sideways faces look outwards, upper ones upwards.
                if p.normal.x.abs() > 0.7 {
                    assert!(p.normal.x * mean.x > 0.0, "{model:?} {mean:?} {:?}", p.normal);
                } else if p.normal.y.abs() > 0.6 {
                    assert!(p.normal.y < 0.0, "{model:?} {mean:?} {:?}", p.normal);
                }
                for c in corners {
                    assert!(((c - corners[0]).dot(&p.normal)).abs() < 1e-6, "{model:?}: not planar");
                    assert!(c.y >= -size.height - 1e-9 && c.z.abs() <= 0.5 * size.length + 0.2);
                }
            }
        }
    }
}
