//! The dsslam program.
fn main() {}
