//! Figures as PNG and SVG: every axis has its label and unit, colors are safe for color-blind readers.

mod axes;
mod bars;
mod canvas;
mod consistency;
mod drift;
mod error;
mod precision_recall;
mod trajectory;

pub use bars::BarFigure;
pub use canvas::{Canvas, Figure, render, save, save_png, save_svg, svg};
pub use consistency::ConsistencyFigure;
pub use drift::{DriftAxis, DriftFigure};
pub use error::ErrorFigure;
pub use precision_recall::PrecisionRecallFigure;
pub use trajectory::{TrajectoryFigure, View};
