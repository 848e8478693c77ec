//! Rendered street worlds with exact ground truth: a stereo camera drives a course between textured houses, trees, parked and moving
//! cars.
//!
//! Start reading at [`World`] (any frame of a drive) and [`write_kitti`] and [`write_euroc`] (a whole drive as files). Inside: `course`, `plan` and `drive` (where
//! the camera is), `town` (what stands where), `traffic` (what moves), `daylight` (what lights it), `camera` and `raster` (how it is drawn).
//!
//! World and camera axes: x right, y down, z forward; meters. Preset, seed, number of rounds, turns on the spot and relighting determine
//! everything; frames depend neither on each other nor on the number of threads.

mod camera;
mod canvas;
mod company;
mod course;
mod daylight;
mod drive;
mod facade;
mod furniture;
mod houses;
mod kernel;
mod layout;
mod lens;
mod library;
mod lookup;
mod materials;
mod mesh;
mod mover;
mod noise;
mod plan;
mod preset;
mod raster;
mod render;
mod roadside;
mod rows;
mod sensor;
mod sky;
mod spot_turns;
mod street;
mod texture;
mod town;
mod traffic;
mod vehicle;
mod vehicle_paint;
mod world;
mod write;
mod write_euroc;

pub use lens::{Lens, LensCamera};
pub use preset::Preset;
pub use spot_turns::SpotTurns;
pub use town::{LABEL_MOVING, LABEL_PARKED, LABEL_SKY, LABEL_STATIC};
pub use world::{FRAME_RATE_HZ, LensRig, StereoFrame, StereoImages, World};
pub use write::{DEPTH_UNITS_PER_METRE, WriteOptions, write_kitti};
pub use write_euroc::write_euroc;
