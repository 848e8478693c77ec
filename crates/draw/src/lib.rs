//! Pictures for people: lines, rings and text drawn over images, color maps, palettes. No file is read or written here.
//!
//! Start reading at [`Canvas`]. Positions are pixels with (0, 0) at the center of the upper left one, as everywhere.

mod canvas;
mod color;
mod font;
mod strip;

pub use canvas::{Canvas, Stroke};
pub use color::{BLACK, Color, PALETTE, WHITE, gradient, spread};
pub use font::{FONT, text_width};
pub use strip::{Strip, Swatch};
