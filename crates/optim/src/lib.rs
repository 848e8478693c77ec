//! Least squares on plain problems: pose and bundle adjustment.
