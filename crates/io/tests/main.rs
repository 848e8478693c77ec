//! Tests of the crate's public face: formats, and the exact message for each kind of bad input.

#![allow(clippy::unwrap_used)]

mod suite {
    mod bad_dataset;
    mod bad_euroc;
    mod bad_image;
    mod calibrations;
    mod camera_file;
    mod euroc_layout;
    mod image_folder;
    mod images;
    mod kitti_layout;
    mod layouts;
    mod real_data;
    mod recordings;
    mod support;
    mod text_files;
    mod trajectory;
    mod tum_layout;
}
