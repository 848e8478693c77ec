//! How far a network trusts each place of an image: plain data, and where it comes from.

use geometry::{GrayImage, Raster};
use std::fmt::Debug;

/// Trust in the places of an image: 1 for the static, distinctive scene, 0 for what moves or looks like much else.
///
/// A source may give a second answer beside it: what will still be there another day, which vehicles will not, standing ones
/// included. The map is usually coarser than the image; the corners of both coincide.
#[derive(Clone, Debug, PartialEq)]
pub struct ActivationMap {
    values: Raster<f32>,
    /// The second answer, of the same size; `None`: the first one stands for both.
    lasting: Option<Raster<f32>>,
    columns_per_pixel: f32,
    rows_per_pixel: f32,
}

/// Makes the activation map of an image; a network outside this crate, or anything else in tests. Equal images give equal maps,
/// so that several frame builders can share a source.
pub trait ActivationSource: Debug + Send + Sync {
    /// The map of `image`.
    ///
    /// # Errors
    /// Why there is none.
    fn activation(&self, image: &GrayImage) -> Result<ActivationMap, ActivationError>;
}

/// Why an image has no activation map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ActivationError {
    /// The network did not run, or its output is not a map.
    #[error("the network failed: {0}")]
    Failed(String),
    /// The source has maps of other images only.
    #[error("there is no activation map of this image")]
    Unknown,
}

/// A map that has been made already, whatever the image.
impl ActivationSource for ActivationMap {
    fn activation(&self, _: &GrayImage) -> Result<ActivationMap, ActivationError> {
        Ok(self.clone())
    }
}

impl ActivationMap {
    /// A map of an image of `width` x `height` pixels. Values are clamped to [0, 1]; `None` where one of them is not a
    /// number, or map or image are empty.
    pub fn new(values: Raster<f32>, width: usize, height: usize) -> Option<Self> {
        let values = clamped(values)?;
        if width == 0 || height == 0 {
            return None;
        }
        let columns_per_pixel = values.width as f32 / width as f32;
        let rows_per_pixel = values.height as f32 / height as f32;
        Some(Self { values, lasting: None, columns_per_pixel, rows_per_pixel })
    }

    /// The same with the second answer; `None` where it has another size or holds something that is not a number.
    #[must_use]
    pub fn with_lasting(self, lasting: Raster<f32>) -> Option<Self> {
        let fits = lasting.width == self.values.width && lasting.height == self.values.height;
        let lasting = clamped(lasting).filter(|_| fits)?;
        Some(Self { lasting: Some(lasting), ..self })
    }

    /// The map's own values, as coarse as they are.
    pub fn values(&self) -> &Raster<f32> {
        &self.values
    }

    /// A map of the same image whose cells have the answers of other ones: those that `from` names, column and row.
    pub(crate) fn taken_from(&self, from: impl Fn(usize, usize) -> (usize, usize)) -> Self {
        let Raster { width, height, .. } = self.values;
        let cells: Vec<usize> = (0..height)
            .flat_map(|row| (0..width).map(move |column| (column, row)))
            .map(|(column, row)| from(column, row))
            .map(|(column, row)| row * width + column)
            .collect();
        let take = |values: &Raster<f32>| Raster {
            data: cells.iter().map(|&i| values.data[i]).collect(),
            ..*values
        };
        Self { values: take(&self.values), lasting: self.lasting.as_ref().map(take), ..*self }
    }

    /// Activation at a position in pixels of the image (whole numbers are centers of pixels), bilinear between the map's
    /// values and constant beyond the outermost ones.
    pub fn at(&self, x: f32, y: f32) -> f32 {
        self.sample(&self.values, x, y)
    }

    /// The second answer at a position, as [`ActivationMap::at`]; the first one where there is no other.
    pub fn lasting_at(&self, x: f32, y: f32) -> f32 {
        self.sample(self.lasting.as_ref().unwrap_or(&self.values), x, y)
    }

