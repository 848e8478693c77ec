//! The one shared data structure, its invariants and its queries.
