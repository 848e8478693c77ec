//! Tests of the crate's public face: what the written files say, read back by readers of these tests' own.

#![allow(clippy::unwrap_used)]

mod suite {
    mod colmap;
    mod images;
    mod other_formats;
    mod scenes;
    mod world;
}
