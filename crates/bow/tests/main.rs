//! Tests of the crate from outside.

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

mod suite;
