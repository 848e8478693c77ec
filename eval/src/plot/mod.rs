//! Figures as PNG and SVG: every axis has its label and unit, colors are safe for color-blind readers.

mod axes;
mod bars;
mod canvas;
mod consistency;
mod drift;
mod error;
mod precision_recall;
mod trajectory;

pub use bars::bars;
pub use canvas::{Canvas, render, save, save_png, svg};
pub use consistency::consistency;
pub use drift::{DriftAxis, drift};
pub use error::error;
pub use precision_recall::precision_recall;
pub use trajectory::{View, trajectory};
