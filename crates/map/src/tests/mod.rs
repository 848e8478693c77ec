//! Tests of the whole map.
