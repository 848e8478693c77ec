//! Laws, known answers and metamorphic tests of the whole crate, through its public interface.

mod alignment;
mod camera_models;
mod cameras;
mod epipolar;
mod groups;
mod homography;
mod p3p;
mod point_sets;
mod ransac;
mod rasters;
mod rectification;
mod scene;
mod support;
mod triangulation;
mod two_view;
