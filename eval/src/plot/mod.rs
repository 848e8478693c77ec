//! Figures as PNG and SVG: every axis has its label and unit, colours are safe for colour-blind readers.

mod axes;
mod canvas;
mod trajectory;

pub use canvas::{Figure, render, save_png, save_svg, svg};
pub use trajectory::{TrajectoryFigure, View, trajectory_png};
