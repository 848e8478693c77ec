//! All textures of a world: asked for while the world is laid out, baked in parallel afterwards.

use crate::facade::FacadePlan;
use crate::mesh::{Surface, SurfaceKind};
use crate::noise::Tile;
use crate::texture::{Texture, TextureId};
use crate::{materials, vehicle_paint};
use rayon::prelude::*;

/// How to make a texture.
#[derive(Clone, Debug)]
pub(crate) enum Recipe {
    Facade(FacadePlan),
    Material(materials::Material, u32),
    Vehicle(vehicle_paint::Part, vehicle_paint::Model, u32),
}

/// Textures by id.
#[derive(Debug, Default)]
pub(crate) struct Library {
    textures: Vec<Texture>,
}

impl Library {
    /// Bakes all recipes; the result does not depend on the number of threads.
    pub(crate) fn bake(recipes: &[Recipe]) -> Self {
        let noise = Tile::new(1);
        let bake = |recipe: &Recipe| match recipe {
            Recipe::Facade(plan) => plan.bake(&noise),
            Recipe::Material(material, seed) => material.bake(*seed),
            Recipe::Vehicle(part, model, seed) => vehicle_paint::bake(*part, *model, *seed),
        };
        Self { textures: recipes.par_iter().map(bake).collect() }
    }

    /// The texture of an id given by [`Recipes::add`].
    #[inline]
    pub(crate) fn texture(&self, id: TextureId) -> &Texture {
        &self.textures[id.0 as usize]
    }
}

/// The list of textures asked for so far.
#[derive(Debug, Default)]
pub(crate) struct Recipes {
    pub(crate) list: Vec<Recipe>,
}

impl Recipes {
    pub(crate) fn add(&mut self, recipe: Recipe) -> TextureId {
        self.list.push(recipe);
        TextureId((self.list.len() - 1) as u32)
    }
}

/// Surfaces that the whole world shares.
#[derive(Clone, Debug)]
pub(crate) struct Common {
    pub(crate) asphalt: Surface,
    pub(crate) paving: Surface,
    pub(crate) curb: Surface,
    pub(crate) grass: Surface,
    pub(crate) paint: Surface,
    pub(crate) patch: Surface,
    pub(crate) manhole: Surface,
    pub(crate) concrete: Surface,
    pub(crate) metal: Surface,
    pub(crate) bark: Surface,
    pub(crate) hedge: Surface,
    pub(crate) dark: Surface,
    pub(crate) tire: Surface,
    pub(crate) clouds: Surface,
    pub(crate) leaves: Vec<Surface>,
    pub(crate) roofs: Vec<Surface>,
    pub(crate) walls: Vec<Surface>,
    pub(crate) signs: Vec<Surface>,
    /// Side walls of houses, shared; v is 0 at the ground.
    pub(crate) gables: Vec<Surface>,
    /// Fine grain that is added to near walls.
    pub(crate) grain: TextureId,
}

/// Texels per meter of the grain.
const GRAIN_DENSITY: f64 = 150.0;
/// Number of different side walls.
const GABLES: u32 = 16;

impl Common {
    /// Asks for the shared textures.
    pub(crate) fn new(recipes: &mut Recipes, seed: u32) -> Self {
        use materials::Material as M;
        let grain = recipes.add(Recipe::Material(M::Grain, seed));
        let gables = (0..GABLES).map(|k| gable_wall(recipes, grain, seed.wrapping_add(k))).collect();
        let mut make = |material: M, k: u32| {
            let density = material.density();
            Surface {
                texture: recipes.add(Recipe::Material(material, seed.wrapping_add(k.wrapping_mul(0x9e37)))),
                detail: (density < 0.5 * GRAIN_DENSITY).then_some((grain, [GRAIN_DENSITY / density; 2])),
                density: [density; 2],
                offset: [0.0; 2],
                gain: 1.0,
                kind: SurfaceKind::Solid,
            }
        };
        let decal = |surface: Surface| Surface { kind: SurfaceKind::Decal, ..surface };
        let plain = |surface: Surface| Surface { detail: None, ..surface };
        let asphalt = make(M::Asphalt, 1);
        let concrete = make(M::Concrete, 2);
        Self {
            asphalt,
            paving: make(M::Paving, 3),
            curb: Surface { gain: 1.15, ..concrete },
            grass: make(M::Grass, 4),
            paint: decal(make(M::Paint, 5)),
            patch: decal(Surface { gain: 0.72, ..asphalt }),
            manhole: decal(make(M::Manhole, 6)),
            concrete,
            metal: plain(make(M::Metal, 7)),
            bark: make(M::Bark, 8),
            hedge: make(M::Hedge, 9),
            dark: decal(Surface { gain: 0.28, ..asphalt }),
            tire: plain(Surface { gain: 0.3, ..concrete }),
            clouds: Surface { kind: SurfaceKind::Emissive, ..plain(make(M::Clouds, 10)) },
            leaves: (0..4)
                .map(|k| Surface { kind: SurfaceKind::CutOut, ..plain(make(M::Leaves, 20 + k)) })
                .collect(),
            roofs: (0..4).map(|k| make(M::Roof, 30 + k)).collect(),
            walls: (0..4).map(|k| make(M::Wall, 40 + k)).collect(),
            signs: (0..8).map(|k| plain(make(M::Sign, 50 + k))).collect(),
            gables,
            grain,
        }
    }

    /// A surface that stretches a texture over a rectangle of `size_m`, its origin the rectangle's upper left corner.
    pub(crate) fn fitted(&self, texture: TextureId, texels: [usize; 2], size_m: [f64; 2]) -> Surface {
        stretched(texture, self.grain, texels, size_m)
    }
}

fn stretched(texture: TextureId, grain: TextureId, texels: [usize; 2], size_m: [f64; 2]) -> Surface {
    let density = [0, 1].map(|i| texels[i] as f64 / size_m[i]);
    Surface {
        texture,
        detail: Some((grain, density.map(|d| GRAIN_DENSITY / d))),
        density,
        offset: [0.0; 2],
        gain: 1.0,
        kind: SurfaceKind::Solid,
    }
}

/// A wall with few windows, four stories high; its lower edge is at v = 0 (it repeats).
fn gable_wall(recipes: &mut Recipes, grain: TextureId, seed: u32) -> Surface {
    let size = [12.0, 12.5];
    let plan = FacadePlan { blank: true, ..FacadePlan::from_seed(size, 4, seed ^ 0x6ab1e) };
    let texels = plan.texels();
    stretched(recipes.add(Recipe::Facade(plan)), grain, texels, size.map(f64::from))
}
