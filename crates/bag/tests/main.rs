//! Bags written by hand, whole and damaged. Bags of independent writers are read by the tests of the Python module.

#![allow(clippy::unwrap_used)]

mod suite {
    mod bytes;
    mod damaged;
    mod kinds;
    mod out;
    mod written;
}
