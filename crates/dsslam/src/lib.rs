//! The library's front door: push images, get poses and a map.
