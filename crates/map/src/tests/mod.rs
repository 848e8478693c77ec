//! Tests of the map as a whole.

mod broken_maps;
mod correction;
mod estimates;
mod insertion;
mod map_file;
mod observations;
mod random_mutations;
mod removal;
mod scale;
mod snapshots;
mod submaps;
mod take_back;
mod world;
