//! Fields of calibration files in YAML: values with their lines, and errors that name both.

use std::path::{Path, PathBuf};

use geometry::{CameraModel, Distortion, KannalaBrandt, Pinhole, SE3, SO3};
use serde::de::DeserializeOwned;
use serde_saphyr::Spanned;

use super::DatasetError;
use crate::file::{TextFile, counted};
use crate::images::ImageSize;

/// Takes the fields of one file, or says what is wrong with them.
pub(super) struct Fields {
    path: PathBuf,
}

/// Reads a YAML file into a typed document.
///
/// # Errors
/// [`DatasetError`] naming the file and the line of what cannot be read.
pub(super) fn document<T: DeserializeOwned>(file: &TextFile) -> Result<T, DatasetError> {
    serde_saphyr::from_str(file.text()).map_err(|error| {
        let line = error.location().map_or(0, |location| location.line());
        let message = error.without_snippet().to_string();
        DatasetError::Yaml { path: file.path.clone(), line, message }
    })
}

impl Fields {
    /// The fields of this file.
    pub(super) fn of(path: &Path) -> Self {
        Self { path: path.to_path_buf() }
    }

    /// The error of a field, with its line where it is there.
    fn error(&self, field: &str, line: Option<u64>, found: String, expected: &str) -> DatasetError {
        DatasetError::Field {
            path: self.path.clone(),
            line: line.map_or_else(String::new, |line| format!(":{line}")),
            field: field.to_string(),
            found,
            expected: expected.to_string(),
        }
    }

    /// The error of a field that is there.
    pub(super) fn wrong<T>(
        &self,
        field: &str,
        value: &Spanned<T>,
        found: String,
        expected: &str,
    ) -> DatasetError {
        self.error(field, Some(value.referenced.line()), found, expected)
    }

    /// The error of a field that is missing.
    pub(super) fn missing(&self, field: &str, expected: &str) -> DatasetError {
        self.error(field, None, "nothing".to_string(), expected)
    }

    /// A value that must be there.
    pub(super) fn need<T>(&self, field: &str, value: Option<T>, expected: &str) -> Result<T, DatasetError> {
        value.ok_or_else(|| self.missing(field, expected))
    }

    /// A list of `N` finite numbers that is valid.
    pub(super) fn numbers<const N: usize>(
        &self,
        field: &str,
        value: Option<Spanned<Vec<f64>>>,
        expected: &str,
        is_valid: impl Fn(&[f64; N]) -> bool,
    ) -> Result<[f64; N], DatasetError> {
        let value = self.need(field, value, expected)?;
        let Ok(numbers) = <[f64; N]>::try_from(value.value.as_slice()) else {
            return Err(self.wrong(field, &value, counted(value.value.len(), "number"), expected));
        };
        let finite = numbers.iter().all(|v| v.is_finite());
        let found = format!("{numbers:?}");
        if finite && is_valid(&numbers) {
            Ok(numbers)
        } else {
            Err(self.wrong(field, &value, found, expected))
        }
    }

    /// Focal lengths and principal point.
    pub(super) fn pinhole(
        &self,
        field: &str,
        value: Option<Spanned<Vec<f64>>>,
        expected: &str,
    ) -> Result<Pinhole, DatasetError> {
        let [fx, fy, cx, cy] = self.numbers(field, value, expected, |v| v[0] > 0.0 && v[1] > 0.0)?;
        Ok(Pinhole { fx, fy, cx, cy })
    }

    /// A pinhole with the coefficients `k1, k2, p1, p2` and perhaps `k3`.
    pub(super) fn radial_tangential(
        &self,
        field: &str,
        camera: Pinhole,
        coefficients: Option<Spanned<Vec<f64>>>,
    ) -> Result<CameraModel, DatasetError> {
        let third = coefficients.as_ref().filter(|c| c.value.len() == 5).map(|c| c.value[4]);
        let four = coefficients.map(|mut c| {
            if third.is_some() {
                c.value.truncate(4);
            }
            c
        });
        let [k1, k2, p1, p2] =
            self.numbers(field, four, "4 or 5 finite numbers (k1, k2, p1, p2, k3)", |_| {
                third.is_none_or(f64::is_finite)
            })?;
        let distortion = Distortion { k1, k2, p1, p2, k3: third.unwrap_or(0.0) };
        Ok(CameraModel::Pinhole { camera, distortion })
    }

    /// A fisheye with the coefficients `k1, k2, k3, k4`.
    pub(super) fn fisheye(
        &self,
        field: &str,
        camera: Pinhole,
        coefficients: Option<Spanned<Vec<f64>>>,
    ) -> Result<CameraModel, DatasetError> {
        let [k1, k2, k3, k4] =
            self.numbers(field, coefficients, "4 finite numbers (k1, k2, k3, k4)", |_| true)?;
        Ok(CameraModel::KannalaBrandt(KannalaBrandt { camera, k1, k2, k3, k4 }))
    }

    /// Width and height.
    pub(super) fn size(
        &self,
        field: &str,
        resolution: Option<Spanned<Vec<u64>>>,
    ) -> Result<ImageSize, DatasetError> {
        const EXPECTED: &str = "width and height in pixels, each from 1 to 65535";
        let value = self.need(field, resolution, EXPECTED)?;
        match value.value[..] {
            [width @ 1..=65535, height @ 1..=65535] => {
                Ok(ImageSize { width: width as usize, height: height as usize })
            }
            _ => Err(self.wrong(field, &value, format!("{:?}", value.value), EXPECTED)),
        }
    }

    /// A rigid motion out of a 4x4 matrix, row by row, whose rotation is made exact.
    pub(super) fn rigid<T>(
        &self,
        field: &str,
        place: &Spanned<T>,
        data: &[f64],
        expected: &str,
    ) -> Result<SE3, DatasetError> {
        /// Files keep four digits or more; a larger deviation is not due to rounding.
        const TOLERANCE: f64 = 0.01;
        if data.len() != 16 {
            return Err(self.wrong(field, place, counted(data.len(), "number"), expected));
        }
        if !data.iter().all(|v| v.is_finite()) {
            return Err(self.wrong(field, place, "a number that is not finite".to_string(), expected));
        }
        let m = geometry::Mat4::from_row_slice(data);
        let given = m.fixed_view::<3, 3>(0, 0).into_owned();
        let deviation = (SO3::from_matrix(&given).matrix() - given).amax();
        let last = m.row(3) - geometry::Vec4::w().transpose();
        if deviation > TOLERANCE || last.amax() > TOLERANCE {
            let found = format!("a matrix that is {:.3} from a rigid motion", deviation.max(last.amax()));
            return Err(self.wrong(field, place, found, expected));
        }
        Ok(SE3::new(SO3::from_matrix(&given), m.fixed_view::<3, 1>(0, 3).into_owned()))
    }
}
