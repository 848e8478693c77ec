//! Maps for other programs: points as PLY, models for COLMAP and nerfstudio with their images, trajectories of the keyframes.
//!
//! A [`Scene`] is what is exported of a map: one sub-map as plain numbers. [`Scene::of`] takes it out of the map,
//! [`SceneImages`] adds images and the colors of the points, and the writers put it into files. Start reading at [`Scene`].

mod colmap;
mod color;
mod error;
mod images;
mod nerfstudio;
mod ply;
mod reprojection;
mod scene;
mod trajectory;

pub use colmap::{ColmapFiles, colmap_binary, colmap_text};
pub use color::Tint;
pub use error::ExportError;
pub use images::SceneImages;
pub use nerfstudio::nerfstudio_json;
pub use ply::{PlyFrame, ply};
pub use reprojection::ReprojectionError;
pub use scene::{Camera, Point, Scene, View};
pub use trajectory::trajectory;