    fn sample(&self, values: &Raster<f32>, x: f32, y: f32) -> f32 {
        let (x0, x1, dx) = between((x + 0.5) * self.columns_per_pixel - 0.5, values.width);
        let (y0, y1, dy) = between((y + 0.5) * self.rows_per_pixel - 0.5, values.height);
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let upper = mix(values.at(x0, y0), values.at(x1, y0), dx);
        let lower = mix(values.at(x0, y1), values.at(x1, y1), dx);
        mix(upper, lower, dy)
    }
}

/// Values between 0 and 1; `None` where there are none or one of them is not a number.
fn clamped(mut values: Raster<f32>) -> Option<Raster<f32>> {
    values.data.iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
    let is_sound = !values.data.is_empty() && !values.data.iter().any(|v| v.is_nan());
    is_sound.then_some(values)
}

/// The indices on both sides of a position among `len` values, and how far it is from the first to the second.
fn between(position: f32, len: usize) -> (usize, usize, f32) {
    let last = len - 1;
    let position = position.clamp(0.0, last as f32);
    let first = (position as usize).min(last);
    (first, (first + 1).min(last), position - first as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn corners_coincide_and_values_lie_at_the_centers_of_their_cells() {
        let values = Raster::from_vec(2, 2, vec![0.0, 1.0, 0.5, 0.5]).unwrap();
        let map = ActivationMap::new(values, 20, 10).unwrap();
        // Cells of 10 x 5 pixels; their centers are at 4.5 and 14.5, 2 and 7.
        assert_eq!(map.at(4.5, 2.0), 0.0);
        assert_eq!(map.at(14.5, 2.0), 1.0);
        assert_eq!(map.at(9.5, 2.0), 0.5);
        assert_eq!(map.at(14.5, 4.5), 0.75);
        assert_eq!(map.at(-30.0, -3.0), 0.0, "constant beyond the edge");
        assert_eq!(map.at(100.0, 0.0), 1.0);
    }

    #[test]
    fn what_is_no_map_is_refused() {
        let ok = Raster::new(2, 2, 0.5);
        assert!(ActivationMap::new(ok.clone(), 0, 10).is_none());
        assert!(ActivationMap::new(ok.clone(), 10, 0).is_none());
        assert!(ActivationMap::new(Raster::new(0, 0, 0.5), 10, 10).is_none());
        assert!(ActivationMap::new(Raster::new(2, 2, f32::NAN), 10, 10).is_none());
        let clamped = ActivationMap::new(Raster::new(2, 2, 7.0), 10, 10).unwrap();
        assert_eq!(clamped.at(3.0, 3.0), 1.0);
        assert!(ok_map().with_lasting(Raster::new(2, 1, 0.5)).is_none(), "another size");
        assert!(ok_map().with_lasting(Raster::new(2, 2, f32::NAN)).is_none());
    }

    fn ok_map() -> ActivationMap {
        ActivationMap::new(Raster::new(2, 2, 0.75), 10, 10).unwrap()
    }

    #[test]
    fn the_first_answer_stands_for_both_where_there_is_no_second() {
        assert_eq!((ok_map().at(3.0, 3.0), ok_map().lasting_at(3.0, 3.0)), (0.75, 0.75));
        let both = ok_map().with_lasting(Raster::new(2, 2, 0.25)).unwrap();
        assert_eq!((both.at(3.0, 3.0), both.lasting_at(3.0, 3.0)), (0.75, 0.25));
    }

    proptest! {
        #[test]
        fn a_plane_is_reproduced_between_the_outermost_centers(
            x in 4.5f32..74.5, y in 4.5f32..34.5,
        ) {
            let values = Raster::from_fn(8, 4, |i, j| 0.1 * i as f32 + 0.05 * j as f32);
            let map = ActivationMap::new(values, 80, 40).unwrap();
            let expected = 0.1 * ((x + 0.5) / 10.0 - 0.5) + 0.05 * ((y + 0.5) / 10.0 - 0.5);
            prop_assert!((map.at(x, y) - expected).abs() < 1e-5);
        }
    }
}
