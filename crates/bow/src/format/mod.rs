//! The two file formats: our own binary one and ORB-SLAM2's text.

pub(crate) mod binary;
pub(crate) mod layout;
pub(crate) mod text;
