//! Tests of the stream.

mod deltas;
mod scenes;
mod streams;
mod world;
